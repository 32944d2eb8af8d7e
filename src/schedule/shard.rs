//! Shares of a batch: whole nights dealt out, so that each machine prepares few of them.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::scheduled::Schedule;
use super::windows::evening_mjd;

/// Share `index` of `count`, counted from 1.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

/// Why a text is no share.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("shard '{given}' is none; allowed: I/N with I from 1 to N and N at most 1000000, as 3/100")]
pub struct ShardError {
    given: String,
}

/// More shares than this are a slip of the finger.
const MOST: usize = 1_000_000;

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let parts = text.trim().split_once('/').and_then(|(index, count)| {
            Some(Shard { index: index.trim().parse().ok()?, count: count.trim().parse().ok()? })
        });
        let is_share = |shard: &Shard| (1..=MOST).contains(&shard.count) && (1..=shard.count).contains(&shard.index);
        parts.filter(is_share).ok_or_else(|| ShardError { given: text.to_owned() })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// Which rows of a schedule are in this share, one for each of them.
    ///
    /// A night lasts from local mean noon to noon at a longitude (east positive, radians). The nights of the schedule are dealt in time order:
    /// the first to share 1, the second to share 2, and so on around. Rows that cannot be judged are in share 1. So every row is in one share.
    pub fn rows(&self, schedule: &Schedule, longitude_rad: f64) -> Vec<bool> {
        let night = |row: &super::ScheduledExposure| {
            row.exposure.as_ref().ok().map(|exposure| evening_mjd(exposure.start, longitude_rad))
        };
        let nights: BTreeSet<i64> = schedule.exposures.iter().filter_map(night).collect();
        let mine: BTreeSet<i64> = nights.into_iter().skip(self.index - 1).step_by(self.count).collect();
        let is_mine = |row| night(row).map_or(self.index == 1, |night| mine.contains(&night));
        schedule.exposures.iter().map(is_mine).collect()
    }
}

#[cfg(test)]
mod tests {
    use hifitime::{Epoch, TimeScale};

    use super::*;
    use crate::frames::{Direction, seconds_after};
    use crate::passes::Exposure;
    use crate::schedule::{ScheduleFormat, ScheduledExposure};

    fn schedule(hours: &[Option<f64>]) -> Schedule {
        let midnight = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let exposure = |hour: f64| Exposure {
            id: "x".into(),
            start: seconds_after(midnight, hour * 3600.0),
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(1.0, 0.5),
            rotation_rad: 0.0,
        };
        let row = |(row, hour): (usize, &Option<f64>)| ScheduledExposure {
            id: "x".into(),
            row,
            band: None,
            exposure: hour.map(exposure).ok_or_else(|| "no".to_owned()),
        };
        Schedule {
            format: ScheduleFormat::Csv,
            exposures: hours.iter().enumerate().map(row).collect(),
            start_column: "start_utc".into(),
            time_scale: TimeScale::UTC,
        }
    }

    #[test]
    fn every_row_is_in_one_share_and_a_night_in_one() {
        // Midnight in Chile is 4.7 h UTC: 16.0 and 23.0 of one day end different nights' sides of noon at 16.7.
        let schedule = schedule(&[Some(1.0), Some(16.0), Some(17.0), Some(25.0), None, Some(41.0), Some(90.0)]);
        let longitude_rad = f64::to_radians(-70.75);
        for count in 1..6 {
            let shares: Vec<Vec<bool>> =
                (1..=count).map(|index| Shard { index, count }.rows(&schedule, longitude_rad)).collect();
            for row in 0..schedule.exposures.len() {
                assert_eq!(shares.iter().filter(|share| share[row]).count(), 1, "row {row} of {count} shares");
            }
        }
        let share = |index| Shard { index, count: 2 }.rows(&schedule, longitude_rad);
        assert_eq!(share(1), [true, true, false, false, true, true, false]);
        assert_eq!(share(2), [false, false, true, true, false, false, true]);
    }

    #[test]
    fn what_is_no_share_is_told_what_is() {
        assert_eq!("3/100".parse::<Shard>().unwrap().to_string(), "3/100");
        for text in ["", "3", "0/4", "5/4", "1/0", "a/b", "1/2/3", "-1/4", "1/10000000"] {
            assert!(text.parse::<Shard>().unwrap_err().to_string().contains("as 3/100"), "{text}");
        }
    }
}
