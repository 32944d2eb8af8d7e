//! Data that all satellites of a request share: Sun and Earth orientation at sampled times, and search windows.
//!
//! A scheduler computes one visit after another. Without caches, most of the time would be spent on precession and
//! nutation at the same few times. Windows lie on a fixed grid of six hours, so that all searches of a night use the
//! same two or three windows. Except for rounding, results do not depend on the caches, because a window only selects
//! the satellites for which SGP4 is evaluated.

use std::sync::{Arc, Mutex, PoisonError};

use hifitime::{Duration, Epoch};

use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::{EopTable, OrientationTable, mjd_utc, seconds_after, seconds_between};
use crate::geometry::SunTable;
use crate::orbit::{MAX_WINDOW_S, Reach, SatelliteIndex, SearchScope, Window};
use crate::watch::Watch;

/// Sun, Earth orientation and orbits during one group of exposures. Times are seconds after its start.
pub(in crate::passes) struct Scene {
    pub start: Epoch,
    pub orientation: OrientationTable,
    pub sun: SunTable,
    /// Search windows in order of time, without gaps; empty if no satellites are searched.
    pub windows: Vec<Arc<Window>>,
    /// Satellites that are searched for.
    pub scope: SearchScope,
}

impl Scene {
    /// Returns the window that contains a time, and the start of the window, both in seconds after the start of the
    /// scene.
    pub fn window_at(&self, time_s: f64) -> Option<(&Window, f64)> {
        let start_s = |window: &Window| seconds_between(self.start, window.start());
        let window = self.windows.iter().rfind(|window| start_s(window) <= time_s).or(self.windows.first())?;
        Some((window, start_s(window)))
    }
}

/// Number of cached days, of 2 kB each. They are cached because a schedule uses its days several times.
const CACHED_DAYS: usize = 64;
/// Length of the tables that begin at the start of a UTC day, seconds.
const REACH_S: f64 = 3.0 * DAY_S;
/// Time by which tables must extend beyond the end of a request for interpolation, seconds.
const BEYOND_S: f64 = DAY_S;

/// Tables of Earth orientation and Sun that begin at the start of a UTC day.
#[derive(Debug)]
struct Day {
    orientation: OrientationTable,
    sun: SunTable,
}

/// Cache of the most recently computed days, the newest last.
#[derive(Debug, Default)]
pub(in crate::passes) struct Almanac {
    kept: Mutex<Vec<(i64, Arc<Day>)>>,
}

impl Almanac {
    /// Returns Earth orientation and Sun from `start` to `end`. `eop` must be the same in every call.
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
        let known = |kept: &[(i64, Arc<Day>)]| kept.iter().find(|(known, _)| *known == key).map(|(_, day)| day.clone());
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(day) = known(&lock()) {
            return day;
        }
        // The lock is free during the computation, so that threads with other days do not wait. Threads that need the
        // same day may compute it twice.
        let first = Epoch::from_mjd_utc(number);
        let last = seconds_after(first, REACH_S);
        let day =
            Arc::new(Day { orientation: OrientationTable::new(first, last, eop), sun: SunTable::new(first, last) });
        let mut kept = lock();
        if let Some(day) = known(&kept) {
            return day;
        }
        kept.push((key, day.clone()));
        let surplus = kept.len().saturating_sub(CACHED_DAYS);
        kept.drain(..surplus);
        day
    }
}

/// Smallest number of cached windows: three windows of a night, and one more.
const LEAST_CACHED_WINDOWS: usize = 4;
/// Number of satellites in all cached windows together, of 140 bytes each. A schedule uses its nights several times,
/// and computing the three windows of a night takes as long as the crossings of 700 exposures.
const CACHED_SATELLITES: usize = 500_000;

/// Returns the start of window 0. It is in UTC, as the epochs of element sets, so that times of windows are compared
/// with them without a conversion for each satellite.
fn start_of_windows() -> Epoch {
    Epoch::from_utc_duration(Duration::ZERO)
}

/// Returns the number of the window of six hours that contains a time.
pub(in crate::passes) fn window_number(epoch: Epoch) -> i64 {
    (seconds_between(start_of_windows(), epoch) / MAX_WINDOW_S).floor() as i64
}

/// Returns the middle of the window with this number.
pub(in crate::passes) fn middle_of_window(number: i64) -> Epoch {
    seconds_after(start_of_windows(), MAX_WINDOW_S * (number as f64 + 0.5))
}

/// Cache of the most recently used windows, the newest last.
#[derive(Debug, Default)]
pub(in crate::passes) struct WindowCache {
    /// Windows with their numbers on the grid of six hours.
    kept: Mutex<Vec<(i64, Arc<Window>)>>,
}

impl WindowCache {
    /// Returns the windows that contain the time between the two `ends`, in order. Missing windows are computed on all
    /// threads.
    ///
    /// `unknown` returns the reason why a satellite has no known position at a time; its arguments are the element
    /// index and the middle of a window. `reach` returns the distance from the predicted position within which a
    /// satellite is searched for; its arguments are the element index and the two ends of a window. It must be the same
    /// function in every call.
    pub fn over(
        &self,
        index: &SatelliteIndex,
        [start, end]: [Epoch; 2],
        unknown: &(dyn Fn(usize, Epoch) -> Option<Error> + Sync),
        reach: &(dyn Fn(usize, [Epoch; 2]) -> Reach + Sync),
        watch: &Watch,
    ) -> Result<Vec<Arc<Window>>, Error> {
        let most = (CACHED_SATELLITES / index.len().max(1)).max(LEAST_CACHED_WINDOWS);
        (window_number(start)..=window_number(end))
            .map(|number| {
                if let Some(window) = self.kept(number) {
                    return Ok(window);
                }
                // Computed while the lock is not held, because the threads that compute the window may use the cache.
                let from = seconds_after(start_of_windows(), MAX_WINDOW_S * number as f64);
                let ends = [from, seconds_after(from, MAX_WINDOW_S)];
                let middle = middle_of_window(number);
                let window = Arc::new(Window::new(
                    index,
                    ends[0],
                    ends[1],
                    &|element_index| unknown(element_index, middle),
                    &|element_index| reach(element_index, ends),
                    watch,
                )?);
                self.keep(number, &window, most);
                Ok(window)
            })
            .collect()
    }

    fn kept(&self, number: i64) -> Option<Arc<Window>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let position = kept.iter().position(|(known, _)| *known == number)?;
        let found = kept.remove(position);
        let window = found.1.clone();
        kept.push(found);
        Some(window)
    }

    fn keep(&self, number: i64, window: &Arc<Window>, most: usize) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.iter().all(|(known, _)| *known != number) {
            kept.push((number, Arc::clone(window)));
            let surplus = kept.len().saturating_sub(most);
            kept.drain(..surplus);
        }
    }
}
