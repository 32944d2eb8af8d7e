//! JSON with its bytes untouched: flags as further members of each row, streaks as a member of the document or in a file beside it.

use std::path::{Path, PathBuf};

use super::super::formats::{JsonRow, Members, display, json_layout};
use super::beside::{OWN_COLUMN, finish, is_kept, read_layout, streaks_path, write_new};
use super::error::AnnotateError;
use super::write::Annotation;
use crate::output::{Section, json_members, json_rows, write_json};

/// What is added to a document.
const ADDED: [&str; 2] = ["streaks", "streak_provenance"];

pub(super) fn annotate(
    input: &Path,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, AnnotateError> {
    let (text, layout) = read_layout(input, annotation, json_layout, |layout| layout.rows.len())?;
    let has_ids = layout
        .rows
        .iter()
        .filter_map(|row| row.members.as_ref())
        .any(|members| members.ends.iter().any(|(key, _)| super::super::formats::ID.contains(&key.as_str())));
    let flags = if has_ids { annotation.flags.without(&[OWN_COLUMN]) } else { annotation.flags.clone() };
    let names: Vec<&str> = flags.columns.iter().map(|column| column.name).collect();
    let rows = || layout.rows.iter().filter_map(|row| row.members.as_ref());
    let annotated = rows().any(|members| members.ends.iter().any(|(key, _)| names.contains(&key.as_str())))
        || layout.document.iter().any(|document| document.ends.iter().any(|(key, _)| ADDED.contains(&key.as_str())));
    if annotated && !annotation.replace {
        let what = "members verdict, streaks and so on".to_owned();
        return Err(AnnotateError::AlreadyThere { path: display(input), what });
    }

    // Pieces of the old text and new ones in turn.
    let mut out = String::with_capacity(text.len() * 2);
    let mut written = 0;
    let mut any = false;
    let mut flag_rows = flags.rows.iter();
    for (number, row) in layout.rows.iter().enumerate() {
        let JsonRow { span: (start, end), members } = row;
        if !is_kept(annotation.keep, number) {
            if number == 0 {
                out.push_str(&text[..*start]);
            }
            written = *end;
            continue;
        }
        // The first row that stays needs no comma before it.
        if any || number == 0 {
            out.push_str(&text[written..*start]);
        }
        any = true;
        written = *start;
        let flags_of_row = flag_rows.next();
        if let (Some(members), Some(values)) = (members, flags_of_row) {
            written = add(&mut out, &text, written, members, &names, &json_members(&flags.columns, values));
        }
        out.push_str(&text[written..*end]);
        written = *end;
    }
    let mut files = Vec::new();
    match &layout.document {
        Some(document) => {
            let provenance = serde_json::to_string(annotation.provenance).unwrap_or_default();
            let streaks = json_rows(&annotation.streaks.columns, &annotation.streaks.rows);
            let added = format!("\"streaks\": {streaks}, \"streak_provenance\": {provenance}");
            written = add(&mut out, &text, written, document, &ADDED, &added);
        }
        None => {
            let beside = streaks_path(output, "json");
            let sections = [Section { name: "streaks", table: annotation.streaks }];
            files.push((write_new(&beside, |out| write_json(out, &sections, annotation.provenance))?, beside));
        }
    }
    out.push_str(&text[written..]);
    files.push((write_new(output, |file| file.write_all(out.as_bytes()))?, output.to_owned()));
    finish(files)
}

/// Adds members behind an object's own, in the place of earlier ones; where the old text goes on.
fn add(out: &mut String, text: &str, written: usize, members: &Members, earlier: &[&str], added: &str) -> usize {
    let own = members.ends.iter().rfind(|(key, _)| !earlier.contains(&key.as_str()));
    let last = members.ends.last().map_or(members.open, |(_, end)| *end);
    let own_end = own.map_or(members.open, |(_, end)| *end);
    out.push_str(&text[written..own_end.max(written)]);
    if own.is_some() {
        out.push_str(", ");
    }
    out.push_str(added);
    last.max(written)
}
