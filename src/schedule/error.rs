//! Errors of schedules and policies.

use std::io;

use hifitime::TimeScale;
use thiserror::Error;

/// Columns of a schedule, as listed in messages.
pub(super) const ALLOWED_COLUMNS: &str = "exposure_id, start_utc (or start_mjd, start_jd with --time-scale, or \
     start_mjd_utc, start_mjd_tai, start_mjd_tt and the like), duration_s, ra_deg, dec_deg and, if known, rotation_deg, band; \
     the names used by Rubin's opsim and ConsDB and by ObsLocTAP are also accepted";

/// Errors of schedules and policies. An invalid row of a schedule is not an error: it is kept with its reason.
#[derive(Debug, Error)]
pub enum ScheduleError {
    /// The file cannot be opened or read.
    #[error("schedule {path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// Error of the system.
        source: io::Error,
    },
    /// A directory was given.
    #[error("schedule {path} is a directory; allowed: one file, opsim SQLite, CSV, ECSV, JSON, VOTable or Parquet")]
    Directory {
        /// The path.
        path: String,
    },
    /// The file is empty.
    #[error(
        "schedule {path} is empty; allowed: opsim SQLite, CSV, ECSV, JSON, VOTable or Parquet with at least one exposure"
    )]
    Empty {
        /// The file.
        path: String,
    },
    /// The file has columns but no rows.
    #[error("schedule {path} has columns but no exposures; allowed: at least one row")]
    NoRows {
        /// The file.
        path: String,
    },
    /// The format is not supported.
    #[error("schedule {path}: {what}; allowed: opsim SQLite, CSV, ECSV, JSON, VOTable (TABLEDATA) or Parquet")]
    Format {
        /// The file.
        path: String,
        /// Description of the file.
        what: String,
    },
    /// A line is invalid.
    #[error("schedule {path}, line {line}: {what}")]
    Line {
        /// The file.
        path: String,
        /// Line, from 1.
        line: u64,
        /// Error in the line.
        what: String,
    },
    /// Required columns are missing.
    #[error("schedule {path}: missing {missing}; found {found}; allowed: {ALLOWED_COLUMNS}")]
    MissingColumns {
        /// The file.
        path: String,
        /// The missing names.
        missing: String,
        /// The columns found.
        found: String,
    },
    /// Required columns of a target list are missing.
    #[error(
        "target list {path}: missing {missing}; found {found}; allowed: name, ra_deg, dec_deg, exposure_s (or --exposure) and, if known, \
         unique_id, rotation_deg, band"
    )]
    MissingTargetColumns {
        /// The file.
        path: String,
        /// The missing names.
        missing: String,
        /// The columns found.
        found: String,
    },
    /// Times are numbers or texts without a zone, and no time scale is specified.
    #[error(
        "schedule {path}: the time scale of column {column} is missing; allowed: --time-scale utc, tai or tt \
         (opsim files use UTC, ConsDB and many others TAI; TAI read as UTC is wrong by 37 s, which invalidates every result)"
    )]
    NoTimeScale {
        /// The file.
        path: String,
        /// The column.
        column: String,
    },
    /// The time scale of the column differs from the one in the options, and the cells have no zone.
    #[error(
        "schedule {path}: column {column} is in {named}, but --time-scale is {given}; allowed: no --time-scale, \
         --time-scale {}, a column of another name, or times that end in Z", .named.to_string().to_ascii_lowercase()
    )]
    OtherTimeScale {
        /// The file.
        path: String,
        /// The column.
        column: String,
        /// Time scale in its name or in the header of the file.
        named: TimeScale,
        /// Time scale in the options.
        given: TimeScale,
    },
    /// The unit of a column contradicts its name.
    #[error("schedule {path}: column {column} is in '{unit}'; allowed: {allowed}")]
    Unit {
        /// The file.
        path: String,
        /// The column.
        column: String,
        /// The unit in the header.
        unit: String,
        /// Allowed unit.
        allowed: &'static str,
    },
    /// SQLite reported an error.
    #[cfg(feature = "sqlite")]
    #[error("schedule {path}: {source}")]
    Sqlite {
        /// The file.
        path: String,
        /// Error of SQLite.
        source: rusqlite::Error,
    },
    /// The format cannot be written.
    #[error("schedule {path} is {format}, which this build cannot write; allowed: CSV, ECSV, JSON and VOTable")]
    AnnotateFormat {
        /// The file.
        path: String,
        /// Its format.
        format: String,
    },
    /// The file has an earlier annotation.
    #[error("schedule {path} already has {what}; allowed: --replace, which replaces them")]
    AlreadyThere {
        /// The file.
        path: String,
        /// Tables or columns of the earlier annotation.
        what: String,
    },
    /// The file changed between reading and writing.
    #[error(
        "schedule {path} has {rows} rows; allowed: the {flags} rows that were judged (the file changed in between)"
    )]
    Changed {
        /// The file.
        path: String,
        /// Rows found.
        rows: usize,
        /// Rows judged.
        flags: usize,
    },
    /// The output cannot be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: String,
        /// Error of the system.
        source: io::Error,
    },
    /// Parquet reported an error.
    #[cfg(feature = "parquet")]
    #[error("cannot write {path}: {what}")]
    AnnotateParquet {
        /// The file.
        path: String,
        /// Error of Parquet.
        what: String,
    },
    /// SQLite reported an error.
    #[cfg(feature = "sqlite")]
    #[error("cannot write {path}: {source}")]
    AnnotateSqlite {
        /// The file.
        path: String,
        /// Error of SQLite.
        source: rusqlite::Error,
    },
    /// The text is not TOML, or has an unknown key or a value of the wrong type.
    #[error(
        "policy: {0}; allowed: limit_mag, max_lost_fraction, saturation_mag, crosstalk_mag, min_probability, margin_s, max_delay_s"
    )]
    PolicySyntax(String),
    /// The magnitude limit is neither a number nor numbers by band.
    #[error("invalid magnitude limit '{given}'; allowed: a number, or numbers by band such as g=7,y=5,default=6")]
    PolicyLimit {
        /// Given value.
        given: String,
    },
    /// A band has two limits.
    #[error("band {band} has two limits in '{given}'; allowed: one number for each band, such as g=7,y=5,default=6")]
    PolicyBand {
        /// The band.
        band: String,
        /// Given value.
        given: String,
    },
    /// A number is out of range.
    #[error("policy: {field} is {value}; allowed: {allowed}")]
    PolicyOutOfRange {
        /// The key.
        field: &'static str,
        /// Given value.
        value: f64,
        /// Allowed range.
        allowed: &'static str,
    },
}
