//! Parser of files with TLEs, names, comments and invalid lines; writer of TLEs.

use super::element_set::{ElementSet, NoradId};
use super::epoch;
use super::record::{Parsed, excerpt, next_line, parse_in_chunks};
use super::tle::{Checksums, parse_lines};
use super::tle_fields::{ALPHA5, BODY, checksum};
use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

/// Line without trailing blanks, with its offset in the text.
type Placed<'a> = (usize, &'a [u8]);

/// Smallest length of a data line, characters. Shorter lines that begin with "1 " or "2 " may be names.
const DATA_LENGTH: usize = 60;
/// Largest length of the names of catalogues, characters.
const NAME_LENGTH: usize = 24;

/// Parses two-line, three-line and "0 NAME" sets, also mixed.
///
/// Blank lines and lines that begin with `#` are skipped, and blanks before a data line are ignored. Text before,
/// between and after the sets (bulletins, mails) is skipped, except for lines with elements in another form, and for a
/// line alone that may be the name of a set that is missing. A line 1 or 2 without its partner is rejected, and parsing
/// continues with the next line.
pub(super) fn parse(text: &str, checksums: Checksums) -> Parsed {
    parse_in_chunks(text, after_next_set, |piece| parse_piece(piece.as_bytes(), checksums))
}

/// Returns the offset after the next complete pair of lines. Parsing from there does not depend on earlier text.
fn after_next_set(text: &str, from: usize) -> usize {
    let mut lines = Lines { text: text.as_bytes(), at: next_line(text, from) };
    let mut after_first = false;
    while let Some((_, line)) = lines.next() {
        if after_first && line.starts_with(b"2 ") {
            return lines.at.min(text.len());
        }
        after_first = line.starts_with(b"1 ");
    }
    text.len()
}

fn parse_piece(text: &[u8], checksums: Checksums) -> Parsed {
    let mut parsed = Parsed::default();
    parsed.sets.reserve(text.len() / 140);
    let mut lines = Lines { text, at: 0 }.peekable();
    // Lines since the last data line that are no data lines, and the line 1 after them.
    let mut texts: Vec<Placed> = Vec::new();
    let mut first: Option<Placed> = None;
    while let Some((offset, line)) = lines.next() {
        if let Some((first_offset, first_line)) = first.take() {
            if line.starts_with(b"2 ") {
                let name_line = name_in(&mut texts, &mut parsed);
                match parse_lines(name_line, first_line, line, checksums) {
                    Ok((set, overlooked)) => {
                        parsed.take(offset, Ok(set));
                        parsed.bad_checksums_accepted += usize::from(overlooked);
                    }
                    Err((1, error)) => parsed.rejected.push((first_offset, error)),
                    Err((_, error)) => parsed.rejected.push((offset, error)),
                }
                continue;
            }
            name_in(&mut texts, &mut parsed);
            parsed
                .rejected
                .push((first_offset, Error::format("line 1 of an element set is not followed by its line 2")));
        }
        let is_data = line.len() >= DATA_LENGTH && !is_key(line);
        // "1 per week" and "2 per day" are text.
        let has_number = line.iter().skip(2).take(5).any(u8::is_ascii_digit);
        let is_pair = has_number && lines.peek().is_some_and(|(_, next)| next.starts_with(b"2 ") && !is_key(next));
        if line.starts_with(b"1 ") && (is_data || is_pair) {
            first = Some((offset, line));
        } else if line.starts_with(b"2 ") && is_data {
            name_in(&mut texts, &mut parsed);
            parsed.rejected.push((offset, Error::format("line 2 of an element set is not preceded by its line 1")));
        } else {
            texts.push((offset, line));
        }
    }
    if let Some((offset, _)) = first {
        name_in(&mut texts, &mut parsed);
        parsed.rejected.push((offset, Error::format("line 1 of an element set is not followed by its line 2")));
    } else {
        // A file that is truncated after the name of a satellite has one line at its end, perhaps with the number of
        // the next line.
        let is_number = |(_, line): &Placed| *line == b"1" || *line == b"2";
        let names = texts.len() - usize::from(texts.last().is_some_and(is_number));
        let is_missing = names == 1 && may_be_name(texts[0].1, &parsed);
        reject_fragments(&texts[..names], is_missing, &mut parsed);
    }
    parsed
}

