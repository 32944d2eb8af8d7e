//! Annotation of JSON: verdicts are added as members of each row; streaks are added as members of the document or
//! written to a second file. The original text is otherwise unchanged.

use std::path::{Path, PathBuf};

use super::super::error;
use super::super::formats::{Members, json_layout};
use super::annotation::{Annotation, Edits, finish, read_text, streaks_path, write_new};
use crate::error::Error;
use crate::output::{Section, json_members, json_rows, write_json};

/// Members added to a document.
const ADDED: [&str; 2] = ["streaks", "streak_provenance"];

pub(super) fn annotate(input: &Path, output: &Path, annotation: &Annotation<'_>) -> Result<Vec<PathBuf>, Error> {
    let text = read_text(input)?;
    let layout = json_layout(input, &text)?;
    annotation.check_rows(input, layout.rows.len())?;
    let keys = || layout.rows.iter().filter_map(|row| row.members.as_ref()).flat_map(|members| members.keys());
    let flags = annotation.flags_for(keys());
    let names: Vec<&str> = flags.columns.iter().map(|column| column.name).collect();
    let is_annotated = keys().any(|key| names.contains(&key))
        || layout.document.iter().flat_map(|document| document.keys()).any(|key| ADDED.contains(&key));
    if is_annotated && !annotation.replace {
        return Err(error::already_there(input, "members of an annotation (verdict, streaks)"));
    }

    let mut edits = Edits::default();
    let mut flag_rows = flags.rows.iter();
    let (mut before, mut is_first) = (None, true);
    for (number, row) in layout.rows.iter().enumerate() {
        let (start, end) = row.span;
        if !annotation.is_kept(number) {
            // A row is removed together with the comma before it.
            edits.remove(before.unwrap_or(start)..end);
        } else {
            if let (true, Some(before)) = (is_first, before) {
                // The first row that is kept must not follow a comma.
                edits.remove(before..start);
            }
            is_first = false;
            if let (Some(members), Some(values)) = (&row.members, flag_rows.next()) {
                add(&mut edits, members, &names, &json_members(&flags.columns, values));
            }
        }
        before = Some(end);
    }
    let mut files = Vec::new();
    match &layout.document {
        Some(document) => {
            let provenance = serde_json::to_string(annotation.provenance).unwrap_or_default();
            let streaks = json_rows(&annotation.streaks.columns, &annotation.streaks.rows);
            let added = format!("\"streaks\": {streaks}, \"streak_provenance\": {provenance}");
            add(&mut edits, document, &ADDED, &added);
        }
        None => {
            let beside = streaks_path(output, "json");
            let sections = [Section { name: "streaks", table: annotation.streaks }];
            files.push((write_new(&beside, |out| write_json(out, &sections, annotation.provenance))?, beside));
        }
    }
    let out = edits.apply(&text);
    files.push((write_new(output, |file| file.write_all(out.as_bytes()))?, output.to_owned()));
    finish(files)
}

/// Adds members to an object after its existing ones, and removes those of an earlier annotation.
fn add(edits: &mut Edits, members: &Members, earlier: &[&str], added: &str) {
    let own = members.ends.iter().rfind(|(key, _)| !earlier.contains(&key.as_str()));
    let last = members.ends.last().map_or(members.open, |(_, end)| *end);
    let own_end = own.map_or(members.open, |(_, end)| *end);
    edits.insert(own_end, if own.is_some() { format!(", {added}") } else { added.to_owned() });
    edits.remove(own_end..last);
}
