//! Columns of CSV files, plain or gzipped, with `#` lines before the header or without.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use flate2::read::MultiGzDecoder;
use hifitime::Epoch;

use super::error::CheckError;

/// The wanted columns of a file, row by row.
pub(super) struct Rows<const N: usize> {
    path: PathBuf,
    columns: [&'static str; N],
    rows: Vec<[String; N]>,
}

/// One of them.
pub(super) struct Row<'a, const N: usize> {
    rows: &'a Rows<N>,
    index: usize,
}

/// The text of a file, unpacked where its name ends in `gz`.
pub(super) fn text_of(path: &Path) -> Result<String, CheckError> {
    let unreadable =
        |error: std::io::Error| CheckError::Unreadable { path: path.to_owned(), problem: error.to_string() };
    let packed = std::fs::read(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    if path.extension().is_some_and(|end| end == "gz") {
        MultiGzDecoder::new(&packed[..]).read_to_end(&mut bytes).map_err(unreadable)?;
    } else {
        bytes = packed;
    }
    // Names in old tables are Latin-1; the numbers are ASCII.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

impl<const N: usize> Rows<N> {
    pub(super) fn read(path: &Path, columns: [&'static str; N]) -> Result<Self, CheckError> {
        let text = text_of(path)?;
        let unreadable =
            |error: csv::Error| CheckError::Unreadable { path: path.to_owned(), problem: error.to_string() };
        let text = text.trim_start_matches('\u{feff}').trim_start();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let headers = reader.headers().map_err(unreadable)?.clone();
        let mut places = [0; N];
        for (place, &column) in places.iter_mut().zip(&columns) {
            *place = headers
                .iter()
                .position(|header| header.trim() == column)
                .ok_or_else(|| CheckError::Column { path: path.to_owned(), column })?;
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            rows.push(places.map(|place| record.get(place).unwrap_or_default().trim().to_owned()));
        }
        Ok(Self { path: path.to_owned(), columns, rows })
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Row<'_, N>> {
        (0..self.rows.len()).map(|index| Row { rows: self, index })
    }
}

impl<const N: usize> Row<'_, N> {
    pub(super) fn text(&self, column: usize) -> &str {
        &self.rows.rows[self.index][column]
    }

    /// A finite number within bounds.
    pub(super) fn number(
        &self,
        column: usize,
        [least, greatest]: [f64; 2],
        expected: &'static str,
    ) -> Result<f64, CheckError> {
        let number = self.text(column).parse::<f64>().ok().filter(|number| (least..=greatest).contains(number));
        number.ok_or_else(|| self.wrong(column, expected))
    }

    pub(super) fn magnitude(&self, column: usize) -> Result<f64, CheckError> {
        self.number(column, [-30.0, 40.0], "a magnitude")
    }

    /// A moment in UTC.
    pub(super) fn utc(&self, column: usize) -> Result<Epoch, CheckError> {
        let text = self.text(column).replace(' ', "T");
        Epoch::from_str(&format!("{text} UTC")).map_err(|_| self.wrong(column, "a moment in UTC"))
    }

    fn wrong(&self, column: usize, expected: &'static str) -> CheckError {
        CheckError::Cell {
            path: self.rows.path.clone(),
            row: self.index + 1,
            column: self.rows.columns[column],
            given: self.text(column).to_owned(),
            expected,
        }
    }
}
