//! Why nothing was injected.

use std::path::Path;

use thiserror::Error;

use crate::config::SetupError;
use crate::frames::FramesError;
use crate::images::FrameError;
use crate::schedule::ScheduleError;
use crate::streaks::{
    DrawError, InjectError, MaskError, ModulationError, RandomStreakError, SatelliteError, SyntheticError, TargetError,
};

/// Why nothing was injected.
#[derive(Debug, Error)]
pub enum InjectionError {
    /// What was said is incomplete, contradicts itself, or is out of range: what, and what is allowed.
    #[error("{0}")]
    Said(String),
    /// Satellites, site, models, camera.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// An angle.
    #[error(transparent)]
    Angle(#[from] FramesError),
    /// The schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// A frame that cannot be injected into.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// A synthetic frame.
    #[error(transparent)]
    Synthetic(#[from] SyntheticError),
    /// How light changes along a streak.
    #[error(transparent)]
    Modulation(#[from] ModulationError),
    /// Random streaks.
    #[error(transparent)]
    Random(#[from] RandomStreakError),
    /// Bits of the mask.
    #[error(transparent)]
    Mask(#[from] MaskError),
    /// Light of satellites.
    #[error(transparent)]
    Satellites(#[from] SatelliteError),
    /// Streaks in pixels.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// The frame with streaks.
    #[error(transparent)]
    Write(#[from] InjectError),
    /// A file of pixels.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// One frame.
    #[error("{path}: {source}")]
    File {
        /// Its file.
        path: String,
        /// What is wrong with it, in words that do not name it.
        source: Box<InjectionError>,
    },
    /// One frame of several.
    #[error("{source}; {done} of {count} frames are written already, without a table of truth beside them")]
    Batch {
        /// What is wrong with it.
        source: Box<InjectionError>,
        /// Frames that stand whole.
        done: usize,
        /// All frames.
        count: usize,
    },
    /// A folder for what is in between.
    #[error(transparent)]
    Scratch(#[from] std::io::Error),
}

impl InjectionError {
    pub(super) fn said(message: impl Into<String>) -> Self {
        Self::Said(message.into())
    }

    /// The same with the file that it is about, where its own words do not say.
    pub(super) fn of_file(self, path: &Path) -> Self {
        match self {
            Self::Mask(_) | Self::Satellites(_) | Self::Draw(_) | Self::Write(InjectError::Detector { .. }) => {
                Self::File { path: path.display().to_string(), source: Box::new(self) }
            }
            other => other,
        }
    }

    /// The same with what was done before, where that is something.
    pub(super) fn of_batch(self, done: usize, count: usize) -> Self {
        if done == 0 { self } else { Self::Batch { source: Box::new(self), done, count } }
    }
}
