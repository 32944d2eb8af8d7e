//! Errors of an injection.

use std::path::Path;

use thiserror::Error;

use super::super::error::StreaksError;
use super::super::frame::{InjectError, SyntheticError, TargetError};
use crate::images::FrameError;

/// Errors of an injection.
#[derive(Debug, Error)]
pub enum InjectionError {
    /// The frames or outputs contradict the plan; the message contains the accepted values.
    #[error("{0}")]
    Invalid(String),
    /// Error of a frame into which streaks are to be injected.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// Error of a synthetic frame.
    #[error(transparent)]
    Synthetic(#[from] SyntheticError),
    /// Error of writing the frame with streaks.
    #[error(transparent)]
    Write(#[from] InjectError),
    /// Error of a FITS file.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Error of the light, images or masks of streaks.
    #[error(transparent)]
    Streaks(#[from] StreaksError),
    /// Error of one frame.
    #[error("{path}: {source}")]
    File {
        /// File of the frame.
        path: String,
        /// Error without the name of the file.
        source: Box<InjectionError>,
    },
    /// Error of one frame of several.
    #[error("{source}; {done} of {count} frames have already been written, without a truth table")]
    Batch {
        /// Error of the frame.
        source: Box<InjectionError>,
        /// Frames that are complete.
        done: usize,
        /// Number of all frames.
        count: usize,
    },
    /// Error of the folder for intermediate files.
    #[error(transparent)]
    Scratch(#[from] std::io::Error),
}

impl InjectionError {
    pub(super) fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid(message.into())
    }

    /// Adds the name of the file to an error without it.
    pub(super) fn of_file(self, path: &Path) -> Self {
        let is_of_frame = match &self {
            Self::Streaks(error) => !matches!(
                error,
                StreaksError::Modulation { .. } | StreaksError::LightCurve { .. } | StreaksError::RandomStreaks { .. }
            ),
            error => matches!(error, Self::Write(InjectError::Detector { .. })),
        };
        if is_of_frame { Self::File { path: path.display().to_string(), source: Box::new(self) } } else { self }
    }

    /// Adds the number of frames written before the error, if any.
    pub(super) fn of_batch(self, done: usize, count: usize) -> Self {
        if done == 0 { self } else { Self::Batch { source: Box::new(self), done, count } }
    }
}
