//! Orbit planes and phases of a catalogue, kept from one question to the next.
//!
//! Windows lie on a fixed grid of six hours, so that every question about a night asks the same two or three, whether a
//! thousand exposures come at once or one by one. The answers do not depend on what is kept: a window only says whom to
//! ask.

use std::sync::{Arc, Mutex, PoisonError};

use hifitime::{Duration, Epoch};

use crate::frames::{seconds_after, seconds_between};
use crate::orbit::{MAX_WINDOW_S, Reach, SatelliteIndex, Window};

/// Windows that are kept: a night of three, for crossings and for chances, and room. About 2 MB each for 15,000 satellites.
const KEPT: usize = 8;

/// How far from its prediction a window still wants a satellite.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// Nominal crossings alone.
    Crossings,
    /// Near misses that are listed.
    NearMisses,
    /// Whoever may come by, however late.
    Anyone,
}

/// A window's place on the grid, and what it wants.
type Key = (i64, Wanted);

/// The last windows that were asked for, newest last.
#[derive(Debug, Default)]
pub(super) struct Windows {
    kept: Mutex<Vec<(Key, Arc<Window>)>>,
}

impl Windows {
    /// The windows that hold the time from `start` to `end`, in order; those that are not kept are made on all threads.
    ///
    /// `reach` gives, for an element index and the two ends of a window, how far from its prediction a satellite is still
    /// wanted; it must be the same function for the same `wanted`.
    pub fn over(
        &self,
        index: &SatelliteIndex,
        start: Epoch,
        end: Epoch,
        wanted: Wanted,
        reach: &(dyn Fn(usize, [Epoch; 2]) -> Reach + Sync),
    ) -> Vec<Arc<Window>> {
        let grid = Epoch::from_tai_duration(Duration::ZERO);
        let number = |epoch: Epoch| (seconds_between(grid, epoch) / MAX_WINDOW_S).floor() as i64;
        (number(start)..=number(end))
            .map(|number| {
                let key = (number, wanted);
                if let Some(window) = self.kept(key) {
                    return window;
                }
                // Made outside of the lock: the threads that help may come here with questions of their own.
                let from = seconds_after(grid, MAX_WINDOW_S * number as f64);
                let ends = [from, seconds_after(from, MAX_WINDOW_S)];
                let window = Arc::new(index.window(ends[0], ends[1], &|element_index| reach(element_index, ends)));
                self.keep(key, &window);
                window
            })
            .collect()
    }

    fn kept(&self, key: Key) -> Option<Arc<Window>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let place = kept.iter().position(|(known, _)| *known == key)?;
        let found = kept.remove(place);
        let window = found.1.clone();
        kept.push(found);
        Some(window)
    }

    fn keep(&self, key: Key, window: &Arc<Window>) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.iter().all(|(known, _)| *known != key) {
            kept.push((key, Arc::clone(window)));
            let surplus = kept.len().saturating_sub(KEPT);
            kept.drain(..surplus);
        }
    }
}
