//! Crosstalk: ghosts of bright pixels in the pixels that other amplifiers read at the same time.

use serde::Deserialize;

use std::fmt::Display;

use crate::error::Error;

/// Corner of an amplifier's area at which the readout begins. Rows and columns are counted from 0.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReadoutCorner {
    /// The first row and the first column are read first.
    #[default]
    FirstRowFirstColumn,
    /// The first row and the last column are read first.
    FirstRowLastColumn,
    /// The last row and the first column are read first.
    LastRowFirstColumn,
    /// The last row and the last column are read first.
    LastRowLastColumn,
}

/// The pixels that one amplifier reads.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Amplifier {
    /// First row, from 0.
    pub first_row: usize,
    /// Number of rows.
    pub rows: usize,
    /// First column, from 0.
    pub first_column: usize,
    /// Number of columns.
    pub columns: usize,
    /// Corner whose pixel is read first.
    #[serde(default)]
    pub corner: ReadoutCorner,
}

/// Amplifiers of equal size that are read simultaneously, and the crosstalk between them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crosstalk {
    /// Amplifiers, all of the same size, without common pixels.
    pub amplifiers: Vec<Amplifier>,
    /// Coefficients `[victim][source]`: fraction of the source's signal that is added to the pixel of the victim that
    /// is read at the same time, \[-0.1, 0.1\]; 0 on the diagonal.
    pub coefficients: Vec<Vec<f64>>,
}

impl Amplifier {
    fn end_row(&self) -> usize {
        self.first_row.saturating_add(self.rows)
    }

    fn end_column(&self) -> usize {
        self.first_column.saturating_add(self.columns)
    }

    fn contains(&self, row: usize, column: usize) -> bool {
        (self.first_row..self.end_row()).contains(&row) && (self.first_column..self.end_column()).contains(&column)
    }

    fn overlaps(&self, other: &Self) -> bool {
        let apart = self.end_row() <= other.first_row
            || other.end_row() <= self.first_row
            || self.end_column() <= other.first_column
            || other.end_column() <= self.first_column;
        !apart
    }

    /// Converts the position of a pixel in the amplifier to its position in the order of readout. The conversion is its
    /// own inverse.
    fn readout_order(&self, line: usize, pixel: usize) -> (usize, usize) {
        let (last_line, last_pixel) = (self.rows - 1, self.columns - 1);
        match self.corner {
            ReadoutCorner::FirstRowFirstColumn => (line, pixel),
            ReadoutCorner::FirstRowLastColumn => (line, last_pixel - pixel),
            ReadoutCorner::LastRowFirstColumn => (last_line - line, pixel),
            ReadoutCorner::LastRowLastColumn => (last_line - line, last_pixel - pixel),
        }
    }
}

impl Crosstalk {
    pub(super) fn validate(&self) -> Result<(), Error> {
        let invalid = |what: String, given: &dyn Display, allowed: String| {
            Err(Error::invalid(format!("crosstalk: {what}"), given, allowed))
        };
        let count = self.amplifiers.len();
        if count < 2 {
            return invalid("number of amplifiers".into(), &count, "at least 2".into());
        }
        for (number, amplifier) in self.amplifiers.iter().enumerate() {
            if amplifier.rows == 0 || amplifier.columns == 0 {
                return invalid(format!("amplifier {number}"), &"empty", "at least one pixel".into());
            }
            if (amplifier.rows, amplifier.columns) != (self.amplifiers[0].rows, self.amplifiers[0].columns) {
                let size = format!("{} rows by {} columns", amplifier.rows, amplifier.columns);
                return invalid(format!("amplifier {number}"), &size, "the size of amplifier 0".into());
            }
            if let Some(other) = self.amplifiers[..number].iter().position(|other| other.overlaps(amplifier)) {
                return invalid(format!("amplifier {number}"), &format!("over amplifier {other}"), "no overlap".into());
            }
        }
        if self.coefficients.len() != count || self.coefficients.iter().any(|row| row.len() != count) {
            let rows: Vec<usize> = self.coefficients.iter().map(Vec::len).collect();
            let given = format!("{} rows of {rows:?} numbers", rows.len());
            return invalid("coefficients".into(), &given, format!("{count} rows of {count} numbers"));
        }
        for (victim, row) in self.coefficients.iter().enumerate() {
            row.iter().try_for_each(|c| Error::check_range("crosstalk.coefficients", *c, -0.1, 0.1))?;
            if row[victim] != 0.0 {
                return invalid(format!("coefficient of amplifier {victim} on itself"), &row[victim], "0".into());
            }
        }
        Ok(())
    }

    /// Checks that all amplifiers lie within a frame of this shape.
    ///
    /// # Errors
    /// An amplifier that extends beyond the frame.
    pub(super) fn check_shape(&self, rows: usize, columns: usize) -> Result<(), Error> {
        for (number, amplifier) in self.amplifiers.iter().enumerate() {
            if amplifier.end_row() > rows || amplifier.end_column() > columns {
                let Amplifier { first_row, first_column, .. } = *amplifier;
                let (last_row, last_column) = (amplifier.end_row() - 1, amplifier.end_column() - 1);
                return Err(Error::invalid(
                    format!("amplifier {number}"),
                    format!("rows {first_row} to {last_row} and columns {first_column} to {last_column}"),
                    format!("rows and columns of the frame of {rows} rows by {columns} columns"),
                ));
            }
        }
        Ok(())
    }

    /// Computes the ghosts of the signal in one pixel: calls `add(row, column, signal)` for the pixel of each victim.
    pub(super) fn spread(&self, row: usize, column: usize, signal: f32, mut add: impl FnMut(usize, usize, f32)) {
        let Some(source) = self.amplifiers.iter().position(|amplifier| amplifier.contains(row, column)) else { return };
        let own = &self.amplifiers[source];
        let (line, pixel) = own.readout_order(row - own.first_row, column - own.first_column);
        for (victim, coefficients) in self.amplifiers.iter().zip(&self.coefficients) {
            if coefficients[source] != 0.0 {
                let (line, pixel) = victim.readout_order(line, pixel);
                add(victim.first_row + line, victim.first_column + pixel, signal * coefficients[source] as f32);
            }
        }
    }
}
