//! Search for keywords in headers, and parsing of dates and times.

use hifitime::{Epoch, TimeScale};

use crate::error::Error;
use crate::frames::seconds_after;
use crate::images::card::{Card, CardValue};
use crate::images::header::Header;

use super::comment::Comment;

/// Result of parsing a date.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum DateText {
    /// A date with a time.
    Moment(Epoch),
    /// A date without a time: year, month, day.
    Day([u32; 3]),
    /// A year of two digits after 1999, or numbers in an ambiguous order.
    Unclear,
    /// Not a date.
    Unreadable,
}

/// Returns a text without "Z", "UTC", "UT" or "GMT" at its end.
fn without_universal(text: &str) -> &str {
    let text = text.trim();
    let ends = ["z", "utc", "ut", "gmt"].into_iter().find(|end| text.to_ascii_lowercase().ends_with(end));
    ends.map_or(text, |end| text[..text.len() - end.len()].trim_end())
}

/// Splits the offset from universal time off a date with a time (ISO 8601), as in `2020-03-06T00:04:15-07:00`. Returns the
/// rest and the offset in seconds.
pub(super) fn without_offset(text: &str) -> (&str, f64) {
    let text = without_universal(text);
    let split = || {
        let time = text.find(':')?;
        let at = time + text[time..].rfind(['+', '-'])?;
        let (hours, minutes) =
            text[at + 1..].split_once(':').unwrap_or((text.get(at + 1..at + 3)?, text.get(at + 3..)?));
        let minutes = if minutes.is_empty() { 0 } else { minutes.parse::<u32>().ok()? };
        let hours = hours.parse::<u32>().ok().filter(|hours| *hours <= 14 && minutes < 60)?;
        let sign = if text[at..].starts_with('-') { -1.0 } else { 1.0 };
        Some((&text[..at], sign * f64::from(3600 * hours + 60 * minutes)))
    };
    split().unwrap_or((text, 0.0))
}

/// Returns true if a date with a time states universal time or an offset from it.
pub(super) fn has_zone(text: &str) -> bool {
    without_offset(text).0 != text.trim()
}

/// First year with satellites, of years with two digits.
const FIRST_YEAR: u32 = 1957;
const MONTHS: &str = "jan feb mar apr may jun jul aug sep oct nov dec";

/// Parses `2020-03-06` and `2020-03-06T00:04:15.41`. A blank or an underscore may replace the T, slashes, dots or nothing the
/// hyphens, and an offset from universal time may follow. A year of two or three digits counts from 1900. Dates that end with
/// the year are read if they exist in only one order, as `22.08.2026` and `22-Aug-2026`.
pub(super) fn parse_date(text: &str, scale: TimeScale) -> DateText {
    parse_date_of("", text, scale)
}

/// Parses the date in a keyword as [`parse_date`]. `05/06/92` in DATE-OBS is June 5, 1992 (FITS standard 4.0, section
/// 4.4.2.1).
pub(super) fn parse_date_of(keyword: &str, text: &str, scale: TimeScale) -> DateText {
    let (text, offset_s) = without_offset(text);
    // Not the T in "Oct".
    let is_separator = |at: &usize| match text.as_bytes()[*at] {
        b'T' | b't' => text.as_bytes()[at - 1].is_ascii_digit(),
        mark => mark == b' ' || mark == b'_',
    };
    let (day, time) = match (1..text.len()).find(is_separator) {
        Some(at) => (&text[..at], Some(text[at + 1..].trim())),
        None => (text, None),
    };
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    // "20260822T031500"
    let split = |text: &str, sign: char| match (text.get(..2), text.get(2..4), text.get(4..)) {
        (Some(a), Some(b), Some(c)) => format!("{a}{sign}{b}{sign}{c}"),
        _ => text.to_owned(),
    };
    let day = if day.len() == 8 && is_digits(day) {
        format!("{}{}", &day[..2], split(&day[2..], '-'))
    } else {
        day.to_owned()
    };
    let time = time.map(|time| if time.get(..6).is_some_and(is_digits) { split(time, ':') } else { time.to_owned() });
    // "2026:08:22" (AAT, EXIF)
    let is_with_colons = day.find(':') == Some(4);
    let parts: Vec<&str> = day.split(|c| matches!(c, '-' | '/' | '.') || (c == ':' && is_with_colons)).collect();
    let &[first, middle, last] = &parts[..] else { return DateText::Unreadable };
    let named =
        MONTHS.split(' ').position(|month| middle.get(..3).is_some_and(|name| name.eq_ignore_ascii_case(month)));
    let number = |text: &str| text.parse::<u32>().ok().filter(|_| text.len() <= 4 && is_digits(text));
    let middle = named.map(|month| month as u32 + 1).or_else(|| number(middle));
    let (Some(a), Some(b), Some(c)) = (number(first), middle, number(last)) else { return DateText::Unreadable };
    let exists = |day: &[u32; 3]| at(*day, [0, 0], 0.0, scale).is_some();
    let date = if first.len() == 4 {
        [a, b, c]
    } else {
        let is_short = last.len() < 4;
        let year = if is_short { 1900 + c } else { c };
        let orders = [[year, b, a], [year, a, b]].into_iter().take(if named.is_some() { 1 } else { 2 });
        let mut readings: Vec<[u32; 3]> = orders.filter(|day| exists(day) && year >= FIRST_YEAR).collect();
        readings.dedup();
        match readings[..] {
            [date] => date,
            [date, _] if is_short && day.contains('/') && keyword == "DATE-OBS" => date,
            _ => return DateText::Unclear,
        }
    };
    let moment = |time: String| {
        let (clock, seconds) = parse_time(&time)?;
        Some(DateText::Moment(seconds_after(at(date, clock, seconds, scale)?, -offset_s)))
    };
    match time {
        None if exists(&date) => DateText::Day(date),
        None => DateText::Unreadable,
        Some(time) => moment(time).unwrap_or(DateText::Unreadable),
    }
}

