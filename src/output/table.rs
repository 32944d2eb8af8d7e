//! Tables: columns with unit and description, rows of cells, and the text of a cell in each kind of format.

use std::borrow::Borrow;

use hifitime::Epoch;

use super::text::format_utc;

/// Type of the cells of a column, with the number of decimals.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Kind {
    /// Text.
    Text,
    /// An integer.
    Integer,
    /// A real number, written with this many decimals in every format.
    Real {
        /// Number of decimals.
        decimals: usize,
    },
    /// A real number that may be small and is not rounded to 0, such as an error: written with at least this many
    /// decimals, and with more if it would have fewer than three significant digits.
    Small {
        /// Smallest number of decimals.
        decimals: usize,
    },
    /// A time, written as UTC with `Z` and this many decimals of the second.
    Time {
        /// Number of decimals of the second, at most 9.
        decimals: usize,
    },
    /// True or false.
    Boolean,
    /// Several texts or integers: an array in JSON, one text with this separator in other formats.
    List {
        /// Text between the items in formats without arrays.
        separator: &'static str,
    },
    /// A table within the cell: an array of objects in JSON, the text of such an array in other formats.
    Rows(&'static [Column]),
}

/// One column of a table.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Column {
    /// Name, in snake_case with the unit at the end.
    pub name: &'static str,
    /// Unit in the spelling of astropy (`deg`, `km`, `mag`); empty for none.
    pub unit: &'static str,
    /// Type of the cells.
    pub kind: Kind,
    /// Description in one sentence.
    pub description: &'static str,
}

impl Column {
    /// Creates a column without unit.
    pub const fn new(name: &'static str, kind: Kind, description: &'static str) -> Self {
        Self { name, unit: "", kind, description }
    }

    /// Creates a column of real numbers with `decimals` digits.
    pub const fn real(name: &'static str, unit: &'static str, decimals: usize, description: &'static str) -> Self {
        Self { name, unit, kind: Kind::Real { decimals }, description }
    }

    /// Creates a column of real numbers with at least `decimals` digits and three significant ones.
    pub const fn small(name: &'static str, unit: &'static str, decimals: usize, description: &'static str) -> Self {
        Self { name, unit, kind: Kind::Small { decimals }, description }
    }

    /// Creates a column of times in UTC, to the microsecond.
    pub const fn time(name: &'static str, description: &'static str) -> Self {
        Self { name, unit: "", kind: Kind::Time { decimals: 6 }, description }
    }

    /// Returns a cell's text in formats without types; empty for a missing value or a number that is not finite.
    ///
    /// Negative zero is written as zero.
    pub fn text(&self, value: &Value) -> String {
        let separator = if let Kind::List { separator } = self.kind { separator } else { " " };
        match (value, self.kind) {
            (Value::Null, _) => String::new(),
            (Value::Text(text), _) => text.clone(),
            (Value::Integer(number), _) => number.to_string(),
            (Value::Boolean(truth), _) => truth.to_string(),
            (Value::Real(number), Kind::Real { decimals }) => real_text(*number, decimals),
            (Value::Real(number), Kind::Small { decimals }) => real_text(*number, small_decimals(*number, decimals)),
            (Value::Real(number), _) if number.is_finite() => number.to_string(),
            (Value::Real(_), _) => String::new(),
            (Value::Time(epoch), Kind::Time { decimals }) => format_utc(*epoch, decimals),
            (Value::Time(epoch), _) => format_utc(*epoch, 6),
            (Value::List(items), _) => items.join(separator),
            (Value::Integers(items), _) => items.iter().map(i64::to_string).collect::<Vec<_>>().join(separator),
            (Value::Rows(rows), Kind::Rows(columns)) => json_rows(columns, rows),
            (Value::Rows(_), _) => String::new(),
        }
    }

    /// Returns a cell as JSON, with the digits of [`text`](Column::text); `null` for a missing value.
    fn json(&self, value: &Value) -> String {
        let array = |items: Vec<String>| format!("[{}]", items.join(", "));
        match value {
            Value::List(items) => array(items.iter().map(|item| quoted(item)).collect()),
            Value::Integers(items) => array(items.iter().map(i64::to_string).collect()),
            Value::Text(_) | Value::Time(_) => quoted(&self.text(value)),
            Value::Null | Value::Integer(_) | Value::Real(_) | Value::Boolean(_) | Value::Rows(_) => {
                let text = self.text(value);
                if text.is_empty() { "null".to_owned() } else { text }
            }
        }
    }
}

/// Returns the number of decimals with which a number has three significant digits, at least `least`.
fn small_decimals(number: f64, least: usize) -> usize {
    /// Numbers with more zeros after the point are rounded to 0.
    const MOST: usize = 30;
    let digits = 2.0 - number.abs().log10().floor();
    if number == 0.0 || !digits.is_finite() { least } else { (digits.max(0.0) as usize).clamp(least, MOST.max(least)) }
}

