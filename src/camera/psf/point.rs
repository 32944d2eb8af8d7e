//! A point of light, drawn: a star, or a satellite that stands still.

use crate::camera::{Patch, PatchRows, PixelPosition};

use super::profile::RadialProfile;

/// The light of a point in a frame of `rows` by `columns`: `flux` times the profile's average over each pixel.
///
/// The sum over all pixels is `flux` to 10⁻⁵ where the whole profile lies on the frame. Nothing is drawn for a place or a flux that is not
/// finite.
pub fn draw_point(profile: &RadialProfile, at: PixelPosition, flux: f64, rows: usize, columns: usize) -> Patch {
    let reach = profile.pixel_reach_pix();
    let mut extents = PatchRows::new(rows, columns);
    if at.x.is_finite() && at.y.is_finite() && flux.is_finite() {
        extents.add_disc(at, reach);
    }
    let mut patch = extents.into_patch();
    patch.fill(|row, first_column, values| {
        let dy = row as f64 - at.y;
        for (column, value) in values.iter_mut().enumerate() {
            let dx = (first_column + column) as f64 - at.x;
            *value = (flux * profile.pixel(dx, dy)) as f32;
        }
    });
    patch
}
