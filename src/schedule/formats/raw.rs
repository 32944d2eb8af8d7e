//! The raw table of a schedule file: cells as written, before their meaning is known.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use hifitime::TimeScale;

/// Format of a schedule file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum ScheduleFormat {
    /// A SQLite database with a table `observations`, as Rubin's simulations write it.
    Opsim,
    /// Comma, semicolon or tab separated text with a header line.
    Csv,
    /// astropy's ECSV.
    Ecsv,
    /// A JSON array of rows, or an object with the array `exposures`.
    Json,
    /// A VOTable whose first table is in TABLEDATA.
    VoTable,
    /// Apache Parquet.
    Parquet,
}

impl fmt::Display for ScheduleFormat {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            ScheduleFormat::Opsim => "opsim SQLite",
            ScheduleFormat::Csv => "CSV",
            ScheduleFormat::Ecsv => "ECSV",
            ScheduleFormat::Json => "JSON",
            ScheduleFormat::VoTable => "VOTable",
            ScheduleFormat::Parquet => "Parquet",
        })
    }
}

/// Returns a path as it is shown in messages.
pub(in crate::schedule) fn display(path: &Path) -> String {
    path.display().to_string()
}

/// One cell as written.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) enum Cell {
    /// Empty, NULL or absent.
    Missing,
    /// A number.
    Number(f64),
    /// Text, or an integer with all its digits.
    Text(String),
}

impl Cell {
    /// Creates a cell from text, without blanks around it; an empty text is missing.
    pub fn from_text(text: &str) -> Self {
        match text.trim() {
            "" => Cell::Missing,
            text => Cell::Text(text.to_owned()),
        }
    }

    /// Returns the number. The error text follows the column's name in the reason of a row.
    pub fn number(&self) -> Result<f64, String> {
        let number = match self {
            Cell::Missing => return Err("is missing".to_owned()),
            Cell::Number(number) => *number,
            Cell::Text(text) => text.parse().map_err(|_| format!("'{text}' is not a number"))?,
        };
        if number.is_finite() { Ok(number) } else { Err(format!("is {number}")) }
    }

    /// Returns the text; `None` for a missing cell.
    pub fn text(&self) -> Option<String> {
        match self {
            Cell::Missing => None,
            Cell::Number(number) => Some(number.to_string()),
            Cell::Text(text) => Some(text.clone()),
        }
    }
}

/// The table of a file, with the names, units and time scales of its columns.
#[derive(Clone, Debug)]
pub(in crate::schedule) struct RawTable {
    /// The format of the file.
    pub format: ScheduleFormat,
    /// Column names in order.
    pub names: Vec<String>,
    /// The rows, each as long as `names`; or the reason why a row is invalid.
    pub rows: Vec<Result<Vec<Cell>, String>>,
    /// Units by column, where the file has them.
    pub units: BTreeMap<String, String>,
    /// Time scales by column, where the file has them.
    pub time_scales: BTreeMap<String, TimeScale>,
}

impl RawTable {
    /// Creates a table without rows, units and time scales.
    pub fn new(format: ScheduleFormat, names: Vec<String>) -> Self {
        Self { format, names, rows: Vec::new(), units: BTreeMap::new(), time_scales: BTreeMap::new() }
    }
}
