//! Checks of the values in model files.

use crate::error::Error;
use crate::message::Quoted;

/// Version of the model file schema that is supported.
pub const SCHEMA_VERSION: u32 = 1;

/// Checks of the values in one model file.
pub(super) struct Check<'a> {
    /// Name of the file.
    pub origin: &'a str,
}

impl Check<'_> {
    pub fn range(&self, key: &str, given: f64, least: f64, greatest: f64) -> Result<(), Error> {
        // NaN is outside every range.
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(self.error(Error::invalid(key.to_owned(), given, format!("{least} to {greatest}"))))
    }

    /// Puts the name of the file before an error.
    fn error(&self, error: Error) -> Error {
        error.in_file("model file", self.origin)
    }

    /// Checks that a number of items is within a range.
    pub fn count(&self, key: &str, given: usize, least: usize, greatest: usize) -> Result<(), Error> {
        self.range(&format!("{key}: number"), given as f64, least as f64, greatest as f64)
    }

    /// Returns the error for a name that is not defined.
    pub fn reference(&self, key: &str, given: &str, allowed: String) -> Error {
        self.error(Error::invalid(key.to_owned(), format_args!("{:?}", Quoted::new(given)), allowed))
    }

    pub fn text(&self, key: &'static str, given: &str, allowed: &'static str) -> Error {
        self.reference(key, given, allowed.to_owned())
    }

    pub fn filled(&self, key: &'static str, given: &str) -> Result<(), Error> {
        if given.trim().is_empty() { Err(self.text(key, given, "any text that is not empty")) } else { Ok(()) }
    }

    pub fn name(&self, key: &'static str, given: &str) -> Result<(), Error> {
        let letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '.' || c == '-';
        if (1..=64).contains(&given.len()) && given.chars().all(letter) {
            return Ok(());
        }
        Err(self.text(key, given, "1 to 64 lower-case letters, digits, '.' and '-'"))
    }

    pub fn covariance(&self, matrix: &[Vec<f64>], size: usize) -> Result<(), Error> {
        let error = |problem: String| {
            let allowed = format!(
                "a finite, symmetric matrix of {size} x {size} (the parameters in their order) with a diagonal of at least 0"
            );
            self.error(Error::format(format!("invalid covariance ({problem})")).allowing(allowed))
        };
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
