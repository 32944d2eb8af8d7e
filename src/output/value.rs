//! Cells and the tables made of them.

use hifitime::Epoch;

use super::column::Column;

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Nothing is known, or nothing applies.
    Null,
    /// Text.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// A number; one that is not finite is written as nothing.
    Real(f64),
    /// A moment.
    Time(Epoch),
    /// True or false.
    Boolean(bool),
    /// Several texts.
    List(Vec<String>),
    /// Several whole numbers.
    Integers(Vec<i64>),
    /// A table within the cell, in the columns of [`Kind::Rows`](super::Kind::Rows).
    Rows(Vec<Vec<Value>>),
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

/// Columns and rows; every row has one value for each column, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What the columns are.
    pub columns: Vec<Column>,
    /// The rows, each as long as `columns`.
    pub rows: Vec<Vec<Value>>,
}

impl Table {
    /// The same table without the columns whose names are not wanted.
    pub fn without(&self, unwanted: &[&str]) -> Self {
        let keep: Vec<usize> = (0..self.columns.len()).filter(|&i| !unwanted.contains(&self.columns[i].name)).collect();
        Self {
            columns: keep.iter().map(|&i| self.columns[i]).collect(),
            rows: self.rows.iter().map(|row| keep.iter().filter_map(|&i| row.get(i).cloned()).collect()).collect(),
        }
    }
}
