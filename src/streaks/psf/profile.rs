//! Light of a point on the pixels of a detector.

use crate::math::quadrature::gauss_legendre;

use super::super::error::StreaksError;
use super::blur::Blur;
use super::convolve::blurred;
use super::curve::Curve;
use super::layers::Layer;

/// Least ratio of the sides of pixels.
const LEAST_ASPECT: f64 = 0.4;
/// Least full width at half maximum of the seeing in parts of a pixel: the average over a square of this size is
/// isotropic to 4·10⁻⁴ of the peak.
const PARTS_PER_FWHM: f64 = 2.5;
/// Largest radius of a profile in parts (the subpixels on which narrow seeing is drawn); it limits memory and time. Only if the seeing is narrower than 1/200 of
/// that radius (sharp rings of hundreds of pixels), parts are wider than above, and the pixels of a point are accurate
/// to about 2 % of the peak.
const MOST_REACH_PARTS: f64 = 500.0;

/// Light of a point on the detector: round on the sky, of unit flux, averaged over the area of each pixel.
///
/// Seeing narrower than 2.5 pixels is drawn on parts of a pixel, which are then summed. The profile is stored averaged
/// over the square of the shorter side of a part; if parts are oblong, the mean of two such profiles side by side is
/// the average over the longer side.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialProfile {
    blur: Blur,
    /// Brightness per pixel of a line of unit light by the distance from it, averaged over the square; pixels of the
    /// mean scale.
    line: Curve,
    /// Width and height of a pixel in pixels of the mean scale.
    sides_pix: [f64; 2],
    /// Parts of a pixel along a row, and along a column.
    parts: [usize; 2],
    /// Distance from the centre of a part to both profiles, parts.
    shift_parts: [f64; 2],
    layers: Vec<Layer>,
    fwhm_pix: f64,
    reach_pix: f64,
}

impl RadialProfile {
    /// Computes the profile of a blur: in about a millisecond for seeing alone, in some milliseconds for a ring.
    ///
    /// # Errors
    /// A number out of range, an inner radius too near to the outer one, wings beyond 4000 pixels.
    pub fn of(blur: &Blur) -> Result<Self, StreaksError> {
        Self::on_oblong(blur, 1.0)
    }

    /// Computes the profile on pixels `aspect` times as wide (along rows) as high, within [0.4, 2.5]. Lengths of the
    /// blur are in pixels of the mean scale, the side of a square of the same area.
    ///
    /// # Errors
    /// The errors of [`of`](Self::of).
    pub fn on_oblong(blur: &Blur, aspect: f64) -> Result<Self, StreaksError> {
        blur.validate()?;
        StreaksError::check_range("aspect", aspect, LEAST_ASPECT, 1.0 / LEAST_ASPECT)?;
        let fwhm = blur.seeing.narrowest_fwhm_pix();
        let sides_pix = [aspect.sqrt(), 1.0 / aspect.sqrt()];
        let profile = blurred(blur)?;
        let part_pix = (fwhm / PARTS_PER_FWHM).max(profile.end_pix() / MOST_REACH_PARTS);
        let parts = sides_pix.map(|side| (side / part_pix).ceil().max(1.0) as usize);
        let cell = [0, 1].map(|axis| sides_pix[axis] / parts[axis] as f64);
        let shorter = cell[0].min(cell[1]);
        // A box of side h has a variance of h²/12.
        let shift_parts = cell.map(|side| ((side * side - shorter * shorter) / 12.0).max(0.0).sqrt() / side);
        let core = blur.flat_radius_pix() + 2.0 * fwhm;
        let reach = profile.end_pix() + shorter * std::f64::consts::FRAC_1_SQRT_2;
        let offsets = square(shorter);
        let averaged = Curve::of(core, reach, fwhm, |r| {
            offsets.iter().map(|([x, y], weight)| weight * profile.at((r + x).hypot(*y))).sum()
        });
        // Width that remains of the seeing after averaging over parts.
        let width = PARTS_PER_FWHM * part_pix;
        let step = 0.2 * width;
        let line = Curve::of(core, reach, fwhm, |v| {
            let steps = ((reach * reach - v * v).max(0.0).sqrt() / step) as usize;
            step * (averaged.at(v) + 2.0 * (1..=steps).map(|k| averaged.at(v.hypot(k as f64 * step))).sum::<f64>())
        });
        let layers = Layer::split(&averaged, cell, width);
        let fwhm_pix = full_width(&profile, 0.02 * fwhm);
        let reach_pix = profile.end_pix() / sides_pix[0].min(sides_pix[1]);
        Ok(Self { blur: *blur, line, sides_pix, parts, shift_parts, layers, fwhm_pix, reach_pix })
    }

