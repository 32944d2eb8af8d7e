//! Errors of times, angles and Earth orientation tables.

/// Errors of this module.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FramesError {
    /// A date that is not a number, or outside the calendar range of this library.
    #[error("invalid {what} {value}: expected a date between {first} and {last}")]
    DateOutOfRange {
        /// Kind of the date: "MJD" or "JD".
        what: &'static str,
        /// The number given, days.
        value: f64,
        /// Smallest number allowed, days.
        first: f64,
        /// Largest number allowed, days.
        last: f64,
    },
    /// A time scale in which dates are not accepted.
    #[error("unsupported time scale {scale}: expected UTC, TAI, TT, TDB or GPS time")]
    UnsupportedTimeScale {
        /// Requested scale.
        scale: hifitime::TimeScale,
    },
    /// An invalid number in a finals2000A file.
    #[error("finals2000A line {line}: {column} {text:?} is not a number")]
    BadEopNumber {
        /// Line in the file, from 1.
        line: usize,
        /// Column name of the IERS ReadMe.
        column: &'static str,
        /// Text found there.
        text: String,
    },
    /// Dates that do not increase from line to line.
    #[error("finals2000A line {line}: MJD {mjd} is not after MJD {previous} of the row before")]
    EopNotInOrder {
        /// Line in the file, from 1.
        line: usize,
        /// Date of this line, days.
        mjd: f64,
        /// Date of the row before, days.
        previous: f64,
    },
    /// No row with polar motion and UT1 - UTC.
    #[error("no rows with UT1-UTC: not a finals2000A file ({lines} lines read)")]
    EmptyEopTable {
        /// Lines that were read.
        lines: usize,
    },
    /// Text that is not an angle of the requested kind.
    #[error("{text:?} is not {wanted}")]
    BadAngle {
        /// Given text.
        text: String,
        /// Accepted forms.
        wanted: &'static str,
    },
}
