//! Errors of element sets.

use std::io;

use thiserror::Error;

use super::element_set::NoradId;
use super::record::{ElementFormat, Rejected};

/// Accepted formats, for messages.
const ALLOWED: &str =
    "TLE, 2LE, 3LE, OMM (JSON, CSV, XML, KVN), or ephemerides as OEM (KVN, XML) or Modified ITC, plain or gzipped";

fn rejected_words(rejected: usize, first: &Option<Box<Rejected>>) -> String {
    match first {
        Some(first) => format!(": {rejected} rejected, the first at line {}: {}", first.line, first.reason),
        None => ": it has no records".into(),
    }
}

/// Errors of files of element sets, of synthetic constellations, and of writing TLEs.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ElementsError {
    /// An empty list of files.
    #[error("no file of element sets is given")]
    NoFiles,
    /// An error of the operating system.
    #[error("cannot read {file}: {source}")]
    Unreadable {
        /// Given name.
        file: String,
        /// Error of the system.
        source: io::Error,
    },
    /// A directory instead of a file.
    #[error("{file} is a directory; specify the files of element sets in it")]
    Directory {
        /// Given name.
        file: String,
    },
    /// An empty file, or one with blanks only.
    #[error("{file} is empty; allowed: {ALLOWED}")]
    Empty {
        /// Given name.
        file: String,
    },
    /// A truncated or damaged gzip file.
    #[error("{file} is an invalid gzip file ({source}): it may be truncated; download it again")]
    BrokenGzip {
        /// Given name.
        file: String,
        /// Error of the decoder.
        source: io::Error,
    },
    /// An unknown format.
    #[error("{file} contains no element sets ({what}); allowed: {ALLOWED}")]
    UnknownFormat {
        /// Given name.
        file: String,
        /// Apparent content.
        what: String,
    },
    /// A known format without a valid record. Continuing would report every exposure as clear.
    #[error("{file} ({format}) contains no valid element set{}", rejected_words(*.rejected, .first))]
    NothingUsable {
        /// Given name.
        file: String,
        /// Format.
        format: ElementFormat,
        /// Number of rejected records.
        rejected: usize,
        /// First rejected record.
        first: Option<Box<Rejected>>,
    },
    /// An invalid ephemeris, which is rejected as a whole.
    #[error("{file}:{line}: {what} is {given}; allowed: {allowed}")]
    Ephemeris {
        /// Given name.
        file: String,
        /// Line in the file, from 1.
        line: usize,
        /// Invalid quantity.
        what: String,
        /// Its value.
        given: String,
        /// Accepted values.
        allowed: String,
    },
    /// An unknown name of a constellation.
    #[error("unknown shells {name:?}: expected one of {known}")]
    UnknownShells {
        /// Requested value.
        name: String,
        /// Known names.
        known: String,
    },
    /// Invalid TOML.
    #[error("constellation file: {0}")]
    ShellSyntax(String),
    /// A number out of range.
    #[error("constellation {name:?}, shell {shell}: {field} {value} is out of range: allowed {allowed}")]
    ShellOutOfRange {
        /// Name of the constellation.
        name: String,
        /// Number of the shell, from 1.
        shell: usize,
        /// Name of the key.
        field: &'static str,
        /// Given number.
        value: f64,
        /// Allowed range with unit.
        allowed: &'static str,
    },
    /// A stated total that differs from the sum of the shells.
    #[error("constellation {name:?} states {stated} satellites, but its shells have {sum} (allowed: 1 to 999999)")]
    ShellTotal {
        /// Name of the constellation.
        name: String,
        /// Stated number, or the sum if none is stated.
        stated: u64,
        /// Sum of planes times satellites per plane.
        sum: u64,
    },
    /// A catalogue number above the range of Alpha-5.
    #[error("catalogue number {0} does not fit a TLE; allowed: up to 339999 (Alpha-5)")]
    TleId(NoradId),
    /// A number that does not fit its columns.
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
