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

/// Sky background and noise of a frame in cells of 64 by 64 pixels.
#[derive(Clone, Debug)]
pub struct Background {
    light_area: LightArea,
    /// Number of cells in a row of cells.
    across: usize,
    /// Median and noise of each cell; `None` without pixels that have a value.
    cells: Vec<Option<(f32, f32)>>,
    /// Noise of pixels that a companion plane states, relative to the noise of the cells; `None` if none is used.
    pub(super) stated_ratio: Option<f64>,
}

impl Background {
    /// Computes the median and the noise in cells from the illuminated pixels that have a value.
    pub fn new(plane: &Plane, light_area: &LightArea) -> Self {
        let (rows, columns) = (plane.rows(), plane.columns());
        let (down, across) = (rows.div_ceil(CELL), columns.div_ceil(CELL));
        let within = |cell: usize, count: usize| cell * CELL..((cell + 1) * CELL).min(count);
        let statistics = |cell: usize| {
            cell_statistics(plane, light_area, within(cell / across, rows), within(cell % across, columns))
        };
        let cells = (0..down * across).into_par_iter().map(statistics).collect();
        Self { light_area: light_area.clone(), across, cells, stated_ratio: None }
    }

    /// Returns the noise of the cell of a pixel; `None` without pixels that have a value.
    pub(super) fn noise(&self, row: usize, column: usize) -> Option<f64> {
        self.cells[row / CELL * self.across + column / CELL].map(|(_, sigma)| f64::from(sigma))
    }

    /// Returns the value of a pixel relative to the sky background, in units of the noise, and clipped; NaN outside the
    /// illuminated area and for NaN.
    ///
    /// Clipping reduces a star to some four sigmas per pixel, so that it contributes little to the sum along a track,
    /// while a bright streak remains far above the noise.
    pub(super) fn normalised(&self, row: usize, column: usize, value: f32) -> f32 {
        let is_lit = self.light_area.rows.contains(&row) && self.light_area.columns.contains(&column);
        match self.cells[row / CELL * self.across + column / CELL] {
            Some((middle, sigma)) if is_lit => ((value - middle) / sigma).clamp(-CLIP_SIGMAS, CLIP_SIGMAS),
            _ => f32::NAN,
        }
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