/// Parses `hh:mm:ss.sss`, also with a decimal comma. Returns hours and minutes, and the seconds with their fraction.
pub(super) fn parse_time(text: &str) -> Option<([u32; 2], f64)> {
    let parts: Vec<&str> = without_universal(text).split(':').collect();
    let [hours, minutes, ref rest @ ..] = parts[..] else { return None };
    let seconds = match rest {
        [] => 0.0,
        [seconds] => seconds.replace(',', ".").parse::<f64>().ok()?,
        _ => return None,
    };
    let clock = [hours.parse().ok()?, minutes.parse().ok()?];
    (clock[0] < 24 && clock[1] < 60 && (0.0..61.0).contains(&seconds)).then_some((clock, seconds))
}

/// Returns the epoch of a date and a time; `None` for a date that does not exist.
pub(super) fn at(day: [u32; 3], clock: [u32; 2], seconds: f64, scale: TimeScale) -> Option<Epoch> {
    let [year, month, day] = day;
    let whole = |number: u32| u8::try_from(number).ok();
    let minute = Epoch::maybe_from_gregorian(
        i32::try_from(year).ok().filter(|year| (1900..2200).contains(year))?,
        whole(month)?,
        whole(day)?,
        whole(clock[0])?,
        whole(clock[1])?,
        0,
        0,
        scale,
    )
    .ok()?;
    Some(seconds_after(minute, seconds))
}

/// Headers in order of precedence: first the header of the image, then the primary header.
#[derive(Copy, Clone)]
pub(super) struct Keywords<'a>(pub &'a [&'a Header]);

impl<'a> Keywords<'a> {
    /// Returns the cards of all headers. A header that is given twice, that of an image in the primary HDU, is read once.
    pub fn cards(self) -> impl Iterator<Item = &'a Card> {
        let is_first = move |(at, header): &(usize, &&'a Header)| {
            !self.0[..*at].iter().any(|other| std::ptr::eq(*other, **header))
        };
        self.0.iter().enumerate().filter(is_first).flat_map(|(_, header)| header.cards())
    }

    /// Returns the first header in which a keyword has a value, and the keyword as written in that header, where an
    /// underscore may replace a hyphen, or the hyphen may be missing.
    pub fn find(self, keyword: &str) -> Option<(&'a Header, String)> {
        let names = [keyword.to_owned(), keyword.replace('-', "_"), keyword.replace('-', "")];
        self.0.iter().find_map(|header| {
            let has_value = |name: &&String| header.number(name).is_some() || header.text(name).is_some();
            names.iter().find(has_value).map(|name| (*header, name.clone()))
        })
    }

    /// Checks that none of several keywords is twice in a header with different values (FITS standard 4.0, section
    /// 4.1.2.1, leaves the value of such a keyword undefined).
    pub fn are_unique<'b>(self, keywords: impl Iterator<Item = &'b str> + Clone) -> Result<(), Error> {
        for header in self.0 {
            for (at, card) in header.cards().iter().enumerate() {
                let name = card.keyword();
                if !keywords.clone().any(|keyword| is_spelling(keyword, &name)) {
                    continue;
                }
                let [first, second] = [header.card(&name).unwrap_or(card), card].map(Card::value);
                // 30 and 30.0 are the same value.
                let number = |value: &Option<CardValue>| match value {
                    Some(CardValue::Integer(number)) => Some(*number as f64),
                    Some(CardValue::Real(number)) => Some(*number),
                    _ => None,
                };
                let is_same = first == second || (number(&first).is_some() && number(&first) == number(&second));
                if !is_same && second.is_some() && header.position(&name) != Some(at) {
                    let given = format!("in two cards with different values: {:?}", card.text().trim_end());
                    return Err(Error::invalid(name, given, "one card, or --start and --exposure"));
                }
            }
        }
        Ok(())
    }

    /// Returns the comment of a keyword, with the COMMENT cards that begin with its name.
    pub fn comment(self, header: &Header, name: &str) -> Comment {
        let mut text = header.comment(name);
        for card in header.cards().iter().filter(|card| card.keyword() == "COMMENT") {
            let remark = card.remark_text();
            if let Some(rest) = remark.trim_start().strip_prefix(name).filter(|rest| rest.starts_with([' ', ':', '=']))
            {
                text = format!("{text}; {rest}");
            }
        }
        Comment::new(text.trim_start_matches("; "))
    }

    /// Returns the first number among several keywords that satisfies a condition, with its keyword and comment.
    pub fn number(self, keywords: &[&str], allows: impl Fn(f64) -> bool) -> Option<(String, f64, String)> {
        keywords.iter().find_map(|keyword| {
            let (header, name) = self.find(keyword)?;
            let number = header.number(&name).filter(|number| allows(*number))?;
            let comment = header.comment(&name);
            Some((name, number, comment))
        })
    }

    /// Returns the keyword as written in the header, its text and its comment.
    pub fn text_and_comment(self, keyword: &str) -> Option<(String, String, Comment)> {
        let (header, name) = self.find(keyword)?;
        let text = header.text(&name)?;
        let comment = self.comment(header, &name);
        Some((name, text, comment))
    }

    /// Returns the first text among several keywords, with its keyword.
    pub fn text(self, keywords: &[&str]) -> Option<(String, String)> {
        keywords.iter().find_map(|keyword| {
            let (header, name) = self.find(keyword)?;
            header.text(&name).map(|text| (name, text))
        })
    }
}

