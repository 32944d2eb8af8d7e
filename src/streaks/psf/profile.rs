//! A point's light on the pixels of a detector.

use crate::math::quadrature::gauss_legendre;

use super::blur::{Blur, BlurError};
use super::convolve::blurred;
use super::curve::Curve;
use super::layers::Layer;

/// Least ratio of the sides of pixels that is drawn.
const LEAST_ASPECT: f64 = 0.4;
/// Parts of a pixel in the seeing's full width at half maximum, at least: the average over a square of this size is the same in all
/// directions to 4·10⁻⁴ of the peak.
const PARTS_PER_FWHM: f64 = 2.5;

/// A point's light on the detector: round on the sky, of unit flux, each pixel with the average over its square (or rectangle), never the value at its middle.
///
/// Seeing narrower than 2.5 pixels is drawn on parts of a pixel, which are then summed. The profile is kept averaged over the square of
/// a part's shorter side; where parts are oblong, the mean of two such profiles beside each other has the average over the longer one.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialProfile {
    blur: Blur,
    /// Surface brightness, and its average over a part; pixels of the mean scale.
    profile: Curve,
    averaged: Curve,
    /// Brightness of a line of unit light per pixel by the distance from it, averaged likewise.
    line: Curve,
    /// Width and height of a pixel in pixels of the mean scale.
    sides_pix: [f64; 2],
    /// Parts of a pixel along a row, and along a column.
    parts: [usize; 2],
    /// From the centre of a part to both profiles, parts.
    shift_parts: [f64; 2],
    layers: Vec<Layer>,
    fwhm_pix: f64,
}

impl RadialProfile {
    /// The profile of a blur; takes from half a millisecond (seeing alone) to some milliseconds (a ring many pixels wide).
    ///
    /// # Errors
    /// As in [`BlurError`]: a number outside its range, a hole as large as its ring, wings beyond 4000 pixels.
    pub fn of(blur: &Blur) -> Result<Self, BlurError> {
        Self::on_oblong(blur, 1.0)
    }

    /// The same on pixels `aspect` times as wide (along rows) as high, within [0.4, 2.5]; lengths of the blur are in pixels of the mean scale, a side of a square of
    /// the same area.
    ///
    /// # Errors
    /// As in [`BlurError`].
    pub fn on_oblong(blur: &Blur, aspect: f64) -> Result<Self, BlurError> {
        blur.validate()?;
        BlurError::hold("aspect", aspect, LEAST_ASPECT, 1.0 / LEAST_ASPECT)?;
        let fwhm = blur.seeing.narrowest_fwhm_pix();
        let sides_pix = [aspect.sqrt(), 1.0 / aspect.sqrt()];
        let parts = sides_pix.map(|side| (PARTS_PER_FWHM * side / fwhm).ceil().max(1.0) as usize);
        let cell = [0, 1].map(|axis| sides_pix[axis] / parts[axis] as f64);
        let shorter = cell[0].min(cell[1]);
        // A box of side h has a variance of h²/12.
        let shift_parts = cell.map(|side| ((side * side - shorter * shorter) / 12.0).max(0.0).sqrt() / side);
        let profile = blurred(blur)?;
        let core = blur.flat_radius_pix() + 2.0 * fwhm;
        let intervals = (48.0 * core / (0.425 * fwhm)).ceil().clamp(256.0, 8192.0) as usize;
        let reach = profile.end_pix() + shorter * std::f64::consts::FRAC_1_SQRT_2;
        let offsets = square(shorter);
        let averaged = Curve::of(core, reach, intervals, |r| {
            offsets.iter().map(|([x, y], weight)| weight * profile.at((r + x).hypot(*y))).sum()
        });
        let step = 0.2 * fwhm;
        let line = Curve::of(core, reach, intervals, |v| {
            let steps = ((reach * reach - v * v).max(0.0).sqrt() / step) as usize;
            step * (averaged.at(v) + 2.0 * (1..=steps).map(|k| averaged.at(v.hypot(k as f64 * step))).sum::<f64>())
        });
        let layers = Layer::split(&averaged, cell, fwhm, blur.seeing.step_pix());
        let fwhm_pix = full_width(&profile, 0.02 * fwhm);
        Ok(Self { blur: *blur, profile, averaged, line, sides_pix, parts, shift_parts, layers, fwhm_pix })
    }

