//! Errors of detectors.

use thiserror::Error;

/// Error in the settings of a detector, or in applying it to a frame.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DetectorError {
    /// Invalid TOML, or a key that is missing, unknown or of the wrong type; the message names key and line.
    #[error("detector: {message}")]
    Toml {
        /// Description and position of the error.
        message: String,
    },
    /// A number outside its range, or not finite.
    #[error("detector: {key} is {given}; allowed: {least} to {greatest}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// Given value.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// Lists of inconsistent lengths, or numbers in the wrong order.
    #[error("detector: {key}: {message}")]
    List {
        /// The key.
        key: &'static str,
        /// Description of the error.
        message: String,
    },
    /// Light computed for a frame of another shape.
    #[error(
        "light of {light_rows} rows by {light_columns} columns does not match the frame of {rows} rows by {columns} columns"
    )]
    Shape {
        /// Rows for which the light was computed.
        light_rows: usize,
        /// Columns for which the light was computed.
        light_columns: usize,
        /// Rows of the frame.
        rows: usize,
        /// Columns of the frame.
        columns: usize,
    },
    /// An amplifier outside the frame.
    #[error(
        "amplifier {number} reads rows {first_row} to {end_row} and columns {first_column} to {end_column}, but the frame has {rows} rows and {columns} columns"
    )]
    AmplifierOutside {
        /// Number of the amplifier, from 0.
        number: usize,
        /// First row of the amplifier.
        first_row: usize,
        /// Row after the last one of the amplifier.
        end_row: usize,
        /// First column of the amplifier.
        first_column: usize,
        /// Column after the last one of the amplifier.
        end_column: usize,
        /// Rows of the frame.
        rows: usize,
        /// Columns of the frame.
        columns: usize,
    },
}

impl DetectorError {
    /// Checks that a number is in its range.
    pub(super) fn check_range(key: &'static str, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::OutOfRange { key, given, least, greatest })
    }
}
