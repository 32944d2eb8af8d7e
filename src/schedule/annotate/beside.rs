//! Files beside an annotated one, and what all annotations have in common.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::super::error::ScheduleError;
use super::super::formats::display;
use super::error::AnnotateError;
use super::write::Annotation;
use crate::output::{AtomicFile, Table};

/// The schedule names its exposures itself.
pub(super) const OWN_COLUMN: &str = "exposure_id";

/// `night.csv` has its streaks in `night.streaks.csv`, `night.parquet` in `night.streaks.parquet`.
pub(super) fn streaks_path(output: &Path, extension: &str) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(".streaks.");
    name.push(extension);
    output.with_file_name(name)
}

/// A file in the making with all its bytes in it.
pub(super) fn write_new(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<AtomicFile, AnnotateError> {
    let error = |source| AnnotateError::Write { path: display(path), source };
    let file = AtomicFile::new(path).map_err(error)?;
    let mut out = io::BufWriter::new(file.file());
    write(&mut out).and_then(|()| out.flush()).map_err(error)?;
    drop(out);
    Ok(file)
}

/// Puts files in their places, the annotated schedule last.
pub(super) fn finish(files: Vec<(AtomicFile, PathBuf)>) -> Result<Vec<PathBuf>, AnnotateError> {
    let mut written = Vec::new();
    for (file, path) in files {
        file.finish().map_err(|source| AnnotateError::Write { path: display(&path), source })?;
        written.push(path);
    }
    written.reverse();
    Ok(written)
}

/// Whether a row of the file is one of those asked for.
pub(super) fn is_kept(keep: Option<&[bool]>, row: usize) -> bool {
    keep.is_none_or(|keep| keep.get(row).copied().unwrap_or(false))
}

/// A file's text and where its parts lie in it, with as many rows as were judged.
pub(super) fn read_layout<L>(
    input: &Path,
    annotation: &Annotation<'_>,
    layout: fn(&Path, &str) -> Result<L, ScheduleError>,
    rows: fn(&L) -> usize,
) -> Result<(String, L), AnnotateError> {
    let text = read_text(input)?;
    let layout = layout(input, &text)?;
    check_rows(input, rows(&layout), annotation)?;
    Ok((text, layout))
}

/// The text of a schedule.
pub(super) fn read_text(input: &Path) -> Result<String, AnnotateError> {
    Ok(std::fs::read_to_string(input).map_err(|source| ScheduleError::Io { path: display(input), source })?)
}

/// That the file still has as many rows as were judged.
pub(super) fn check_rows(input: &Path, rows: usize, annotation: &Annotation<'_>) -> Result<(), AnnotateError> {
    let expected = annotation.keep.map_or(annotation.flags.rows.len(), <[bool]>::len);
    if rows == expected {
        return Ok(());
    }
    Err(AnnotateError::Changed { path: display(input), rows, flags: expected })
}

/// Which of a file's columns an earlier annotation left.
///
/// # Errors
/// There are some, and they must stay.
pub(super) fn earlier_columns(
    input: &Path,
    names: &[String],
    flags: &Table,
    replace: bool,
) -> Result<Vec<usize>, AnnotateError> {
    let is_flag = |name: &String| flags.columns.iter().any(|column| column.name == name);
    let there: Vec<usize> = (0..names.len()).filter(|&index| is_flag(&names[index])).collect();
    if there.is_empty() || replace {
        return Ok(there);
    }
    let shown: Vec<&str> = there.iter().map(|&index| names[index].as_str()).collect();
    Err(AnnotateError::AlreadyThere { path: display(input), what: format!("columns {}", shown.join(", ")) })
}

/// The flags without the column that the schedule has itself, and with it where the schedule's rows have no name.
pub(super) fn flags_beside(names: &[String], flags: &Table) -> Table {
    let has_names = super::super::formats::ID.iter().any(|id| names.iter().any(|name| name == id));
    if has_names { flags.without(&[OWN_COLUMN]) } else { flags.clone() }
}
