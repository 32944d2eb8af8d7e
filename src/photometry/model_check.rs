//! Checks of the values of a model file.

use super::error::PhotometryError;

/// Checks of the values of one file.
pub(super) struct Check<'a> {
    /// Name of the file.
    pub origin: &'a str,
}

impl Check<'_> {
    pub fn range(&self, key: &str, given: f64, least: f64, greatest: f64) -> Result<(), PhotometryError> {
        // NaN is in no range.
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(PhotometryError::ModelOutOfRange {
            origin: self.origin.to_owned(),
            key: key.to_owned(),
            given,
            least,
            greatest,
        })
    }

    /// Holds a number of items to its range.
    pub fn count(&self, key: &str, given: usize, least: usize, greatest: usize) -> Result<(), PhotometryError> {
        self.range(&format!("{key}: number"), given as f64, least as f64, greatest as f64)
    }

    /// Error for an undefined name.
    pub fn reference(&self, key: &str, given: &str, allowed: String) -> PhotometryError {
        PhotometryError::ModelReference {
            origin: self.origin.to_owned(),
            key: key.to_owned(),
            given: given.to_owned(),
            allowed,
        }
    }

    pub fn text(&self, key: &'static str, given: &str, allowed: &'static str) -> PhotometryError {
        PhotometryError::ModelText { origin: self.origin.to_owned(), key, given: given.to_owned(), allowed }
    }

    pub fn filled(&self, key: &'static str, given: &str) -> Result<(), PhotometryError> {
        if given.trim().is_empty() { Err(self.text(key, given, "any text that is not empty")) } else { Ok(()) }
    }

    pub fn name(&self, key: &'static str, given: &str) -> Result<(), PhotometryError> {
        let letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '.' || c == '-';
        if (1..=64).contains(&given.len()) && given.chars().all(letter) {
            return Ok(());
        }
        Err(self.text(key, given, "1 to 64 lower-case letters, digits, '.' and '-'"))
    }

    pub fn covariance(&self, matrix: &[Vec<f64>], size: usize) -> Result<(), PhotometryError> {
        let error =
            |problem: String| PhotometryError::ModelCovariance { origin: self.origin.to_owned(), size, problem };
        if matrix.len() != size {
            return Err(error(format!("it has {} rows", matrix.len())));
        }
        if let Some((i, row)) = matrix.iter().enumerate().find(|(_, row)| row.len() != size) {
            return Err(error(format!("row {i} has {} columns", row.len())));
        }
        for (i, row) in matrix.iter().enumerate() {
            for (j, (&value, mirrored)) in row.iter().zip(matrix.iter().map(|row| row[i])).enumerate() {
                if !value.is_finite() || (i == j && value < 0.0) {
                    return Err(error(format!("element [{i}][{j}] is {value}")));
                }
                if (value - mirrored).abs() > 1e-9 * value.abs().max(mirrored.abs()) {
                    return Err(error(format!("element [{i}][{j}] is {value}, [{j}][{i}] is {mirrored}")));
                }
            }
        }
        Ok(())
    }
}
