//! What can go wrong with times, angles and tables of the Earth's orientation.

/// Errors of this module.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
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
}