/// Returns a name without hyphens, underscores and blanks.
pub(super) fn bare(name: &str) -> String {
    name.replace(['-', '_', ' '], "")
}

/// Returns true if a name is a keyword as [`Keywords::find`] reads it.
pub(super) fn is_spelling(keyword: &str, name: &str) -> bool {
    keyword == name || keyword.replace('-', "_") == name || keyword.replace('-', "") == name
}

/// Returns half a unit of the last digit that the card gives for its number.
pub(super) fn resolution(card: &Card) -> f64 {
    let text = card.text();
    let field = text.split_once('=').map_or("", |(_, field)| field.split('/').next().unwrap_or(""));
    let field = field.trim_matches([' ', '\'']).to_ascii_uppercase();
    let (mantissa, exponent) = field.split_once(['E', 'D']).unwrap_or((&field, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, digits)| digits.len() as i32);
    0.5 * 10f64.powi(exponent.trim().parse::<i32>().unwrap_or(0) - decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_dates() {
        let at = |text: &str| parse_date_of("DATE-OBS", text, TimeScale::UTC);
        let expected = DateText::Moment(Epoch::from_gregorian_utc(2020, 3, 6, 0, 4, 15, 410_235_000));
        for text in [
            "2020-03-06T00:04:15.410235",
            " 2020-03-06 00:04:15.410235",
            "2020/03/06T00:04:15.410235Z",
            "2020:03:06 00:04:15.410235",
            "2020.03.06t00:04:15,410235z",
            "20200306T000415.410235Z",
            "2020-03-06_00:04:15.410235 UTC",
            "6-Mar-2020 00:04:15.410235+00:00",
            "6/3/120 00:04:15.410235",
            "2020-Mar-06 00:04:15.410235",
        ] {
            assert_eq!(at(text), expected, "{text}");
        }
        assert_eq!(at("        2020-12-09"), DateText::Day([2020, 12, 9]));
        for (text, day) in [
            ("22/08/2026", [2026, 8, 22]),
            ("08/22/2026", [2026, 8, 22]),
            ("22.08.2026", [2026, 8, 22]),
            ("08/08/2026", [2026, 8, 8]),
            ("20260822", [2026, 8, 22]),
            ("26/10/92", [1992, 10, 26]),
            ("05/06/92", [1992, 6, 5]),
            ("26/07/102", [2002, 7, 26]),
            ("2-Oct-2026", [2026, 10, 2]),
        ] {
            assert_eq!(at(text), DateText::Day(day), "{text}");
        }
        assert_eq!(parse_date("05/06/92", TimeScale::UTC), DateText::Unclear);
        for text in ["2026-08-22T03:15:00 UTC", "2026-08-22_03:15:00+02:00", "2026-08-22T03:15:00z"] {
            assert!(has_zone(text), "{text}");
        }
        assert!(!has_zone(" 2026-08-22T03:15:00"));
        for text in ["06/03/2020", "06.03.2020 00:04:15", "20-12-09", "26/10/20", "05-06-92"] {
            assert_eq!(at(text), DateText::Unclear, "{text}");
        }
        for text in
            ["", "yesterday", "2020-13-01", "2020-02-30", "2020-03-06T25:00:00", "2020-03-06T00:61:00", "2020-03"]
        {
            assert_eq!(at(text), DateText::Unreadable, "{text}");
        }
        assert_eq!(parse_time("19:36:37.5"), Some(([19, 36], 37.5)));
        assert_eq!(parse_time("19:36"), Some(([19, 36], 0.0)));
        assert_eq!(parse_time("70577.1"), None);
    }
}
