//! Sky background and noise of a frame in cells, for the search.

use rayon::prelude::*;

use crate::images::{LightArea, Plane};
use crate::math::quantile::quantile;

/// Side of a cell, pixels.
const CELL: usize = 64;
/// Distance of the pixels that are sampled in a cell, along rows and columns.
const STEP: usize = 3;
/// Pixels are clipped to this number of sigmas around the background.
const CLIP_SIGMAS: f32 = 4.0;
/// Ratio of the standard deviation of a normal distribution and its median absolute deviation.
pub const SIGMA_OF_MAD: f64 = 1.482_602_218_505_602;

/// Image relative to its sky background, in units of the noise, and clipped.
///
/// Clipping reduces a star to some four sigmas per pixel, so that it contributes little to the sum along a track, while
/// a bright streak remains far above the noise.
#[derive(Clone, Debug)]
pub struct Background {
    normalised: Plane,
}

impl Background {
    /// Computes the median and the noise in cells of 64 by 64 pixels, subtracts the former and divides by the latter.
    /// Pixels outside the illuminated area or without a value become NaN.
    pub fn new(plane: &Plane, light_area: &LightArea) -> Self {
        let (rows, columns) = (plane.rows(), plane.columns());
        let across = columns.div_ceil(CELL);
        let mut normalised = Plane::zeros(rows, columns);
        let strips: Vec<_> = normalised.values_mut().chunks_mut(CELL * columns).enumerate().collect();
        strips.into_par_iter().for_each(|(strip, values)| {
            let first = strip * CELL;
            for cell in 0..across {
                let range = cell * CELL..((cell + 1) * CELL).min(columns);
                let rows_of_cell = first..(first + CELL).min(rows);
                let Some((middle, sigma)) = cell_statistics(plane, light_area, rows_of_cell.clone(), range.clone())
                else {
                    for row in rows_of_cell {
                        values[(row - first) * columns..][range.clone()].fill(f32::NAN);
                    }
                    continue;
                };
                for row in rows_of_cell {
                    let is_lit_row = light_area.rows.contains(&row);
                    let out = &mut values[(row - first) * columns..][range.clone()];
                    for (offset, (value, pixel)) in out.iter_mut().zip(&plane.row(row)[range.clone()]).enumerate() {
                        let is_lit = is_lit_row && light_area.columns.contains(&(range.start + offset));
                        // NaN stays NaN.
                        let z = (pixel - middle) / sigma;
                        *value = if is_lit { z.clamp(-CLIP_SIGMAS, CLIP_SIGMAS) } else { f32::NAN };
                    }
                }
            }
        });
        Self { normalised }
    }

    /// Returns the normalised image.
    pub fn normalised(&self) -> &Plane {
        &self.normalised
    }
}

/// Returns the median and the noise of the sampled pixels in a cell; `None` without pixels that have a value.
fn cell_statistics(
    plane: &Plane,
    light_area: &LightArea,
    rows: std::ops::Range<usize>,
    columns: std::ops::Range<usize>,
) -> Option<(f32, f32)> {
    let mut values: Vec<f32> = Vec::with_capacity((CELL / STEP + 1).pow(2));
    for row in rows.step_by(STEP).filter(|row| light_area.rows.contains(row)) {
        let lit = columns.clone().step_by(STEP).filter(|column| light_area.columns.contains(column));
        values.extend(lit.map(|column| plane.row(row)[column]).filter(|value| value.is_finite()));
    }
    let middle = median_f32(&mut values)?;
    values.iter_mut().for_each(|value| *value = (*value - middle).abs());
    let sigma = median_f32(&mut values)? * SIGMA_OF_MAD as f32;
    Some((middle, if sigma > 0.0 { sigma } else { 1.0 }))
}

/// Returns a middle value and reorders the values; `None` if there are none.
fn median_f32(values: &mut [f32]) -> Option<f32> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// Returns the median and 1.4826 times the median absolute deviation; NaN without values.
pub fn median_and_sigma(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = quantile(&sorted, 0.5);
    let mut away: Vec<f64> = sorted.iter().map(|value| (value - middle).abs()).collect();
    away.sort_by(f64::total_cmp);
    (middle, SIGMA_OF_MAD * quantile(&away, 0.5))
}
