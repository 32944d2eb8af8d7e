//! Why a whole file of measured magnitudes, or a whole question about it, has no answer.

use thiserror::Error;

/// What is wrong with a file of photometry, or with what was asked of it. Single bad rows are no errors: they are counted
/// in [`DropCounts`](super::DropCounts).
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeasuredError {
    /// No file was named.
    #[error("no file of photometry was named")]
    NoFiles,
    /// A file that cannot be opened, read or unpacked.
    #[error("cannot read {file}: {problem}")]
    Unreadable {
        /// Name as it was given.
        file: String,
        /// What the system or the unpacking said.
        problem: String,
    },
    /// Not one row.
    #[error("{file} has no rows; it should hold measured magnitudes as {}", super::format::ALLOWED)]
    Empty {
        /// Name as it was given.
        file: String,
    },
    /// The header belongs to none of the known formats.
    #[error(
        "{file}: the header '{header}' belongs to no known format; name one of {}, or give a column map",
        super::format::ALLOWED
    )]
    UnknownFormat {
        /// Name as it was given.
        file: String,
        /// The first line that is no comment, cut short.
        header: String,
    },
    /// A name of a format that is none.
    #[error("unknown format of photometry '{name}'; known are {}", super::format::ALLOWED)]
    UnknownFormatName {
        /// What was given.
        name: String,
    },
    /// A column that is not there.
    #[error("{file}: no column '{column}'")]
    Column {
        /// Name as it was given.
        file: String,
        /// The column.
        column: String,
    },
    /// A column map that cannot be understood, or lacks what is needed.
    #[error("column map: {problem}")]
    ColumnMap {
        /// What is wrong, and what is allowed.
        problem: String,
    },
    /// A column of times without a scale: TAI read as UTC turns every answer wrong.
    #[error("column map: the times of column '{column}' have no scale; say time_scale = utc, tai or tt")]
    NoTimeScale {
        /// The column of times.
        column: String,
    },
    /// Two filters in one file, and nobody said which is wanted.
    #[error("{file} data row {row}: filter '{other}' after rows of filter '{first}'; name the filters that are wanted")]
    MixedFilters {
        /// Name as it was given.
        file: String,
        /// Data row, from 1.
        row: u64,
        /// The filter of the first row.
        first: String,
        /// The other one.
        other: String,
    },
    /// A setting outside of what it can be.
    #[error("{name} {given} is not allowed: {allowed}")]
    Setting {
        /// Name of the option.
        name: &'static str,
        /// What was given.
        given: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Element sets are needed and none were given.
    #[error("{what} needs element sets, and none were given")]
    NoHistory {
        /// What was asked for.
        what: &'static str,
    },
    /// A table that cannot be written.
    #[error("cannot write photometry: {problem}")]
    Unwritable {
        /// What the system said.
        problem: String,
    },
}
