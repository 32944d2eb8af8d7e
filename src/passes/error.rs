//! Errors of a sky.

use hifitime::Epoch;
use thiserror::Error;

use super::field::FieldError;

use crate::frames::FramesError;
use crate::orbit::OrbitError;

/// First and last year of the ephemeris of Sun and Earth.
const YEARS: (i32, i32) = (1957, 2099);

/// Error of a whole request to a sky.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SkyError {
    /// No ephemeris of Sun and Earth, and no elements either.
    #[error("{epoch} is outside the years for which Sun and Earth are known (allowed: {} to {})", YEARS.0, YEARS.1)]
    NoEphemeris {
        /// The requested time.
        epoch: Epoch,
    },
    /// The elements of a telescope in orbit give no position.
    #[error("cannot compute the position of observer {observer}: {reason}")]
    Observer {
        /// Its name.
        observer: String,
        /// Why.
        reason: OrbitError,
    },
    /// A request that needs a horizon, for an observer in orbit.
    #[error("observer {observer} is in orbit and has no horizon (allowed: a site)")]
    NoHorizon {
        /// Its name.
        observer: String,
    },
    /// An invalid number in a request.
    #[error("exposure {id}: {problem}")]
    Exposure {
        /// The exposure's name, or that of the request.
        id: String,
        /// What is wrong, and what is allowed.
        problem: String,
    },
    /// Invalid start of an exposure from text.
    #[error("start: {0}")]
    Start(FramesError),
    /// Invalid right ascension or declination of an exposure from text.
    #[error(transparent)]
    Direction(FramesError),
    /// Invalid field of view.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A brightness model that the library does not have.
    #[error("unknown brightness model {name:?} (allowed: {})", known.join(", "))]
    UnknownModel {
        /// The requested name.
        name: String,
        /// The names in the library.
        known: Vec<String>,
    },
}

/// Rejects times outside the years of the Sun's ephemeris.
pub(super) fn check_epoch(epoch: Epoch) -> Result<(), SkyError> {
    let (year, ..) = epoch.to_gregorian_utc();
    if year < YEARS.0 || year > YEARS.1 { Err(SkyError::NoEphemeris { epoch }) } else { Ok(()) }
}
