//! OMM as lines of `KEYWORD = value`; a file contains one or more messages.

use std::borrow::Cow;

use super::omm::{Fields, Keyword};
use super::record::{Parsed, excerpt};
use super::record::{next_line, parse_in_chunks};
use super::tle::Checksums;
use crate::error::Error;

/// The keyword at the start of a message.
const OPENING: &str = "CCSDS_OMM_VERS";
/// Beginning of the keywords of user-defined parameters.
const USER_DEFINED: &str = "USER_DEFINED_";

/// Returns true if one of the first lines starts an OMM.
pub(super) fn looks_like(text: &str) -> bool {
    text.split(['\n', '\r']).take(40).any(opens)
}

/// Returns true for the first line of a message.
pub(super) fn opens(line: &str) -> bool {
    line.trim_start().strip_prefix(OPENING).is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// Reads every message. A line that is not `KEYWORD = value` invalidates only its own message.
pub(super) fn parse(text: &str) -> Parsed {
    parse_in_chunks(text, next_message, parse_piece)
}

/// Returns the offset of the next line that starts a message.
fn next_message(text: &str, from: usize) -> usize {
    let mut at = next_line(text, from);
    for line in text[at..].split_inclusive(['\n', '\r']) {
        if opens(line) {
            return at;
        }
        at += line.len();
    }
    text.len()
}

fn parse_piece(text: &str) -> Parsed {
    let mut parsed = Parsed::default();
    let mut fields = Fields::default();
    let mut broken: Option<(usize, Error)> = None;
    let (mut opened_at, mut at) = (0, 0);
    let mut close = |fields: &mut Fields<'_>, opened_at: usize, broken: &mut Option<(usize, Error)>| {
        match broken.take() {
            Some(rejected) => parsed.rejected.push(rejected),
            None if fields.is_empty() => {}
            // The two lines of a TLE are user-defined parameters.
            None => fields.finish(opened_at, Checksums::Require, &mut parsed),
        }
        fields.clear();
    };
    for line in text.split_inclusive(['\n', '\r']) {
        let offset = at;
        at += line.len();
        let line = line.trim();
        if line.is_empty() || line.starts_with("COMMENT") || line.starts_with('#') {
            continue;
        }
        let Some((key, value)) = line.split_once('=') else {
            if !line.starts_with("META_") && !line.starts_with("DATA_") {
                let what = format!("{:?} is not KEYWORD = value", excerpt(line.as_bytes()));
                broken.get_or_insert((offset, Error::format(format!("invalid KVN: {what}"))));
            }
            continue;
        };
        let key = key.trim();
        if key == OPENING {
            close(&mut fields, opened_at, &mut broken);
            opened_at = offset;
        } else if let Some(keyword) =
            key.strip_prefix(USER_DEFINED).map_or_else(|| Keyword::parse(key), Keyword::of_user)
        {
            let (value, unit) = split_unit(value);
            fields.check_unit(keyword, key, unit);
            fields.set(keyword, Cow::Borrowed(value));
        }
    }
    close(&mut fields, opened_at, &mut broken);
    parsed
}

/// Returns a value and the unit that CCSDS allows after a number, as in `15.5 [rev/day]`; empty without a unit.
fn split_unit(value: &str) -> (&str, &str) {
    let value = value.trim();
    match value.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((number, unit)) if value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
            (number.trim_end(), unit)
        }
        _ => (value, ""),
    }
}
