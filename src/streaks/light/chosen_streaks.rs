//! Streaks that the user chooses, from a table with one row a streak.

use std::io;
use std::path::{Path, PathBuf};

use super::given_streaks::{GivenColumns, GivenStreak, GivenWidth};
use super::modulation::LightCurve;
use crate::error::Error;
use crate::images::{Bounded, StreakRow, StreakTable};
use crate::input::{Column, TableRows};
use crate::message::listed;
use crate::units::{COUNTS, MAGNITUDES};

/// Greatest number of streaks in a table.
const MOST_STREAKS: usize = 100_000;

/// Brightness of a chosen streak.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum ChosenLight {
    /// Apparent magnitude, irrespective of the motion.
    Magnitude(f64),
    /// Light in the brightest pixel of the streak, in the unit of the frame, before noise and detector.
    Peak(f64),
}

/// One streak of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenStreak {
    /// Ends, times and width.
    pub given: GivenStreak,
    /// Brightness.
    pub light: ChosenLight,
    /// Magnitudes that are added during the exposure.
    pub curve: Option<LightCurve>,
}

/// Streaks of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenStreaks {
    /// Path of the table.
    pub path: PathBuf,
    /// The streaks.
    pub streaks: Vec<ChosenStreak>,
    /// Remarks about the columns.
    pub remarks: Vec<String>,
}

/// Columns besides those of the ends.
struct Columns {
    given: GivenColumns,
    magnitude: Option<Bounded>,
    peak: Option<Bounded>,
    curve: Option<Column>,
}

impl Columns {
    fn find(rows: &TableRows) -> io::Result<Self> {
        let columns = Self {
            given: GivenColumns::find(rows)?,
            magnitude: Bounded::find(rows, &["magnitude"], &MAGNITUDES, [-20.0, 40.0])?,
            peak: Bounded::find(rows, &["peak"], &COUNTS, [f64::MIN_POSITIVE, 1e12])?,
            curve: rows.find("light_curve"),
        };
        if columns.magnitude.is_none() && columns.peak.is_none() {
            let given = listed(rows.names().iter().map(String::as_str));
            let problem = format!("columns are {given}; allowed: also magnitude or peak");
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        }
        Ok(columns)
    }
}

impl ChosenStreaks {
    /// Reads a table (CSV, ECSV or FITS). Paths in its column `light_curve` are relative to its folder.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing, or a cell is invalid.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let names = [&GivenColumns::NAMES[..], &["magnitude", "peak", "light_curve"]].concat();
        let (table, columns) = StreakTable::read(path, MOST_STREAKS, &names, Columns::find)?;
        // No row is left out: the frame would lack a streak that the user chose.
        if let Some(error) = table.invalid().first() {
            return Err(error.clone());
        }
        let rows = table.rows().map(|row| ChosenStreak::of_row(&row, &columns, path));
        let streaks = rows.collect::<Result<_, _>>()?;
        Ok(Self { path: path.to_owned(), streaks, remarks: table.remarks() })
    }

    /// Checks that each row has a distance, without which a size of the satellites, m, has no angle.
    ///
    /// # Errors
    /// A row has no range_km.
    pub fn check_distances(&self, size_m: f64) -> Result<(), Error> {
        let without = |streak: &&ChosenStreak| !matches!(streak.given.width, GivenWidth::Distance { .. });
        self.streaks.iter().find(without).map_or(Ok(()), |streak| {
            let allowed = "with range_km in each row, which gives the angle";
            Err(streak.given.invalid("--satellite-size", format!("{size_m} m"), allowed))
        })
    }
}

impl ChosenStreak {
    fn of_row(row: &StreakRow<'_>, columns: &Columns, path: &Path) -> Result<Self, Error> {
        let light = match (row.number(columns.magnitude)?, row.number(columns.peak)?) {
            (Some(magnitude), None) => ChosenLight::Magnitude(magnitude),
            (None, Some(peak)) => ChosenLight::Peak(peak),
            (None, None) => return Err(row.invalid("magnitude", "", "a magnitude or a peak")),
            (Some(_), Some(peak)) => {
                return Err(row.invalid("peak", &peak.to_string(), "no peak with a magnitude"));
            }
        };
        let curve = match row.text(columns.curve) {
            "" => None,
            file => Some(LightCurve::read(&path.parent().unwrap_or(Path::new("")).join(file))?),
        };
        Ok(Self { given: GivenStreak::of_row(row, &columns.given)?, light, curve })
    }
}
