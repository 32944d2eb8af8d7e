//! Table of cells, as read from a schedule file of any format.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use hifitime::TimeScale;

use super::columns::{ScheduleFormat, ScheduleRow};
use super::csv_text::CsvText;
use crate::error::Error;
use crate::units::Unit;

/// Rows of a table.
#[derive(Clone, Debug)]
pub(in crate::schedule) enum Rows {
    /// Cells of all rows.
    Cells(Vec<ScheduleRow>),
    /// Text of a CSV file, whose rows are split into cells one by one: the cells take several times its memory.
    Csv(CsvText),
}

impl Rows {
    /// Returns true if there are no rows.
    pub fn is_empty(&self) -> bool {
        match self {
            Rows::Cells(rows) => rows.is_empty(),
            Rows::Csv(text) => text.rows == 0,
        }
    }

    /// Returns the rows in order.
    pub fn iter(&self) -> Box<dyn Iterator<Item = Cow<'_, ScheduleRow>> + '_> {
        match self {
            Rows::Cells(rows) => Box::new(rows.iter().map(Cow::Borrowed)),
            Rows::Csv(text) => Box::new(text.rows().map(Cow::Owned)),
        }
    }
}

impl From<Vec<ScheduleRow>> for Rows {
    fn from(rows: Vec<ScheduleRow>) -> Self {
        Rows::Cells(rows)
    }
}

/// Table of a schedule file, with names, units and time scales of its columns.
#[derive(Clone, Debug)]
pub(in crate::schedule) struct RawTable {
    /// Format of the file.
    pub format: ScheduleFormat,
    /// Column names in order.
    pub names: Vec<String>,
    /// Rows; a valid one has as many cells as `names`.
    pub rows: Rows,
    /// Units by column name, if the file states them.
    pub units: BTreeMap<String, String>,
    /// Time scales by column name, if the file states them.
    pub time_scales: BTreeMap<String, TimeScale>,
    /// What the file states of a column that cannot be used, and what is allowed, by column name.
    pub rejected: BTreeMap<String, String>,
    /// Names of the columns whose numbers were rounded to single precision, if the file states their types.
    pub single_precision: BTreeSet<String>,
    /// Number of comments in CSV and ECSV that have as many cells as a row.
    pub comments_like_rows: usize,
    /// Warnings about the content of the file.
    pub warnings: Vec<String>,
}

impl RawTable {
    /// Creates a table without rows, units or time scales.
    pub fn new(format: ScheduleFormat, names: Vec<String>) -> Self {
        Self {
            format,
            names,
            rows: Rows::Cells(Vec::new()),
            units: BTreeMap::new(),
            time_scales: BTreeMap::new(),
            rejected: BTreeMap::new(),
            single_precision: BTreeSet::new(),
            comments_like_rows: 0,
            warnings: Vec::new(),
        }
    }

    /// Returns the value of the unit of a column, in the given unit.
    ///
    /// # Errors
    /// The unit is unknown or contradicts the name of the column.
    pub fn scale(&self, path: &Path, index: usize, unit: &Unit) -> Result<f64, Error> {
        let name = self.names.get(index).map_or("", String::as_str);
        unit.scale(name, &self.units).map_err(|error| error.in_file("schedule", path))
    }
}
