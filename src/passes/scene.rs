//! What the exposures of one stretch of time share: Sun, Earth, orbit planes.

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
    pub windows: Vec<Window>,
}

impl Scene {
    /// The window that holds a moment, and when it starts, both in seconds of the scene.
    pub fn window_at(&self, time_s: f64) -> Option<(&Window, f64)> {
        let length_s = self.windows.first()?.span_s();
        let number = ((time_s / length_s).max(0.0) as usize).min(self.windows.len() - 1);
        let window = &self.windows[number];
        Some((window, seconds_between(self.start, window.start())))
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
