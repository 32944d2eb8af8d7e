//! Chooses the writer by the format of the schedule.

use std::path::{Path, PathBuf};

use crate::output::{Provenance, Table};

use super::super::formats::ScheduleFormat;
#[cfg(not(all(feature = "sqlite", feature = "parquet")))]
use super::super::formats::display;
use super::error::AnnotateError;
use super::{csv_file, ecsv_file, json_file, votable_file};

/// What is put beside a schedule's own cells.
pub struct Annotation<'a> {
    /// One row for each row of the schedule (of those kept), in its order, as [`flag_table`](super::super::flag_table) makes them.
    pub flags: &'a Table,
    /// One row for each exposure and satellite, as [`streak_table`](super::super::streak_table) makes them.
    pub streaks: &'a Table,
    /// What both rest on.
    pub provenance: &'a Provenance,
    /// Take the place of an earlier annotation.
    pub replace: bool,
    /// Which rows of the schedule are written, one for each of them; all where `None`.
    pub keep: Option<&'a [bool]>,
}

/// Writes `output`: the schedule at `input` with every original cell as it was, flags and streaks. Returns the files written.
///
/// - **opsim SQLite**: a copy of the database, page by page, with the tables `streaks` (one row for each exposure and
///   satellite), `streak_flags` (one row for each exposure) and `streak_provenance` (name, value as JSON).
/// - **CSV**: every byte of every line as it was, the flags as further columns at the right; the streaks with the provenance in
///   `NAME.streaks.csv` beside `NAME.csv`. The file itself gets no comment lines, so that whatever read it still does.
/// - **ECSV**: every byte as it was, the flags as further entries of the header's list and cells at the right; the streaks in
///   `NAME.streaks.ecsv`.
/// - **JSON**: every byte as it was, the flags as further members of each row; the streaks as members `streaks` and `streak_provenance` of the
///   document, or in `NAME.streaks.json` where the document is a bare array.
/// - **VOTable** (TABLEDATA): every byte as it was, the flags as further `FIELD`s and cells of the first table; the streaks as a table
///   `streaks` behind it.
/// - **Parquet** (feature `parquet`): every column with its type, values, gaps and metadata, and the metadata of the file; the flags as
///   further columns, the streaks in `NAME.streaks.parquet`.
///
/// Rows that have no name of their own (ObsLocTAP) get `exposure_id` too: their number, from 1.
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
        ScheduleFormat::Ecsv => ecsv_file::annotate(input, output, annotation),
        ScheduleFormat::Json => json_file::annotate(input, output, annotation),
        ScheduleFormat::VoTable => votable_file::annotate(input, output, annotation),
        #[cfg(feature = "sqlite")]
        ScheduleFormat::Opsim => super::opsim_file::annotate(input, output, annotation),
        #[cfg(feature = "parquet")]
        ScheduleFormat::Parquet => super::parquet_file::annotate(input, output, annotation),
        #[cfg(not(all(feature = "sqlite", feature = "parquet")))]
        unwritten => Err(AnnotateError::Format { path: display(input), format: unwritten.to_string() }),
    }
}
