//! Why a question makes no sense.

use thiserror::Error;

use crate::config::SetupError;
use crate::forecast::ForecastError;
use crate::frames::FramesError;
use crate::identify::IdentifyError;
#[cfg(feature = "fits")]
use crate::images::FrameError;

/// Why a question makes no sense.
#[derive(Debug, Error)]
pub enum QuestionError {
    /// What was said is incomplete, contradicts itself, or is out of range: what, and what is allowed.
    #[error("{0}")]
    Said(String),
    /// Site, times, units.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// An angle.
    #[error(transparent)]
    Angle(#[from] FramesError),
    /// A number of a forecast.
    #[error(transparent)]
    Forecast(#[from] ForecastError),
    /// What is no streak.
    #[error(transparent)]
    Streak(#[from] IdentifyError),
    /// A frame that cannot be read.
    #[cfg(feature = "fits")]
    #[error(transparent)]
    Frame(#[from] FrameError),
}

impl QuestionError {
    pub(super) fn said(message: impl Into<String>) -> Self {
        Self::Said(message.into())
    }
}
