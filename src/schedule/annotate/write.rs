//! Writes an annotated schedule in the format of the input.

use std::path::{Path, PathBuf};

use super::super::formats::{ScheduleFormat, display, read_raw};
use super::super::tables::flag_table;
use super::annotation::{Annotation, streaks_path};
use super::{delimited, json, votable};
use crate::error::Error;
use crate::output::{Provenance, Table};

/// Writes a copy of the schedule at `input`, with verdicts and streaks, to `output`. Returns the files written.
///
/// - **opsim SQLite**: a copy of the database with the tables `streaks` (one row for each exposure and satellite),
///   `streak_flags` (one row for each exposure) and `streak_provenance` (name, value as JSON).
/// - **CSV**: the original lines, with verdict columns appended; streaks and provenance in `NAME.streaks.csv` next to
///   `NAME.csv`. No comment lines are added, because other readers may not accept them.
/// - **ECSV**: the original lines, with verdict columns appended to the header's list and to each line; streaks in
///   `NAME.streaks.ecsv`.
/// - **JSON**: the original text, with verdicts as members of each row; streaks as members `streaks` and
///   `streak_provenance` of the document, or in `NAME.streaks.json` if the document is an array.
/// - **VOTable** (TABLEDATA): the original text, with verdicts as `FIELD`s and cells of the first table; streaks as a
///   table `streaks` after it.
///
/// For rows without an identifier (ObsLocTAP), a column `exposure_id` with the row number, from 1, is added.
///
/// `output` may be the same path as `input`. Each file is replaced as a whole, or not changed if an error occurs.
///
/// # Errors
/// Those of [`check_extension`]; or the format cannot be written, an earlier annotation exists and `replace` is false,
/// the schedule has changed since it was judged, or the operating system reports an error.
pub fn annotate(
    input: &Path,
    format: ScheduleFormat,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, Error> {
    check_extension(input, format, output)?;
    match format {
        ScheduleFormat::Csv => delimited::annotate_csv(input, output, annotation),
        ScheduleFormat::Ecsv => delimited::annotate_ecsv(input, output, annotation),
        ScheduleFormat::Json => json::annotate(input, output, annotation),
        ScheduleFormat::VoTable => votable::annotate(input, output, annotation),
        #[cfg(feature = "sqlite")]
        ScheduleFormat::Opsim => super::opsim::annotate(input, output, annotation),
        #[cfg(not(feature = "sqlite"))]
        unwritten => {
            Err(Error::about_file("schedule", input, format!("is {unwritten}, which this build cannot write"))
                .allowing("CSV, ECSV, JSON and VOTable"))
        }
    }
}

/// Checks the name of an annotated file, which has the format of the schedule, and of the file of its streaks.
///
/// # Errors
/// The extension of `output` is that of another format (that of `input` is always allowed), or the file of the streaks
/// is the schedule.
pub fn check_extension(input: &Path, format: ScheduleFormat, output: &Path) -> Result<(), Error> {
    let is_parquet = output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet"));
    let is_other = is_parquet || ScheduleFormat::by_extension(output).is_some_and(|other| other != format);
    if is_other && output.extension() != input.extension() {
        return Err(Error::about_file("output", output, "has the extension of another format")
            .allowing(format!(".{}, because the schedule is {format}", format.extensions().join(", ."))));
    }
    let extension = match format {
        ScheduleFormat::Csv => "csv",
        ScheduleFormat::Ecsv => "ecsv",
        ScheduleFormat::Json => "json",
        ScheduleFormat::VoTable | ScheduleFormat::Opsim => return Ok(()),
    };
    let streaks = streaks_path(output, extension);
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    if real(&streaks).is_some_and(|streaks| real(input) == Some(streaks)) {
        let predicate = format!("are written to {}, which is the schedule", display(&streaks));
        return Err(Error::about_file("the streaks of", output, predicate).allowing("an output of another name"));
    }
    Ok(())
}

/// Checks that a schedule has no earlier annotation, before a computation that may be long. JSON is checked only by
/// [`annotate`].
///
/// # Errors
/// An earlier annotation exists, or the file cannot be read.
pub fn check_not_annotated(input: &Path, format: ScheduleFormat) -> Result<(), Error> {
    match format {
        #[cfg(feature = "sqlite")]
        ScheduleFormat::Opsim => super::opsim::check_not_annotated(input),
        ScheduleFormat::Csv | ScheduleFormat::Ecsv | ScheduleFormat::VoTable => {
            let names = read_raw(input)?.names;
            let flags = flag_table(&[]);
            let (streaks, provenance) = (Table::default(), Provenance::default());
            let annotation =
                Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace: false, keep: None };
            let flags = annotation.flags_for(names.iter().map(String::as_str));
            annotation.earlier_columns(input, &names, &flags).map(drop)
        }
        _ => Ok(()),
    }
}
