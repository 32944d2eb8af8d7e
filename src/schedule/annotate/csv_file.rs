//! CSV with its bytes untouched: flags appended to each line, streaks in a file beside it.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::super::formats::{CsvLayout, csv_layout, display};
use super::beside::{check_rows, earlier_columns, finish, flags_beside, is_kept, read_text, streaks_path, write_new};
use super::error::AnnotateError;
use super::write::Annotation;
use crate::output::{Table, write_csv};

pub(super) fn annotate(
    input: &Path,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, AnnotateError> {
    let text = read_text(input)?;
    // The byte order mark stays, but is no part of the first name.
    let (mark, body) = match text.strip_prefix('\u{feff}') {
        Some(body) => ("\u{feff}", body),
        None => ("", text.as_str()),
    };
    let layout = csv_layout(input, body)?;
    check_rows(input, layout.rows.len(), annotation)?;
    let flags = flags_beside(&layout.names, annotation.flags);
    let old = trailing_columns(input, &layout.names, &flags, annotation.replace)?;
    let beside = streaks_path(output, "csv");
    let main = write_new(output, |out| {
        out.write_all(mark.as_bytes())?;
        write_lines(out, body, &layout, &flags, old, annotation.keep)
    })?;
    let streaks = write_new(&beside, |out| write_csv(out, annotation.streaks, annotation.provenance))?;
    finish(vec![(streaks, beside), (main, output.to_owned())])
}

/// How many columns at the right an earlier annotation left; they are cut off where they may be replaced.
pub(super) fn trailing_columns(
    input: &Path,
    names: &[String],
    flags: &Table,
    replace: bool,
) -> Result<usize, AnnotateError> {
    let there = earlier_columns(input, names, flags, replace)?;
    if there.iter().rev().zip((0..names.len()).rev()).all(|(index, last)| *index == last) {
        return Ok(there.len());
    }
    let there: Vec<&str> = there.iter().map(|&index| names[index].as_str()).collect();
    let what = format!("columns among its own {}", there.join(", "));
    Err(AnnotateError::AlreadyThere { path: display(input), what })
}

fn write_lines(
    out: &mut dyn Write,
    body: &str,
    layout: &CsvLayout,
    flags: &Table,
    old: usize,
    keep: Option<&[bool]>,
) -> io::Result<()> {
    let delimiter = layout.delimiter;
    let header = &body[..layout.header_end];
    out.write_all(without_last_cells(header, old, delimiter).as_bytes())?;
    out.write_all(&suffix(flags.columns.iter().map(|column| column.name.to_owned()), delimiter)?)?;
    let mut written = layout.header_end;
    let mut flag_rows = flags.rows.iter();
    for (number, (end, cells)) in layout.row_ends.iter().zip(&layout.rows).enumerate() {
        if !is_kept(keep, number) {
            // Comments before a row that goes stay.
            out.write_all(before_record(&body[written..*end]).as_bytes())?;
            written = *end;
            continue;
        }
        let Some(row) = flag_rows.next() else { break };
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

/// What stands before a record in a piece that ends with it: comments and blank lines, less the line end that goes with the record.
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

/// A delimiter and the cells behind it, quoted where they need it.
pub(super) fn suffix(cells: impl Iterator<Item = String>, delimiter: u8) -> io::Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().delimiter(delimiter).from_writer(vec![delimiter]);
    writer.write_record(cells)?;
    let mut bytes = writer.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
    // The writer ends its record with one line feed; the line's own end comes from the file.
    bytes.pop();
    Ok(bytes)
}

/// The record without its last cells; delimiters within quotes part nothing.
pub(super) fn without_last_cells(record: &str, count: usize, delimiter: u8) -> &str {
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
    use crate::output::{Column, Kind, Provenance, Value};

    fn flags(verdicts: &[&str]) -> Table {
        let row = |verdict: &&str| vec!["id".into(), (*verdict).into(), Value::Text("a, \"b\"".into())];
        Table {
            columns: ["exposure_id", "verdict", "reasons"].map(|name| Column::new(name, Kind::Text, "")).to_vec(),
            rows: verdicts.iter().map(row).collect(),
        }
    }

    fn run(text: &str, verdicts: &[&str], replace: bool) -> Result<String, AnnotateError> {
        run_rows(text, verdicts, replace, None)
    }

    fn run_rows(text: &str, verdicts: &[&str], replace: bool, keep: Option<&[bool]>) -> Result<String, AnnotateError> {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
        std::fs::write(&input, text).unwrap();
        let (flags, streaks, provenance) = (flags(verdicts), Table::default(), Provenance::default());
        let annotation = Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace, keep };
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
    fn rows_that_are_not_asked_for_go_with_their_lines() {
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
    fn a_file_that_grew_is_left_alone() {
        let answer = run("id,n\n1,2\n", &["clear", "clear"], false);
        assert!(matches!(answer, Err(AnnotateError::Changed { rows: 1, flags: 2, .. })));
    }
}
