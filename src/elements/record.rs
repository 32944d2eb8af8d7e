//! Records of element files: their errors, rejected records, and reading in parallel chunks.

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;
use thiserror::Error;

use super::element_set::ElementSet;

/// Errors of one record.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// A fixed-column field holds no number.
    #[error("line {line}: {field} {text:?} is not a number in columns {first}-{last}")]
    NotANumber {
        /// Line of the element set, 1 or 2.
        line: u8,
        /// Name of the field.
        field: &'static str,
        /// Text found there.
        text: String,
        /// First column, from 1.
        first: u8,
        /// Last column.
        last: u8,
    },
    /// The catalogue number of a TLE is neither digits nor Alpha-5.
    #[error(
        "line {line}: {text:?} in columns 3-7 is not a catalogue number (1-99999, or Alpha-5 with A-Z without I and O)"
    )]
    BadTleId {
        /// Line of the element set, 1 or 2.
        line: u8,
        /// Text found there.
        text: String,
    },
    /// A message without any of the fields of an element set, or with empty ones only.
    #[error("this message holds no elements")]
    NoElements,
    /// A line of a TLE is too short or too long.
    #[error("line {line} has {length} characters; 69 are allowed, or 68 where the checksum is missing")]
    LineLength {
        /// Line of the element set, 1 or 2.
        line: u8,
        /// Characters without the blanks at the end.
        length: usize,
    },
    /// Something stands where a TLE has a blank between two fields: the columns are shifted.
    #[error("line {line}: {found:?} in column {column}, where a blank separates two fields: the columns are shifted")]
    ShiftedColumns {
        /// Line of the element set, 1 or 2.
        line: u8,
        /// Column, from 1.
        column: u8,
        /// The character found.
        found: char,
    },
    /// The checksum of a line is there and wrong.
    #[error("line {line}: the checksum is {stated:?}, the line adds up to {computed}")]
    BadChecksum {
        /// Line of the element set, 1 or 2.
        line: u8,
        /// The character in column 69.
        stated: char,
        /// Sum of the digits, a minus counting 1, modulo 10.
        computed: u8,
    },
    /// The two lines have different catalogue numbers.
    #[error("line 1 is of object {first}, line 2 of object {second}")]
    MixedObjects {
        /// Catalogue number in line 1.
        first: u32,
        /// Catalogue number in line 2.
        second: u32,
    },
    /// A line 1 that no line 2 follows.
    #[error("line 1 of an element set is not followed by its line 2")]
    LineOneAlone,
    /// A line 2 without a line 1 before it.
    #[error("line 2 of an element set has no line 1 before it")]
    LineTwoAlone,
    /// A line that no element set follows.
    #[error("{text:?} is neither part of an element set nor the name of one")]
    Stray {
        /// The line, shortened.
        text: String,
    },
    /// A field of an OMM, or a column of a CSV file, holds no number.
    #[error("{field} {text:?} is not a number")]
    FieldNotANumber {
        /// Keyword.
        field: &'static str,
        /// Text found there.
        text: String,
    },
    /// A field that must be there is not.
    #[error("{field} is missing")]
    Missing {
        /// Keyword.
        field: &'static str,
    },
    /// The catalogue number of an OMM is no number of one to nine digits.
    #[error("NORAD_CAT_ID {text:?} is not a catalogue number (1 to 999999999, or Alpha-5)")]
    BadId {
        /// Text found there.
        text: String,
    },
    /// An epoch that is no date.
    #[error("epoch {text:?} is not a date: {allowed}")]
    BadEpoch {
        /// Text found there.
        text: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A number outside what can be.
    #[error("{field} {value} is out of range: {allowed}")]
    OutOfRange {
        /// Name of the field.
        field: &'static str,
        /// The number, in the unit of `allowed`.
        value: f64,
        /// What is allowed, with its unit.
        allowed: &'static str,
    },
    /// Mean elements of another theory, frame or time system than SGP4's.
    #[error("{field} {text:?} is not supported: {allowed}")]
    Unsupported {
        /// Keyword.
        field: &'static str,
        /// Text found there.
        text: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The syntax around the record is broken.
    #[error("broken {format}: {what}")]
    Syntax {
        /// JSON, XML, KVN or CSV.
        format: &'static str,
        /// What is wrong.
        what: String,
    },
}

/// Rejected record with its position and reason. Prints as `file:line: why`.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// Name of the file as it was given.
    pub file: Arc<str>,
    /// Line in the file, from 1.
    pub line: usize,
    /// Why it was left out.
    pub reason: RecordError,
}

impl fmt::Display for Rejected {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}: {}", self.file, self.line, self.reason)
    }
}

