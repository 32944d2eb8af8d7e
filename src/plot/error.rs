//! What can go wrong with a picture.

use thiserror::Error;

use crate::maps::MapError;

/// Why there is no picture.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlotError {
    /// A file name that ends in neither `.png` nor `.svg`.
    #[error("picture {name}: its name must end in .png or .svg")]
    UnknownFormat {
        /// The name given.
        name: String,
    },
    /// A panel that is no map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Nothing to be drawn.
    #[error("nothing to draw: there are no {what}")]
    Empty {
        /// What there is none of.
        what: String,
    },
    /// Columns that belong together differ in length.
    #[error("{what}: {given} values, but there must be {expected}, as many as in the column beside")]
    Length {
        /// The column.
        what: String,
        /// Its values.
        given: usize,
        /// Values of the other.
        expected: usize,
    },
    /// A value that has no place on an axis.
    #[error("{what}: value {index}, counted from 0, is {value}; only finite numbers can be drawn")]
    NotFinite {
        /// The column.
        what: String,
        /// Where in it.
        index: usize,
        /// Not a number, or infinite.
        value: f64,
    },
    /// A number out of its range.
    #[error("{what} is {given}, allowed: {allowed}")]
    OutOfRange {
        /// The number.
        what: String,
        /// As given.
        given: String,
        /// In words, with unit.
        allowed: &'static str,
    },
    /// What the drawing or encoding crate reports.
    #[error("drawing failed: {0}")]
    Drawing(String),
}
