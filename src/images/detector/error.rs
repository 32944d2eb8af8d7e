//! What can be wrong with a detector.

use thiserror::Error;

/// Why a detector cannot be had, or not be used on a frame.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DetectorError {
    /// Not TOML, a key missing, unknown or of the wrong type; the message names key and line.
    #[error("detector: {message}")]
    Toml {
        /// What and where.
        message: String,
    },
    /// A number outside its range, or not finite.
    #[error("detector: {key} is {given}, allowed is {least} to {greatest}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// As given.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// Lists that do not go together, or numbers in the wrong order.
    #[error("detector: {key}: {message}")]
    List {
        /// The key.
        key: &'static str,
        /// What is wrong.
        message: String,
    },
    /// Light for another frame.
    #[error(
        "light for a frame of {light_rows} rows by {light_columns} columns was given to one of {rows} by {columns}"
    )]
    Shape {
        /// Rows that the light was drawn for.
        light_rows: usize,
        /// Columns that the light was drawn for.
        light_columns: usize,
        /// Rows of the frame.
        rows: usize,
        /// Columns of the frame.
        columns: usize,
    },
    /// An amplifier that reads pixels that are not there.
    #[error(
        "amplifier {number} reads rows {first_row} to {end_row} and columns {first_column} to {end_column} of a frame of {rows} rows by {columns} columns"
    )]
    AmplifierOutside {
        /// Its number, from 0.
        number: usize,
        /// Its first row.
        first_row: usize,
        /// The row after its last.
        end_row: usize,
        /// Its first column.
        first_column: usize,
        /// The column after its last.
        end_column: usize,
        /// Rows of the frame.
        rows: usize,
        /// Columns of the frame.
        columns: usize,
    },
}

impl DetectorError {
    /// Holds a number to its range.
    pub(super) fn hold(key: &'static str, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::OutOfRange { key, given, least, greatest })
    }
}
