//! JSON: an array of rows, or an object with this array as `exposures` (schedules) or `targets` (target lists).

use std::collections::HashMap;
use std::fmt;
use std::path::Path;

use serde::de::{Deserializer, Error as _, MapAccess, Visitor};
use serde_json::Value;
use serde_json::value::RawValue;

use super::super::error;
use super::columns::{Cell, ScheduleFormat};
use super::raw_table::RawTable;
use crate::error::Error;
use crate::input::{MOST_ROWS, json_error};
use crate::message::Quoted;

/// Names of the array of rows if the document is an object.
const ARRAYS: [&str; 2] = ["exposures", "targets"];

/// Largest number of columns. Every row has a cell in every column.
const MOST_COLUMNS: usize = 1000;

/// Largest number of commas, for [`MOST_ROWS`] rows of 40 members.
const MOST_COMMAS: usize = 40 * MOST_ROWS;

/// Reads JSON text. The columns are the keys that occur in any row.
///
/// # Errors
/// The text is not JSON, or has no array of rows.
pub(super) fn read(path: &Path, text: &str) -> Result<RawTable, Error> {
    let mut table = RawTable::new(ScheduleFormat::Json, Vec::new());
    let mut columns: HashMap<String, usize> = HashMap::new();
    let mut rows = Vec::new();
    for row in raw_rows(path, text)?.1 {
        let Some(object) = object_of(path, text, row)? else {
            rows.push(Err("the row is not an object".to_owned()));
            continue;
        };
        let mut cells = vec![Cell::Missing; columns.len()];
        for (name, value) in object.0 {
            let raw = value.get();
            let value = serde_json::from_str(raw).map_err(|error| bad_at(path, text, value, &error))?;
            let next = columns.len();
            let index = *columns.entry(name).or_insert_with_key(|name| {
                table.names.push(name.clone());
                next
            });
            if index == MOST_COLUMNS {
                return Err(format(path, &format!("JSON with more than {MOST_COLUMNS} keys of rows")));
            }
            if index == cells.len() {
                cells.push(Cell::Missing);
            }
            cells[index] = cell(raw, &value);
        }
        rows.push(Ok(cells));
    }
    for cells in rows.iter_mut().flatten() {
        cells.resize(table.names.len(), Cell::Missing);
    }
    table.rows = rows.into();
    Ok(table)
}

/// Returns the document, unless it is an array, and its rows.
fn raw_rows<'a>(path: &Path, text: &'a str) -> Result<(Option<Object<'a>>, Vec<&'a RawValue>), Error> {
    let document: &RawValue = serde_json::from_str(text).map_err(|error| bad(path, &error))?;
    let (document, array) = match object_of(path, text, document)? {
        Some(object) => {
            let array = ARRAYS.iter().find_map(|name| object.0.iter().find(|(key, _)| key == name));
            let array = array.map(|(_, value)| *value);
            let array = array.ok_or_else(|| format(path, "JSON without an array 'exposures' or 'targets'"))?;
            (Some(object), array)
        }
        None => (None, document),
    };
    if !array.get().starts_with('[') {
        let what = match document {
            Some(_) => "JSON without an array 'exposures' or 'targets'",
            None => "JSON that is neither an array of rows nor an object with one",
        };
        return Err(format(path, what));
    }
    // Before memory is taken for each row.
    if array.get().bytes().filter(|byte| *byte == b',').take(MOST_COMMAS + 1).count() > MOST_COMMAS {
        return Err(error::too_many_rows(path, MOST_ROWS));
    }
    let rows: Vec<&RawValue> = serde_json::from_str(array.get()).map_err(|error| bad_at(path, text, array, &error))?;
    if rows.len() > MOST_ROWS {
        return Err(error::too_many_rows(path, MOST_ROWS));
    }
    if let (Some(object), Some(first)) = (&document, rows.first()) {
        let keys_of = |row: &RawValue| -> Result<Option<Vec<String>>, Error> {
            let members = object_of(path, text, row)?;
            Ok(members.map(|members| members.0.into_iter().map(|(key, _)| key).collect()))
        };
        let keys = keys_of(first)?;
        for (name, value) in &object.0 {
            if std::ptr::eq(*value, array) || !value.get().starts_with('[') {
                continue;
            }
            let other: Vec<&RawValue> =
                serde_json::from_str(value.get()).map_err(|error| bad_at(path, text, value, &error))?;
            let Some(first) = other.first() else { continue };
            let is_table = first.get().starts_with('{');
            if ARRAYS.contains(&&**name) && is_table || (keys.is_some() && keys_of(first)? == keys) {
                let what = format!("JSON with {} more rows in the array '{}'", other.len(), Quoted::new(name));
                return Err(format(path, &what).allowing("one array of rows; split the file"));
            }
        }
    }
    Ok((document, rows))
}

