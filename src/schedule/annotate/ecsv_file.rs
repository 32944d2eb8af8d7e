//! ECSV with its bytes untouched: entries added to the header's list, flags to each line, streaks in a file beside it.

use std::path::{Path, PathBuf};

use super::super::error::ScheduleError;
use super::super::formats::{display, ecsv_layout};
use super::beside::{finish, flags_beside, is_kept, read_layout, streaks_path, write_new};
use super::csv_file::{suffix, trailing_columns, without_last_cells};
use super::error::AnnotateError;
use super::write::Annotation;
use crate::output::{Column, ecsv_column, write_ecsv};

pub(super) fn annotate(
    input: &Path,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, AnnotateError> {
    let (text, layout) = read_layout(input, annotation, ecsv_layout, |layout| layout.rows.len())?;
    let flags = flags_beside(&layout.names, annotation.flags);
    let old = trailing_columns(input, &layout.names, &flags, annotation.replace)?;
    let old_names = &layout.names[layout.names.len() - old..];
    let line_end = if text.contains("\r\n") { "\r\n" } else { "\n" };

    let mut out = String::with_capacity(text.len() * 2);
    for &(start, end) in &layout.header_lines {
        let line = &text[start..end];
        let is_old = |name: &String| line.starts_with(&format!("# - {{name: {name},"));
        if !old_names.iter().any(is_old) {
            out.push_str(line);
        }
        if end == layout.datatype_end {
            for (index, column) in flags.columns.iter().enumerate() {
                let values = flags.rows.iter().filter_map(|row| row.get(index));
                let entry = ecsv_column(column, values).map_err(|error| syntax(input, error.to_string()))?;
                out += &format!("# - {entry}{line_end}");
            }
        }
    }
    let names = |column: &Column| column.name.to_owned();
    let mut written = layout.header_lines.last().map_or(0, |(_, end)| *end);
    let (start, end) = layout.names_line;
    out.push_str(&text[written..start]);
    out.push_str(without_last_cells(&text[start..end], old, layout.delimiter));
    out.push_str(&cells(flags.columns.iter().map(names), layout.delimiter)?);
    written = end;
    let mut flag_rows = flags.rows.iter();
    for (row, &(start, end)) in layout.rows.iter().enumerate() {
        if !is_kept(annotation.keep, row) {
            // The line goes, and its end with it.
            written = end;
            continue;
        }
        out.push_str(&text[written..start]);
        out.push_str(without_last_cells(&text[start..end], old, layout.delimiter));
        let texts = flag_rows.next().into_iter().flat_map(|row| flags.columns.iter().zip(row));
        out.push_str(&cells(texts.map(|(column, value)| column.text(value)), layout.delimiter)?);
        written = end;
    }
    out.push_str(&text[written..]);

    let beside = streaks_path(output, "ecsv");
    let streaks = write_new(&beside, |out| write_ecsv(out, annotation.streaks, annotation.provenance))?;
    let main = write_new(output, |file| file.write_all(out.as_bytes()))?;
    finish(vec![(streaks, beside), (main, output.to_owned())])
}

/// A delimiter and the cells behind it.
fn cells(texts: impl Iterator<Item = String>, delimiter: u8) -> Result<String, AnnotateError> {
    if delimiter == b',' {
        let bytes =
            suffix(texts, delimiter).map_err(|source| AnnotateError::Write { path: "cells".to_owned(), source })?;
        return Ok(String::from_utf8_lossy(&bytes).into_owned());
    }
    // Between blanks an empty cell must be seen.
    let quoted = |text: String| {
        let needs = text.is_empty() || text.contains(|c: char| c.is_whitespace() || c == '"');
        if needs { format!(" \"{}\"", text.replace('"', "\"\"")) } else { format!(" {text}") }
    };
    Ok(texts.map(quoted).collect())
}

fn syntax(input: &Path, what: String) -> AnnotateError {
    ScheduleError::Format { path: display(input), what }.into()
}
