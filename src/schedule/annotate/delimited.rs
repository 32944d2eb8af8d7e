//! Annotation of CSV and ECSV: verdict columns are appended to each line, streaks are written to a second file. The
//! original text is otherwise unchanged.

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::super::error;
use super::super::formats::{csv_layout, ecsv_layout};
use super::annotation::{Annotation, Edits, finish, read_text, streaks_path, write_new};
use crate::error::Error;
use crate::output::{Table, ecsv_column, write_csv, write_ecsv};

pub(super) fn annotate_csv(input: &Path, output: &Path, annotation: &Annotation<'_>) -> Result<Vec<PathBuf>, Error> {
    let text = read_text(input)?;
    // The byte order mark is kept, and is not part of the first column name.
    let (mark, body) = match text.strip_prefix('\u{feff}') {
        Some(body) => ("\u{feff}", body),
        None => ("", text.as_str()),
    };
    let layout = csv_layout(input, body)?;
    annotation.check_rows(input, layout.rows.len())?;
    let flags = annotation.flags_for(layout.names.iter().map(String::as_str));
    let width = layout.names.len();
    let mut lines =
        Lines::new(body, layout.delimiter, &flags, trailing_columns(input, &layout.names, &flags, annotation)?);
    lines.append_names(0..layout.header_end)?;
    let mut start = layout.header_end;
    for (row, &(end, cells)) in layout.rows.iter().enumerate() {
        if !annotation.is_kept(row) {
            // Comments before a removed row are kept.
            lines.edits.remove(start + before_record(&body[start..end]).len()..end);
        } else {
            // A row with more or fewer cells than the header has no cells of an earlier annotation. A short row is
            // padded with empty cells, so that the verdict columns are aligned with their names.
            let earlier = if cells == width { lines.earlier } else { 0 };
            lines.append_flags(start..end, earlier, (width - lines.earlier).saturating_sub(cells))?;
        }
        start = end;
    }
    let out = lines.edits.apply(body);
    let main = write_new(output, |file| {
        file.write_all(mark.as_bytes())?;
        file.write_all(out.as_bytes())
    })?;
    let beside = streaks_path(output, "csv");
    let streaks = write_new(&beside, |out| write_csv(out, annotation.streaks, annotation.provenance))?;
    finish(vec![(streaks, beside), (main, output.to_owned())])
}

pub(super) fn annotate_ecsv(input: &Path, output: &Path, annotation: &Annotation<'_>) -> Result<Vec<PathBuf>, Error> {
    let text = read_text(input)?;
    let layout = ecsv_layout(input, &text)?;
    annotation.check_rows(input, layout.rows.len())?;
    let flags = annotation.flags_for(layout.names.iter().map(String::as_str));
    let earlier = trailing_columns(input, &layout.names, &flags, annotation)?;
    let earlier_names = &layout.names[layout.names.len() - earlier..];
    let mut lines = Lines::new(&text, layout.delimiter, &flags, earlier);
    for &(start, end) in &layout.header_lines {
        let is_entry = |name: &String| text[start..end].starts_with(&format!("# - {{name: {name},"));
        if earlier_names.iter().any(is_entry) {
            lines.edits.remove(start..end);
        }
    }
    // A header without the list of columns is not changed.
    if layout.header_lines.iter().any(|(_, end)| *end == layout.datatype_end) {
        let line_end = if text.contains("\r\n") { "\r\n" } else { "\n" };
        let mut entries = String::new();
        for (index, column) in flags.columns.iter().enumerate() {
            let values = flags.rows.iter().filter_map(|row| row.get(index));
            let entry = ecsv_column(column, values).map_err(|error| error::format(input, error.to_string()))?;
            entries += &format!("# - {entry}{line_end}");
        }
        lines.edits.insert(layout.datatype_end, entries);
    }
    lines.append_names(layout.names_line.0..layout.names_line.1)?;
    let mut before = layout.names_line.1;
    for (row, &(start, end)) in layout.rows.iter().enumerate() {
        if annotation.is_kept(row) {
            lines.append_flags(start..end, earlier, 0)?;
        } else {
            lines.edits.remove(before..end);
        }
        before = end;
    }
    let out = lines.edits.apply(&text);
    let beside = streaks_path(output, "ecsv");
    let streaks = write_new(&beside, |out| write_ecsv(out, annotation.streaks, annotation.provenance))?;
    let main = write_new(output, |file| file.write_all(out.as_bytes()))?;
    finish(vec![(streaks, beside), (main, output.to_owned())])
}

