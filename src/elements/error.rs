//! Errors of element sets.

use std::io;

use thiserror::Error;

use super::element_set::NoradId;
use super::record::{ElementFormat, Rejected};
use crate::message::Quoted;

/// Accepted formats, for error messages.
const ALLOWED: &str =
    "TLE, 2LE, 3LE, OMM (JSON, CSV, XML, KVN), or ephemerides as OEM (KVN, XML) or Modified ITC, plain or gzipped";

fn rejected_words(rejected: usize, first: &Option<Box<Rejected>>) -> String {
    match first {
        Some(first) => format!(": {rejected} rejected, the first at line {}: {}", first.line, first.reason),
        None => ": it has no records".into(),
    }
}

/// Error in files of element sets, in simulated constellations, or in writing TLEs.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ElementsError {
    /// No file is given.
    #[error("no file of element sets is given")]
    NoFiles,
    /// The operating system reports an error.
    #[error("cannot read {file}: {source}")]
    Unreadable {
        /// Name of the file as given.
        file: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The folder contains no files.
    #[error(
        "the folder {folder} contains no files; allowed: files of element sets, or folders that contain only these"
    )]
    EmptyFolder {
        /// Name of the folder as given.
        folder: String,
    },
    /// The file is empty or contains only blanks.
    #[error("{file} is empty; allowed: {ALLOWED}")]
    Empty {
        /// Name of the file as given.
        file: String,
    },
    /// The gzip file is truncated or damaged.
    #[error("{file} is an invalid gzip file ({source}): it may be truncated; download it again")]
    BrokenGzip {
        /// Name of the file as given.
        file: String,
        /// Error of the decoder.
        source: io::Error,
    },
    /// The format is unknown.
    #[error("{file} contains no element sets ({what}); allowed: {ALLOWED}")]
    UnknownFormat {
        /// Name of the file as given.
        file: String,
        /// What the file appears to contain.
        what: String,
    },
    /// The format is known, but no record is valid. Without this error, every exposure would be reported as clear.
    #[error("{file} ({format}) contains no valid element set{}", rejected_words(*.rejected, .first))]
    #[doc(hidden)]
    NothingUsable {
        /// Name of the file as given.
        file: String,
        /// Format of the file.
        format: ElementFormat,
        /// Number of rejected records.
        rejected: usize,
        /// First rejected record.
        first: Option<Box<Rejected>>,
    },
    /// An ephemeris is invalid. It is rejected as a whole.
    #[error("{file}:{line}: {what} is {given}; allowed: {allowed}")]
    Ephemeris {
        /// Name of the file as given.
        file: String,
        /// Line number, from 1.
        line: usize,
        /// Name of the invalid quantity.
        what: String,
        /// Its value.
        given: String,
        /// Accepted values.
        allowed: String,
    },
    /// The name of a constellation is unknown.
    #[error("unknown shells {name:?}: expected one of {known}", name = Quoted::new(.name))]
    UnknownShells {
        /// Unknown name.
        name: String,
        /// All known names.
        known: String,
    },
    /// The TOML text is invalid.
    #[error("constellation file: {0}")]
    ShellSyntax(String),
    /// A number is out of range.
    #[error("constellation {name:?}, shell {shell}: {field} {value} is out of range: allowed {allowed}", name = Quoted::new(.name))]
    ShellOutOfRange {
        /// Name of the constellation.
        name: String,
        /// Number of the shell, from 1.
        shell: usize,
        /// Name of the key.
        field: &'static str,
        /// Invalid number.
        value: f64,
        /// Accepted range with unit.
        allowed: &'static str,
    },
    /// The stated total differs from the sum of the shells.
    #[error("constellation {name:?} states {stated} satellites, but its shells have {sum}", name = Quoted::new(.name))]
    ShellTotal {
        /// Name of the constellation.
        name: String,
        /// Stated number.
        stated: u64,
        /// Sum of planes times satellites per plane.
        sum: u64,
    },
    /// A constellation has no satellites or too many.
    #[error("constellation {name:?} has {sum} satellites; allowed: 1 to {most}", name = Quoted::new(.name))]
    ShellSize {
        /// Name of the constellation.
        name: String,
        /// Sum of planes times satellites per plane.
        sum: u64,
        /// Largest number accepted.
        most: u64,
    },
    /// All constellations together have too many satellites.
    #[error("the constellations of the files have more than {most} satellites in all; allowed: at most {most}")]
    TooManyInShells {
        /// Largest number accepted.
        most: u64,
    },
    /// A night is before the first period of growing constellations.
    #[error(
        "{file}: the simulated constellations begin with the night of {first}, after that of the request; allowed: a [[period]] from an earlier date"
    )]
    BeforeFirstPeriod {
        /// Name of the file.
        file: String,
        /// Date of the first period.
        first: String,
    },
    /// The catalogue number is above the range of Alpha-5.
    #[error("catalogue number {0} does not fit a TLE; allowed: up to 339999 (Alpha-5)")]
    TleId(NoradId),
    /// A number does not fit its columns.
    #[error("{field} {value} of object {norad_id} does not fit its columns in a TLE")]
    TleColumns {
        /// NORAD catalogue number.
        norad_id: NoradId,
        /// Name of the field.
        field: &'static str,
        /// The number.
        value: f64,
    },
}