fn real_text(number: f64, decimals: usize) -> String {
    if !number.is_finite() {
        return String::new();
    }
    let text = format!("{number:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|byte| byte == b'0' || byte == b'.') => digits.to_owned(),
        _ => text,
    }
}

/// Returns rows as a JSON array of objects, on one line.
pub fn json_rows(columns: &[Column], rows: &[Vec<Value>]) -> String {
    let objects: Vec<String> = rows.iter().map(|row| format!("{{{}}}", json_members(columns, row))).collect();
    format!("[{}]", objects.join(", "))
}

/// Returns the members of a row's JSON object, without its braces: `"name": value, ...`.
pub fn json_members(columns: &[Column], row: &[Value]) -> String {
    let member = |(column, value): (&Column, &Value)| format!("{}: {}", quoted(column.name), column.json(value));
    columns.iter().zip(row).map(member).collect::<Vec<_>>().join(", ")
}

/// Returns a text as a JSON string.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A missing value.
    Null,
    /// Text.
    Text(String),
    /// An integer.
    Integer(i64),
    /// A real number; one that is not finite is written as a missing value.
    Real(f64),
    /// A time.
    Time(Epoch),
    /// True or false.
    Boolean(bool),
    /// Several texts.
    List(Vec<String>),
    /// Several integers.
    Integers(Vec<i64>),
    /// A table within the cell, in the columns of [`Kind::Rows`].
    Rows(Vec<Vec<Value>>),
}

impl Value {
    /// Returns a text, or a missing value for an empty one.
    pub(crate) fn nonempty(text: &str) -> Self {
        if text.is_empty() { Value::Null } else { text.into() }
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Value::Null, Into::into)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Value::Real(number)
    }
}

impl From<Epoch> for Value {
    fn from(epoch: Epoch) -> Self {
        Value::Time(epoch)
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Value::Text(text)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Value::Text(text.to_owned())
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Value::Integer(number)
    }
}

impl From<usize> for Value {
    fn from(number: usize) -> Self {
        Value::Integer(i64::try_from(number).unwrap_or(i64::MAX))
    }
}

impl From<bool> for Value {
    fn from(truth: bool) -> Self {
        Value::Boolean(truth)
    }
}

/// Table of columns and rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, each with one value for each column, in the order of `columns`.
    pub rows: Vec<Vec<Value>>,
}

/// Column with the function that computes its values from records of type `R`.
pub struct TableField<R> {
    column: Column,
    value: fn(&R) -> Value,
}

impl<R> TableField<R> {
    /// Combines a column with its function.
    pub const fn new(column: Column, value: fn(&R) -> Value) -> Self {
        Self { column, value }
    }

    /// Returns the value of a record.
    pub fn value_of(&self, record: &R) -> Value {
        (self.value)(record)
    }
}

impl Table {
    /// Builds a table with one row for each record, in their order.
    pub fn from_records<R>(fields: &[TableField<R>], records: impl IntoIterator<Item = impl Borrow<R>>) -> Self {
        let row = |record: &R| fields.iter().map(|field| field.value_of(record)).collect();
        Self {
            columns: fields.iter().map(|field| field.column).collect(),
            rows: records.into_iter().map(|record| row(record.borrow())).collect(),
        }
    }

    /// Returns the table without the columns of these names.
    pub fn without(&self, names: &[&str]) -> Self {
        let keep: Vec<usize> = (0..self.columns.len()).filter(|&i| !names.contains(&self.columns[i].name)).collect();
        Self {
            columns: keep.iter().map(|&i| self.columns[i]).collect(),
            rows: self.rows.iter().map(|row| keep.iter().filter_map(|&i| row.get(i).cloned()).collect()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_decimals_and_zero_has_no_sign() {
        let column = Column::real("range_km", "km", 3, "");
        for (number, text) in [
            (550.0, "550.000"),
            (-0.00049, "0.000"),
            (-0.0, "0.000"),
            (-0.0006, "-0.001"),
            (f64::NAN, ""),
            (f64::INFINITY, ""),
        ] {
            assert_eq!(column.text(&Value::Real(number)), text, "{number}");
        }
    }

    #[test]
    fn small_numbers_are_not_rounded_to_zero() {
        let column = Column::small("sigma_s", "s", 3, "");
        for (number, text) in [
            (550.0, "550.000"),
            (0.0123, "0.0123"),
            (0.000_123_4, "0.000123"),
            (-2.5e-9, "-0.00000000250"),
            (0.0, "0.000"),
            (1e-300, "0.000000000000000000000000000000"),
            (f64::NAN, ""),
        ] {
            assert_eq!(column.text(&Value::Real(number)), text, "{number}");
        }
    }

    #[test]
    fn lists_are_joined_with_the_columns_separator() {
        let column = Column::new("reasons", Kind::List { separator: "; " }, "");
        assert_eq!(column.text(&Value::List(vec!["a".into(), "b".into()])), "a; b");
    }
}
