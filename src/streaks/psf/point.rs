//! A point of light, drawn: a star, or a satellite that stands still.

use crate::images::{Patch, PatchRows, PixelPosition};
use crate::math::vectors::{NullaryFnOnce, widest};

use super::profile::RadialProfile;
use super::tables::ProfileTables;

/// The light of a point in a frame of `rows` by `columns`: `flux` times the profile's average over each pixel.
///
/// The sum over all pixels is `flux` to 10⁻⁵ where the whole profile lies on the frame. Nothing is drawn for a place or a flux that is not
/// finite.
pub fn draw_point(profile: &RadialProfile, at: PixelPosition, flux: f64, rows: usize, columns: usize) -> Patch {
    let parts = profile.parts();
    if !parts.is_whole() {
        let finer = draw_on(profile.tables(), parts.place(at), flux, rows * parts.y, columns * parts.x);
        return finer.summed(parts.x, parts.y);
    }
    draw_on(profile.tables(), at, flux, rows, columns)
}

fn draw_on(profile: &ProfileTables, at: PixelPosition, flux: f64, rows: usize, columns: usize) -> Patch {
    let reach = profile.pixel_reach_pix();
    let mut extents = PatchRows::new(rows, columns);
    if at.x.is_finite() && at.y.is_finite() && flux.is_finite() {
        extents.add_disc(at, reach);
    }
    let mut patch = extents.into_patch();
    widest(Point { profile, at, flux, patch: &mut patch });
    patch
}

/// Pixels at a time.
const LANES: usize = 16;

struct Point<'a> {
    profile: &'a ProfileTables,
    at: PixelPosition,
    flux: f64,
    patch: &'a mut Patch,
}

impl NullaryFnOnce for Point<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { profile, at, flux, patch } = self;
        patch.fill(
            #[inline(always)]
            |row, first_column, values| {
                let dy = [(row as f64 - at.y) as f32; LANES];
                let is_round = f64::from(dy[0].abs()) > profile.round_from_pix();
                for (block, out) in values.chunks_mut(LANES).enumerate() {
                    let first = ((first_column + block * LANES) as f64 - at.x) as f32;
                    let dx: [f32; LANES] = std::array::from_fn(|lane| first + lane as f32);
                    let shares = profile.pixels(&dx, &dy, is_round);
                    for (value, share) in out.iter_mut().zip(shares) {
                        *value = share * flux as f32;
                    }
                }
            },
        );
    }
}
