//! Errors of times.

use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

/// The text is not ISO 8601.
pub(super) fn not_a_time(given: &str) -> Error {
    Error::malformed("time", given, "ISO 8601, for example 2024-08-14T00:30:00.000Z")
}

/// The text is a date without a time of day.
pub(super) fn without_time_of_day(given: &str) -> Error {
    Error::malformed("time", given, "a date with the time of day, for example 2024-08-14T00:30:00.000Z")
}

/// A second 60 is given for a minute without a leap second.
pub(super) fn no_leap_second(given: &str) -> Error {
    Error::malformed("time", given, "second 60 only where a leap second was inserted")
}

/// No clock has this offset from UTC.
pub(super) fn no_offset(given: &str, offset: &str) -> Error {
    let [given, offset] = [given, offset].map(Quoted::new);
    Error::new(ErrorKind::Invalid, format!("invalid time '{given}': offset {offset} from UTC is out of range"))
        .allowing("-12:00 to +14:00")
}

/// The time has no scale.
pub(super) fn no_scale(given: &str) -> Error {
    let given = Quoted::new(given);
    Error::new(ErrorKind::NoTimeScale, format!("time '{given}' has no time scale")).with_given(given).allowing(
        "a time that ends in Z (UTC) or in an offset of local time (+02:00), or any time with --time-scale utc, tai or tt \
         (TAI read as UTC is 37 s off, and a satellite crosses a field within seconds)",
    )
}

/// A time scale in which dates are not accepted.
pub(super) fn unsupported_time_scale(scale: hifitime::TimeScale) -> Error {
    Error::new(ErrorKind::Invalid, format!("unsupported time scale {scale}")).allowing("UTC, TAI, TT, TDB and GPS time")
}
