//! JSON and JSON lines: one object with typed values for each row, with keys in the order of the columns.

use std::io::{self, Write};

use super::provenance::Provenance;
use super::table::{Table, json_members, quoted};

/// One array of objects in a JSON document.
pub struct Section<'a> {
    /// Key of the array.
    pub name: &'a str,
    /// Rows of the array, one object each.
    pub table: &'a Table,
}

/// Writes `{"provenance": {...}, "name": [...], ...}`, one row per line, with the attachments of the provenance at the
/// end.
///
/// Numbers have the same digits as in CSV; a missing value is `null`.
///
/// # Errors
/// Any error of the writer.
pub fn write_json(out: &mut dyn Write, sections: &[Section], provenance: &Provenance) -> io::Result<()> {
    write!(out, "{{\"provenance\": {}", serde_json::to_string_pretty(provenance)?)?;
    for section in sections {
        write!(out, ",\n{}: [", quoted(section.name))?;
        for (index, row) in section.table.rows.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            write!(out, "{comma}\n  {{{}}}", json_members(&section.table.columns, row))?;
        }
        write!(out, "{}]", if section.table.rows.is_empty() { "" } else { "\n" })?;
    }
    for (name, value) in provenance.attached() {
        write!(out, ",\n{}: ", quoted(name))?;
        match value.as_array().filter(|items| !items.is_empty()) {
            Some(items) => {
                let items: Vec<String> = items.iter().map(|item| format!("\n  {item}")).collect();
                write!(out, "[{}\n]", items.join(","))?;
            }
            None => write!(out, "{value}")?,
        }
    }
    writeln!(out, "}}")
}

/// Writes a first line `{"provenance": {...}}` with the attachments of the provenance, then one line for each row.
///
/// # Errors
/// Any error of the writer.
pub fn write_json_lines(out: &mut dyn Write, table: &Table, provenance: &Provenance) -> io::Result<()> {
    let attached: String = provenance.attached().map(|(name, value)| format!(", {}: {value}", quoted(name))).collect();
    writeln!(out, "{{\"provenance\": {}{attached}}}", serde_json::to_string(provenance)?)?;
    for row in &table.rows {
        writeln!(out, "{{{}}}", json_members(&table.columns, row))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{Column, Kind, Value};
    use super::*;

    fn table() -> Table {
        static INNER: [Column; 1] = [Column::real("enter_s", "s", 3, "")];
        Table {
            columns: vec![
                Column::new("zulu", Kind::Text, ""),
                Column::real("alpha", "", 2, ""),
                Column::new("norad_ids", Kind::List { separator: " " }, ""),
                Column::new("chords", Kind::Rows(&INNER), ""),
            ],
            rows: vec![
                vec![
                    "a \"b\"\n".into(),
                    1.239.into(),
                    Value::Integers(vec![44713, 5]),
                    Value::Rows(vec![vec![0.5.into()]]),
                ],
                vec![Value::Null, f64::NAN.into(), Value::List(vec![]), Value::Rows(vec![])],
            ],
        }
    }

    #[test]
    fn documents_parse_and_keep_digits_and_gaps() {
        let mut out = Vec::new();
        let mut provenance = Provenance::default();
        provenance.state("version", "0.1.0");
        let table = table();
        let empty = Table::default();
        let sections = [Section { name: "passes", table: &table }, Section { name: "left_out", table: &empty }];
        write_json(&mut out, &sections, &provenance).unwrap();
        let document: serde_json::Value = serde_json::from_slice(&out).unwrap();
        assert_eq!(
            document,
            serde_json::json!({
                "provenance": {"version": "0.1.0"},
                "passes": [
                    {"zulu": "a \"b\"\n", "alpha": 1.24, "norad_ids": [44713, 5], "chords": [{"enter_s": 0.5}]},
                    {"zulu": null, "alpha": null, "norad_ids": [], "chords": []},
                ],
                "left_out": [],
            })
        );
    }

    #[test]
    fn lines_begin_with_the_provenance() {
        let mut out = Vec::new();
        write_json_lines(&mut out, &table(), &Provenance::default()).unwrap();
        let text = String::from_utf8(out).unwrap();
        let lines: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.len(), 3);
        assert!(lines[0]["provenance"].is_object());
        assert!(text.lines().nth(1).unwrap().starts_with("{\"zulu\""), "keys keep the order of the columns");
    }
}
