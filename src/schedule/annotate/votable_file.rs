//! VOTable with its bytes untouched: fields and cells added to its first table, streaks as a table of their own behind it.

use std::path::{Path, PathBuf};

use super::super::error::ScheduleError;
use super::super::formats::{Span, VoTableLayout, display, votable_layout};
use super::beside::{earlier_columns, finish, flags_beside, is_kept, read_layout, write_new};
use super::error::AnnotateError;
use super::write::Annotation;
use crate::output::{votable_cells, votable_fields, votable_table};

const STREAKS: &str = "streaks";

pub(super) fn annotate(
    input: &Path,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, AnnotateError> {
    let (text, layout) = read_layout(input, annotation, votable_layout, |layout| layout.rows.len())?;
    let flags = flags_beside(&layout.names, annotation.flags);
    let old = earlier_columns(input, &layout.names, &flags, annotation.replace)?;
    let earlier: Vec<Span> = layout.others.iter().filter(|(name, _)| name == STREAKS).map(|(_, span)| *span).collect();
    if !earlier.is_empty() && !annotation.replace {
        return Err(AnnotateError::AlreadyThere { path: display(input), what: format!("a table {STREAKS}") });
    }
    if let Some(short) = layout.rows.iter().position(|row| row.cells.len() != layout.names.len()) {
        let (cells, fields) = (layout.rows[short].cells.len(), layout.names.len());
        let what = format!("row {} has {cells} cells, the header {fields}", short + 1);
        return Err(ScheduleError::Format { path: display(input), what }.into());
    }

    let mut edits: Vec<Edit> = Vec::new();
    cut_all(&mut edits, &layout, &old, &earlier, annotation);
    let fields: String = votable_fields(&flags.columns).iter().map(|field| format!("\n{field}")).collect();
    edits.extend(layout.fields.last().map(|last| Edit { start: last.end, end: last.end, new: fields }));
    let mut flag_rows = flags.rows.iter();
    for (row, places) in layout.rows.iter().enumerate().filter(|(row, _)| is_kept(annotation.keep, *row)) {
        let cells = flag_rows.next().map(|values| votable_cells(&flags.columns, values)).unwrap_or_default();
        let end = places.cells.last().map_or(layout.rows[row].span.start, |cell| cell.end);
        edits.push(Edit { start: end, end, new: cells });
    }
    let streaks = format!("\n{}", votable_table(STREAKS, annotation.streaks, annotation.provenance));
    edits.push(Edit { start: layout.table.end, end: layout.table.end, new: streaks });
    let out = edited(&text, edits);
    finish(vec![(write_new(output, |file| file.write_all(out.as_bytes()))?, output.to_owned())])
}

/// New text in the place of old.
struct Edit {
    start: usize,
    end: usize,
    new: String,
}

/// What goes: rows that are not wanted, and all of an earlier annotation.
fn cut_all(
    edits: &mut Vec<Edit>,
    layout: &VoTableLayout,
    old: &[usize],
    earlier: &[Span],
    annotation: &Annotation<'_>,
) {
    let mut cut = |span: &Span| edits.push(Edit { start: span.after, end: span.end, new: String::new() });
    old.iter().filter_map(|&index| layout.fields.get(index)).for_each(&mut cut);
    earlier.iter().for_each(&mut cut);
    for (row, places) in layout.rows.iter().enumerate() {
        if is_kept(annotation.keep, row) {
            old.iter().filter_map(|&index| places.cells.get(index)).for_each(&mut cut);
        } else {
            cut(&places.span);
        }
    }
}

fn edited(text: &str, mut edits: Vec<Edit>) -> String {
    // What is cut ends where something new is put in: the cut goes first.
    edits.sort_by_key(|edit| (edit.start, edit.end));
    let mut out = String::with_capacity(text.len() * 2);
    let mut written = 0;
    for edit in edits {
        out.push_str(&text[written..edit.start.max(written)]);
        out.push_str(&edit.new);
        written = written.max(edit.end);
    }
    out.push_str(&text[written..]);
    out
}
