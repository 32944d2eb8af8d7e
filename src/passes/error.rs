//! Errors of requests to a sky.

use hifitime::Epoch;

use crate::error::{Error, ErrorKind};

/// First and last year for which the positions of Sun and Earth are computed.
const YEARS: (i32, i32) = (1957, 2099);

/// The time is outside the years of the ephemeris of Sun and Earth.
pub(crate) fn no_ephemeris(epoch: Epoch) -> Error {
    Error::new(ErrorKind::Invalid, format!("{epoch} is outside the years of the ephemeris of Sun and Earth"))
        .allowing(format!("{} to {}", YEARS.0, YEARS.1))
}

/// The elements of a telescope in orbit give no position.
pub(crate) fn no_observer(observer: &str, reason: &Error) -> Error {
    Error::new(ErrorKind::NoPosition, format!("cannot compute the position of observer {observer}: {reason}"))
}

/// Rejects times outside the years of the ephemeris of Sun and Earth.
pub(super) fn check_epoch(epoch: Epoch) -> Result<(), Error> {
    let (year, ..) = epoch.to_gregorian_utc();
    if year < YEARS.0 || year > YEARS.1 { Err(no_ephemeris(epoch)) } else { Ok(()) }
}
