//! Records of element files: errors, rejected records, and parsing in parallel chunks.

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;

use super::element_set::ElementSet;
use crate::error::Error;

/// Format of a file of element sets.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ElementFormat {
    /// Two-line element sets, with or without name lines.
    Tle,
    /// Orbit mean-elements messages as JSON (CelesTrak, Space-Track, JSON lines).
    OmmJson,
    /// Orbit mean-elements messages as CSV, and tables with the two lines of a TLE in columns.
    OmmCsv,
    /// Orbit mean-elements messages as XML (CCSDS 505.0-B).
    OmmXml,
    /// Orbit mean-elements messages as lines of `KEYWORD = value` (CCSDS 502.0-B).
    OmmKvn,
    /// Ephemeris in Modified ITC, as published for Starlink satellites.
    ModifiedItc,
    /// Orbit ephemeris messages as lines of `KEYWORD = value` (CCSDS 502.0-B).
    OemKvn,
    /// Orbit ephemeris messages as XML (CCSDS 505.0-B).
    OemXml,
}

impl fmt::Display for ElementFormat {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Tle => "TLE",
            Self::OmmJson => "OMM JSON",
            Self::OmmCsv => "OMM CSV",
            Self::OmmXml => "OMM XML",
            Self::OmmKvn => "OMM KVN",
            Self::ModifiedItc => "Modified ITC",
            Self::OemKvn => "OEM KVN",
            Self::OemXml => "OEM XML",
        })
    }
}

/// Rejected record with its position and reason. It is displayed as `file:line: reason`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rejected {
    /// Name of the file as given.
    pub file: Arc<str>,
    /// Line in the file, from 1.
    pub line: usize,
    /// Reason for the rejection.
    pub reason: Error,
}

impl fmt::Display for Rejected {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}: {}", self.file, self.line, self.reason)
    }
}

/// Result of parsing a text. Positions are byte offsets; they are converted to line numbers at the end.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    /// Valid records in order.
    pub sets: Vec<ElementSet>,
    /// Offset of the last valid record.
    pub last_good_at: Option<usize>,
    /// Offsets of the rejected records with the reasons.
    pub rejected: Vec<(usize, Error)>,
    /// Number of records accepted with a wrong checksum.
    pub bad_checksums_accepted: usize,
}

impl Parsed {
    /// Adds a valid record, or the reason why a record is rejected.
    pub fn take(&mut self, offset: usize, record: Result<ElementSet, Error>) {
        match record {
            Ok(set) => {
                self.sets.push(set);
                self.last_good_at = Some(offset);
            }
            Err(reason) => self.rejected.push((offset, reason)),
        }
    }

    /// Joins the results of the parts of a text, each with its offset.
    pub fn joined(parts: impl IntoIterator<Item = (usize, Self)>) -> Self {
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

    /// Returns true if the last record was rejected: the file may be truncated within it.
    pub fn is_cut_short(&self) -> bool {
        self.rejected.iter().map(|(offset, _)| *offset).max() > self.last_good_at
    }
}

/// Checks the ranges of an element set, which are the same for all formats.
///
/// Angles may be up to one turn below or above the normal range.
pub(super) fn checked(set: ElementSet) -> Result<ElementSet, Error> {
    const TURN: &str = "-360 to 360 deg";
    let out_of_range = |field: &str, value: f64, allowed: &str| {
        Err(Error::format(format!("{field} {value} is out of range: allowed {allowed}")))
    };
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

/// Returns at most 60 characters of a text, for error messages.
pub(crate) fn excerpt(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_string(),
    }
}

/// Smallest length of a chunk, bytes. Parallel parsing of smaller chunks is not faster.
const LEAST_CHUNK: usize = 200_000;

/// Parses `text` with `parse` in parallel chunks, with the same result as for the whole text. Chunks begin at
/// `next_record(text, from)`: the first offset at or after `from` where a record can begin, or the length of the text.
pub(super) fn parse_in_chunks<'a>(
    text: &'a str,
    next_record: impl Fn(&'a str, usize) -> usize,
    parse: impl Fn(&'a str) -> Parsed + Sync,
) -> Parsed {
    // Two chunks per thread balance the load if threads are busy.
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
    Parsed::joined(parts)
}

/// Returns the offset of the first line that begins at or after `from`.
pub(super) fn next_line(text: &str, from: usize) -> usize {
    if from == 0 {
        return 0;
    }
    let rest = text.as_bytes().get(from - 1..).unwrap_or_default();
    rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').map_or(text.len(), |at| from + at)
}
