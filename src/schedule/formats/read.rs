//! Reads a schedule file. The format is determined from its first bytes.

use std::fs;
use std::io::Read;
use std::path::Path;

use super::super::error;
use super::raw_table::RawTable;
use super::{delimited, json, votable};
use crate::error::Error;
use crate::input;

/// Reads a file into a table of cells.
///
/// # Errors
/// Same as [`Schedule::read`](super::super::Schedule::read), except for errors of columns and time scales.
pub(in crate::schedule) fn read_raw(path: &Path) -> Result<RawTable, Error> {
    let io_error = |source| Error::system(source).in_file("schedule", path);
    if fs::metadata(path).map_err(io_error)?.is_dir() {
        return Err(Error::about_file("schedule", path, "is a directory")
            .allowing("one file, opsim SQLite, CSV, ECSV, JSON or VOTable"));
    }
    let mut file = input::open(path).map_err(io_error)?;
    let mut head = Vec::new();
    file.by_ref().take(16).read_to_end(&mut head).map_err(io_error)?;
    if head == *b"SQLite format 3\0" {
        return read_sqlite(path);
    }
    let what = match head.as_slice() {
        [b'P', b'A', b'R', b'1', ..] => Some(
            "Parquet file; convert it to CSV first, in Python with pandas.read_parquet(NAME).to_csv(NAME, index=False), \
             or pass its columns to the Python package",
        ),
        [0x1f, 0x8b, ..] => Some("compressed with gzip; decompress it first"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16 text; convert it to UTF-8 first"),
        [b'S', b'I', b'M', b'P', b'L', b'E', ..] => Some("FITS file"),
        _ => None,
    };
    if let Some(what) = what {
        return Err(error::format(path, what));
    }
    input::check_size(&file).map_err(io_error)?;
    let bytes = input::read_at_most(head.as_slice().chain(file), input::LARGEST_INPUT).map_err(io_error)?;
    let text = input::text_of(bytes).map_err(|error| error::format(path, error.to_string()))?;
    let text = input::without_mark(text);
    let body = text.trim_start();
    if body.is_empty() {
        Err(error::empty(path))
    } else if votable::is_votable(body) {
        votable::read(path, &text)
    } else if body.starts_with('<') {
        Err(error::format(path, "XML or HTML, but not a VOTable"))
    } else if body.starts_with(['{', '[']) {
        json::read(path, body)
    } else if input::is_ecsv(body) {
        delimited::read_ecsv(path, body)
    } else {
        delimited::read_csv(path, text)
    }
}

#[cfg(feature = "sqlite")]
fn read_sqlite(path: &Path) -> Result<RawTable, Error> {
    super::opsim::read(path)
}

#[cfg(not(feature = "sqlite"))]
fn read_sqlite(path: &Path) -> Result<RawTable, Error> {
    let what = "SQLite, which this build does not support (cargo feature sqlite)".to_owned();
    Err(error::format(path, what))
}
