//! Noise of a frame in cells, relative to which the light of a streak is marked in masks.

use crate::error::Error;
use crate::images::LightArea;

/// Side of a cell, pixels.
const CELL: usize = 64;
/// Distance of the rows from which the noise is computed.
const ROW_STEP: usize = 4;
/// Distance of the pixels of these rows. A cell then has 512 values, and its noise an error of 5 %, which the median of
/// the neighbours reduces.
const COLUMN_STEP: usize = 2;
/// Fewest pixels with a value in a cell whose noise is computed.
const FEWEST_PIXELS: usize = 32;
/// Ratio of the standard deviation of a normal distribution and its median absolute deviation.
const SIGMA_OF_MAD: f32 = 1.4826;

/// Standard deviation of the pixels of a frame in cells of 64 by 64 pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseMap {
    /// Number of cells in a row of cells.
    across: usize,
    sigmas: Vec<f32>,
}

impl NoiseMap {
    /// Creates a map with the same noise everywhere; 0 for a frame without noise.
    pub fn uniform(sigma: f32) -> Self {
        Self { across: 0, sigmas: vec![sigma] }
    }

    /// Computes the noise of a chip from every fourth illuminated row. `read` returns the pixels of the rows of a row
    /// of cells, one row after the other, each with all `columns`. Pixels without a value are NaN.
    ///
    /// The noise of a cell is 1.4826 times the median absolute deviation from a plane through the medians of its
    /// halves, which a gradient of the sky, stars and streaks hardly change; then the median of the cell and its
    /// neighbours is used. Cells without pixels or without noise have the median noise of the others.
    ///
    /// # Errors
    /// The errors of `read`.
    pub fn new(
        light_area: &LightArea,
        columns: usize,
        mut read: impl FnMut(&[usize]) -> Result<Vec<f64>, Error>,
    ) -> Result<Self, Error> {
        let across = columns.div_ceil(CELL).max(1);
        let down = light_area.rows.end.div_ceil(CELL).max(1);
        let mut cells: Vec<Vec<[f32; 3]>> = vec![Vec::new(); across];
        let mut sigmas = vec![0.0; across * down];
        let rows: Vec<usize> = light_area.rows.clone().step_by(ROW_STEP).collect();
        for rows in rows.chunk_by(|a, b| a / CELL == b / CELL) {
            for (row, pixels) in rows.iter().zip(read(rows)?.chunks(columns.max(1))) {
                for column in light_area.columns.clone().step_by(COLUMN_STEP) {
                    let value = pixels[column] as f32;
                    if value.is_finite() {
                        cells[column / CELL].push([column as f32, *row as f32, value]);
                    }
                }
            }
            for (cell, sigma) in cells.iter_mut().zip(&mut sigmas[rows[0] / CELL * across..]) {
                *sigma = noise_of_cell(cell);
                cell.clear();
            }
        }
        let mut known: Vec<f32> = sigmas.iter().copied().filter(|sigma| *sigma > 0.0).collect();
        let usual = median(&mut known);
        sigmas.iter_mut().filter(|sigma| **sigma <= 0.0).for_each(|sigma| *sigma = usual);
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let smooth = |cell: usize| {
            let rows = near(cell / across, down);
            let mut around: Vec<f32> = rows
                .flat_map(|row| near(cell % across, across).map(move |column| row * across + column))
                .map(|other| sigmas[other])
                .collect();
            median(&mut around)
        };
        Ok(Self { across, sigmas: (0..sigmas.len()).map(smooth).collect() })
    }

    /// Returns the standard deviation of the pixels near a pixel; 0 for a frame without noise.
    pub fn at(&self, row: usize, column: usize) -> f32 {
        match self.sigmas[..] {
            [sigma] => sigma,
            _ => self.sigmas.get(row / CELL * self.across + column / CELL).copied().unwrap_or(0.0),
        }
    }

    /// Returns true if the frame has noise.
    pub fn is_noisy(&self) -> bool {
        self.sigmas.iter().any(|sigma| *sigma > 0.0)
    }
}

/// Returns the noise of a cell from its pixels: column, row, value. 0 if there are too few.
fn noise_of_cell(pixels: &[[f32; 3]]) -> f32 {
    if pixels.len() < FEWEST_PIXELS {
        return 0.0;
    }
    let slopes = [0, 1].map(|axis| {
        let middle = pixels.iter().map(|pixel| f64::from(pixel[axis])).sum::<f64>() / pixels.len() as f64;
        let half = |is_upper: bool| {
            let of_half = pixels.iter().filter(|pixel| (f64::from(pixel[axis]) >= middle) == is_upper);
            let (places, mut values): (Vec<f32>, Vec<f32>) = of_half.map(|pixel| (pixel[axis], pixel[2])).unzip();
            let place = places.iter().sum::<f32>() / places.len().max(1) as f32;
            (place, median(&mut values))
        };
        let ((low, below), (high, above)) = (half(false), half(true));
        if high > low { (above - below) / (high - low) } else { 0.0 }
    });
    let mut rest: Vec<f32> =
        pixels.iter().map(|[column, row, value]| value - slopes[0] * column - slopes[1] * row).collect();
    let centre = median(&mut rest);
    rest.iter_mut().for_each(|value| *value = (*value - centre).abs());
    SIGMA_OF_MAD * median(&mut rest)
}

/// Returns a middle value and reorders the values; 0 if there are none.
fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the map of a chip of 200 by 300 pixels, with a value for each row and column.
    fn map(value: impl Fn(usize, usize) -> f64) -> NoiseMap {
        let area = LightArea { rows: 0..200, columns: 0..300 };
        let read = |rows: &[usize]| {
            let pixels = rows.iter().flat_map(|row| (0..300).map(move |column| (*row, column)));
            Ok(pixels.map(|(row, column)| value(row, column)).collect())
        };
        NoiseMap::new(&area, 300, read).unwrap()
    }

    /// Values from -1 to 1 in no order, whose median absolute deviation is 0.5.
    fn scattered(row: usize, column: usize) -> f64 {
        ((row * 7919 + column * 104_729) % 2001) as f64 / 1000.0 - 1.0
    }

    #[test]
    fn verif_noise_is_local_and_free_of_gradients() {
        // Noise of 3 on the left and 30 on the right, on a gradient of 2,000 counts.
        let noise = |column: usize| if column < 150 { 3.0 } else { 30.0 };
        let tilted = map(|row, column| 5.0 * row as f64 + 6.7 * column as f64 + noise(column) * scattered(row, column));
        for (column, expected) in [(20, 1.4826 * 1.5), (280, 1.4826 * 15.0)] {
            let sigma = f64::from(tilted.at(100, column));
            assert!((sigma / expected - 1.0).abs() < 0.1, "{column}: {sigma}");
        }
        let starry = map(|row, column| if row % 64 < 12 && column % 64 < 12 { 1e6 } else { scattered(row, column) });
        assert!((starry.at(30, 30) - 0.74).abs() < 0.1, "{}", starry.at(30, 30));
        assert!(!map(|_, _| 5.0).is_noisy());
        assert!(!map(|_, _| f64::NAN).is_noisy());
        // A part without values has the noise of the rest.
        let half = map(|row, column| if column < 128 { f64::NAN } else { scattered(row, column) });
        assert!((half.at(10, 10) - 0.74).abs() < 0.1, "{}", half.at(10, 10));
    }
}