/// Returns the name line before a data line, and removes all lines. Two lines are a name and a line that may be a
/// damaged part of an element set; more lines are a text, such as the head of a bulletin.
fn name_in<'a>(texts: &mut Vec<Placed<'a>>, parsed: &mut Parsed) -> &'a [u8] {
    let is_name = |(_, line): &mut Placed| line.len() < DATA_LENGTH || elements_in(line).is_none();
    let name = texts.pop_if(is_name).map_or(&[][..], |(_, line)| line);
    let is_missing = texts.len() == 1 && may_be_name(texts[0].1, parsed);
    reject_fragments(texts, is_missing, parsed);
    texts.clear();
    name
}

/// Rejects lines that are parts of element sets by their first characters or contain elements, or all of them if they
/// are the name of a missing set.
fn reject_fragments(texts: &[Placed<'_>], is_missing: bool, parsed: &mut Parsed) {
    let is_part = |line: &[u8]| {
        (line.starts_with(b"1 ") || line.starts_with(b"2 ")) && line.get(2).is_some_and(u8::is_ascii_digit)
    };
    let mut before = None;
    for (offset, line) in texts {
        let found = elements_in(line);
        // The two lines of a set are one record.
        let is_second = (before, found) == (Some(Elements::First), Some(Elements::Second));
        if is_part(line) || (found.is_some() && !is_second) || is_missing {
            parsed.rejected.push((*offset, unexpected(line)));
        }
        before = found;
    }
}

fn unexpected(line: &[u8]) -> Error {
    let line = Quoted::new(excerpt(line));
    Error::format(format!("unexpected line {line:?}: neither part nor name of an element set"))
}

/// Rejects the lines of a text between messages that contain elements; `offset` is that of the text.
pub(super) fn reject_elements(text: &str, offset: usize, parsed: &mut Parsed) {
    let lines = Lines { text: text.as_bytes(), at: 0 };
    // Other messages of a combined XML file are read elsewhere.
    let lines = lines.filter(|(_, line)| !line.trim_ascii_start().starts_with(b"<"));
    let texts: Vec<Placed> = lines.map(|(at, line)| (offset + at, line)).collect();
    reject_fragments(&texts, false, parsed);
}

/// What a line that is not read contains.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Elements {
    /// Numbers of line 1, at any place of the line.
    First,
    /// Numbers of line 2.
    Second,
    /// Elements of a table, or a keyword that is once in each message.
    Message,
}

/// Returns the kind of elements in a line of any form, such as quoted or numbered lines of a TLE; `None` for a text.
fn elements_in(line: &[u8]) -> Option<Elements> {
    let line = String::from_utf8_lossy(line);
    // The keyword is also the start of MEAN_MOTION_DOT.
    let is_keyword = |keyword| line.split(keyword).skip(1).any(|rest| !rest.starts_with('_'));
    if ["MEAN_MOTION", "TLE_LINE1", "CCSDS_OEM_VERS"].into_iter().any(is_keyword) {
        return Some(Elements::Message);
    }
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let words = || line.split(|c: char| c.is_whitespace() || ",;|\"'<>\u{fffd}".contains(c));
    let is_decimal = |word: &str| word.split_once('.').is_some_and(|(_, digits)| is_digits(digits));
    let is_epoch = |word: &str| is_decimal(word) && word.find('.') == Some(5) && word.len() >= 12;
    // Such as 10370-3.
    let is_exponential = |word: &str| {
        let parts = word.trim_start_matches(['+', '-']).split_once(['+', '-']);
        parts.is_some_and(|(digits, power)| digits.len() == 5 && is_digits(digits) && is_digits(power))
    };
    let is_date = |word: &str| matches!(word.as_bytes(), [_, _, _, _, b'-', _, _, b'-', _, _, ..]);
    if words().any(is_epoch) && words().any(is_exponential) {
        Some(Elements::First)
    } else if words().filter(|word| is_decimal(word)).count() < 5 {
        None
    } else if words().any(|word| word.len() == 7 && is_digits(word)) {
        Some(Elements::Second)
    } else {
        words().any(is_date).then_some(Elements::Message)
    }
}

