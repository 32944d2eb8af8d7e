//! Nights at a longitude, and division of a schedule into shards of whole nights for separate machines.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use hifitime::{Epoch, TimeScale, Unit};

use crate::error::Error;
use crate::frames::{mjd_utc, seconds_after};

use super::scheduled::{Schedule, ScheduledExposure};

/// Returns start and end of the night that begins on the evening of a date: from local mean noon to the next, at a
/// longitude in radians (east positive).
pub fn night_of(evening: Epoch, longitude_rad: f64) -> (Epoch, Epoch) {
    let (year, month, day, ..) = evening.to_gregorian_utc();
    let longitude_rad = (longitude_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    let day_s = Unit::Day.in_seconds();
    // UTC of local mean noon: 12 h - λ / 15 deg/h
    let noon_s = day_s * (0.5 - longitude_rad / std::f64::consts::TAU);
    let noon = seconds_after(Epoch::from_gregorian_utc_at_midnight(year, month, day), noon_s);
    (noon, seconds_after(noon, day_s).to_time_scale(TimeScale::UTC))
}

/// Returns the date of the evening of the night that contains a time, as MJD.
///
/// A night lasts from one local mean noon to the next at a longitude in radians (east positive).
pub fn evening_mjd(epoch: Epoch, longitude_rad: f64) -> i64 {
    // Local mean time is ahead of UTC by λ / 2π days.
    (mjd_utc(epoch) + longitude_rad / std::f64::consts::TAU - 0.5).floor() as i64
}

/// Shard `index` of `count`; the index counts from 1.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

/// Largest number of shards.
const MAX_SHARDS: usize = 1_000_000;

impl FromStr for Shard {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let parts = text.trim().split_once('/').and_then(|(index, count)| {
            Some(Shard { index: index.trim().parse().ok()?, count: count.trim().parse().ok()? })
        });
        let is_valid =
            |shard: &Shard| (1..=MAX_SHARDS).contains(&shard.count) && (1..=shard.count).contains(&shard.index);
        parts
            .filter(is_valid)
            .ok_or_else(|| Error::malformed("shard", text, "I/N with 1 <= I <= N <= 1000000, for example 3/100"))
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// Returns, for each row of a schedule, true if it belongs to this shard.
    ///
    /// Every row is in exactly one shard. A night lasts from one local mean noon to the next at a longitude in radians
    /// (east positive). The nights are sorted by time and assigned to shards 1, 2, ..., `count`, 1, ... in turn.
    /// Invalid rows are in shard 1.
    pub fn rows(&self, schedule: &Schedule, longitude_rad: f64) -> Vec<bool> {
        let night = |row: &ScheduledExposure| {
            row.exposure.as_ref().ok().map(|exposure| evening_mjd(exposure.start, longitude_rad))
        };
        let nights: BTreeSet<i64> = schedule.exposures.iter().filter_map(night).collect();
        let own: BTreeSet<i64> = nights.into_iter().skip(self.index - 1).step_by(self.count).collect();
        let is_own = |row| night(row).map_or(self.index == 1, |night| own.contains(&night));
        schedule.exposures.iter().map(is_own).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Direction, seconds_between};
    use crate::output::format_utc;
    use crate::passes::Exposure;
    use crate::schedule::ScheduleFormat;

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
            open_s: None,
            exposure: hour.map(exposure).ok_or_else(|| "no".to_owned()),
        };
        Schedule {
            format: ScheduleFormat::Csv,
            exposures: hours.iter().enumerate().map(row).collect(),
            start_column: "start_utc".into(),
            time_scale: TimeScale::UTC,
            comments_like_rows: 0,
            other_ends: None,
            stated_altitudes: Vec::new(),
            warnings_of_file: Vec::new(),
        }
    }

    #[test]
    fn every_row_and_every_night_is_in_one_shard() {
        // Local noon in Chile is at 16.7 h UTC, so that 16.0 h and 23.0 h of one date belong to different nights.
        let schedule = schedule(&[Some(1.0), Some(16.0), Some(17.0), Some(25.0), None, Some(41.0), Some(90.0)]);
        let longitude_rad = f64::to_radians(-70.75);
        for count in 1..6 {
            let shards: Vec<Vec<bool>> =
                (1..=count).map(|index| Shard { index, count }.rows(&schedule, longitude_rad)).collect();
            for row in 0..schedule.exposures.len() {
                assert_eq!(shards.iter().filter(|shard| shard[row]).count(), 1, "row {row} of {count} shards");
            }
        }
        let shard = |index| Shard { index, count: 2 }.rows(&schedule, longitude_rad);
        assert_eq!(shard(1), [true, true, false, false, true, true, false]);
        assert_eq!(shard(2), [false, false, true, true, false, false, true]);
    }

    #[test]
    fn invalid_shards_are_errors_with_the_accepted_form() {
        assert_eq!("3/100".parse::<Shard>().unwrap().to_string(), "3/100");
        for text in ["", "3", "0/4", "5/4", "1/0", "a/b", "1/2/3", "-1/4", "1/10000000"] {
            assert!(text.parse::<Shard>().unwrap_err().to_string().contains("allowed: I/N with 1 <= I <= N"), "{text}");
        }
    }

    #[test]
    fn nights_begin_at_the_local_noon_of_their_evening() {
        let date = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        for (longitude_deg, noon) in [
            (0.0, "2024-08-14T12:00:00Z"),
            (-70.75, "2024-08-14T16:43:00Z"),
            (289.25, "2024-08-14T16:43:00Z"),
            (150.0, "2024-08-14T02:00:00Z"),
        ] {
            let (first, last) = night_of(date, f64::to_radians(longitude_deg));
            assert_eq!(format_utc(first, 0), noon, "{longitude_deg}");
            assert_eq!(seconds_between(first, last), 86_400.0);
        }
    }
}
