//! CSV and ECSV: a header with provenance, a line with the column names, then the rows.

use std::io::{self, Write};

use super::provenance::Provenance;
use super::table::{Column, Kind, Table, Value};

/// Writes the table as CSV (RFC 4180 quoting, `\n` line ends).
///
/// Each entry of the provenance is a line `# name: value` with the value as JSON. A missing value is an empty cell.
///
/// # Errors
/// Any error of the writer.
pub fn write_csv(out: &mut dyn Write, table: &Table, provenance: &Provenance) -> io::Result<()> {
    for (name, value) in provenance.entries() {
        writeln!(out, "# {name}: {value}")?;
    }
    write_records(out, table, Column::text)
}

/// Writes the rows of a table as CSV without its header, for tables that are written in parts.
///
/// # Errors
/// Any error of the writer.
pub fn write_csv_rows(out: &mut dyn Write, table: &Table) -> io::Result<()> {
    write_rows(&mut csv_writer(out), table, Column::text)
}

/// Writes the table as comma-separated ECSV that `astropy.table.Table.read` opens with units and metadata.
///
/// In astropy, the provenance is in `meta['provenance']`. Texts in the header are JSON strings, which are valid YAML. A
/// missing value is an empty cell, which astropy reads as a masked one.
///
/// # Errors
/// Any error of the writer.
pub fn write_ecsv(out: &mut dyn Write, table: &Table, provenance: &Provenance) -> io::Result<()> {
    writeln!(out, "# %ECSV 1.0")?;
    writeln!(out, "# ---")?;
    writeln!(out, "# delimiter: ','")?;
    writeln!(out, "# datatype:")?;
    for (index, column) in table.columns.iter().enumerate() {
        writeln!(out, "# - {}", ecsv_column(column, table.rows.iter().filter_map(|row| row.get(index)))?)?;
    }
    writeln!(out, "# meta: {{\"provenance\": {}}}", serde_json::to_string(provenance)?)?;
    writeln!(out, "# schema: astropy-2.0")?;
    write_records(out, table, ecsv_text)
}

/// Returns the text of a cell of ECSV, whose reader in astropy accepts only `True` and `False` as truth values.
fn ecsv_text(column: &Column, value: &Value) -> String {
    match value {
        Value::Boolean(true) => "True".to_owned(),
        Value::Boolean(false) => "False".to_owned(),
        _ => column.text(value),
    }
}

/// Returns the header entry of one column: its name, unit, type (which depends on the values) and description.
///
/// # Errors
/// Errors of serialization, which do not occur for text.
pub fn ecsv_column<'a>(column: &Column, mut values: impl Iterator<Item = &'a Value>) -> serde_json::Result<String> {
    let datatype = match column.kind {
        Kind::Integer => "int64",
        Kind::Real { .. } | Kind::Small { .. } => "float64",
        // Astropy's reader rejects missing values in a boolean column.
        Kind::Boolean if values.all(|value| matches!(value, Value::Boolean(_))) => "bool",
        Kind::Boolean | Kind::Text | Kind::Time { .. } | Kind::List { .. } | Kind::Rows(_) => "string",
    };
    let mut text = format!("{{name: {}", column.name);
    if !column.unit.is_empty() {
        text += &format!(", unit: {}", column.unit);
    }
    text += &format!(", datatype: {datatype}");
    if !column.description.is_empty() {
        text += &format!(", description: {}", serde_json::to_string(column.description)?);
    }
    Ok(text + "}")
}

