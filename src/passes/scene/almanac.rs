//! Cache of Sun and Earth, by day.
//!
//! A scheduler computes visit by visit; without the cache most of its time would go into precession and nutation at the
//! same few times. Results do not depend on the cache, to rounding.

use std::sync::{Arc, Mutex, PoisonError};

use hifitime::Epoch;

use crate::constants::DAY_S;
use crate::frames::{EopTable, OrientationTable, mjd_utc, seconds_after, seconds_between};
use crate::geometry::SunTable;

/// Days that are kept, 2 kB each: a schedule goes through its days several times.
const KEPT: usize = 64;
/// The tables of a day reach as far beyond its beginning, seconds.
const REACH_S: f64 = 3.0 * DAY_S;
/// Interpolation needs this much beyond the end, seconds.
const BEYOND_S: f64 = DAY_S;

/// Tables from the beginning of a UTC day on.
#[derive(Debug)]
struct Day {
    orientation: OrientationTable,
    sun: SunTable,
}

/// The days used last, newest last.
#[derive(Debug, Default)]
pub(in crate::passes) struct Almanac {
    kept: Mutex<Vec<(i64, Arc<Day>)>>,
}

impl Almanac {
    /// Earth and Sun from `start` to `end`; `eop` is always the same.
    pub fn over(&self, start: Epoch, end: Epoch, eop: &EopTable) -> (OrientationTable, SunTable) {
        let day = self.day(start, eop);
        if seconds_between(day.sun.reference(), end) + BEYOND_S > REACH_S {
            return (OrientationTable::new(start, end, eop), SunTable::new(start, end));
        }
        (day.orientation.part(start, end, eop), day.sun.part(start))
    }

    fn day(&self, start: Epoch, eop: &EopTable) -> Arc<Day> {
        let number = mjd_utc(start).floor();
        let key = number as i64;
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, day)) = kept.iter().find(|(known, _)| *known == key) {
            return day.clone();
        }
        let first = Epoch::from_mjd_utc(number);
        let last = seconds_after(first, REACH_S);
        let day =
            Arc::new(Day { orientation: OrientationTable::new(first, last, eop), sun: SunTable::new(first, last) });
        kept.push((key, day.clone()));
        let surplus = kept.len().saturating_sub(KEPT);
        kept.drain(..surplus);
        day
    }
}
