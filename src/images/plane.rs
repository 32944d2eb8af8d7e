//! Pixels: positions, and planes of values.

use super::error::ImagesError;

/// An image, shape (rows, columns), row after row, the row that FITS holds first at index 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
}

impl Plane {
    /// All zero.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, values: vec![0.0; rows * columns] }
    }

    /// From values row after row.
    ///
    /// # Errors
    /// [`ImagesError::PlaneShape`] where their number is not rows times columns.
    pub fn from_values(rows: usize, columns: usize, values: Vec<f32>) -> Result<Self, ImagesError> {
        if values.len() != rows * columns {
            return Err(ImagesError::PlaneShape { rows, columns, given: values.len() });
        }
        Ok(Self { rows, columns, values })
    }

    /// Number of rows (NAXIS2).
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns (NAXIS1).
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All values, row after row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// All values, row after row, out of the plane.
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// All values, row after row, to be changed.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// One row; empty where there is none of this number.
    pub fn row(&self, row: usize) -> &[f32] {
        self.values.get(row * self.columns..(row + 1) * self.columns).unwrap_or(&[])
    }

    /// One row, to be changed; empty where there is none of this number.
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        self.values.get_mut(row * self.columns..(row + 1) * self.columns).unwrap_or(&mut [])
    }
}

/// A place in a frame, pixels, counted from 0: the centre of the first pixel of the first row is (0, 0), its corners at ±0.5.
///
/// FITS headers, DS9 and most people count from 1: add 1 to both for them ([`PixelPosition::fits`]).
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct PixelPosition {
    /// Along a row (FITS axis 1).
    pub x: f64,
    /// Along a column (FITS axis 2).
    pub y: f64,
}

impl PixelPosition {
    /// From coordinates counted from 1.
    pub fn from_fits(x: f64, y: f64) -> Self {
        Self { x: x - 1.0, y: y - 1.0 }
    }

    /// Coordinates counted from 1, as FITS counts.
    pub fn fits(self) -> [f64; 2] {
        [self.x + 1.0, self.y + 1.0]
    }

    /// Distance to another place, pixels.
    pub fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}