/// Returns the text of one cell of CSV, quoted if necessary.
pub(crate) fn csv_cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) || text.starts_with('#') {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Function that returns the text of a cell.
type CellText = fn(&Column, &Value) -> String;

/// Writes the line of column names and the rows.
fn write_records(out: &mut dyn Write, table: &Table, text: CellText) -> io::Result<()> {
    let mut writer = csv_writer(out);
    writer.write_record(table.columns.iter().map(|column| column.name)).map_err(io_error)?;
    write_rows(&mut writer, table, text)
}

fn csv_writer(out: &mut dyn Write) -> csv::Writer<&mut dyn Write> {
    // A row whose first cell begins with # is quoted: readers, also that of schedules, take it for a comment otherwise.
    csv::WriterBuilder::new().flexible(true).comment(Some(b'#')).from_writer(out)
}

fn write_rows(writer: &mut csv::Writer<&mut dyn Write>, table: &Table, text: CellText) -> io::Result<()> {
    for row in &table.rows {
        let cells = table.columns.iter().zip(row).map(|(column, value)| text(column, value));
        writer.write_record(cells).map_err(io_error)?;
    }
    writer.flush()
}

/// Returns the underlying system error with its kind, because callers check whether it is a closed pipe.
fn io_error(error: csv::Error) -> io::Error {
    let text = error.to_string();
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        _ => io::Error::other(text),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Column, Kind, Value};
    use super::*;

    /// Pipe with a closed reading end.
    struct Closed;

    impl Write for Closed {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::BrokenPipe.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_closed_pipe_is_reported_as_one() {
        let rows = vec![vec![Value::Text("x".repeat(100))]; 10_000];
        let table = Table { columns: vec![Column::new("name", Kind::Text, "")], rows };
        let error = write_records(&mut Closed, &table, Column::text).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
    }

    #[test]
    fn provenance_header_and_quoted_cells() {
        let mut provenance = Provenance::default();
        provenance.state("version", "0.1.0");
        provenance.state("elements", serde_json::json!([{"name": "a, b"}]));
        let table = Table {
            columns: vec![Column::new("name", Kind::Text, ""), Column::real("magnitude", "mag", 2, "")],
            rows: vec![vec!["A \"B\", C".into(), 5.0.into()], vec!["D".into(), Value::Null]],
        };
        let mut out = Vec::new();
        write_csv(&mut out, &table, &provenance).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "# version: \"0.1.0\"\n# elements: [{\"name\":\"a, b\"}]\nname,magnitude\n\"A \"\"B\"\", C\",5.00\nD,\n"
        );
    }

    #[test]
    fn the_header_names_unit_type_and_meaning() {
        let table = Table {
            columns: vec![
                Column::new("name", Kind::Text, "Name: \"the name\"."),
                Column::real("ra_deg", "deg", 1, ""),
                Column::new("norad_id", Kind::Integer, ""),
            ],
            rows: vec![vec!["A".into(), 12.0.into(), 7_i64.into()]],
        };
        let mut out = Vec::new();
        write_ecsv(&mut out, &table, &Provenance::default()).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n\
             # - {name: name, datatype: string, description: \"Name: \\\"the name\\\".\"}\n\
             # - {name: ra_deg, unit: deg, datatype: float64}\n\
             # - {name: norad_id, datatype: int64}\n\
             # meta: {\"provenance\": {}}\n# schema: astropy-2.0\n\
             name,ra_deg,norad_id\nA,12.0,7\n"
        );
    }

    /// `astropy.io.ascii.ecsv` rejects `true`; other readers of CSV expect it.
    #[test]
    fn truth_values_of_ecsv_are_those_of_astropy() {
        let columns = vec![Column::new("detected", Kind::Boolean, "")];
        let table = Table { columns, rows: vec![vec![true.into()], vec![false.into()]] };
        let written = |write: fn(&mut dyn Write, &Table, &Provenance) -> io::Result<()>| {
            let mut out = Vec::new();
            write(&mut out, &table, &Provenance::default()).unwrap();
            String::from_utf8(out).unwrap()
        };
        assert!(written(write_ecsv).ends_with("detected\nTrue\nFalse\n"), "{}", written(write_ecsv));
        assert_eq!(written(write_csv), "detected\ntrue\nfalse\n");
    }

    #[test]
    fn an_id_that_begins_like_a_comment_is_quoted() {
        let table = Table { columns: vec![Column::new("exposure_id", Kind::Text, "")], rows: vec![vec!["#7".into()]] };
        let mut out = Vec::new();
        write_csv_rows(&mut out, &table).unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), "\"#7\"\n");
    }
}
