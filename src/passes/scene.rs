//! What the exposures of one stretch of time share: Sun, Earth, orbit planes.

use std::sync::Arc;

use hifitime::Epoch;

use super::exposure::Exposure;
use crate::frames::{OrientationTable, seconds_between};
use crate::geometry::SunTable;
use crate::orbit::{MAX_WINDOW_S, Window};

/// Sun, Earth and orbits over the time of one group of exposures.
pub(super) struct Scene {
    pub start: Epoch,
    pub orientation: OrientationTable,
    pub sun: SunTable,
    /// In order of time, without gaps.
    pub windows: Vec<Arc<Window>>,
}

impl Scene {
    /// The window that holds a moment, and when it starts, both in seconds of the scene.
    pub fn window_at(&self, time_s: f64) -> Option<(&Window, f64)> {
        let start_s = |window: &Window| seconds_between(self.start, window.start());
        let window = self.windows.iter().rfind(|window| start_s(window) <= time_s).or(self.windows.first())?;
        Some((window, start_s(window)))
    }
}

/// When an exposure ends, seconds after `start`.
pub(super) fn end_s(start: Epoch, exposure: &Exposure) -> f64 {
    seconds_between(start, exposure.start) + exposure.duration_s
}

/// Exposures in order of time, in groups that one window covers; one that is longer than a window is a group of its own.
pub(super) fn groups(exposures: &[Exposure]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..exposures.len()).collect();
    order.sort_by_key(|&one| exposures[one].start);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for one in order {
        match groups.last_mut() {
            Some(group) if end_s(exposures[group[0]].start, &exposures[one]) <= MAX_WINDOW_S => group.push(one),
            _ => groups.push(vec![one]),
        }
    }
    groups
}
