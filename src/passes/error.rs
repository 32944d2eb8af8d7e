//! Errors of requests to a sky.

use hifitime::Epoch;
use thiserror::Error;

use super::field::FieldError;

use crate::frames::FramesError;
use crate::orbit::OrbitError;

/// First and last year of the ephemeris of Sun and Earth.
const YEARS: (i32, i32) = (1957, 2099);

/// Error that makes a whole request fail.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SkyError {
    /// The time is outside the ephemeris of Sun and Earth.
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
    /// A number in a request is invalid.
    #[error("exposure {id}: {problem}")]
    Exposure {
        /// Name of the exposure or of the request.
        id: String,
        /// Cause, with the allowed values.
        problem: String,
    },
    /// The text of the start of an exposure is invalid.
    #[error("start: {0}")]
    Start(FramesError),
    /// The text of a right ascension or declination is invalid.
    #[error(transparent)]
    Direction(FramesError),
    /// The field of view is invalid.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The library does not have the brightness model.
    #[error("unknown brightness model {name:?}; allowed: {}", known.join(", "))]
    UnknownModel {
        /// Requested name.
        name: String,
        /// Names in the library.
        known: Vec<String>,
    },
}

/// Rejects times outside the years of the Sun's ephemeris.
pub(super) fn check_epoch(epoch: Epoch) -> Result<(), SkyError> {
    let (year, ..) = epoch.to_gregorian_utc();
    if year < YEARS.0 || year > YEARS.1 { Err(SkyError::NoEphemeris { epoch }) } else { Ok(()) }
}
