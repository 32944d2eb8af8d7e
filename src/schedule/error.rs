//! Errors of schedules and policies.

use std::io;

use crate::message::Quoted;
use crate::units::UnitError;
use hifitime::TimeScale;
use thiserror::Error;

/// Accepted columns of a schedule, for error messages.
pub(super) const ALLOWED_COLUMNS: &str = "exposure_id, start_utc (or start_mjd, start_jd with --time-scale, or \
     start_mjd_utc, start_mjd_tai, start_mjd_tt and the like), duration_s, ra_deg, dec_deg and, if known, rotation_deg, band; \
     the names used by Rubin's opsim and ConsDB and by ObsLocTAP are also accepted";

/// Error of a schedule or policy file. An invalid row of a schedule is not an error: the row is kept with the reason.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ScheduleError {
    /// The file cannot be opened or read.
    #[error("schedule {path}: {source}")]
    Io {
        /// Path of the file.
        path: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The path is a directory.
    #[error("schedule {path} is a directory; allowed: one file, opsim SQLite, CSV, ECSV, JSON or VOTable")]
    Directory {
        /// The path.
        path: String,
    },
    /// The file is empty.
    #[error("schedule {path} is empty; allowed: opsim SQLite, CSV, ECSV, JSON or VOTable with at least one exposure")]
    Empty {
        /// Path of the file.
        path: String,
    },
    /// The file has columns but no rows.
    #[error("schedule {path} has columns but no exposures; allowed: at least one row")]
    NoRows {
        /// Path of the file.
        path: String,
    },
    /// The file has more rows than the largest number.
    #[error("schedule {path} has more than {most} rows; allowed: at most {most}; split it")]
    TooManyRows {
        /// Path of the file.
        path: String,
        /// The largest number of rows.
        most: usize,
    },
    /// The format is not supported.
    #[error("schedule {path}: {what}; allowed: opsim SQLite, CSV, ECSV, JSON or VOTable (TABLEDATA)")]
    Format {
        /// Path of the file.
        path: String,
        /// Description of the file.
        what: String,
    },
    /// The table of streaks would replace the schedule.
    #[error(
        "the streaks of {output} are written to {streaks}, which is the schedule; allowed: an output of another name"
    )]
    StreaksAreInput {
        /// Path of the annotated schedule.
        output: String,
        /// Path of its table of streaks.
        streaks: String,
    },
    /// A column that is read occurs several times.
    #[error("schedule {path}: column {column} occurs twice; allowed: once")]
    RepeatedColumn {
        /// Path of the file.
        path: String,
        /// Name of the column.
        column: String,
    },
    /// The days of the starts were rounded to single precision.
    #[error(
        "schedule {path}: column {column} has single precision, in which MJD have steps of 5 min and JD of 6 h; allowed: \
         double precision (float64 in ECSV, double in VOTable), or times as text"
    )]
    SinglePrecision {
        /// Path of the file.
        path: String,
        /// Name of the column.
        column: String,
    },
    /// A line is invalid.
    #[error("schedule {path}, line {line}: {what}")]
    Line {
        /// Path of the file.
        path: String,
        /// Line number, from 1.
        line: u64,
        /// What is wrong with the line.
        what: String,
    },
    /// Required columns are missing.
    #[error("schedule {path}: missing {missing}; found {found}; allowed: {ALLOWED_COLUMNS}")]
    MissingColumns {
        /// Path of the file.
        path: String,
        /// Names of the missing columns.
        missing: String,
        /// Names of the columns of the file.
        found: String,
    },
    /// Required columns of a target list are missing.
    #[error(
        "target list {path}: missing {missing}; found {found}; allowed: name, ra_deg, dec_deg, exposure_s (or --exposure) and, if known, \
         unique_id, rotation_deg, band"
    )]
    MissingTargetColumns {
        /// Path of the file.
        path: String,
        /// Names of the missing columns.
        missing: String,
        /// Names of the columns of the file.
        found: String,
    },
    /// Times are numbers or texts without a time zone, and no time scale is given.
    #[error(
        "schedule {path}: the time scale of column {column} is missing; allowed: --time-scale utc, tai or tt \
         (opsim files use UTC, ConsDB and many others TAI; TAI read as UTC is wrong by 37 s, which invalidates every result)"
    )]
    NoTimeScale {
        /// Path of the file.
        path: String,
        /// Name of the column.
        column: String,
    },
    /// The time scale of the column differs from the one in the options, and the cells have no time zone.
    #[error(
        "schedule {path}: column {column} is in {named}, but --time-scale is {given}; allowed: no --time-scale, \
         --time-scale {}, a column of another name, or times that end in Z", .named.to_string().to_ascii_lowercase()
    )]
    OtherTimeScale {
        /// Path of the file.
        path: String,
        /// Name of the column.
        column: String,
        /// Time scale in the column name or in the header of the file.
        named: TimeScale,
        /// Time scale in the options.
        given: TimeScale,
    },
    /// The unit of a column is unknown, or contradicts its name.
    #[error("schedule {path}: {source}")]
    #[doc(hidden)]
    Unit {
        /// Path of the file.
        path: String,
        /// Column, unit and accepted units.
        source: UnitError,
    },
    /// The time scale in the name of a column contradicts that in the header of the file.
    #[error("schedule {path}: column {column} is in '{header}'; allowed: the time scale in the name of the column")]
    NamedTimeScale {
        /// Path of the file.
        path: String,
        /// Name of the column.
        column: String,
        /// Time scale in the header of the file.
        header: TimeScale,
    },
    /// SQLite reported an error.
    #[cfg(feature = "sqlite")]
    #[error("schedule {path}: {source}")]
    #[doc(hidden)]
    Sqlite {
        /// Path of the file.
        path: String,
        /// Error of SQLite.
        source: rusqlite::Error,
    },
    /// This build cannot write the format.
    #[error("schedule {path} is {format}, which this build cannot write; allowed: CSV, ECSV, JSON and VOTable")]
    AnnotateFormat {
        /// Path of the file.
        path: String,
        /// Format of the file.
        format: String,
    },
    /// The extension of the output is that of another format than the schedule's.
    #[error("output {path} has the extension of another format; allowed: .{allowed}, because the schedule is {format}")]
    OutputExtension {
        /// Path of the output.
        path: String,
        /// Format of the schedule.
        format: String,
        /// Extensions of this format.
        allowed: String,
    },
    /// The file has an earlier annotation.
    #[error("schedule {path} already has {what}; allowed: --replace, which replaces them")]
    AlreadyThere {
        /// Path of the file.
        path: String,
        /// Tables or columns of the earlier annotation.
        what: String,
    },
    /// The number of rows of the file changed between reading and writing.
    #[error(
        "schedule {path} has {rows} rows; allowed: the {flags} rows that were judged (the file changed in between)"
    )]
    Changed {
        /// Path of the file.
        path: String,
        /// Rows in the file now.
        rows: usize,
        /// Rows when the exposures were judged.
        flags: usize,
    },
    /// The output cannot be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// Path of the file.
        path: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// SQLite reported an error while the annotated copy was written.
    #[cfg(feature = "sqlite")]
    #[error("cannot write {path}: {source}")]
    #[doc(hidden)]
    AnnotateSqlite {
        /// Path of the file.
        path: String,
        /// Error of SQLite.
        source: rusqlite::Error,
    },
    /// The text is not TOML, or has an unknown key or a value of the wrong type.
    #[error(
        "policy: {0}; allowed: limit_mag, limit_surface_brightness, max_cost_s, min_probability, blocking, margin_s, max_delay_s"
    )]
    PolicySyntax(String),
    /// The magnitude limit is neither a number nor numbers by band.
    #[error("invalid magnitude limit '{given}'; allowed: a number, or numbers by band such as g=7,y=5,default=6", given = Quoted::new(.given))]
    PolicyLimit {
        /// Text that cannot be parsed.
        given: String,
    },
    /// A choice of blocking satellites is not one of the allowed words.
    #[error("blocking is '{given}'; allowed: any, avoid", given = Quoted::new(.given))]
    PolicyBlocking {
        /// Text that is not allowed.
        given: String,
    },
    /// A band has two limits.
    #[error("band {band} has two limits in '{given}'; allowed: one number for each band, such as g=7,y=5,default=6", given = Quoted::new(.given))]
    PolicyBand {
        /// Name of the band.
        band: String,
        /// Text of the limits.
        given: String,
    },
    /// A number is out of range.
    #[error("policy: {field} is {value}; allowed: {allowed}")]
    PolicyOutOfRange {
        /// Key of the policy.
        field: &'static str,
        /// Invalid value.
        value: f64,
        /// Accepted range.
        allowed: &'static str,
    },
}
