//! JSON body of an answer, assembled from tables and values, and its JSON Schema.

use serde_json::{Value, json};
use streakcast::output::{Column, Kind, Provenance, Table, json_members, json_rows};

use super::super::state::Caveats;

/// A JSON object to which members are added.
#[derive(Default)]
pub struct Document {
    text: String,
}

impl Document {
    /// An object with the provenance of the answer.
    pub fn with_provenance(provenance: &Provenance) -> Self {
        let mut document = Self::default();
        document.raw("provenance", &serde_json::to_string(provenance).unwrap_or_else(|_| "{}".to_owned()));
        document
    }

    fn raw(&mut self, name: &str, text: &str) {
        let comma = if self.text.is_empty() { "" } else { ",\n" };
        self.text.push_str(&format!("{comma}{}: {text}", Value::from(name)));
    }

    pub fn value(&mut self, name: &str, value: impl Into<Value>) {
        self.raw(name, &value.into().to_string());
    }

    pub fn caveats(&mut self, caveats: &Caveats) {
        self.value("warnings", caveats.warnings.as_slice());
        self.value("left_out_count", caveats.left_out_count);
    }

    /// An array of objects.
    pub fn table(&mut self, name: &str, table: &Table) {
        self.raw(name, &json_rows(&table.columns, &table.rows));
    }

    /// The first row as an object.
    pub fn record(&mut self, name: &str, table: &Table) {
        let members = table.rows.first().map(|row| json_members(&table.columns, row)).unwrap_or_default();
        self.raw(name, &format!("{{{members}}}"));
    }

    pub fn into_json(self) -> String {
        format!("{{{}}}\n", self.text)
    }
}

/// The schema of a table's row.
pub fn row_schema(columns: &[Column]) -> Value {
    let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
    let members: serde_json::Map<String, Value> =
        columns.iter().map(|column| (column.name.to_owned(), cell_schema(column))).collect();
    json!({"type": "object", "properties": members, "required": names, "additionalProperties": false})
}

/// The schema of a table.
pub fn rows_schema(columns: &[Column]) -> Value {
    json!({"type": "array", "items": row_schema(columns)})
}

/// The schema of an object with exactly these members.
pub fn object_schema(members: &[(&str, Value)]) -> Value {
    let names: Vec<&str> = members.iter().map(|(name, _)| *name).collect();
    let members: serde_json::Map<String, Value> =
        members.iter().map(|(name, schema)| ((*name).to_owned(), schema.clone())).collect();
    json!({"type": "object", "properties": members, "required": names, "additionalProperties": false})
}

/// The schema of the provenance.
pub fn provenance_schema() -> Value {
    json!({"type": "object", "description": "Origin of the answer: version, elements with hash and epochs, models, time scale, options."})
}

/// The schema of the warnings.
pub fn warnings_schema() -> Value {
    json!({
        "type": "array",
        "items": {"type": "string"},
        "description": "The warnings of the command line: age of the elements, satellites left out, invalid records.",
    })
}

/// The schema of the number of satellites left out.
pub fn left_out_count_schema() -> Value {
    json!({"type": "integer", "minimum": 0, "description": "Number of satellites that are missing from the answer because SGP4 cannot compute their position at that time."})
}

fn cell_schema(column: &Column) -> Value {
    let unit = if column.unit.is_empty() { String::new() } else { format!(" [{}]", column.unit) };
    let description = format!("{}{unit}", column.description);
    let mut schema = match column.kind {
        Kind::Text => json!({"type": ["string", "null"]}),
        Kind::Integer => json!({"type": ["integer", "null"]}),
        Kind::Real { .. } => json!({"type": ["number", "null"]}),
        Kind::Time { .. } => json!({"type": ["string", "null"], "format": "date-time"}),
        Kind::Boolean => json!({"type": ["boolean", "null"]}),
        Kind::List { .. } => json!({"type": "array", "items": {"type": ["string", "integer"]}}),
        Kind::Rows(columns) => json!({"type": ["array", "null"], "items": row_schema(columns)}),
    };
    schema["description"] = description.into();
    schema
}
