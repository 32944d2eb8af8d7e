//! Errors of element sets.

use std::io;

use thiserror::Error;

use super::element_set::NoradId;
use super::record::{ElementFormat, Rejected};

/// What a file may be, for messages.
const ALLOWED: &str = "TLE, 2LE, 3LE or OMM (JSON, CSV, XML, KVN), plain or gzipped";

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
    /// No file was named.
    #[error("no file of element sets was named")]
    NoFiles,
    /// The operating system refused.
    #[error("cannot read {file}: {source}")]
    Unreadable {
        /// Name as it was given.
        file: String,
        /// Its words.
        source: io::Error,
    },
    /// A directory was named.
    #[error("{file} is a directory; name the files of element sets in it")]
    Directory {
        /// Name as it was given.
        file: String,
    },
    /// Nothing in it, or blanks only.
    #[error("{file} is empty; it should hold element sets as {ALLOWED}")]
    Empty {
        /// Name as it was given.
        file: String,
    },
    /// A gzip file cut short or damaged.
    #[error("{file} is a broken gzip file ({source}): it may have been cut short; fetch it again")]
    BrokenGzip {
        /// Name as it was given.
        file: String,
        /// Error of the decoder.
        source: io::Error,
    },
    /// None of the formats.
    #[error("{file} holds no element sets ({what}); allowed are {ALLOWED}")]
    UnknownFormat {
        /// Name as it was given.
        file: String,
        /// What it looks like.
        what: String,
    },
    /// A known format in which no record is good. Going on would call every exposure clear.
    #[error("{file} ({format}) holds no usable element set{}", rejected_words(*.rejected, .first))]
    NothingUsable {
        /// Name as it was given.
        file: String,
        /// Its format.
        format: ElementFormat,
        /// How many records were rejected.
        rejected: usize,
        /// The first of them.
        first: Option<Box<Rejected>>,
    },
    /// No constellation of this name comes with the library.
    #[error("unknown shells {name:?}; known are {known}")]
    UnknownShells {
        /// Requested value.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The TOML is invalid.
    #[error("constellation file: {0}")]
    ShellSyntax(String),
    /// A number outside what can be.
    #[error("constellation {name:?}, shell {shell}: {field} {value} is out of range: {allowed}")]
    ShellOutOfRange {
        /// Name of the constellation.
        name: String,
        /// Which shell, from 1.
        shell: usize,
        /// The key.
        field: &'static str,
        /// The number.
        value: f64,
        /// What is allowed, with its unit.
        allowed: &'static str,
    },
    /// The stated total is not what the shells add up to.
    #[error("constellation {name:?} states {stated} satellites, its shells add up to {sum} (1 to 999999 are allowed)")]
    ShellTotal {
        /// Name of the constellation.
        name: String,
        /// The number stated, or the sum where none is.
        stated: u64,
        /// What planes times satellites add up to.
        sum: u64,
    },
    /// Alpha-5 ends at 339,999.
    #[error("catalogue number {0} does not fit a TLE: Alpha-5 ends at 339999")]
    TleId(NoradId),
    /// A number does not fit its columns.
    #[error("{field} {value} of object {norad_id} does not fit its columns of a TLE")]
    TleColumns {
        /// NORAD catalogue number.
        norad_id: NoradId,
        /// Name of the field.
        field: &'static str,
        /// The number.
        value: f64,
    },
}
