//! Errors of pictures.

use thiserror::Error;

use crate::maps::MapError;

/// Errors of drawing a picture.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlotError {
    /// The file name ends in neither `.png` nor `.svg`.
    #[error("picture {name}: its name must end in .png or .svg")]
    UnknownFormat {
        /// The name given.
        name: String,
    },
    /// A panel is not a map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// There is nothing to draw.
    #[error("nothing to draw: there are no {what}")]
    Empty {
        /// What is missing.
        what: String,
    },
    /// Columns differ in length.
    #[error("{what}: {given} values, but there must be {expected}, as many as in the column beside")]
    Length {
        /// The column.
        what: String,
        /// Its values.
        given: usize,
        /// Values of the other.
        expected: usize,
    },
    /// A value is not finite.
    #[error("{what}: value {index}, counted from 0, is {value}; only finite numbers can be drawn")]
    NotFinite {
        /// The column.
        what: String,
        /// Where in it.
        index: usize,
        /// Not a number, or infinite.
        value: f64,
    },
    /// A number is out of range.
    #[error("{what} is {given}, allowed: {allowed}")]
    OutOfRange {
        /// The number.
        what: String,
        /// As given.
        given: String,
        /// In words, with unit.
        allowed: &'static str,
    },
    /// Error of the drawing or encoding crate.
    #[error("drawing failed: {0}")]
    Drawing(String),
}
