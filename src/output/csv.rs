//! CSV: provenance in leading `#` lines, one header line, then the rows.

use std::io::{self, Write};

use super::provenance::Provenance;
use super::value::Table;

/// Writes the table as CSV (RFC 4180 quoting, `\n` line ends).
///
/// Each statement of the provenance is a line `# name: value`, the value as JSON on one line. A missing value is an empty cell.
///
/// # Errors
/// Whatever the writer reports.
pub fn write_csv(out: &mut dyn Write, table: &Table, provenance: &Provenance) -> io::Result<()> {
    for (name, value) in provenance.entries() {
        writeln!(out, "# {name}: {value}")?;
    }
    write_records(out, table)
}

/// Header and rows, as CSV and ECSV share them.
pub(super) fn write_records(out: &mut dyn Write, table: &Table) -> io::Result<()> {
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(out);
    writer.write_record(table.columns.iter().map(|column| column.name)).map_err(as_it_was)?;
    for row in &table.rows {
        writer
            .write_record(table.columns.iter().zip(row).map(|(column, value)| column.text(value)))
            .map_err(as_it_was)?;
    }
    writer.flush()
}

/// What the system reported, with its kind: a closed pipe is then still told from a failure.
fn as_it_was(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Column, Kind, Value};
    use super::*;

    /// A reader that has gone.
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
        let error = write_records(&mut Closed, &table).unwrap_err();
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
}