/// Returns the number of columns of an earlier annotation, which must be the last columns.
fn trailing_columns(
    input: &Path,
    names: &[String],
    flags: &Table,
    annotation: &Annotation<'_>,
) -> Result<usize, Error> {
    let earlier = annotation.earlier_columns(input, names, flags)?;
    if earlier.iter().rev().zip((0..names.len()).rev()).all(|(index, last)| *index == last) {
        return Ok(earlier.len());
    }
    let earlier: Vec<&str> = earlier.iter().map(|&index| names[index].as_str()).collect();
    let what = format!("columns {}, which are not the last ones", earlier.join(", "));
    Err(error::already_there(input, &what))
}

/// Lines of the file, with the edits that append the verdict columns and remove those of an earlier annotation.
struct Lines<'a> {
    text: &'a str,
    delimiter: u8,
    flags: &'a Table,
    /// Rows of verdicts that are not yet appended.
    flag_rows: std::slice::Iter<'a, Vec<crate::output::Value>>,
    /// Number of columns of the earlier annotation.
    earlier: usize,
    edits: Edits,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, delimiter: u8, flags: &'a Table, earlier: usize) -> Self {
        Self { text, delimiter, flags, flag_rows: flags.rows.iter(), earlier, edits: Edits::default() }
    }

    /// Appends the names of the verdict columns to the line of names.
    fn append_names(&mut self, line: Range<usize>) -> Result<(), Error> {
        let names = self.flags.columns.iter().map(|column| column.name.to_owned());
        let names = cells(names, self.delimiter)?;
        self.append(line, self.earlier, names);
        Ok(())
    }

    /// Appends the next row of verdicts to a line, after `empty` empty cells; removes the last `earlier` cells.
    fn append_flags(&mut self, line: Range<usize>, earlier: usize, empty: usize) -> Result<(), Error> {
        let row = self.flag_rows.next().into_iter().flat_map(|row| self.flags.columns.iter().zip(row));
        let texts = cells(row.map(|(column, value)| column.text(value)), self.delimiter)?;
        let filled = char::from(self.delimiter).to_string().repeat(empty) + &texts;
        self.append(line, earlier, filled);
        Ok(())
    }

    fn append(&mut self, line: Range<usize>, earlier: usize, texts: String) {
        let end = line.start + length_without(&self.text[line.clone()], earlier, self.delimiter);
        self.edits.remove(end..line.end);
        self.edits.insert(line.end, texts);
    }
}

/// Returns the comments and blank lines before the record at the end of `piece`, without the last line break.
fn before_record(piece: &str) -> &str {
    let mut start = 0;
    loop {
        start = piece.len() - piece[start..].trim_start_matches(['\r', '\n']).len();
        if !piece[start..].starts_with('#') {
            break;
        }
        start += piece[start..].find('\n').unwrap_or(piece.len() - start);
    }
    let before = &piece[..start];
    before.strip_suffix("\r\n").or_else(|| before.strip_suffix('\n')).unwrap_or(before)
}

/// Returns cells as text to append: each with a separator before it, quoted if necessary.
fn cells(texts: impl Iterator<Item = String>, delimiter: u8) -> Result<String, Error> {
    if delimiter == b' ' {
        // With a blank as separator, an empty cell must be quoted.
        let quoted = |text: String| {
            let needs_quotes = text.is_empty() || text.contains(|c: char| c.is_whitespace() || c == '"');
            if needs_quotes { format!(" \"{}\"", text.replace('"', "\"\"")) } else { format!(" {text}") }
        };
        return Ok(texts.map(quoted).collect());
    }
    let error = |source| Error::cannot("write", "cells", source);
    let mut writer = csv::WriterBuilder::new().delimiter(delimiter).from_writer(vec![delimiter]);
    writer.write_record(texts).map_err(|source| error(source.into()))?;
    let bytes = writer.into_inner().map_err(|source| error(io::Error::other(source.to_string())))?;
    // The CSV writer ends its record with a line feed, but the file already has a line break.
    Ok(String::from_utf8_lossy(bytes.strip_suffix(b"\n").unwrap_or(&bytes)).into_owned())
}