/// Returns the members of a value; `None` if it is not an object.
fn object_of<'a>(path: &Path, text: &str, value: &'a RawValue) -> Result<Option<Object<'a>>, Error> {
    let object = value.get().starts_with('{').then(|| serde_json::from_str(value.get())).transpose();
    object.map_err(|error| bad_at(path, text, value, &error))
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
pub(in crate::schedule) fn json_layout(path: &Path, text: &str) -> Result<JsonLayout, Error> {
    let offset = |piece: &str| piece.as_ptr() as usize - text.as_ptr() as usize;
    let (document, rows) = raw_rows(path, text)?;
    let document = document.map(|object| members(text, &object, offset));
    let rows = rows
        .into_iter()
        .map(|row| {
            let start = offset(row.get());
            let object = object_of(path, text, row)?;
            let members = object.map(|object| members(&text[start..], &object, |piece| offset(piece) - start));
            let members = members.map(|members| Members {
                ends: members.ends.into_iter().map(|(key, end)| (key, end + start)).collect(),
                open: members.open + start,
            });
            Ok(JsonRow { span: (start, start + row.get().len()), members })
        })
        .collect::<Result<_, Error>>()?;
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
                while let Some(member) = map.next_entry::<String, &RawValue>()? {
                    members.push(member);
                }
                let mut keys: Vec<&str> = members.iter().map(|(key, _)| key.as_str()).collect();
                keys.sort_unstable();
                if let Some(twice) = keys.windows(2).find(|keys| keys[0] == keys[1]) {
                    let key = Quoted::new(twice[0]);
                    return Err(A::Error::custom(format!("the key '{key}' occurs twice; allowed: once in an object")));
                }
                Ok(Object(members))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

fn bad(path: &Path, error: &serde_json::Error) -> Error {
    json_error(error).in_file("schedule", path)
}

/// Returns the error of a part of the text, with its line in the text.
fn bad_at(path: &Path, text: &str, part: &RawValue, error: &serde_json::Error) -> Error {
    let start = part.get().as_ptr() as usize - text.as_ptr() as usize;
    let line = text[..start].matches('\n').count() + error.line().max(1);
    // The error ends with its line and column in this part.
    let what = error.to_string();
    let what = what.rsplit_once(" at line ").map_or(&*what, |(what, _)| what).to_owned();
    Error::format(what).in_line("schedule", path, line)
}

fn format(path: &Path, what: &str) -> Error {
    error::format(path, what)
}

fn cell(raw: &str, value: &Value) -> Cell {
    match value {
        Value::Null => Cell::Missing,
        // Integers keep all digits: an identifier may have more digits than a double can represent.
        Value::Number(_) if raw.trim_start_matches('-').bytes().all(|byte| byte.is_ascii_digit()) => {
            Cell::Text(raw.to_owned())
        }
        Value::Number(number) if number.is_f64() => Cell::Number(number.as_f64().unwrap_or(f64::NAN)),
        Value::Number(number) => Cell::Text(number.to_string()),
        Value::String(text) => Cell::from_text(text),
        other => Cell::Text(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_array_of_rows_is_an_error() {
        let read = |text: &str| read(Path::new("t.json"), text);
        for (text, name) in [
            (
                r#"{"exposures": [{"ra_deg": 1}], "targets": [{"ra": 2}, {"ra": 3}]}"#,
                "2 more rows in the array 'targets'",
            ),
            (r#"{"targets": [{"ra": 2}], "exposures": [{"ra_deg": 1}]}"#, "1 more rows in the array 'targets'"),
            (r#"{"exposures": [{"ra_deg": 1}], "more": [{"ra_deg": 2}]}"#, "1 more rows in the array 'more'"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains("allowed: one array of rows"), "{error}");
        }
        let text = r#"{"exposures": [{"ra_deg": 1}], "targets": [], "streaks": [{"mag": 2}], "tags": [1], "n": 3}"#;
        assert_eq!(read(text).unwrap().rows.iter().count(), 1);
    }

    #[test]
    fn integers_keep_all_digits() {
        let text = r#"[{"exposure_id": 123456789012345678901234, "duration_s": -7, "ra_deg": 1.5e1}]"#;
        let table = read(Path::new("t.json"), text).unwrap();
        let cells = table.rows.iter().next().unwrap().into_owned().unwrap();
        assert_eq!(cells[0], Cell::Text("123456789012345678901234".to_owned()));
        assert_eq!(cells[1..], [Cell::Text("-7".to_owned()), Cell::Number(15.0)]);
    }
}
