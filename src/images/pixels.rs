//! Images as arrays of values, and positions in a frame.

use crate::error::Error;

/// Image of shape (rows, columns), stored row by row. Row 0 is the first row of a FITS file.
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

    /// Creates an image from values, given row by row.
    ///
    /// # Errors
    /// The number of values is not `rows` times `columns`.
    pub fn from_values(rows: usize, columns: usize, values: Vec<f32>) -> Result<Self, Error> {
        if values.len() != rows * columns {
            let allowed = format!("{} for {rows} rows by {columns} columns", rows * columns);
            return Err(Error::invalid("number of pixels", values.len(), allowed));
        }
        Ok(Self { rows, columns, values })
    }

    /// Returns the number of rows (NAXIS2).
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns (NAXIS1).
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns all values, row by row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Converts the image into its values, row by row.
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// Returns all values for modification, row by row.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Returns one row; empty if the index is out of range.
    pub fn row(&self, row: usize) -> &[f32] {
        self.values.get(row * self.columns..(row + 1) * self.columns).unwrap_or(&[])
    }

    /// Returns one row for modification; empty if the index is out of range.
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        self.values.get_mut(row * self.columns..(row + 1) * self.columns).unwrap_or(&mut [])
    }
}

/// Position in a frame, pixels, counted from 0. The centre of the first pixel of the first row is (0, 0), and its
/// corners are at ±0.5.
///
/// FITS headers and DS9 count from 1: [`PixelPosition::fits`] returns such coordinates.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct PixelPosition {
    /// Coordinate along a row (FITS axis 1).
    pub x: f64,
    /// Coordinate along a column (FITS axis 2).
    pub y: f64,
}

impl PixelPosition {
    /// Creates a position from coordinates counted from 1.
    pub fn from_fits(x: f64, y: f64) -> Self {
        Self { x: x - 1.0, y: y - 1.0 }
    }

    /// Returns the coordinates counted from 1, as in FITS.
    pub fn fits(self) -> [f64; 2] {
        [self.x + 1.0, self.y + 1.0]
    }

    /// Returns the distance to another position, pixels.
    pub fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}