/// Returns the length of a record without its last `count` cells. Delimiters within quotes are ignored.
fn length_without(record: &str, count: usize, delimiter: u8) -> usize {
    if count == 0 {
        return record.len();
    }
    let mut quoted = false;
    let ends: Vec<usize> = record
        .bytes()
        .enumerate()
        .filter_map(|(at, byte)| {
            quoted ^= byte == b'"';
            (byte == delimiter && !quoted).then_some(at)
        })
        .collect();
    let end = ends.len().checked_sub(count).and_then(|kept| ends.get(kept));
    end.map_or(record.len(), |end| *end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Column, Kind, Provenance, Value};

    fn flags(verdicts: &[&str]) -> Table {
        let row = |verdict: &&str| vec!["id".into(), (*verdict).into(), Value::Text("a, \"b\"".into())];
        Table {
            columns: ["exposure_id", "verdict", "reasons"].map(|name| Column::new(name, Kind::Text, "")).to_vec(),
            rows: verdicts.iter().map(row).collect(),
        }
    }

    fn run(text: &str, verdicts: &[&str], replace: bool) -> Result<String, Error> {
        run_rows(text, verdicts, replace, None)
    }

    fn run_rows(text: &str, verdicts: &[&str], replace: bool, keep: Option<&[bool]>) -> Result<String, Error> {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
        std::fs::write(&input, text).unwrap();
        let (flags, streaks, provenance) = (flags(verdicts), Table::default(), Provenance::default());
        let annotation = Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace, keep };
        let written = annotate_csv(&input, &output, &annotation)?;
        assert_eq!(written, [output.clone(), folder.path().join("out.streaks.csv")]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
        Ok(std::fs::read_to_string(output).unwrap())
    }

    #[test]
    fn bytes_stay_and_flags_follow() {
        let text = "\u{feff}# by hand\r\nid;n\r\n \"1\" ;0.10\r\n\r\n2;\"x\r\ny\"\r\n# end\r\n3\r\n";
        let expected = "\u{feff}# by hand\r\nid;n;verdict;reasons\r\n \"1\" ;0.10;clear;\"a, \"\"b\"\"\"\r\n\r\n\
                        2;\"x\r\ny\";avoid;\"a, \"\"b\"\"\"\r\n# end\r\n3;;streaked;\"a, \"\"b\"\"\"\r\n";
        assert_eq!(run(text, &["clear", "avoid", "streaked"], false).unwrap(), expected);
    }

    #[test]
    fn no_line_end_at_the_end_of_the_file() {
        let expected = "id,n,verdict,reasons\n1,2,clear,\"a, \"\"b\"\"\"";
        assert_eq!(run("id,n\n1,2", &["clear"], false).unwrap(), expected);
    }

    #[test]
    fn an_earlier_annotation_is_replaced_only_with_replace() {
        let first = run("id,n\n1,\"2,3\"\n", &["clear"], false).unwrap();
        let error = run(&first, &["avoid"], false).unwrap_err().to_string();
        assert!(error.contains("already has columns verdict, reasons") && error.contains("--replace"), "{error}");
        let second = run(&first, &["avoid"], true).unwrap();
        assert_eq!(second, first.replace("clear", "avoid"));
    }

    #[test]
    fn rows_outside_the_shard_are_removed_with_their_lines() {
        let text = "id,n\r\n1,a\r\n# note\r\n2,\"b\r\nc\"\r\n3,d\r\n";
        let shard = |verdicts: &[&str], keep: [bool; 3]| run_rows(text, verdicts, false, Some(&keep)).unwrap();
        let reasons = "\"a, \"\"b\"\"\"";
        let head = "id,n,verdict,reasons\r\n";
        assert_eq!(
            shard(&["clear"], [false, true, false]),
            format!("{head}# note\r\n2,\"b\r\nc\",clear,{reasons}\r\n")
        );
        assert_eq!(
            shard(&["clear", "avoid"], [true, false, true]),
            format!("{head}1,a,clear,{reasons}\r\n# note\r\n3,d,avoid,{reasons}\r\n")
        );
        assert_eq!(shard(&[], [false; 3]), format!("{head}# note\r\n"));
    }

    #[test]
    fn a_file_that_grew_is_an_error() {
        let result = run("id,n\n1,2\n", &["clear", "clear"], false);
        assert!(result.unwrap_err().to_string().contains("has 1 rows; allowed: the 2 rows that were judged"));
    }
}
