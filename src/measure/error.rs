//! Errors of the module `measure`.

#[cfg(all(feature = "fits", unix))]
use std::fmt::Display;

use thiserror::Error;

use crate::images::ImagesError;
use crate::orbit::OrbitError;
use crate::passes::SkyError;
use crate::streaks::StreaksError;
use crate::watch::Interrupted;

/// Errors of measuring streaks.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// A value in a frame, a table of stars or an argument is missing or invalid.
    #[error("{what} is {given}; allowed: {allowed}")]
    Invalid {
        /// Name of the value, preceded by the file and the HDU if the value is in a file.
        what: String,
        /// Given value, or `missing`.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// Errors of drawing the model of a streak, or of the frame that contains it.
    #[error(transparent)]
    Streaks(#[from] StreaksError),
    /// Errors of a frame or its world coordinates.
    #[error(transparent)]
    Images(#[from] ImagesError),
    /// Errors of the computation of satellite passes.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// The computation was stopped.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// Errors of the propagation of a satellite.
    #[error(transparent)]
    Orbit(#[from] OrbitError),
}

#[cfg(all(feature = "fits", unix))]
impl MeasureError {
    pub(super) fn invalid(what: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        Self::Invalid { what: what.into(), given: given.to_string(), allowed: allowed.into() }
    }
}
