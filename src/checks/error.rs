//! Why measured magnitudes could not be read.

use std::path::PathBuf;

use thiserror::Error;

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
        /// What the system, the unpacking or the CSV reader said.
        problem: String,
    },
    /// A column that is not there.
    #[error("photometry {}: no column '{column}'", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// A cell that cannot be what it says.
    #[error("photometry {} data row {row}: {column} '{given}', expected {expected}", path.display())]
    Cell {
        /// The file.
        path: PathBuf,
        /// Data row, from 1.
        row: usize,
        /// The column.
        column: &'static str,
        /// What stands there.
        given: String,
        /// What should.
        expected: &'static str,
    },
}
