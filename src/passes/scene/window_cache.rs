//! Cache of search windows.
//!
//! Windows lie on a fixed grid of six hours, so that all searches of a night use the same two or three, whether a
//! thousand exposures come at once or one by one. Results do not depend on the cache: a window only selects the
//! satellites for which SGP4 is evaluated.

use std::sync::{Arc, Mutex, PoisonError};

use hifitime::{Duration, Epoch};

use crate::frames::{seconds_after, seconds_between};
use crate::orbit::{MAX_WINDOW_S, Reach, SatelliteIndex, Window};

/// Windows that are kept at least: a night of three, for both scopes, and two more.
const LEAST_KEPT: usize = 8;
/// Satellites in all windows that are kept, 140 bytes each: a schedule goes through its nights several times, and
/// making the three windows of a night takes as long as the crossings of 700 exposures.
const KEPT_SATELLITES: usize = 500_000;

/// Which satellites a window searches.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(in crate::passes) enum SearchScope {
    /// Those that cross where they are predicted.
    Nominal,
    /// Those that cross with a delay and an offset across the track that their errors allow.
    Delayed,
}

/// A window's number on the grid, and its scope.
type Key = (i64, SearchScope);

/// The windows used last, newest last.
#[derive(Debug, Default)]
pub(in crate::passes) struct WindowCache {
    kept: Mutex<Vec<(Key, Arc<Window>)>>,
}

impl WindowCache {
    /// The windows that hold the time from `start` to `end`, in order; those that are missing are made on all threads.
    ///
    /// `reach` gives, for an element index and the two ends of a window, how far from its prediction a satellite is
    /// searched; it must be the same function for the same `scope`.
    pub fn over(
        &self,
        index: &SatelliteIndex,
        start: Epoch,
        end: Epoch,
        scope: SearchScope,
        reach: &(dyn Fn(usize, [Epoch; 2]) -> Reach + Sync),
    ) -> Vec<Arc<Window>> {
        let most = (KEPT_SATELLITES / index.len().max(1)).max(LEAST_KEPT);
        let grid = Epoch::from_tai_duration(Duration::ZERO);
        let number = |epoch: Epoch| (seconds_between(grid, epoch) / MAX_WINDOW_S).floor() as i64;
        (number(start)..=number(end))
            .map(|number| {
                let key = (number, scope);
                if let Some(window) = self.kept(key) {
                    return window;
                }
                // Made outside of the lock: the threads that help may use the cache themselves.
                let from = seconds_after(grid, MAX_WINDOW_S * number as f64);
                let ends = [from, seconds_after(from, MAX_WINDOW_S)];
                let window =
                    Arc::new(Window::new(index, ends[0], ends[1], &|element_index| reach(element_index, ends)));
                self.keep(key, &window, most);
                window
            })
            .collect()
    }

    fn kept(&self, key: Key) -> Option<Arc<Window>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let position = kept.iter().position(|(known, _)| *known == key)?;
        let found = kept.remove(position);
        let window = found.1.clone();
        kept.push(found);
        Some(window)
    }

    fn keep(&self, key: Key, window: &Arc<Window>, most: usize) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.iter().all(|(known, _)| *known != key) {
            kept.push((key, Arc::clone(window)));
            let surplus = kept.len().saturating_sub(most);
            kept.drain(..surplus);
        }
    }
}