/// Returns true for a line that may be the name of a set that is missing, because the file is truncated after it. It is
/// as short as the names of catalogues, has letters, and is in capitals if the name before it is. Lines of a text are
/// not: `/EX` of packet radio, `NNNN` of telegrams, a greeting (`73 de ...`), an HTML tag, a date, an address, a remark
/// in brackets, and any line after a set that has no name.
fn may_be_name(line: &[u8], parsed: &Parsed) -> bool {
    let line = line.trim_ascii();
    let name = line.strip_prefix(b"0 ").unwrap_or(line);
    let before = parsed.sets.last().map_or("A", |set| set.name.as_ref());
    let is_end = ["/EX", "/EXIT", "/ACK", "NNNN", "END", "EOF", "EOT", "QUIT", "BYE", "EXIT", "STOP"]
        .iter()
        .any(|end| line.eq_ignore_ascii_case(end.as_bytes()));
    let is_text = is_end
        || ["73 ", "<", "(", "*", "-", "www.", "http"].iter().any(|start| line.starts_with(start.as_bytes()))
        || (name.iter().any(u8::is_ascii_lowercase) && !before.bytes().any(|byte| byte.is_ascii_lowercase()));
    let has_letters = name.iter().any(u8::is_ascii_alphabetic);
    !before.is_empty() && !is_text && has_letters && name.len() <= NAME_LENGTH.max(before.len())
}

/// Returns true for a line that explains the columns, with letters in place of a catalogue number.
fn is_key(line: &[u8]) -> bool {
    line.len() >= 7
        && (line.starts_with(b"1 ") || line.starts_with(b"2 "))
        && line[2..7].iter().all(u8::is_ascii_alphabetic)
}

/// Returns true if a line of the text can be a data line by its length, line number and catalogue number.
pub(super) fn looks_like(text: &str) -> bool {
    Lines { text: text.as_bytes(), at: 0 }.any(|(_, line)| {
        line.len() >= DATA_LENGTH
            && line.len() < 200
            && (line.starts_with(b"1 ") || line.starts_with(b"2 "))
            && line[2..7].iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b' ')
    })
}

/// Iterator of lines that are neither blank nor comments.
struct Lines<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = Placed<'a>;

    fn next(&mut self) -> Option<Placed<'a>> {
        while self.at < self.text.len() {
            let offset = self.at;
            let rest = &self.text[offset..];
            let length = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').unwrap_or(rest.len());
            self.at = offset + length + 1;
            let line = rest[..length].trim_ascii_end();
            // Files truncated by a system crash may contain NUL bytes.
            if line.is_empty() || line[0] == b'#' || line.iter().all(|&byte| byte == 0) {
                continue;
            }
            let line = match line.trim_ascii_start() {
                indented if indented.starts_with(b"1 ") || indented.starts_with(b"2 ") => indented,
                _ => line,
            };
            if !line.trim_ascii().is_empty() {
                return Some((offset, line));
            }
        }
        None
    }
}

/// Formats an element set as two lines of 69 characters, rounded to the width of the columns.
///
/// The classification is `U` and the set number 999. Digits beyond the format are lost: the resolution is 1e-7 for the
/// eccentricity, five digits for B*, and 1e-8 day for the epoch. OMM files keep all digits.
///
/// # Errors
/// * the catalogue number is above 339,999;
/// * a derivative, B*, the mean motion or the year of the epoch (1957-2056) does not fit its columns.
pub fn format_tle(set: &ElementSet) -> Result<[String; 2], Error> {
    let id = format_id(set.norad_id)?;
    let misfit = |field, value| {
        Error::format(format!("{field} {value} of object {} does not fit its columns in a TLE", set.norad_id))
    };
    let (mut year, mut day, nanosecond) = epoch::to_day_of_year(set.epoch);
    let mut fraction = (nanosecond + 432_000) / 864_000;
    if fraction == 100_000_000 {
        (fraction, day) = (0, day + 1);
        // After rounding, day 366 of a common year is 1 January of the next year.
        (year, day, _) = epoch::to_day_of_year(epoch::from_day_of_year(year, day, 0));
    }
    if !(1957..=2056).contains(&year) {
        return Err(misfit("year of the epoch", f64::from(year)));
    }
    let dot = format!("{:.8}", set.mean_motion_dot_rev_day2.abs());
    let dot = dot.strip_prefix('0').unwrap_or(&dot);
    if dot.len() != 9 {
        return Err(misfit("first derivative of the mean motion", set.mean_motion_dot_rev_day2));
    }
    let sign = if set.mean_motion_dot_rev_day2.is_sign_negative() { '-' } else { ' ' };
    let ddot = format_exponential(set.mean_motion_ddot_rev_day3)
        .ok_or_else(|| misfit("second derivative of the mean motion", set.mean_motion_ddot_rev_day3))?;
    let bstar =
        format_exponential(set.bstar_per_earth_radius).ok_or_else(|| misfit("B*", set.bstar_per_earth_radius))?;
    let line1 = format!(
        "1 {id}U {:<8} {:02}{day:03}.{fraction:08} {sign}{dot} {ddot} {bstar} 0  999",
        format_designator(&set.international_designator),
        year % 100,
    );
    // A value that rounds to 1 does not fit the seven digits.
    let eccentricity = (set.eccentricity * 1e7).round().min(9_999_999.0);
    let line2 = format!(
        "2 {id} {:8.4} {:8.4} {eccentricity:07} {:8.4} {:8.4} {:11.8}{:5}",
        set.inclination_deg,
        set.right_ascension_of_node_deg.rem_euclid(360.0),
        set.argument_of_perigee_deg.rem_euclid(360.0),
        set.mean_anomaly_deg.rem_euclid(360.0),
        set.mean_motion_rev_day,
        set.revolution_at_epoch % 100_000,
    );
    if line2.len() != BODY {
        return Err(misfit("mean motion", set.mean_motion_rev_day));
    }
    Ok([line1, line2].map(|line| {
        let checksum = checksum(line.as_bytes());
        format!("{line}{checksum}")
    }))
}

