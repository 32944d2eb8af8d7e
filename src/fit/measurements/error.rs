//! Errors in files of photometry and in the options of their reduction.

use thiserror::Error;

/// Names of the formats, for messages.
pub(super) const FORMATS: &str = "pomenis, mmt, score, slingshot, csv";

/// Errors in a file of photometry or in options. Invalid rows are not errors but are counted in
/// [`DropCounts`](super::DropCounts).
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeasurementError {
    /// An empty list of files.
    #[error("no file of photometry is given")]
    NoFiles,
    /// A file that cannot be opened, read or decompressed.
    #[error("cannot read {file}: {problem}")]
    Unreadable {
        /// Name of the file.
        file: String,
        /// Message of the system or of the decompression.
        problem: String,
    },
    /// A file without rows.
    #[error("{file} has no rows; expected measured magnitudes in one of the formats {FORMATS}")]
    Empty {
        /// Name of the file.
        file: String,
    },
    /// A header that matches none of the known formats.
    #[error("{file}: unknown format with the header '{header}'; specify one of {FORMATS}, or a column map")]
    UnknownFormat {
        /// Name of the file.
        file: String,
        /// First line that is not a comment, truncated.
        header: String,
    },
    /// An unknown name of a format.
    #[error("unknown format of photometry '{name}': expected one of {FORMATS}")]
    UnknownFormatName {
        /// Given name.
        name: String,
    },
    /// A missing column.
    #[error("{file}: no column '{column}'")]
    Column {
        /// Name of the file.
        file: String,
        /// The column.
        column: String,
    },
    /// An invalid or incomplete column map.
    #[error("column map: {problem}")]
    ColumnMap {
        /// The problem and what is allowed.
        problem: String,
    },
    /// A column of times without a time scale; TAI read as UTC would be 37 s off.
    #[error("column map: the times of column '{column}' have no scale; specify time_scale = utc, tai or tt")]
    NoTimeScale {
        /// The column of times.
        column: String,
    },
    /// Several filters in one file without a selection.
    #[error("{file} data row {row}: filter '{other}' after rows of filter '{first}'; specify the filters")]
    MixedFilters {
        /// Name of the file.
        file: String,
        /// Data row, from 1.
        row: u64,
        /// The filter of the first row.
        first: String,
        /// The other one.
        other: String,
    },
    /// An option outside its range.
    #[error("invalid {name} {given}: allowed {allowed}")]
    Setting {
        /// Name of the option.
        name: &'static str,
        /// Given value.
        given: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Missing element sets.
    #[error("{what} requires element sets; none are given")]
    NoHistory {
        /// Operation that requires them.
        what: &'static str,
    },
}
