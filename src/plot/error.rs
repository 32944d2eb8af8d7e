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
    /// What the drawing or encoding crate reports.
    #[error("drawing failed: {0}")]
    Drawing(String),
}
