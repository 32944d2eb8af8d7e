//! Pixels that a program divided by the largest count, beside a gain that is still that of counts.

use crate::error::Error;
use crate::images::{FrameFile, LightArea};
use crate::math::scatter::scatter;

/// Approximate number of rows that are read, and of pixels that are used.
const ROWS: usize = 64;
const PIXELS: usize = 100_000;
/// Largest value of fractions, with rounding.
const LARGEST: f64 = 1.0 + 1e-6;
/// Largest ratio of the variance of the sky to that of its photons by the gain, and largest noise of a pixel, electrons,
/// for which the gain is that of other pixels.
const LEAST_VARIANCE: f64 = 0.01;
const LEAST_NOISE_E: f64 = 0.1;

/// Returns true if the illuminated pixels are fractions of a largest count, and the gain is that of counts: no value is
/// above 1, and the noise is far below that of the photons of the sky, √(sky / gain), or below a tenth of an electron.
///
/// # Errors
/// The pixels cannot be read.
pub fn are_fractions(file: &FrameFile, hdu: usize, area: &LightArea, electrons_per_unit: f64) -> Result<bool, Error> {
    let rows = area.rows.clone().step_by((area.rows.len() / ROWS).max(1));
    let [_, columns] = file.image_size(hdu)?;
    let pixels = file.read_rows(hdu, rows)?;
    let lit = pixels.chunks(columns.max(1)).flat_map(|row| &row[area.columns.clone()]).copied();
    let known: Vec<f64> = lit.filter(|value| value.is_finite()).collect();
    if known.iter().any(|value| *value > LARGEST) {
        return Ok(false);
    }
    let step = known.len().div_ceil(PIXELS).max(1);
    let mut sample: Vec<f32> = known.iter().step_by(step).map(|value| *value as f32).collect();
    Ok(scatter(&mut sample).is_some_and(|found| {
        let (sky, noise) = (f64::from(found.middle), f64::from(found.sigma));
        let is_below_photons = noise.powi(2) < LEAST_VARIANCE * sky.max(0.0) / electrons_per_unit;
        noise > 0.0 && (is_below_photons || noise * electrons_per_unit < LEAST_NOISE_E)
    }))
}
