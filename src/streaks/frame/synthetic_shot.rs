//! Exposure of a synthetic frame.

use hifitime::Epoch;

use super::super::optics::Optics;
use super::super::tracking::Tracking;
use crate::frames::{Direction, Gcrs};
use crate::watch::Watch;

/// Time, pointing and optics of the exposure of a synthetic frame.
#[derive(Copy, Clone, Debug)]
pub struct SyntheticShot<'a> {
    /// Time at which the shutter opened.
    pub opened: Epoch,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Direction of the centre of the frame.
    pub centre: Direction<Gcrs>,
    /// Tracking of the telescope; stars trail unless the tracking is sidereal.
    pub tracking: Tracking,
    /// Seeing and telescope.
    pub optics: &'a Optics,
    /// Name of the filter, written to the header.
    pub filter: &'a str,
    /// Seed of the random stars and of the noise.
    pub seed: u64,
    /// Handle that stops the computation of the frame.
    pub watch: &'a Watch,
}
