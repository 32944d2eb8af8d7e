//! Annotation in the format of the schedule.

use std::path::{Path, PathBuf};

use super::super::error::ScheduleError;
use super::super::formats::ScheduleFormat;
#[cfg(not(all(feature = "sqlite", feature = "parquet")))]
use super::super::formats::display;
use super::annotation::Annotation;
use super::{delimited, json, votable};

/// Writes the schedule at `input` with flags and streaks added to `output`. Returns the files written.
///
/// - **opsim SQLite**: a copy of the database, page by page, with the tables `streaks` (one row for each exposure and
///   satellite), `streak_flags` (one row for each exposure) and `streak_provenance` (name, value as JSON).
/// - **CSV**: all bytes of the lines, with the flags as further columns at the right; the streaks with the provenance
///   in `NAME.streaks.csv` next to `NAME.csv`. No comment lines are added, because other readers may not accept them.
/// - **ECSV**: all bytes, with the flags as further entries of the header's list and cells at the right; the streaks in
///   `NAME.streaks.ecsv`.
/// - **JSON**: all bytes, with the flags as further members of each row; the streaks as members `streaks` and
///   `streak_provenance` of the document, or in `NAME.streaks.json` if the document is an array.
/// - **VOTable** (TABLEDATA): all bytes, with the flags as further `FIELD`s and cells of the first table; the streaks
///   as a table `streaks` after it.
/// - **Parquet** (feature `parquet`): every column with its type, values, nulls and metadata, and the metadata of the
///   file; the flags as further columns, the streaks in `NAME.streaks.parquet`.
///
/// Rows without an identifier (ObsLocTAP) get a column `exposure_id`: their number, from 1.
///
/// `output` may be `input`. Each file is written completely or not at all.
///
/// # Errors
/// The format cannot be written, an earlier annotation exists and `replace` is not set, the schedule has changed since
/// it was judged, or the system reports an error.
pub fn annotate(
    input: &Path,
    format: ScheduleFormat,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, ScheduleError> {
    match format {
        ScheduleFormat::Csv => delimited::annotate_csv(input, output, annotation),
        ScheduleFormat::Ecsv => delimited::annotate_ecsv(input, output, annotation),
        ScheduleFormat::Json => json::annotate(input, output, annotation),
        ScheduleFormat::VoTable => votable::annotate(input, output, annotation),
        #[cfg(feature = "sqlite")]
        ScheduleFormat::Opsim => super::opsim::annotate(input, output, annotation),
        #[cfg(feature = "parquet")]
        ScheduleFormat::Parquet => super::parquet::annotate(input, output, annotation),
        #[cfg(not(all(feature = "sqlite", feature = "parquet")))]
        unwritten => Err(ScheduleError::AnnotateFormat { path: display(input), format: unwritten.to_string() }),
    }
}
