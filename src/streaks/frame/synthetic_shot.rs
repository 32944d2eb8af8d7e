//! Exposure of a synthetic frame, and its errors.

use hifitime::Epoch;

use super::super::optics::Optics;
use super::super::tracking::Tracking;
use crate::frames::{Direction, Gcrs};

/// Time, pointing and optics of a synthetic frame.
#[derive(Copy, Clone, Debug)]
pub struct SyntheticShot<'a> {
    /// Time at which the shutter opened.
    pub opened: Epoch,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Centre of the frame.
    pub centre: Direction<Gcrs>,
    /// Tracking of the telescope; stars trail unless it is sidereal.
    pub tracking: Tracking,
    /// Seeing and telescope.
    pub optics: &'a Optics,
    /// Filter, for the header.
    pub filter: &'a str,
    /// Seed of the stars and of the noise.
    pub seed: u64,
}
