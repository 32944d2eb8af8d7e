//! Errors of model files, bands and tables of standard magnitudes.

use thiserror::Error;

/// The schema version that this code reads and writes.
pub const SCHEMA_VERSION: u32 = 1;

/// Errors of model files, bands and tables of standard magnitudes. `origin` is the name of a model file.
#[derive(Debug, Error)]
pub enum PhotometryError {
    /// Not JSON, a key missing, unknown or of the wrong type; the message names the key, the line and the column.
    #[error("model file {origin}: {source}")]
    ModelJson {
        /// The file.
        origin: String,
        /// Cause and position.
        source: serde_json::Error,
    },
    /// Written for another version of the schema.
    #[error("model file {origin}: schema is {given}, this version reads {SCHEMA_VERSION}")]
    ModelSchema {
        /// The file.
        origin: String,
        /// Value in the file.
        given: u32,
    },
    /// A number out of range, or not finite.
    #[error("model file {origin}: {key} is {given}, allowed is {least} to {greatest}")]
    ModelOutOfRange {
        /// The file.
        origin: String,
        /// The key, with its path.
        key: String,
        /// Value in the file.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// A text that is not one of the allowed ones.
    #[error("model file {origin}: {key} is {given:?}, allowed is {allowed}")]
    ModelText {
        /// The file.
        origin: String,
        /// The key.
        key: &'static str,
        /// Value in the file.
        given: String,
        /// Accepted values.
        allowed: &'static str,
    },
    /// A key that the kind needs is missing, or a key is given that the kind does not use.
    #[error("model file {origin}: kind {kind} {problem} the key {key:?}")]
    ModelKey {
        /// The file.
        origin: String,
        /// Kind of the model, as in files.
        kind: &'static str,
        /// `needs` or `has no use for`.
        problem: &'static str,
        /// The key.
        key: &'static str,
    },
    /// A name that is not defined in this file.
    #[error("model file {origin}: {key} is {given:?}, allowed: {allowed}")]
    ModelReference {
        /// The file.
        origin: String,
        /// The key, with its path.
        key: String,
        /// Value in the file.
        given: String,
        /// Accepted values.
        allowed: String,
    },
    /// The covariance is not a symmetric matrix of the parameters with a non-negative diagonal.
    #[error(
        "model file {origin}: covariance must be {size} x {size} (the coefficients in their order), finite and \
         symmetric, with a diagonal of at least 0: {problem}"
    )]
    ModelCovariance {
        /// The file.
        origin: String,
        /// Number of parameters.
        size: usize,
        /// Description of the defect.
        problem: String,
    },
    /// Not a band.
    #[error("unknown band {given:?}; known are B V R I (Johnson-Cousins), u g r i z y (LSST), G (Gaia)")]
    UnknownBand {
        /// Given name.
        given: String,
    },
    /// Not a magnitude system.
    #[error("unknown magnitude system {given:?}; known are Vega and AB")]
    UnknownSystem {
        /// Given name.
        given: String,
    },
    /// No line has an id and a magnitude in their columns.
    #[error(
        "none of {lines} lines has a NORAD id in columns 1-5 and a magnitude in columns 34-37: is this a qs.mag table?"
    )]
    NoStandardMagnitudes {
        /// Number of lines.
        lines: usize,
    },
}
