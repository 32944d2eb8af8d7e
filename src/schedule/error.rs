//! What can be wrong with a schedule as a whole.

use std::io;

use hifitime::TimeScale;
use thiserror::Error;

/// The columns a schedule has, for every message that names them.
pub(super) const ALLOWED_COLUMNS: &str = "exposure_id, start_utc (or start_mjd, start_jd with --time-scale, or \
     start_mjd_utc, start_mjd_tai, start_mjd_tt and the like), duration_s, ra_deg, dec_deg and, if known, rotation_deg, band; \
     the names of Rubin's opsim and ConsDB and of ObsLocTAP are understood too";

/// Why a schedule cannot be read at all. What is wrong with one row stays with the row.
#[derive(Debug, Error)]
pub enum ScheduleError {
    /// The file cannot be opened or read.
    #[error("schedule {path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the system said.
        source: io::Error,
    },
    /// A directory was given.
    #[error("schedule {path} is a directory; allowed: one file, opsim SQLite, CSV, ECSV, JSON, VOTable or Parquet")]
    Directory {
        /// The path.
        path: String,
    },
    /// Nothing is in the file.
    #[error(
        "schedule {path} is empty; allowed: opsim SQLite, CSV, ECSV, JSON, VOTable or Parquet with at least one exposure"
    )]
    Empty {
        /// The file.
        path: String,
    },
    /// Columns but no rows.
    #[error("schedule {path} has columns but no exposures; at least one row is needed")]
    NoRows {
        /// The file.
        path: String,
    },
    /// No format that is read here.
    #[error("schedule {path}: {what}; allowed: opsim SQLite, CSV, ECSV, JSON, VOTable (TABLEDATA) or Parquet")]
    Format {
        /// The file.
        path: String,
        /// What was found.
        what: String,
    },
    /// A line that does not parse.
    #[error("schedule {path}, line {line}: {what}")]
    Line {
        /// The file.
        path: String,
        /// Line, from 1.
        line: u64,
        /// What is wrong with it.
        what: String,
    },
    /// Columns that must be there are not.
    #[error("schedule {path}: missing {missing}; found {found}; allowed: {ALLOWED_COLUMNS}")]
    MissingColumns {
        /// The file.
        path: String,
        /// The missing names.
        missing: String,
        /// The names that are there.
        found: String,
    },
    /// Columns that a target list must have are not there.
    #[error(
        "target list {path}: missing {missing}; found {found}; allowed: name, ra_deg, dec_deg, exposure_s (or --exposure) and, if known, \
         unique_id, rotation_deg, band"
    )]
    MissingTargetColumns {
        /// The file.
        path: String,
        /// The missing names.
        missing: String,
        /// The names that are there.
        found: String,
    },
    /// Times are bare numbers or texts without a zone, and nobody said their scale.
    #[error(
        "schedule {path}: column {column} names no time scale; say --time-scale utc, tai or tt \
         (opsim files hold UTC, ConsDB and many others TAI; TAI read as UTC is 37 s off, which turns every answer wrong)"
    )]
    NoTimeScale {
        /// The file.
        path: String,
        /// The column.
        column: String,
    },
    /// The column names one time scale, the caller another, and the cells have no zone of their own.
    #[error(
        "schedule {path}: column {column} is in {named}, but --time-scale says {said}; allowed: no --time-scale, \
         --time-scale {}, a column named otherwise, or times that end in Z", .named.to_string().to_ascii_lowercase()
    )]
    OtherTimeScale {
        /// The file.
        path: String,
        /// The column.
        column: String,
        /// The scale of its name or its file's header.
        named: TimeScale,
        /// The scale that the caller says.
        said: TimeScale,
    },
    /// A column in another unit than its name says.
    #[error("schedule {path}: column {column} is in '{unit}'; allowed: {allowed}")]
    Unit {
        /// The file.
        path: String,
        /// The column.
        column: String,
        /// The unit in the header.
        unit: String,
        /// The unit that the name promises.
        allowed: &'static str,
    },
    /// SQLite found something wrong.
    #[cfg(feature = "sqlite")]
    #[error("schedule {path}: {source}")]
    Sqlite {
        /// The file.
        path: String,
        /// What SQLite said.
        source: rusqlite::Error,
    },
}
