//! Sun, Earth and search windows over one time interval.

use std::sync::Arc;

use hifitime::Epoch;

use crate::frames::{OrientationTable, seconds_between};
use crate::geometry::SunTable;
use crate::orbit::Window;

/// Sun, Earth and orbits over the time of one group of exposures. Times within it are seconds after its start.
pub(in crate::passes) struct Scene {
    pub start: Epoch,
    pub orientation: OrientationTable,
    pub sun: SunTable,
    /// In order of time, without gaps; empty where no satellites are searched.
    pub windows: Vec<Arc<Window>>,
}

impl Scene {
    /// The window that holds a time, and its start, both in seconds of the scene.
    pub fn window_at(&self, time_s: f64) -> Option<(&Window, f64)> {
        let start_s = |window: &Window| seconds_between(self.start, window.start());
        let window = self.windows.iter().rfind(|window| start_s(window) <= time_s).or(self.windows.first())?;
        Some((window, start_s(window)))
    }
}