    /// Blur of the profile.
    pub fn blur(&self) -> &Blur {
        &self.blur
    }

    /// Returns the light in a pixel of a long straight line of unit light per pixel of its length, at `angle_rad` from
    /// the rows and a distance from the centre of the pixel.
    pub fn line(&self, across_pix: f64, angle_rad: f64) -> f64 {
        let per_pix = self.mean_pixels_across(angle_rad);
        let [cos, sin] =
            [angle_rad.cos() * self.sides_pix[0], angle_rad.sin() * self.sides_pix[1]].map(|side| side * per_pix);
        let parts = self.parts.map(|count| count as f64);
        let sides: &[f64] = if self.shift_parts == [0.0; 2] { &[0.0] } else { &[-1.0, 1.0] };
        let mut sum = 0.0;
        for row in 0..self.parts[1] {
            for column in 0..self.parts[0] {
                for side in sides {
                    // Distance from the centre of the pixel, mean pixels.
                    let [x, y] = [0, 1].map(|axis| {
                        let position = [column, row][axis] as f64 + 0.5 + side * self.shift_parts[axis];
                        (position / parts[axis] - 0.5) * self.sides_pix[axis]
                    });
                    sum += self.line.at((across_pix * per_pix + x * sin - y * cos).abs());
                }
            }
        }
        per_pix * sum / (parts[0] * parts[1] * sides.len() as f64)
    }

    /// Returns the length in pixels of the mean scale of one pixel across a line at `angle_rad` from the rows on the
    /// sky: 1 for square pixels.
    pub fn mean_pixels_across(&self, angle_rad: f64) -> f64 {
        // Areas are conserved: across times along is 1.
        1.0 / self.mean_pixels([angle_rad.cos(), angle_rad.sin()])
    }

    /// Returns the length of a vector along rows and columns, in pixels of the mean scale.
    pub fn mean_pixels(&self, [x, y]: [f64; 2]) -> f64 {
        (x * self.sides_pix[0]).hypot(y * self.sides_pix[1])
    }

    /// Full width at half of the greatest brightness, pixels of the mean scale; for a ring, that of its outer edge.
    pub fn fwhm_pix(&self) -> f64 {
        self.fwhm_pix
    }

    /// Greatest radius of the profile, pixels along the shorter side.
    pub fn reach_pix(&self) -> f64 {
        self.reach_pix
    }

    /// Greatest distance of an illuminated pixel from a point, pixels.
    pub fn pixel_reach_pix(&self) -> f64 {
        self.reach_pix + std::f64::consts::FRAC_1_SQRT_2
    }

    pub(super) fn layers(&self) -> &[Layer] {
        &self.layers
    }

    pub(super) fn parts(&self) -> [usize; 2] {
        self.parts
    }

    pub(super) fn shift_parts(&self) -> [f64; 2] {
        self.shift_parts
    }
}

/// Returns the nodes of a square, as offsets from its centre, with weights that sum to 1, at two angles: the average
/// over both has no harmonics below the sixteenth.
fn square(side: f64) -> Vec<([f64; 2], f64)> {
    let rule = gauss_legendre(4);
    let mut nodes = Vec::new();
    for eighths in [0.5, 1.5] {
        let (sin, cos) = (eighths * std::f64::consts::FRAC_PI_8).sin_cos();
        for (x, wx) in &rule {
            for (y, wy) in &rule {
                let [x, y] = [x - 0.5, y - 0.5].map(|share| share * side);
                nodes.push(([x * cos - y * sin, x * sin + y * cos], 0.5 * wx * wy));
            }
        }
    }
    nodes
}

/// Returns twice the greatest radius at which a profile is half as bright as its maximum.
fn full_width(profile: &Curve, step_pix: f64) -> f64 {
    let half = 0.5 * profile.greatest();
    let mut outside = profile.end_pix();
    while profile.at(outside - step_pix) < half {
        outside -= step_pix;
    }
    let mut bounds = [outside - step_pix, outside];
    for _ in 0..40 {
        let middle = 0.5 * (bounds[0] + bounds[1]);
        bounds[usize::from(profile.at(middle) < half)] = middle;
    }
    bounds[0] + bounds[1]
}
