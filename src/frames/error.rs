//! Errors of times, angles and Earth orientation.

use thiserror::Error;

/// Errors of times, angles and Earth orientation.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FramesError {
    /// A date that is not a number, or far outside of what the calendar of this library covers.
    #[error("{what} {value} is not a date between {first} and {last}")]
    DateOutOfRange {
        /// What was given: "MJD" or "JD".
        what: &'static str,
        /// The number given, days.
        value: f64,
        /// Smallest number allowed, days.
        first: f64,
        /// Largest number allowed, days.
        last: f64,
    },
    /// A time scale that dates are not read in.
    #[error("dates in {scale} are not read; use UTC, TAI, TT, TDB or GPS time")]
    UnsupportedTimeScale {
        /// Requested scale.
        scale: hifitime::TimeScale,
    },
    /// A line of a finals2000A file that cannot be read.
    #[error("finals2000A line {line}: {column} {text:?} is not a number")]
    BadEopNumber {
        /// Line in the file, from 1.
        line: usize,
        /// Column name of the IERS ReadMe.
        column: &'static str,
        /// Text found there.
        text: String,
    },
    /// Dates that do not grow from line to line.
    #[error("finals2000A line {line}: MJD {mjd} does not follow MJD {previous}")]
    EopNotInOrder {
        /// Line in the file, from 1.
        line: usize,
        /// Date of the line, days.
        mjd: f64,
        /// Date of the line before, days.
        previous: f64,
    },
    /// No row with polar motion and UT1-UTC.
    #[error("no rows with UT1-UTC: not a finals2000A file ({lines} lines read)")]
    EmptyEopTable {
        /// Lines that were read.
        lines: usize,
    },
    /// The text is not an angle of the requested kind.
    #[error("{text:?} is not {wanted}")]
    BadAngle {
        /// What was given.
        text: String,
        /// What is allowed.
        wanted: &'static str,
    },
    /// The text is not ISO 8601.
    #[error("'{0}' is not a time; allowed: ISO 8601 like 2024-08-14T00:30:00.000Z")]
    NotATime(String),
    /// A field is out of range.
    #[error("'{text}': {field} {value} is out of range")]
    TimeField {
        /// Given text.
        text: String,
        /// `month`, `day`, `hour`, `minute` or `second`.
        field: &'static str,
        /// The value of the field.
        value: u32,
    },
    /// A second 60 is given for a minute without a leap second.
    #[error("'{0}': there was no leap second at that moment")]
    NoLeapSecond(String),
    /// The time has no scale.
    #[error(
        "'{0}' names no time scale: end it with Z (UTC) or say --time-scale utc, tai or tt \
         (TAI read as UTC is 37 s off, and a satellite crosses a field within seconds)"
    )]
    NoScale(String),
}