fn format_id(norad_id: NoradId) -> Result<String, Error> {
    let (tens, rest) = (norad_id.0 / 10_000, norad_id.0 % 10_000);
    if tens < 10 {
        return Ok(format!("{:05}", norad_id.0));
    }
    let letter = ALPHA5.get(tens as usize - 10).ok_or_else(|| {
        Error::new(ErrorKind::Invalid, format!("catalogue number {norad_id} does not fit a TLE"))
            .allowing("up to 339999 (Alpha-5)")
    })?;
    Ok(format!("{}{rest:04}", char::from(*letter)))
}

/// Converts `1998-067A` to `98067A`; other forms give blanks.
fn format_designator(designator: &str) -> String {
    match designator.as_bytes() {
        [_, _, y1, y2, b'-', rest @ ..] if (3..=6).contains(&rest.len()) && designator.is_ascii() => {
            format!("{}{}{}", char::from(*y1), char::from(*y2), String::from_utf8_lossy(rest))
        }
        _ => String::new(),
    }
}

/// Formats a number in the form ` 10370-3`; `None` if its magnitude is 1e9 or more. Magnitudes below 1e-10 give 0.
fn format_exponential(value: f64) -> Option<String> {
    let sign = if value < 0.0 { '-' } else { ' ' };
    // Rust formats d.dddde-n; the decimal point is moved one digit to the left.
    let text = format!("{:.4e}", value.abs());
    let (mantissa, exponent) = text.split_once('e')?;
    let digits = mantissa.replace('.', "");
    let exponent = exponent.parse::<i32>().ok()? + 1;
    if value == 0.0 || exponent < -9 {
        return Some(" 00000+0".into());
    }
    let exponent_sign = if exponent < 0 { '-' } else { '+' };
    (exponent <= 9).then(|| format!("{sign}{digits}{exponent_sign}{}", exponent.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::{ReadOptions, Satellites};

    const TEXT: &str = "1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9999\n\
                        2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097";

    #[test]
    fn verif_round_trip_of_a_text() {
        let catalogue = Satellites::from_bytes("iss", TEXT.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(format_tle(&catalogue.element_sets[0]).unwrap().join("\n"), TEXT);
    }

    #[test]
    fn verif_alpha5_has_its_largest_number() {
        for (id, text) in [(5, "00005"), (99_999, "99999"), (100_000, "A0000"), (180_000, "J0000"), (339_999, "Z9999")]
        {
            assert_eq!(format_id(NoradId(id)).unwrap(), text);
        }
        assert!(
            format_id(NoradId(340_000)).unwrap_err().to_string().contains("catalogue number 340000 does not fit a TLE")
        );
    }

    #[test]
    fn verif_numbers_that_do_not_fit_are_errors() {
        let catalogue = Satellites::from_bytes("iss", TEXT.as_bytes(), &ReadOptions::default()).unwrap();
        let good = &catalogue.element_sets[0];
        let cases = [
            ElementSet { mean_motion_dot_rev_day2: 1.5, ..good.clone() },
            ElementSet { bstar_per_earth_radius: 1e10, ..good.clone() },
            ElementSet { mean_motion_rev_day: 123.0, ..good.clone() },
            ElementSet { epoch: hifitime::Epoch::from_gregorian_utc_at_noon(2057, 1, 1), ..good.clone() },
        ];
        for set in cases {
            assert!(
                format_tle(&set).unwrap_err().to_string().ends_with("does not fit its columns in a TLE"),
                "{set:?}"
            );
        }
    }
}
