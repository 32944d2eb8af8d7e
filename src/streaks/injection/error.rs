//! Errors of an injection.

use std::path::Path;

use thiserror::Error;

use super::super::error::StreaksError;
use super::super::frame::{InjectError, SyntheticError, TargetError};
use crate::images::FrameError;

/// Errors of an injection.
#[derive(Debug, Error)]
pub enum InjectionError {
    /// The frames and outputs contradict the request: what, and what is accepted.
    #[error("{0}")]
    Invalid(String),
    /// A frame that cannot be injected into.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// A synthetic frame.
    #[error(transparent)]
    Synthetic(#[from] SyntheticError),
    /// The frame with streaks.
    #[error(transparent)]
    Write(#[from] InjectError),
    /// A file of pixels.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Light, images and masks of streaks.
    #[error(transparent)]
    Streaks(#[from] StreaksError),
    /// One frame.
    #[error("{path}: {source}")]
    File {
        /// Its file.
        path: String,
        /// Error, in words that do not name the file.
        source: Box<InjectionError>,
    },
    /// One frame of several.
    #[error("{source}; {done} of {count} frames are written already, without a table of truth beside them")]
    Batch {
        /// Error of the frame.
        source: Box<InjectionError>,
        /// Frames that are complete.
        done: usize,
        /// All frames.
        count: usize,
    },
    /// A folder for intermediate files.
    #[error(transparent)]
    Scratch(#[from] std::io::Error),
}

impl InjectionError {
    pub(super) fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid(message.into())
    }

    /// Returns the error with the file that it is about, if its own words do not name it.
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

    /// Returns the error with the number of frames that were written before it, if any.
    pub(super) fn of_batch(self, done: usize, count: usize) -> Self {
        if done == 0 { self } else { Self::Batch { source: Box::new(self), done, count } }
    }
}
