//! Errors of times, angles and Earth orientation.

use crate::message::Quoted;
use thiserror::Error;

/// Errors of times, angles and Earth orientation.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FramesError {
    /// A name outside the table of deep-sky objects.
    #[error("unknown target '{name}'; {}", known_targets(similar), name = Quoted::new(.name))]
    UnknownObject {
        /// Given name.
        name: String,
        /// Names in the table that begin with it; empty if there are none.
        similar: Vec<String>,
    },
    /// A date that is not a number, or outside the calendar range of this library.
    #[error("{what} is {value}; allowed: {first} to {last}")]
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
    #[error("unsupported time scale {scale}; allowed: UTC, TAI, TT, TDB and GPS time")]
    UnsupportedTimeScale {
        /// Requested scale.
        scale: hifitime::TimeScale,
    },
    /// An invalid number in a finals2000A file.
    #[error("finals2000A line {line}: {column} is {text:?}; allowed: a number", text = Quoted::new(.text))]
    BadEopNumber {
        /// Line in the file, from 1.
        line: usize,
        /// Column name of the IERS ReadMe.
        column: &'static str,
        /// Text found there.
        text: String,
    },
    /// Dates that do not increase from line to line.
    #[error("finals2000A line {line}: MJD is {mjd}; allowed: later than {previous}, the MJD of the previous row")]
    EopNotInOrder {
        /// Line in the file, from 1.
        line: usize,
        /// Date of this line, days.
        mjd: f64,
        /// Date of the row before, days.
        previous: f64,
    },
    /// No line of a finals2000A file has both polar motion and UT1 - UTC.
    #[error("none of {lines} lines contains UT1-UTC; allowed: a finals2000A file of the IERS")]
    EmptyEopTable {
        /// Number of lines read.
        lines: usize,
    },
    /// Text that is not an angle of the requested kind.
    #[error("{text:?} is not {wanted}", text = Quoted::new(.text))]
    BadAngle {
        /// Given text.
        text: String,
        /// Accepted forms.
        wanted: &'static str,
    },
    /// The text is not ISO 8601.
    #[error("invalid time '{given}'; allowed: ISO 8601, for example 2024-08-14T00:30:00.000Z", given = Quoted::new(.0))]
    NotATime(String),
    /// A field is out of range.
    #[error("invalid time '{text}': {field} {value} is out of range; allowed: {allowed}", text = Quoted::new(.text))]
    TimeField {
        /// Given text.
        text: String,
        /// `month`, `day`, `hour`, `minute` or `second`.
        field: &'static str,
        /// The value of the field.
        value: u32,
        /// Valid values.
        allowed: &'static str,
    },
    /// A second 60 is given for a minute without a leap second.
    #[error("invalid time '{given}'; allowed: second 60 only where a leap second was inserted", given = Quoted::new(.0))]
    NoLeapSecond(String),
    /// The time has no scale.
    #[error(
        "time '{given}' has no time scale; allowed: a time that ends in Z (UTC) or in an offset of local \
         time (+02:00), or any time with --time-scale utc, tai or tt \
         (TAI read as UTC is 37 s off, and a satellite crosses a field within seconds)", given = Quoted::new(.0)
    )]
    NoScale(String),
}

/// Returns the names similar to an unknown one, or all accepted forms.
fn known_targets(similar: &[String]) -> String {
    let similar = match similar {
        [] => String::new(),
        names => format!("similar names: {}; ", names.join(", ")),
    };
    similar + "allowed: Messier, Caldwell, and their NGC and IC numbers and names (M31, NGC 224), or --ra and --dec"
}
