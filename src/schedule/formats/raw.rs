//! The raw table: what a file says before anybody asks what it means.

use std::collections::BTreeMap;

use hifitime::TimeScale;

use super::sniff::ScheduleFormat;

/// One cell as it was found.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) enum Cell {
    /// Empty, NULL or absent.
    Missing,
    /// A number.
    Number(f64),
    /// Text, or a whole number with all its digits.
    Text(String),
}

impl Cell {
    /// From text: blanks around it do not count, and an empty text is missing.
    pub fn from_text(text: &str) -> Self {
        match text.trim() {
            "" => Cell::Missing,
            text => Cell::Text(text.to_owned()),
        }
    }

    /// As a number. The error is what a row's reason says after the column's name.
    pub fn number(&self) -> Result<f64, String> {
        let number = match self {
            Cell::Missing => return Err("is missing".to_owned()),
            Cell::Number(number) => *number,
            Cell::Text(text) => text.parse().map_err(|_| format!("'{text}' is not a number"))?,
        };
        if number.is_finite() { Ok(number) } else { Err(format!("is {number}")) }
    }

    /// As text; `None` where it is missing.
    pub fn text(&self) -> Option<String> {
        match self {
            Cell::Missing => None,
            Cell::Number(number) => Some(number.to_string()),
            Cell::Text(text) => Some(text.clone()),
        }
    }
}

/// A file's table with its names, and what its header says about the columns.
#[derive(Clone, Debug)]
pub(in crate::schedule) struct RawTable {
    /// The syntax.
    pub format: ScheduleFormat,
    /// The columns' names in order.
    pub names: Vec<String>,
    /// The rows, each as long as `names`; or the reason why a row has no cells.
    pub rows: Vec<Result<Vec<Cell>, String>>,
    /// Units by column, where the file states them.
    pub units: BTreeMap<String, String>,
    /// Time scales by column, where the file states them.
    pub time_scales: BTreeMap<String, TimeScale>,
}

impl RawTable {
    /// A table whose header says names and nothing else.
    pub fn new(format: ScheduleFormat, names: Vec<String>) -> Self {
        Self { format, names, rows: Vec::new(), units: BTreeMap::new(), time_scales: BTreeMap::new() }
    }
}