/// What a reader made of a text. Places are byte offsets; they become line numbers when the file is done.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    /// The good records in their order.
    pub sets: Vec<ElementSet>,
    /// Where the last of them stands.
    pub last_good_at: Option<usize>,
    /// The bad ones: where and why.
    pub rejected: Vec<(usize, RecordError)>,
    /// Records taken in spite of a wrong checksum.
    pub bad_checksums_accepted: usize,
}

impl Parsed {
    /// Takes a record or notes why not.
    pub fn take(&mut self, offset: usize, record: Result<ElementSet, RecordError>) {
        match record {
            Ok(set) => {
                self.sets.push(set);
                self.last_good_at = Some(offset);
            }
            Err(reason) => self.rejected.push((offset, reason)),
        }
    }

    /// Whether no good record follows the last bad one: the text may have been cut within it.
    pub fn is_cut_short(&self) -> bool {
        self.rejected.iter().map(|(offset, _)| *offset).max() > self.last_good_at
    }
}

/// The ranges every element set must keep, whatever the syntax.
///
/// Angles may leave one turn by a turn in either direction: they mean the same.
pub(super) fn checked(set: ElementSet) -> Result<ElementSet, RecordError> {
    const TURN: &str = "-360 to 360 deg";
    let out_of_range = |field, value, allowed| Err(RecordError::OutOfRange { field, value, allowed });
    if set.norad_id.0 == 0 || set.norad_id.0 > 999_999_999 {
        return out_of_range("catalogue number", f64::from(set.norad_id.0), "1 to 999999999");
    }
    if !(set.mean_motion_rev_day > 0.0 && set.mean_motion_rev_day.is_finite()) {
        return out_of_range("mean motion", set.mean_motion_rev_day, "above 0 revolutions a day");
    }
    if !(0.0..1.0).contains(&set.eccentricity) {
        return out_of_range("eccentricity", set.eccentricity, "0 to below 1");
    }
    if !(0.0..=180.0).contains(&set.inclination_deg) {
        return out_of_range("inclination", set.inclination_deg, "0 to 180 deg");
    }
    for (field, value) in [
        ("right ascension of the node", set.right_ascension_of_node_deg),
        ("argument of perigee", set.argument_of_perigee_deg),
        ("mean anomaly", set.mean_anomaly_deg),
    ] {
        if !(-360.0..=360.0).contains(&value) {
            return out_of_range(field, value, TURN);
        }
    }
    for (field, value) in [
        ("B*", set.bstar_per_earth_radius),
        ("first derivative of the mean motion", set.mean_motion_dot_rev_day2),
        ("second derivative of the mean motion", set.mean_motion_ddot_rev_day3),
    ] {
        if !value.is_finite() {
            return out_of_range(field, value, "a finite number");
        }
    }
    Ok(set)
}

/// A text for an error message: at most 60 characters of it.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_string(),
    }
}

/// Least length of a chunk, bytes: smaller ones cost more than they save.
const LEAST_CHUNK: usize = 200_000;

/// Reads `text` with `parse`, in pieces that begin where `next_record(text, from)` says: the offset at or after `from`
/// at which reading may begin afresh, or the length of the text. The answer is the one that a single piece gives.
pub(super) fn parse_in_chunks<'a>(
    text: &'a str,
    next_record: impl Fn(&'a str, usize) -> usize,
    parse: impl Fn(&'a str) -> Parsed + Sync,
) -> Parsed {
    // Two pieces a thread, for threads may be busy elsewhere.
    let pieces = (text.len() / LEAST_CHUNK).min(2 * rayon::current_num_threads());
    let mut cuts = vec![0];
    for piece in 1..pieces {
        let from = text.len() / pieces * piece;
        let last = cuts[cuts.len() - 1];
        let from = (from.max(last + 1)..=text.len()).find(|&at| text.is_char_boundary(at)).unwrap_or(text.len());
        cuts.push(next_record(text, from));
    }
    cuts.push(text.len());
    let parts: Vec<(usize, Parsed)> =
        cuts.par_windows(2).map(|cut| (cut[0], parse(text.get(cut[0]..cut[1]).unwrap_or_default()))).collect();
    let mut parts = parts.into_iter();
    let mut whole = parts.next().map(|(_, first)| first).unwrap_or_default();
    for (offset, part) in parts {
        whole.sets.extend(part.sets);
        whole.last_good_at = part.last_good_at.map(|at| at + offset).or(whole.last_good_at);
        whole.rejected.extend(part.rejected.into_iter().map(|(at, reason)| (at + offset, reason)));
        whole.bad_checksums_accepted += part.bad_checksums_accepted;
    }
    whole
}

/// Offset of the first line that begins at or after `from`.
pub(super) fn next_line(text: &str, from: usize) -> usize {
    if from == 0 {
        return 0;
    }
    let rest = text.as_bytes().get(from - 1..).unwrap_or_default();
    rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').map_or(text.len(), |at| from + at)
}
