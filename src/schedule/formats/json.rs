//! JSON: an array of rows, or an object that holds it under `exposures`.

use std::path::Path;

use serde_json::Value;

use super::super::error::ScheduleError;
use super::raw::{Cell, RawTable};
use super::sniff::{ScheduleFormat, display};

/// Reads JSON text. The columns are the keys of all rows together.
///
/// # Errors
/// Text that is not JSON, no array of rows, or no rows.
pub(super) fn read(path: &Path, text: &str) -> Result<RawTable, ScheduleError> {
    let document: Value = serde_json::from_str(text).map_err(|error| ScheduleError::Line {
        path: display(path),
        line: error.line() as u64,
        what: error.to_string(),
    })?;
    let rows = match &document {
        Value::Array(rows) => rows,
        Value::Object(object) => match object.get("exposures") {
            Some(Value::Array(rows)) => rows,
            _ => return Err(format(path, "is JSON without an array 'exposures'")),
        },
        _ => return Err(format(path, "is JSON, but neither an array of rows nor an object")),
    };
    let mut table = RawTable::new(ScheduleFormat::Json, Vec::new());
    for row in rows {
        for name in row.as_object().into_iter().flat_map(|object| object.keys()) {
            if !table.names.contains(name) {
                table.names.push(name.clone());
            }
        }
    }
    table.rows = rows
        .iter()
        .map(|row| match row {
            Value::Object(object) => Ok(table.names.iter().map(|name| cell(object.get(name))).collect()),
            _ => Err("the row is not an object".to_owned()),
        })
        .collect();
    Ok(table)
}

fn format(path: &Path, what: &str) -> ScheduleError {
    ScheduleError::Format { path: display(path), what: what.to_owned() }
}

fn cell(value: Option<&Value>) -> Cell {
    match value {
        None | Some(Value::Null) => Cell::Missing,
        // Whole numbers keep their digits: an identifier may be longer than a double holds.
        Some(Value::Number(number)) if number.is_f64() => Cell::Number(number.as_f64().unwrap_or(f64::NAN)),
        Some(Value::Number(number)) => Cell::Text(number.to_string()),
        Some(Value::String(text)) => Cell::from_text(text),
        Some(other) => Cell::Text(other.to_string()),
    }
}
