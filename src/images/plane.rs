//! Pixels: positions, and images as arrays of values.

use super::error::ImagesError;

/// Image of shape (rows, columns), row by row; row 0 is the first row of a FITS file.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
}

impl Plane {
    /// Creates an image of zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, values: vec![0.0; rows * columns] }
    }

    /// Creates an image from values row by row.
    ///
    /// # Errors
    /// A number of values other than rows times columns.
    pub fn from_values(rows: usize, columns: usize, values: Vec<f32>) -> Result<Self, ImagesError> {
        if values.len() != rows * columns {
            let allowed = format!("{} for {rows} rows by {columns} columns", rows * columns);
            return Err(ImagesError::invalid("number of pixels", values.len(), allowed));
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

    /// All values, row by row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Converts the image into its values, row by row.
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// All values, row by row, mutable.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// One row; empty if the index is out of range.
    pub fn row(&self, row: usize) -> &[f32] {
        self.values.get(row * self.columns..(row + 1) * self.columns).unwrap_or(&[])
    }

    /// One row, mutable; empty if the index is out of range.
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        self.values.get_mut(row * self.columns..(row + 1) * self.columns).unwrap_or(&mut [])
    }
}

/// Position in a frame, pixels, counted from 0: the centre of the first pixel of the first row is (0, 0), its corners
/// are at ±0.5.
///
/// FITS headers and DS9 count from 1: [`PixelPosition::fits`] adds 1 to both.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct PixelPosition {
    /// Along a row (FITS axis 1).
    pub x: f64,
    /// Along a column (FITS axis 2).
    pub y: f64,
}

impl PixelPosition {
    /// Creates a position from coordinates counted from 1.
    pub fn from_fits(x: f64, y: f64) -> Self {
        Self { x: x - 1.0, y: y - 1.0 }
    }

    /// Coordinates counted from 1, as in FITS.
    pub fn fits(self) -> [f64; 2] {
        [self.x + 1.0, self.y + 1.0]
    }

    /// Distance to another position, pixels.
    pub fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}
