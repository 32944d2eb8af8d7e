//! Why a schedule cannot be annotated.

use std::io;

use thiserror::Error;

use super::super::error::ScheduleError;

/// Why a schedule cannot be annotated. Nothing is written then.
#[derive(Debug, Error)]
pub enum AnnotateError {
    /// The schedule cannot be read.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// A format that cannot be written back.
    #[error("schedule {path} is {format}, which this build cannot write; allowed: CSV, ECSV, JSON and VOTable")]
    Format {
        /// The file.
        path: String,
        /// Its format.
        format: String,
    },
    /// The file has been annotated before.
    #[error("schedule {path} already has {what}; say --replace to put new ones in their place")]
    AlreadyThere {
        /// The file.
        path: String,
        /// The tables or columns.
        what: String,
    },
    /// The file changed between reading and writing.
    #[error("schedule {path} has {rows} rows now, {flags} were judged: it changed in between")]
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
        /// What the system said.
        source: io::Error,
    },
    /// Parquet found something wrong.
    #[cfg(feature = "parquet")]
    #[error("cannot write {path}: {what}")]
    Parquet {
        /// The file.
        path: String,
        /// What was said.
        what: String,
    },
    /// SQLite found something wrong.
    #[cfg(feature = "sqlite")]
    #[error("cannot write {path}: {source}")]
    Sqlite {
        /// The file.
        path: String,
        /// What SQLite said.
        source: rusqlite::Error,
    },
}
