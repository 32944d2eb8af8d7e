//! A schedule: exposures in the order of their rows, judged or not.

use std::collections::{BTreeSet, HashSet};
use std::path::Path;

use hifitime::TimeScale;

use crate::passes::Exposure;

use super::error::ScheduleError;
use super::formats::{self, ScheduleFormat};
use super::policy::MagnitudeLimit;
use super::rows;

/// One row of a schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledExposure {
    /// The schedule's own name for the exposure; the row's number from 1 where the cell is empty.
    pub id: String,
    /// The row, counted from 0 in the order of the file.
    pub row: usize,
    /// The band as written; `None` where the schedule says nothing. Any name is taken.
    pub band: Option<String>,
    /// The exposure, or why the row cannot be judged.
    pub exposure: Result<Exposure, String>,
}

/// How to read what a file leaves unsaid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScheduleOptions {
    /// The scale of times that name none. Without it, bare MJD, JD and times without `Z` are refused. It must not contradict what the
    /// file itself says.
    pub time_scale: Option<TimeScale>,
    /// The same, as a habit: it yields to what the file itself says.
    pub default_time_scale: Option<TimeScale>,
    /// Rotation of the field where a row gives none, radians.
    pub default_rotation_rad: f64,
}

/// All exposures of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// The syntax it was read in.
    pub format: ScheduleFormat,
    /// The rows in the order of the file.
    pub exposures: Vec<ScheduledExposure>,
    /// The column that shutter openings were read from.
    pub start_column: String,
    /// The time scale in which that column was read.
    pub time_scale: TimeScale,
}

impl Schedule {
    /// Reads a schedule; the format is found by its content, not by its name.
    ///
    /// Rows with cells that are missing, not finite or out of range stay in their place with their reason.
    ///
    /// # Errors
    /// - a file that is missing, a directory, empty or of another format;
    /// - missing columns, or a column in another unit;
    /// - times without a scale where `options` gives none.
    pub fn read(path: &Path, options: &ScheduleOptions) -> Result<Self, ScheduleError> {
        let table = formats::read_raw(path)?;
        rows::schedule_from_raw(path, table, options)
    }

    /// The rows that can be judged, with their place in `exposures`.
    pub fn judged(&self) -> impl Iterator<Item = (usize, &Exposure)> {
        self.exposures
            .iter()
            .enumerate()
            .filter_map(|(index, scheduled)| scheduled.exposure.as_ref().ok().map(|exposure| (index, exposure)))
    }

    /// How many rows carry an id that an earlier row has already.
    pub fn repeated_ids(&self) -> usize {
        let distinct: HashSet<&str> = self.exposures.iter().map(|row| row.id.as_str()).collect();
        self.exposures.len() - distinct.len()
    }

    /// Bands of the rows for which a limit has no number, each once; none where the telescope has the numbers.
    pub fn bands_without(&self, limit: &MagnitudeLimit) -> BTreeSet<&str> {
        let has_numbers = !matches!(limit, MagnitudeLimit::OfTelescope(_));
        self.exposures
            .iter()
            .filter(|row| has_numbers && limit.of(row.band.as_deref()).is_none())
            .map(|row| row.band.as_deref().unwrap_or("none"))
            .collect()
    }
}
