//! Place of a row of a table of streaks, for errors.

use std::fmt::{self, Display};
use std::path::{Path, PathBuf};

use crate::error::Error;

/// Table of streaks and the number of its line, or of its row in a FITS table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RowOrigin {
    path: PathBuf,
    number: u64,
    is_line: bool,
}

impl RowOrigin {
    /// Returns the place of a line of a table. The rows of a FITS table have numbers; in its text they are below
    /// `lines_before_rows`.
    pub fn new(path: &Path, line: u64, lines_before_rows: Option<u64>) -> Self {
        let number = line - lines_before_rows.unwrap_or(0);
        Self { path: path.to_owned(), number, is_line: lines_before_rows.is_none() }
    }

    /// Puts the table and the row before the message of an error, which may name another file such as the frame. An
    /// error that names the table is returned unchanged.
    pub fn of(&self, error: Error) -> Error {
        if error.file() == Some(self.path.as_path()) {
            return error;
        }
        error.within(self, &self.path, self.is_line.then_some(self.number as usize))
    }
}

impl Display for RowOrigin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.is_line { "line" } else { "row" };
        write!(formatter, "{}: {what} {}", self.path.display(), self.number)
    }
}
