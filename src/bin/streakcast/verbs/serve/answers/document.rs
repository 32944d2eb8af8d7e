//! A JSON document put together from tables and values, each table with its own digits.

use serde_json::{Value, json};
use streakcast::output::{Column, Kind, Provenance, Table, json_members, json_rows};

use super::super::house::Caveats;
use super::super::reply::Reply;

/// An object that grows member by member.
#[derive(Default)]
pub struct Document {
    text: String,
}

impl Document {
    /// With what the answer rests on.
    pub fn resting_on(provenance: &Provenance) -> Self {
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

    pub fn reply(self) -> Reply {
        Reply::json(format!("{{{}}}\n", self.text))
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

/// An object of these members, all of them there and no others.
pub fn object_schema(members: &[(&str, Value)]) -> Value {
    let names: Vec<&str> = members.iter().map(|(name, _)| *name).collect();
    let members: serde_json::Map<String, Value> =
        members.iter().map(|(name, schema)| ((*name).to_owned(), schema.clone())).collect();
    json!({"type": "object", "properties": members, "required": names, "additionalProperties": false})
}

/// What an answer rests on: statements by name.
pub fn provenance_schema() -> Value {
    json!({"type": "object", "description": "What the answer rests on: version, elements with hash and epochs, models, time scale, options."})
}

/// What the user should know: warnings in words.
pub fn warnings_schema() -> Value {
    json!({
        "type": "array",
        "items": {"type": "string"},
        "description": "What the user should know, in the words of the command line: age of the elements, satellites left out, broken records.",
    })
}

/// How many satellites the answer does without.
pub fn left_out_count_schema() -> Value {
    json!({"type": "integer", "minimum": 0, "description": "How many satellites have no place at the time asked about, and are missing from the answer."})
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
