//! ECSV 1.0, the text table of astropy: a YAML header with unit, type and meaning of every column.

use std::io::{self, Write};

use super::column::{Column, Kind};
use super::csv::write_records;
use super::provenance::Provenance;
use super::value::{Table, Value};

/// Writes the table as comma-separated ECSV that `astropy.table.Table.read` opens with units and metadata.
///
/// The provenance is `meta['provenance']`. Texts in the header are JSON strings, which YAML reads as they are.
/// A missing value is an empty cell, which astropy masks.
///
/// # Errors
/// Whatever the writer reports.
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
    write_records(out, table)
}

/// One entry of the header's list `datatype`: name, unit, type and meaning of a column with these values.
///
/// # Errors
/// None that a text can cause.
pub fn ecsv_column<'a>(column: &Column, mut values: impl Iterator<Item = &'a Value>) -> serde_json::Result<String> {
    let datatype = match column.kind {
        Kind::Integer => "int64",
        Kind::Real { .. } => "float64",
        // A column with gaps would make astropy's bool parser stop.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_names_unit_type_and_meaning() {
        let table = Table {
            columns: vec![
                Column::new("name", Kind::Text, "Who: \"the name\"."),
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
             # - {name: name, datatype: string, description: \"Who: \\\"the name\\\".\"}\n\
             # - {name: ra_deg, unit: deg, datatype: float64}\n\
             # - {name: norad_id, datatype: int64}\n\
             # meta: {\"provenance\": {}}\n# schema: astropy-2.0\n\
             name,ra_deg,norad_id\nA,12.0,7\n"
        );
    }
}
