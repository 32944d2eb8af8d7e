//! Errors of pictures.

use thiserror::Error;

use crate::maps::MapError;

/// Errors of drawing a picture.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlotError {
    /// The extension of a file name is neither `.png` nor `.svg`.
    #[error("invalid picture name {name}; allowed: a name that ends in .png or .svg")]
    UnknownFormat {
        /// Given name.
        name: String,
    },
    /// The extension of a file name is `.pdf`.
    #[error(
        "invalid picture name {name}: PDF is not supported; allowed: a name that ends in .png or .svg \
         (rsvg-convert and Inkscape convert SVG to PDF)"
    )]
    Pdf {
        /// Given name.
        name: String,
    },
    /// A panel of a figure cannot be computed as a map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// There is nothing to draw.
    #[error("nothing to draw: no {what}")]
    Empty {
        /// Name of the missing data.
        what: String,
    },
    /// Columns differ in length.
    #[error("{what}: {given} values; allowed: {expected}, as in the other columns")]
    Length {
        /// Name of the column.
        what: String,
        /// Number of its values.
        given: usize,
        /// Number of values of the other columns.
        expected: usize,
    },
    /// A value is not finite.
    #[error("{what}: value {index} (counted from 0) is {value}; allowed: a finite number")]
    NotFinite {
        /// Name of the column.
        what: String,
        /// Index in the column.
        index: usize,
        /// The value, NaN or infinite.
        value: f64,
    },
    /// A number is out of range.
    #[error("{what} is {given}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the number.
        what: String,
        /// Given value.
        given: String,
        /// Allowed range with unit.
        allowed: &'static str,
    },
    /// The drawing or encoding crate fails.
    #[error("drawing failed: {0}")]
    Drawing(String),
}