    /// What it was made of.
    pub fn blur(&self) -> &Blur {
        &self.blur
    }

    /// Surface brightness at a distance from the centre in pixels of the mean scale, per pixel.
    pub fn at(&self, r_pix: f64) -> f64 {
        self.profile.at(r_pix.abs())
    }

    /// Share of the light in a pixel whose centre lies this far from the profile's.
    pub fn pixel(&self, dx_pix: f64, dy_pix: f64) -> f64 {
        let [dx, dy] = [dx_pix * self.sides_pix[0], dy_pix * self.sides_pix[1]];
        self.mean(|[x, y]| self.averaged.at((dx + x).hypot(dy + y)))
    }

    /// Light in a pixel of a long straight line of unit light per pixel of its length, at `angle_rad` from the rows, that passes the pixel's
    /// centre at a distance.
    pub fn line(&self, across_pix: f64, angle_rad: f64) -> f64 {
        let per_pix = self.mean_pixels_across(angle_rad);
        let [cos, sin] =
            [angle_rad.cos() * self.sides_pix[0], angle_rad.sin() * self.sides_pix[1]].map(|side| side * per_pix);
        per_pix * self.mean(|[x, y]| self.line.at((across_pix * per_pix + x * sin - y * cos).abs()))
    }

    /// A length of one pixel across a line at `angle_rad` from the rows, in pixels of the mean scale across it on the sky: 1 where pixels are squares.
    pub fn mean_pixels_across(&self, angle_rad: f64) -> f64 {
        // Areas are kept: across times along.
        1.0 / self.mean_pixels([angle_rad.cos(), angle_rad.sin()])
    }

    /// A way along rows and columns, in pixels of the mean scale.
    pub fn mean_pixels(&self, [x, y]: [f64; 2]) -> f64 {
        (x * self.sides_pix[0]).hypot(y * self.sides_pix[1])
    }

    /// Full width at half of the greatest brightness, pixels of the mean scale; of a ring, its outer edges'.
    pub fn fwhm_pix(&self) -> f64 {
        self.fwhm_pix
    }

    /// Where the profile ends, pixels along the shorter side.
    pub fn reach_pix(&self) -> f64 {
        self.profile.end_pix() / self.sides_pix[0].min(self.sides_pix[1])
    }

    /// How far from its centre a point puts light into pixels, pixels.
    pub fn pixel_reach_pix(&self) -> f64 {
        self.reach_pix() + std::f64::consts::FRAC_1_SQRT_2
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

    /// Mean of a function of places about the centre of a pixel, pixels of the mean scale: over its parts and the profiles of each.
    fn mean(&self, function: impl Fn([f64; 2]) -> f64) -> f64 {
        let [columns, rows] = self.parts;
        let offset = |axis: usize, number: usize, side: f64| {
            let count = self.parts[axis] as f64;
            (number as f64 + 0.5 + side * self.shift_parts[axis] - 0.5 * count) * self.sides_pix[axis] / count
        };
        let sides: &[f64] = if self.shift_parts == [0.0; 2] { &[0.0] } else { &[-1.0, 1.0] };
        let places = (0..rows)
            .flat_map(|row| (0..columns).flat_map(move |column| sides.iter().map(move |side| (row, column, *side))));
        let sum: f64 =
            places.map(|(row, column, side)| function([offset(0, column, side), offset(1, row, side)])).sum();
        sum / (columns * rows * sides.len()) as f64
    }
}

/// Nodes of a square of a side, offsets from its centre and weights that sum to 1, at two angles: with both the average has no harmonics
/// below the sixteenth.
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

/// Twice the greatest radius at which a profile is half as bright as its maximum.
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
