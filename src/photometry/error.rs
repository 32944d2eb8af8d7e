//! Errors of model files, bands and tables of standard magnitudes, and the checks of model files that return them.

use crate::message::Quoted;
use thiserror::Error;

/// Version of the model file schema that is supported.
pub const SCHEMA_VERSION: u32 = 1;

/// Errors of model files, bands and tables of standard magnitudes. `origin` is the name of a model file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PhotometryError {
    /// A name that no model has.
    #[error("unknown model '{given}'; allowed: {known}", given = Quoted::new(.given))]
    UnknownModel {
        /// Given value.
        given: String,
        /// Names of all models.
        known: String,
    },
    /// Invalid JSON, or a key that is missing, unknown or of the wrong type; the message contains key, line and column.
    #[error("model file {origin}: {source}")]
    #[doc(hidden)]
    ModelJson {
        /// Name of the file.
        origin: String,
        /// Cause and position.
        source: serde_json::Error,
    },
    /// The version of the schema is not supported.
    #[error("model file {origin}: schema is {given}; allowed: {SCHEMA_VERSION}")]
    ModelSchema {
        /// Name of the file.
        origin: String,
        /// Value in the file.
        given: u32,
    },
    /// A number is out of range or not finite.
    #[error("model file {origin}: {key} is {given}; allowed: {least} to {greatest}")]
    ModelOutOfRange {
        /// Name of the file.
        origin: String,
        /// Key with its path in the file.
        key: String,
        /// Value in the file.
        given: f64,
        /// Smallest allowed value.
        least: f64,
        /// Largest allowed value.
        greatest: f64,
    },
    /// A text is not one of the allowed ones.
    #[error("model file {origin}: {key} is {given:?}; allowed: {allowed}", given = Quoted::new(.given))]
    ModelText {
        /// Name of the file.
        origin: String,
        /// Key in the file.
        key: &'static str,
        /// Value in the file.
        given: String,
        /// Accepted values.
        allowed: &'static str,
    },
    /// A key that the kind of model requires is missing, or the kind does not use the key.
    #[error("model file {origin}: kind {kind} {problem} the key {key:?}")]
    ModelKey {
        /// Name of the file.
        origin: String,
        /// Kind of the model, as in files.
        kind: &'static str,
        /// `requires` or `does not use`.
        problem: &'static str,
        /// Key in the file.
        key: &'static str,
    },
    /// A name refers to something that is not defined in the file.
    #[error("model file {origin}: {key} is {given:?}; allowed: {allowed}", given = Quoted::new(.given))]
    ModelReference {
        /// Name of the file.
        origin: String,
        /// Key with its path in the file.
        key: String,
        /// Value in the file.
        given: String,
        /// Accepted values.
        allowed: String,
    },
    /// The covariance is not a symmetric matrix of the parameters with a non-negative diagonal.
    #[error(
        "model file {origin}: invalid covariance ({problem}); allowed: a finite, symmetric matrix of {size} x {size} \
         (the parameters in their order) with a diagonal of at least 0"
    )]
    ModelCovariance {
        /// Name of the file.
        origin: String,
        /// Number of parameters.
        size: usize,
        /// Description of the defect.
        problem: String,
    },
    /// The name of a band is unknown.
    #[error("unknown band {given:?}; allowed: B V R I (Johnson-Cousins), u g r i z y (LSST), G (Gaia), J H K (2MASS), W1 W2 (WISE)", given = Quoted::new(.given))]
    UnknownBand {
        /// Given name.
        given: String,
    },
    /// The name of a magnitude system is unknown.
    #[error("unknown magnitude system {given:?}; allowed: Vega and AB", given = Quoted::new(.given))]
    UnknownSystem {
        /// Given name.
        given: String,
    },
    /// No line of a qs.mag table has a NORAD number and a magnitude in their columns.
    #[error(
        "none of {lines} lines is a row of a qs.mag table; allowed: a NORAD id in columns 1-5 and a magnitude in columns 34-37"
    )]
    NoStandardMagnitudes {
        /// Number of lines.
        lines: usize,
    },
}

/// Checks of the values in one model file.
pub(super) struct Check<'a> {
    /// Name of the file.
    pub origin: &'a str,
}

impl Check<'_> {
    pub fn range(&self, key: &str, given: f64, least: f64, greatest: f64) -> Result<(), PhotometryError> {
        // NaN is outside every range.
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

    /// Checks that a number of items is within a range.
    pub fn count(&self, key: &str, given: usize, least: usize, greatest: usize) -> Result<(), PhotometryError> {
        self.range(&format!("{key}: number"), given as f64, least as f64, greatest as f64)
    }

    /// Returns the error for a name that is not defined.
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
