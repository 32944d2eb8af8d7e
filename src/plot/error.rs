//! Errors of pictures.

use thiserror::Error;

use crate::maps::MapError;

/// Errors of drawing a picture.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlotError {
    /// A file name that ends in neither `.png` nor `.svg`.
    #[error("invalid picture name {name}; allowed: a name that ends in .png or .svg")]
    UnknownFormat {
        /// Given name.
        name: String,
    },
    /// A panel that cannot be computed as a map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Missing data.
    #[error("nothing to draw: no {what}")]
    Empty {
        /// Missing data.
        what: String,
    },
    /// Columns of different length.
    #[error("{what}: {given} values; allowed: {expected}, as in the other columns")]
    Length {
        /// Name of the column.
        what: String,
        /// Number of its values.
        given: usize,
        /// Number of values of the other columns.
        expected: usize,
    },
    /// A value that is not finite.
    #[error("{what}: value {index} (counted from 0) is {value}; allowed: a finite number")]
    NotFinite {
        /// Name of the column.
        what: String,
        /// Index in the column.
        index: usize,
        /// NaN or infinite.
        value: f64,
    },
    /// A number out of range.
    #[error("{what} is {given}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the number.
        what: String,
        /// Given value.
        given: String,
        /// Allowed range with unit.
        allowed: &'static str,
    },
    /// Error of the drawing or encoding crate.
    #[error("drawing failed: {0}")]
    Drawing(String),
}
