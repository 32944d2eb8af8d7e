//! Why measured magnitudes could not be read.

use std::path::PathBuf;

use thiserror::Error;

use super::super::measurements::{DropExample, MeasuredError};

/// What is wrong with a folder of photometry.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CheckError {
    /// None of the known files is in the folder.
    #[error("no photometry in {}: looked for {looked_for}", folder.display())]
    Nothing {
        /// The folder.
        folder: PathBuf,
        /// Paths of the known files in it.
        looked_for: String,
    },
    /// A file that is there and cannot be read.
    #[error("photometry {}: {problem}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system or the table's reader said.
        problem: String,
    },
    /// A survey's table that cannot be read.
    #[error("photometry {0}")]
    Survey(#[from] MeasuredError),
    /// A row that cannot be what it says: here every one counts.
    #[error("photometry {0}")]
    Row(DropExample),
}
