//! Errors of requests to a sky.

use std::fmt::Display;

use hifitime::Epoch;
use thiserror::Error;

use crate::frames::FramesError;
use crate::orbit::OrbitError;
use crate::watch::Interrupted;

/// First and last year for which the positions of Sun and Earth are computed.
const YEARS: (i32, i32) = (1957, 2099);

/// Error that stops a whole request. Satellites without a position do not stop a request; results list them as left
/// out.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SkyError {
    /// The time is outside the years of the ephemeris of Sun and Earth.
    #[error("{epoch} is outside the years of the ephemeris of Sun and Earth; allowed: {} to {}", YEARS.0, YEARS.1)]
    NoEphemeris {
        /// The requested time.
        epoch: Epoch,
    },
    /// The elements of a telescope in orbit give no position.
    #[error("cannot compute the position of observer {observer}: {reason}")]
    Observer {
        /// Name of the observer.
        observer: String,
        /// Cause.
        reason: OrbitError,
    },
    /// The request needs a horizon, but the observer is in orbit.
    #[error("observer {observer} is in orbit and has no horizon; allowed: a site")]
    NoHorizon {
        /// Name of the observer.
        observer: String,
    },
    /// A value of an exposure, a field or a request is missing or invalid.
    #[error("{what} is {given}; allowed: {allowed}")]
    Invalid {
        /// Name of the value, preceded by the exposure or the shape to which it belongs.
        what: String,
        /// Given value, or `missing`.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// The text of the start of an exposure is invalid.
    #[error("start: {0}")]
    Start(FramesError),
    /// The text of a right ascension or declination is invalid.
    #[error(transparent)]
    Direction(FramesError),
    /// The computation was stopped.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl SkyError {
    pub(super) fn invalid(what: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        Self::Invalid { what: what.into(), given: given.to_string(), allowed: allowed.into() }
    }
}

/// Rejects times outside the years of the ephemeris of Sun and Earth.
pub(super) fn check_epoch(epoch: Epoch) -> Result<(), SkyError> {
    let (year, ..) = epoch.to_gregorian_utc();
    if year < YEARS.0 || year > YEARS.1 { Err(SkyError::NoEphemeris { epoch }) } else { Ok(()) }
}
