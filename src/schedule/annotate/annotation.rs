//! Results to add to a schedule, edits of its text, and output files.

use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::super::error;
use super::super::formats::ID;
use crate::error::Error;
use crate::output::{AtomicFile, Provenance, Table};

/// Column of the exposure identifier; not added if the schedule has one.
const ID_COLUMN: &str = "exposure_id";

/// Results to add to a schedule file.
pub struct Annotation<'a> {
    /// Verdicts, one row for each row of the schedule that is kept, from [`flag_table`](super::super::flag_table).
    pub flags: &'a Table,
    /// Streaks, one row for each exposure and satellite, from [`streak_table`](super::super::streak_table).
    pub streaks: &'a Table,
    /// Provenance of both tables.
    pub provenance: &'a Provenance,
    /// If true, an earlier annotation is replaced; otherwise it is an error.
    pub replace: bool,
    /// For each row of the schedule, true if it is kept in the output; all rows if `None`.
    pub keep: Option<&'a [bool]>,
}

impl Annotation<'_> {
    /// Returns true if a row of the schedule is kept in the output.
    pub(super) fn is_kept(&self, row: usize) -> bool {
        self.keep.is_none_or(|keep| keep.get(row).copied().unwrap_or(false))
    }

    /// Checks that the file has the same number of rows as when it was judged.
    pub(super) fn check_rows(&self, input: &Path, rows: usize) -> Result<(), Error> {
        let expected = self.keep.map_or(self.flags.rows.len(), <[bool]>::len);
        if rows == expected {
            return Ok(());
        }
        Err(error::changed(input, rows, expected))
    }

    /// Returns the verdict columns, without the exposure identifier if the schedule has a column of identifiers.
    pub(super) fn flags_for<'a>(&self, mut names: impl Iterator<Item = &'a str>) -> Table {
        if names.any(|name| ID.contains(&name)) { self.flags.without(&[ID_COLUMN]) } else { self.flags.clone() }
    }

    /// Returns the indices of the columns of an earlier annotation.
    ///
    /// # Errors
    /// An earlier annotation exists and `replace` is false.
    pub(super) fn earlier_columns(&self, input: &Path, names: &[String], flags: &Table) -> Result<Vec<usize>, Error> {
        let is_flag = |name: &String| flags.columns.iter().any(|column| column.name == name);
        let earlier: Vec<usize> = (0..names.len()).filter(|&index| is_flag(&names[index])).collect();
        if earlier.is_empty() || self.replace {
            return Ok(earlier);
        }
        let shown: Vec<&str> = earlier.iter().map(|&index| names[index].as_str()).collect();
        Err(error::already_there(input, &format!("columns {}", shown.join(", "))))
    }
}

/// Reads a schedule as text, with its byte order mark, which is copied to the output.
pub(super) fn read_text(input: &Path) -> Result<String, Error> {
    crate::input::read(input)
        .and_then(crate::input::text_of)
        .map_err(|source| Error::system(source).in_file("schedule", input))
}

/// Insertions into a text and removals of byte ranges. All other bytes are unchanged.
#[derive(Default)]
pub(super) struct Edits(Vec<(Range<usize>, String)>);

impl Edits {
    /// Inserts text at a byte position.
    pub fn insert(&mut self, at: usize, text: String) {
        self.0.push((at..at, text));
    }

    /// Removes a byte range.
    pub fn remove(&mut self, range: Range<usize>) {
        self.0.push((range, String::new()));
    }

    /// Returns the edited copy of `text`.
    pub fn apply(mut self, text: &str) -> String {
        // A removal that ends at the position of an insertion is applied before it; a removal that starts there is
        // applied after it.
        self.0.sort_by_key(|(range, _)| (range.start, range.end));
        let mut out = String::with_capacity(text.len() * 2);
        let mut written = 0;
        for (range, new) in self.0 {
            out.push_str(&text[written..range.start.max(written)]);
            out.push_str(&new);
            written = written.max(range.end);
        }
        out.push_str(&text[written..]);
        out
    }
}

/// Returns the path of the streak file: `night.streaks.csv` for `night.csv`.
pub(super) fn streaks_path(output: &Path, extension: &str) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(".streaks.");
    name.push(extension);
    output.with_file_name(name)
}

/// Writes a temporary file, which [`finish`] renames to its path.
pub(super) fn write_new(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<AtomicFile, Error> {
    let error = |source| Error::cannot("write", path, source);
    let file = AtomicFile::new(path).map_err(error)?;
    let mut out = io::BufWriter::new(file.file());
    write(&mut out).and_then(|()| out.flush()).map_err(error)?;
    drop(out);
    Ok(file)
}

/// Renames temporary files to their paths, the annotated schedule last. Returns the paths, the schedule first.
pub(super) fn finish(files: Vec<(AtomicFile, PathBuf)>) -> Result<Vec<PathBuf>, Error> {
    let mut written = Vec::new();
    for (file, path) in files {
        file.finish().map_err(|source| Error::cannot("write", &path, source))?;
        written.push(path);
    }
    written.reverse();
    Ok(written)
}
