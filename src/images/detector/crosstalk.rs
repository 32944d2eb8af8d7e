//! Ghosts of bright pixels in what other amplifiers read at the same moment.

use serde::Deserialize;

use super::error::DetectorError;

/// Where an amplifier's first pixel lies, by rows and columns counted from 0.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReadoutCorner {
    /// First row and first column of its pixels.
    #[default]
    FirstRowFirstColumn,
    /// First row and last column: read to the right.
    FirstRowLastColumn,
    /// Last row and first column.
    LastRowFirstColumn,
    /// Last row and last column.
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
    /// Which pixel is read first.
    #[serde(default)]
    pub corner: ReadoutCorner,
}

/// Amplifiers of one size that are read together, and what each hears of the others.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crosstalk {
    /// The amplifiers, all of one size, without common pixels.
    pub amplifiers: Vec<Amplifier>,
    /// `(victim, source)`: the share of the source's signal that is added to the victim's pixel read at the same moment, \[-0.1, 0.1\]; 0 on
    /// the diagonal.
    pub coefficients: Vec<Vec<f64>>,
}

impl Amplifier {
    fn end_row(&self) -> usize {
        self.first_row.saturating_add(self.rows)
    }

    fn end_column(&self) -> usize {
        self.first_column.saturating_add(self.columns)
    }

    fn holds(&self, row: usize, column: usize) -> bool {
        (self.first_row..self.end_row()).contains(&row) && (self.first_column..self.end_column()).contains(&column)
    }

    fn overlaps(&self, other: &Self) -> bool {
        let apart = self.end_row() <= other.first_row
            || other.end_row() <= self.first_row
            || self.end_column() <= other.first_column
            || other.end_column() <= self.first_column;
        !apart
    }

    /// From a pixel to its place in the order of reading, and back: the same turn.
    fn turned(&self, line: usize, place: usize) -> (usize, usize) {
        let (last_line, last_place) = (self.rows - 1, self.columns - 1);
        match self.corner {
            ReadoutCorner::FirstRowFirstColumn => (line, place),
            ReadoutCorner::FirstRowLastColumn => (line, last_place - place),
            ReadoutCorner::LastRowFirstColumn => (last_line - line, place),
            ReadoutCorner::LastRowLastColumn => (last_line - line, last_place - place),
        }
    }
}

impl Crosstalk {
    pub(super) fn validate(&self) -> Result<(), DetectorError> {
        let list = |message: String| DetectorError::List { key: "crosstalk", message };
        let count = self.amplifiers.len();
        if count < 2 {
            return Err(list(format!("{count} amplifiers, at least 2 are needed")));
        }
        for (number, amplifier) in self.amplifiers.iter().enumerate() {
            if amplifier.rows == 0 || amplifier.columns == 0 {
                return Err(list(format!("amplifier {number} has no pixels")));
            }
            if (amplifier.rows, amplifier.columns) != (self.amplifiers[0].rows, self.amplifiers[0].columns) {
                return Err(list(format!("amplifier {number} is not of the size of amplifier 0")));
            }
            if let Some(other) = self.amplifiers[..number].iter().position(|other| other.overlaps(amplifier)) {
                return Err(list(format!("amplifiers {other} and {number} have pixels in common")));
            }
        }
        if self.coefficients.len() != count || self.coefficients.iter().any(|row| row.len() != count) {
            return Err(list(format!("coefficients must be {count} rows of {count} numbers")));
        }
        for (victim, row) in self.coefficients.iter().enumerate() {
            row.iter().try_for_each(|c| DetectorError::hold("crosstalk.coefficients", *c, -0.1, 0.1))?;
            if row[victim] != 0.0 {
                return Err(list(format!("the coefficient of amplifier {victim} on itself must be 0")));
            }
        }
        Ok(())
    }

    /// # Errors
    /// [`DetectorError::AmplifierOutside`] where an amplifier reads what a frame of this shape does not have.
    pub(super) fn check_shape(&self, rows: usize, columns: usize) -> Result<(), DetectorError> {
        for (number, amplifier) in self.amplifiers.iter().enumerate() {
            if amplifier.end_row() > rows || amplifier.end_column() > columns {
                return Err(DetectorError::AmplifierOutside {
                    number,
                    first_row: amplifier.first_row,
                    end_row: amplifier.end_row(),
                    first_column: amplifier.first_column,
                    end_column: amplifier.end_column(),
                    rows,
                    columns,
                });
            }
        }
        Ok(())
    }

    /// What a signal in one pixel adds elsewhere: calls `add(row, column, signal)` for each victim.
    pub(super) fn spread(&self, row: usize, column: usize, signal: f32, mut add: impl FnMut(usize, usize, f32)) {
        let Some(source) = self.amplifiers.iter().position(|amplifier| amplifier.holds(row, column)) else { return };
        let own = &self.amplifiers[source];
        let (line, place) = own.turned(row - own.first_row, column - own.first_column);
        for (victim, coefficients) in self.amplifiers.iter().zip(&self.coefficients) {
            if coefficients[source] != 0.0 {
                let (line, place) = victim.turned(line, place);
                add(victim.first_row + line, victim.first_column + place, signal * coefficients[source] as f32);
            }
        }
    }
}
