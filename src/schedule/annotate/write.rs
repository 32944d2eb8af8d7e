//! Chooses the writer by the format of the schedule.

use std::path::{Path, PathBuf};

use crate::table::{Provenance, Table};

use super::super::formats::{ScheduleFormat, display};
use super::csv_file;
use super::error::AnnotateError;

/// What is put beside a schedule's own cells.
pub struct Annotation<'a> {
    /// One row for each row of the schedule, in its order, as [`flag_table`](super::super::flag_table) makes them.
    pub flags: &'a Table,
    /// One row for each exposure and satellite, as [`streak_table`](super::super::streak_table) makes them.
    pub streaks: &'a Table,
    /// What both rest on.
    pub provenance: &'a Provenance,
    /// Take the place of an earlier annotation.
    pub replace: bool,
}

/// Writes `output`: the schedule at `input` with every original cell as it was, flags and streaks. Returns the files written.
///
/// - **opsim SQLite**: a copy of the database, page by page, with the tables `streaks` (one row for each exposure and
///   satellite), `streak_flags` (one row for each exposure) and `streak_provenance` (name, value as JSON).
/// - **CSV**: every byte of every line as it was, the flags as further columns at the right; the streaks with the provenance in
///   `NAME.streaks.csv` beside `NAME.csv`. The file itself gets no comment lines, so that whatever read it still does.
///
/// `output` may be `input`. Files are written beside their targets and renamed: they are there whole or not at all.
///
/// # Errors
/// Another format, an earlier annotation without `replace`, a schedule that changed meanwhile, or whatever the system reports.
pub fn annotate(
    input: &Path,
    format: ScheduleFormat,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, AnnotateError> {
    match format {
        ScheduleFormat::Csv => csv_file::annotate(input, output, annotation),
        #[cfg(feature = "sqlite")]
        ScheduleFormat::Opsim => super::opsim_file::annotate(input, output, annotation),
        _ => Err(AnnotateError::Format { path: display(input), format: format.to_string() }),
    }
}
