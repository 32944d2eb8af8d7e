//! Annotation of VOTable: verdicts are added as fields and cells of the first table, streaks as a table after it. The
//! original text is otherwise unchanged.

use std::path::{Path, PathBuf};

use super::super::error;
use super::super::formats::{Span, votable_layout};
use super::annotation::{Annotation, Edits, finish, read_text, write_new};
use crate::error::Error;
use crate::output::{votable_cells, votable_fields, votable_table};

const STREAKS: &str = "streaks";

pub(super) fn annotate(input: &Path, output: &Path, annotation: &Annotation<'_>) -> Result<Vec<PathBuf>, Error> {
    let text = read_text(input)?;
    let layout = votable_layout(input, &text)?;
    annotation.check_rows(input, layout.rows.len())?;
    let flags = annotation.flags_for(layout.names.iter().map(String::as_str));
    let earlier_columns = annotation.earlier_columns(input, &layout.names, &flags)?;
    let earlier_tables = || layout.others.iter().filter(|(name, _)| name == STREAKS).map(|(_, span)| span);
    if earlier_tables().next().is_some() && !annotation.replace {
        return Err(error::already_there(input, &format!("a table {STREAKS}")));
    }
    if let Some(short) = layout.rows.iter().position(|row| row.cells.len() != layout.names.len()) {
        let (cells, fields) = (layout.rows[short].cells.len(), layout.names.len());
        let what = format!("row {} has {cells} cells but the header has {fields}", short + 1);
        return Err(error::format(input, what));
    }

    let mut edits = Edits::default();
    let remove = |edits: &mut Edits, span: &Span| edits.remove(span.after..span.end);
    earlier_columns.iter().for_each(|&index| remove(&mut edits, &layout.fields[index]));
    earlier_tables().for_each(|span| remove(&mut edits, span));
    if let Some(last) = layout.fields.last() {
        edits.insert(last.end, votable_fields(&flags.columns).iter().map(|field| format!("\n{field}")).collect());
    }
    let mut flag_rows = flags.rows.iter();
    for (number, row) in layout.rows.iter().enumerate() {
        if !annotation.is_kept(number) {
            remove(&mut edits, &row.span);
            continue;
        }
        earlier_columns.iter().for_each(|&index| remove(&mut edits, &row.cells[index]));
        let cells = flag_rows.next().map(|values| votable_cells(&flags.columns, values)).unwrap_or_default();
        edits.insert(row.cells.last().map_or(row.span.start, |cell| cell.end), cells);
    }
    let streaks = votable_table(STREAKS, annotation.streaks, annotation.provenance);
    edits.insert(layout.table.end, format!("\n{streaks}"));
    let out = edits.apply(&text);
    finish(vec![(write_new(output, |file| file.write_all(out.as_bytes()))?, output.to_owned())])
}
