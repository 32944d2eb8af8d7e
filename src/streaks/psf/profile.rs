//! Light of a point in the pixels of a detector.

use crate::error::Error;
use crate::math::quadrature::gauss_legendre;

use super::blur::Blur;
use super::convolve::blurred;
use super::curve::Curve;
use super::layers::Layer;

/// Smallest accepted ratio of the sides of a pixel.
const LEAST_ASPECT: f64 = 0.4;
/// Smallest ratio of the FWHM of the seeing to the side of a part of a pixel. At this ratio, the average over a square
/// part is isotropic to 4·10⁻⁴ of the peak.
const PARTS_PER_FWHM: f64 = 2.5;
/// Largest radius of a profile in parts of pixels, which limits memory and time. If the seeing is narrower than 1/200
/// of the radius (sharp rings of hundreds of pixels), this makes parts wider than [`PARTS_PER_FWHM`] requires, and the
/// pixels of a point are accurate to only about 2 % of the peak.
const MOST_REACH_PARTS: f64 = 500.0;

/// Image of a point of unit flux on the detector, round on the sky and averaged over the area of each pixel.
///
/// If the seeing is narrower than 2.5 pixels, each pixel is divided into parts, whose light is summed. The stored
/// profile is averaged over a square with the shorter side of a part. If parts are oblong, two such profiles side by
/// side approximate the average over the longer side.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialProfile {
    blur: Blur,
    /// Light per area of a mean pixel from a long straight line that emits unit light per mean pixel of length,
    /// averaged over the square described above, as a function of the distance from the line in mean pixels. A mean
    /// pixel is a square with the area of a pixel.
    line: Curve,
    /// Width and height of a pixel in pixels of the mean scale.
    sides_pix: [f64; 2],
    /// Number of parts of a pixel along a row and along a column.
    parts: [usize; 2],
    /// Distances of the two profiles from the centre of an oblong part, in parts.
    shift_parts: [f64; 2],
    layers: Vec<Layer>,
    fwhm_pix: f64,
    reach_pix: f64,
}

impl RadialProfile {
    /// Computes the profile of a blur. This takes about a millisecond for seeing alone and some milliseconds for a
    /// ring.
    ///
    /// # Errors
    /// A number is out of range, the inner radius is too near the outer one, or the wings extend beyond 4000 pixels.
    pub fn new(blur: &Blur) -> Result<Self, Error> {
        Self::on_oblong(blur, 1.0)
    }

    /// Computes the profile on pixels that are `aspect` times as wide (along rows) as high, from 0.4 to 2.5. Lengths of
    /// the blur are in pixels of the mean scale: the side of a square with the area of a pixel.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    pub fn on_oblong(blur: &Blur, aspect: f64) -> Result<Self, Error> {
        blur.validate()?;
        Error::check_range("aspect", aspect, LEAST_ASPECT, 1.0 / LEAST_ASPECT)?;
        let fwhm = blur.seeing.narrowest_fwhm_pix();
        let sides_pix = [aspect.sqrt(), 1.0 / aspect.sqrt()];
        let profile = blurred(blur)?;
        let part_pix = (fwhm / PARTS_PER_FWHM).max(profile.end_pix() / MOST_REACH_PARTS);
        let parts = sides_pix.map(|side| (side / part_pix).ceil().max(1.0) as usize);
        let cell = [0, 1].map(|axis| sides_pix[axis] / parts[axis] as f64);
        let shorter = cell[0].min(cell[1]);
        // The average over a length h adds h²/12 to the variance.
        let shift_parts = cell.map(|side| ((side * side - shorter * shorter) / 12.0).max(0.0).sqrt() / side);
        let core = blur.flat_radius_pix() + 2.0 * fwhm;
        let reach = profile.end_pix() + shorter * std::f64::consts::FRAC_1_SQRT_2;
        let offsets = square(shorter);
        let averaged = Curve::new(core, reach, fwhm, |r| {
            offsets.iter().map(|([x, y], weight)| weight * profile.at((r + x).hypot(*y))).sum()
        });
        // Width of the seeing that remains after averaging over parts.
        let width = PARTS_PER_FWHM * part_pix;
        let step = 0.2 * width;
        let line = Curve::new(core, reach, fwhm, |v| {
            let steps = ((reach * reach - v * v).max(0.0).sqrt() / step) as usize;
            step * (averaged.at(v) + 2.0 * (1..=steps).map(|k| averaged.at(v.hypot(k as f64 * step))).sum::<f64>())
        });
        let layers = Layer::split(&averaged, cell, width);
        let fwhm_pix = full_width(&profile, 0.02 * fwhm);
        let reach_pix = profile.end_pix() / sides_pix[0].min(sides_pix[1]);
        Ok(Self { blur: *blur, line, sides_pix, parts, shift_parts, layers, fwhm_pix, reach_pix })
    }

    /// Returns the blur from which the profile was computed.
    pub fn blur(&self) -> &Blur {
        &self.blur
    }

    /// Returns the light that a long straight line gives to a pixel, for unit light per pixel of length. The line is at
    /// `angle_rad` from the rows, and `across_pix` pixels from the centre of the pixel.
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
                    // Distance from the centre of the pixel, pixels of the mean scale.
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

    /// Returns the length, in pixels of the mean scale, of one pixel measured across a line that is at `angle_rad` from
    /// the rows. It is 1 for square pixels.
    pub fn mean_pixels_across(&self, angle_rad: f64) -> f64 {
        // A pixel has unit area, so the product of the lengths across and along is 1.
        1.0 / self.mean_pixels([angle_rad.cos(), angle_rad.sin()])
    }

    /// Returns the length, in pixels of the mean scale, of a vector given along rows and columns in pixels.
    pub fn mean_pixels(&self, [x, y]: [f64; 2]) -> f64 {
        (x * self.sides_pix[0]).hypot(y * self.sides_pix[1])
    }

    /// Returns the full width at half of the greatest brightness, pixels of the mean scale. For a ring it is measured
    /// at the outer edge.
    pub fn fwhm_pix(&self) -> f64 {
        self.fwhm_pix
    }

    /// Returns the greatest radius of the profile, pixels along the shorter side.
    pub fn reach_pix(&self) -> f64 {
        self.reach_pix
    }

    /// Returns the greatest distance between a point and the centre of a pixel that it illuminates, pixels.
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

/// Returns nodes and weights for the average over a square, as offsets from its centre; the weights sum to 1. The nodes
/// are those of squares at two angles, so that the average has no angular harmonics below the sixteenth.
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
