//! CSV with its bytes untouched: flags appended to each line, streaks in a file beside it.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::table::{AtomicFile, Table, write_csv};

use super::super::error::ScheduleError;
use super::super::formats::{CsvLayout, csv_layout, display};
use super::error::AnnotateError;
use super::write::Annotation;

/// The schedule names its exposures itself.
const OWN_COLUMN: &str = "exposure_id";

pub(super) fn annotate(
    input: &Path,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, AnnotateError> {
    let text = std::fs::read_to_string(input).map_err(|source| ScheduleError::Io { path: display(input), source })?;
    // The byte order mark stays, but is no part of the first name.
    let (mark, body) = match text.strip_prefix('\u{feff}') {
        Some(body) => ("\u{feff}", body),
        None => ("", text.as_str()),
    };
    let layout = csv_layout(input, body)?;
    let flags = annotation.flags.without(&[OWN_COLUMN]);
    if layout.rows.len() != flags.rows.len() {
        let (rows, flags) = (layout.rows.len(), flags.rows.len());
        return Err(AnnotateError::Changed { path: display(input), rows, flags });
    }
    let old = earlier_columns(input, &layout, &flags, annotation.replace)?;
    let beside = streaks_path(output);
    let write_error = |path: &Path, source| AnnotateError::Write { path: display(path), source };
    let main = write_new(output, |out| {
        out.write_all(mark.as_bytes())?;
        write_lines(out, body, &layout, &flags, old)
    })
    .map_err(|source| write_error(output, source))?;
    let streaks = write_new(&beside, |out| write_csv(out, annotation.streaks, annotation.provenance))
        .map_err(|source| write_error(&beside, source))?;
    streaks.finish().map_err(|source| write_error(&beside, source))?;
    main.finish().map_err(|source| write_error(output, source))?;
    Ok(vec![output.to_owned(), beside])
}

/// `night.csv` has its streaks in `night.streaks.csv`.
fn streaks_path(output: &Path) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(".streaks.csv");
    output.with_file_name(name)
}

fn write_new(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<AtomicFile> {
    let file = AtomicFile::new(path)?;
    let mut out = io::BufWriter::new(file.file());
    write(&mut out)?;
    out.flush()?;
    drop(out);
    Ok(file)
}

/// How many columns at the right an earlier annotation left; they are cut off where they may be replaced.
fn earlier_columns(input: &Path, layout: &CsvLayout, flags: &Table, replace: bool) -> Result<usize, AnnotateError> {
    let is_flag = |name: &&String| flags.columns.iter().any(|column| column.name == *name);
    let there: Vec<&str> = layout.names.iter().filter(is_flag).map(String::as_str).collect();
    let trailing = layout.names.iter().rev().take_while(is_flag).count();
    if there.is_empty() {
        Ok(0)
    } else if replace && trailing == there.len() {
        Ok(trailing)
    } else {
        let kind = if replace { "columns among its own" } else { "columns" };
        Err(AnnotateError::AlreadyThere { path: display(input), what: format!("{kind} {}", there.join(", ")) })
    }
}

fn write_lines(out: &mut dyn Write, body: &str, layout: &CsvLayout, flags: &Table, old: usize) -> io::Result<()> {
    let delimiter = layout.delimiter;
    let header = &body[..layout.header_end];
    out.write_all(without_last_cells(header, old, delimiter).as_bytes())?;
    out.write_all(&suffix(flags.columns.iter().map(|column| column.name.to_owned()), delimiter)?)?;
    let mut written = layout.header_end;
    for ((end, cells), row) in layout.row_ends.iter().zip(&layout.rows).zip(&flags.rows) {
        // A row of another length than the header's was never annotated in its columns.
        let cut = if cells.len() == layout.names.len() { old } else { 0 };
        out.write_all(without_last_cells(&body[written..*end], cut, delimiter).as_bytes())?;
        // A short row is filled up, so that the flags stand below their names.
        for _ in cells.len()..layout.names.len() - old {
            out.write_all(&[delimiter])?;
        }
        let texts = flags.columns.iter().zip(row).map(|(column, value)| column.text(value));
        out.write_all(&suffix(texts, delimiter)?)?;
        written = *end;
    }
    out.write_all(&body.as_bytes()[written..])
}

/// A delimiter and the cells behind it, quoted where they need it.
fn suffix(cells: impl Iterator<Item = String>, delimiter: u8) -> io::Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().delimiter(delimiter).from_writer(vec![delimiter]);
    writer.write_record(cells)?;
    let mut bytes = writer.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
    // The writer ends its record with one line feed; the line's own end comes from the file.
    bytes.pop();
    Ok(bytes)
}

/// The record without its last cells; delimiters within quotes part nothing.
fn without_last_cells(record: &str, count: usize, delimiter: u8) -> &str {
    if count == 0 {
        return record;
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
    end.map_or(record, |end| &record[..*end])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Column, Kind, Provenance, Value};

    fn flags(verdicts: &[&str]) -> Table {
        let row = |verdict: &&str| vec!["id".into(), (*verdict).into(), Value::Text("a, \"b\"".into())];
        Table {
            columns: ["exposure_id", "verdict", "reasons"].map(|name| Column::new(name, Kind::Text, "")).to_vec(),
            rows: verdicts.iter().map(row).collect(),
        }
    }

    fn run(text: &str, verdicts: &[&str], replace: bool) -> Result<String, AnnotateError> {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
        std::fs::write(&input, text).unwrap();
        let (flags, streaks, provenance) = (flags(verdicts), Table::default(), Provenance::default());
        let annotation = Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace };
        let written = annotate(&input, &output, &annotation)?;
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
    fn an_earlier_annotation_is_replaced_only_when_told() {
        let first = run("id,n\n1,\"2,3\"\n", &["clear"], false).unwrap();
        let error = run(&first, &["avoid"], false).unwrap_err().to_string();
        assert!(error.contains("already has columns verdict, reasons") && error.contains("--replace"), "{error}");
        let second = run(&first, &["avoid"], true).unwrap();
        assert_eq!(second, first.replace("clear", "avoid"));
    }

    #[test]
    fn a_file_that_grew_is_left_alone() {
        let answer = run("id,n\n1,2\n", &["clear", "clear"], false);
        assert!(matches!(answer, Err(AnnotateError::Changed { rows: 1, flags: 2, .. })));
    }
}
