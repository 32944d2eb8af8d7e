//! JSON: an array of rows, or an object with this array as `exposures` (schedules) or `targets` (target lists).

use std::fmt;
use std::path::Path;

use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::Value;
use serde_json::value::RawValue;

use super::super::error::ScheduleError;
use super::columns::{Cell, RawTable, ScheduleFormat, display};

/// Names of the array of rows if the document is an object.
const ARRAYS: [&str; 2] = ["exposures", "targets"];

/// Reads JSON text. The columns are the keys that occur in any row.
///
/// # Errors
/// The text is not JSON, or has no array of rows.
pub(super) fn read(path: &Path, text: &str) -> Result<RawTable, ScheduleError> {
    let document: Value = serde_json::from_str(text).map_err(|error| bad(path, &error))?;
    let rows = match &document {
        Value::Array(rows) => rows,
        Value::Object(object) => match ARRAYS.iter().find_map(|name| object.get(*name)) {
            Some(Value::Array(rows)) => rows,
            _ => return Err(format(path, "JSON without an array 'exposures' or 'targets'")),
        },
        _ => return Err(format(path, "JSON that is neither an array of rows nor an object with one")),
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

/// Byte positions of the members of an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::schedule) struct Members {
    /// Keys in order, each with the end of its value.
    pub ends: Vec<(String, usize)>,
    /// Position after the opening brace.
    pub open: usize,
}

impl Members {
    /// Returns the keys in order.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.ends.iter().map(|(key, _)| key.as_str())
    }
}

/// Byte positions of one row.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct JsonRow {
    /// Start and end of the row.
    pub span: (usize, usize),
    /// Members of the row; `None` if the row is not an object.
    pub members: Option<Members>,
}

/// Byte positions of the rows of a JSON file.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct JsonLayout {
    /// The rows in order.
    pub rows: Vec<JsonRow>,
    /// Members of the document; `None` if the document is an array.
    pub document: Option<Members>,
}

/// Finds the rows of JSON text.
///
/// # Errors
/// Same as [`read`].
pub(in crate::schedule) fn json_layout(path: &Path, text: &str) -> Result<JsonLayout, ScheduleError> {
    let error = |error: serde_json::Error| bad(path, &error);
    let offset = |piece: &str| piece.as_ptr() as usize - text.as_ptr() as usize;
    let (array, document) = if text.trim_start().starts_with('{') {
        let object: Object<'_> = serde_json::from_str(text).map_err(error)?;
        let array =
            ARRAYS.iter().find_map(|name| object.0.iter().find(|(key, _)| key == name)).map(|(_, value)| *value);
        let array = array.ok_or_else(|| format(path, "JSON without an array 'exposures' or 'targets'"))?;
        (array.get(), Some(members(text, &object, offset)))
    } else {
        (text, None)
    };
    let rows: Vec<&RawValue> = serde_json::from_str(array).map_err(error)?;
    let rows = rows
        .into_iter()
        .map(|row| {
            let start = offset(row.get());
            let object = row.get().starts_with('{').then(|| serde_json::from_str::<Object<'_>>(row.get())).transpose();
            let object = object.map_err(error)?;
            let members = object.map(|object| members(&text[start..], &object, |piece| offset(piece) - start));
            let members = members.map(|members| Members {
                ends: members.ends.into_iter().map(|(key, end)| (key, end + start)).collect(),
                open: members.open + start,
            });
            Ok(JsonRow { span: (start, start + row.get().len()), members })
        })
        .collect::<Result<_, ScheduleError>>()?;
    Ok(JsonLayout { rows, document })
}

fn members(text: &str, object: &Object<'_>, offset: impl Fn(&str) -> usize) -> Members {
    Members {
        ends: object.0.iter().map(|(key, value)| (key.clone(), offset(value.get()) + value.get().len())).collect(),
        open: text.find('{').map_or(0, |brace| brace + 1),
    }
}

/// Members of a JSON object in order, with their values as slices of the text.
struct Object<'a>(Vec<(String, &'a RawValue)>);

impl<'de> serde::Deserialize<'de> for Object<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Object<'de>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut members = Vec::new();
                while let Some(member) = map.next_entry()? {
                    members.push(member);
                }
                Ok(Object(members))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

fn bad(path: &Path, error: &serde_json::Error) -> ScheduleError {
    ScheduleError::Line { path: display(path), line: error.line() as u64, what: error.to_string() }
}

fn format(path: &Path, what: &str) -> ScheduleError {
    ScheduleError::Format { path: display(path), what: what.to_owned() }
}

fn cell(value: Option<&Value>) -> Cell {
    match value {
        None | Some(Value::Null) => Cell::Missing,
        // Integers keep all digits: an identifier may have more digits than a double can represent.
        Some(Value::Number(number)) if number.is_f64() => Cell::Number(number.as_f64().unwrap_or(f64::NAN)),
        Some(Value::Number(number)) => Cell::Text(number.to_string()),
        Some(Value::String(text)) => Cell::from_text(text),
        Some(other) => Cell::Text(other.to_string()),
    }
}
