//! Exposure of a synthetic frame, and its errors.

use hifitime::Epoch;
use thiserror::Error;

use super::super::count_scale::CountScaleError;
use super::super::optics::{Optics, OpticsError};
use super::super::render::PathError;
use super::super::tracking::Tracking;
use crate::frames::{Direction, Gcrs};
use crate::images::{DetectorError, FrameError, WcsError};
use crate::streaks::{BackgroundError, BlurError};

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

/// Errors of a synthetic frame.
#[derive(Debug, Error)]
pub enum SyntheticError {
    /// Invalid TOML, or a key that is missing, unknown or of the wrong type.
    #[error("synthetic frame {origin}: {message}")]
    Toml {
        /// Name of the file.
        origin: String,
        /// Problem and line.
        message: String,
    },
    /// A number is out of range.
    #[error("synthetic frame: {key} is {given}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the key.
        key: &'static str,
        /// Value given.
        given: f64,
        /// Allowed range.
        allowed: &'static str,
    },
    /// A list of stars is invalid.
    #[error("star list {path}: {problem}; allowed: CSV with ra_deg, dec_deg, magnitude")]
    StarList {
        /// Name of the file.
        path: String,
        /// Problem and line.
        problem: String,
    },
    /// Error of the world coordinates.
    #[error("synthetic frame: {0}")]
    Wcs(#[from] WcsError),
    /// Error of the optics.
    #[error("synthetic frame: {0}")]
    Optics(#[from] OpticsError),
    /// Error of the point spread function.
    #[error("synthetic frame: {0}")]
    Blur(#[from] BlurError),
    /// Error of the path of a trailed star.
    #[error("synthetic frame: {0}")]
    Path(#[from] PathError),
    /// Error of the count scale.
    #[error("synthetic frame: {0}")]
    Scale(#[from] CountScaleError),
    /// Error of the sky or the stars.
    #[error(transparent)]
    Background(#[from] BackgroundError),
    /// Error of the detector.
    #[error("synthetic frame: {0}")]
    Detector(#[from] DetectorError),
    /// Error of reading or writing the file.
    #[error(transparent)]
    Frame(#[from] FrameError),
}
