//! VOTable, the table format of the Virtual Observatory: `FIELD`s with unit, type and description, rows as `TABLEDATA`.

use std::io::{self, Write};

use super::provenance::Provenance;
use super::table::{Column, Kind, Table, Value};

/// Number that stands for a missing value in columns of integers.
const NULL: i64 = i64::MIN;

/// Returns one `<FIELD>` for each column.
pub fn votable_fields(columns: &[Column]) -> Vec<String> {
    columns.iter().map(field).collect()
}

fn field(column: &Column) -> String {
    let datatype = match column.kind {
        Kind::Integer => "datatype=\"long\"",
        Kind::Real { .. } | Kind::Small { .. } => "datatype=\"double\"",
        Kind::Boolean => "datatype=\"boolean\"",
        Kind::Text | Kind::Time { .. } | Kind::List { .. } | Kind::Rows(_) => {
            "datatype=\"unicodeChar\" arraysize=\"*\""
        }
    };
    let unit = if column.unit.is_empty() { String::new() } else { format!(" unit=\"{}\"", escaped(column.unit)) };
    let name = escaped(column.name);
    let values = if column.kind == Kind::Integer { format!("<VALUES null=\"{NULL}\"/>") } else { String::new() };
    let description = match column.description {
        "" => String::new(),
        text => format!("<DESCRIPTION>{}</DESCRIPTION>", escaped(text)),
    };
    format!("<FIELD name=\"{name}\" {datatype}{unit}>{description}{values}</FIELD>")
}

/// Returns the `<TD>` elements of a row.
pub fn votable_cells(columns: &[Column], row: &[Value]) -> String {
    let cell = |(column, value): (&Column, &Value)| {
        let text = column.text(value);
        let text = if text.is_empty() && column.kind == Kind::Integer { NULL.to_string() } else { text };
        format!("<TD>{}</TD>", escaped(&text))
    };
    columns.iter().zip(row).map(cell).collect()
}

/// Returns a `<TABLE>` with its provenance as `INFO` elements, their values as JSON.
pub fn votable_table(name: &str, table: &Table, provenance: &Provenance) -> String {
    let mut text = format!("<TABLE name=\"{}\">\n", escaped(name));
    for (name, value) in provenance.entries() {
        text += &format!("<INFO name=\"{}\" value=\"{}\"/>\n", escaped(name), escaped(&value.to_string()));
    }
    for field in votable_fields(&table.columns) {
        text += &format!("{field}\n");
    }
    text += "<DATA><TABLEDATA>\n";
    for row in &table.rows {
        text += &format!("<TR>{}</TR>\n", votable_cells(&table.columns, row));
    }
    text + "</TABLEDATA></DATA>\n</TABLE>"
}

/// Writes a VOTable 1.4 document with one table, which astropy and TOPCAT read.
///
/// # Errors
/// Any error of the writer.
pub fn write_votable(out: &mut dyn Write, table: &Table, provenance: &Provenance) -> io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    writeln!(out, "<VOTABLE version=\"1.4\" xmlns=\"http://www.ivoa.net/xml/VOTable/v1.3\">")?;
    writeln!(out, "<RESOURCE>\n{}\n</RESOURCE>\n</VOTABLE>", votable_table("streakcast", table, provenance))
}

/// Escapes text for XML; control characters, which XML does not allow, become blanks.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\t' => out.push(' '),
            character if character.is_control() => out.push(' '),
            character => out.push(character),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_and_cells_are_escaped_and_gaps_stay_gaps() {
        let columns = [
            Column::new("reasons", Kind::List { separator: "; " }, "Why, if a < b."),
            Column::real("p", "deg", 2, ""),
            Column::new("n", Kind::Integer, ""),
        ];
        let fields = votable_fields(&columns);
        assert_eq!(
            fields[0],
            "<FIELD name=\"reasons\" datatype=\"unicodeChar\" arraysize=\"*\"><DESCRIPTION>Why, if a &lt; b.</DESCRIPTION></FIELD>"
        );
        assert_eq!(fields[1], "<FIELD name=\"p\" datatype=\"double\" unit=\"deg\"></FIELD>");
        let row = [Value::List(vec!["a & b\u{1}".into()]), f64::NAN.into(), Value::Null];
        assert_eq!(votable_cells(&columns, &row), "<TD>a &amp; b </TD><TD></TD><TD>-9223372036854775808</TD>");
    }
}
