//! Search for keywords in headers, and parsing of dates and times.

use hifitime::{Epoch, TimeScale};

use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::{seconds_after, seconds_between};
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

/// Returns a text without "Z", "UTC", "UT" or "GMT" at its end, perhaps in brackets.
fn without_universal(text: &str) -> &str {
    let text = text.trim_matches([' ', '[', ']', '(', ')']);
    let ends = ["z", "utc", "ut", "gmt"].into_iter().find(|end| text.to_ascii_lowercase().ends_with(end));
    ends.map_or(text, |end| text[..text.len() - end.len()].trim_end_matches([' ', '[', '(']))
}

/// Splits the offset from universal time off a date with a time (ISO 8601), as in `2020-03-06T00:04:15-07:00` and
/// `2020-03-06 00:04:15 UTC-7`. Returns the rest and the offset in seconds.
pub(super) fn without_offset(text: &str) -> (&str, f64) {
    let text = without_universal(text);
    let split = || {
        let time = text.find(':')?;
        let at = time + text[time..].rfind(['+', '-'])?;
        // "03:15:00 2026-08-22" has no offset.
        if text[time..at].contains(['+', '-']) {
            return None;
        }
        let digits = &text[at + 1..];
        let (hours, minutes) = digits.split_once(':').or_else(|| digits.split_at_checked(2)).unwrap_or((digits, ""));
        let minutes = if minutes.is_empty() { 0 } else { minutes.parse::<u32>().ok()? };
        let hours = hours.parse::<u32>().ok().filter(|hours| *hours <= 14 && minutes < 60)?;
        let sign = if text[at..].starts_with('-') { -1.0 } else { 1.0 };
        Some((without_universal(&text[..at]), sign * f64::from(3600 * hours + 60 * minutes)))
    };
    split().unwrap_or((text, 0.0))
}

/// Returns true if a date with a time states universal time or an offset from it.
pub(super) fn has_zone(text: &str) -> bool {
    without_offset(text).0 != text.trim()
}

/// First year with satellites, of years with two digits.
const FIRST_YEAR: u32 = 1957;
/// Beginnings of the names of months and weekdays.
const MONTHS: &str = "jan feb mar apr may jun jul aug sep oct nov dec";
const WEEKDAYS: &str = "mon tue wed thu fri sat sun";

/// Parses `2020-03-06` and `2020-03-06T00:04:15.41`. A blank or an underscore may replace the T, slashes, dots or
/// nothing the hyphens, and an offset from universal time may follow. A year of two or three digits counts from 1900.
/// Dates in another order are read if they exist in only one order, as `22.08.2026`, `Aug 22, 2026`, and `2026-234`
/// with the day of the year.
pub(super) fn parse_date(text: &str, scale: TimeScale) -> DateText {
    parse_date_of("", text, scale)
}

/// Parses the date in a keyword as [`parse_date`]. `05/06/92` in DATE-OBS is June 5, 1992 (FITS standard 4.0, section
/// 4.4.2.1).
pub(super) fn parse_date_of(keyword: &str, text: &str, scale: TimeScale) -> DateText {
    let (text, offset_s) = without_offset(text);
    let (day, time) = date_and_time(text);
    let is_of_standard = is_spelling("DATE-OBS", keyword) && day.contains('/');
    match (parse_day(&day, is_of_standard, scale), time) {
        (DateText::Day(date), Some(time)) => {
            let epoch = parse_time(&time).and_then(|(clock, seconds)| at(date, clock, seconds, scale));
            epoch.map_or(DateText::Unreadable, |epoch| DateText::Moment(seconds_after(epoch, -offset_s)))
        }
        (date, _) => date,
    }
}

/// Splits a text into its date and its time of day. The time follows a T or a numeric date, or is the word with a
/// colon, as in `Sat Aug 22 03:15:00 2026`.
pub(super) fn date_and_time(text: &str) -> (String, Option<String>) {
    let bytes = text.as_bytes();
    // Not the T in "Oct".
    let is_separator = |at: &usize| {
        matches!(bytes[*at], b'T' | b't') && bytes[at - 1].is_ascii_digit() && !bytes[at + 1].is_ascii_alphabetic()
    };
    if let Some(at) = (1..text.len().saturating_sub(1)).find(is_separator) {
        return (text[..at].to_owned(), Some(text[at + 1..].trim().to_owned()));
    }
    // "20260822-031500"
    if let Some((day, time)) = text.split_once('-')
        && [day.len(), time.find('.').unwrap_or(time.len())] == [8, 6]
        && day.bytes().all(|byte| byte.is_ascii_digit())
    {
        return (day.to_owned(), Some(time.to_owned()));
    }
    let mut words: Vec<&str> = text.split([' ', '_']).filter(|word| !word.is_empty()).collect();
    // "2026:234:03:15:00"
    if let [word] = words[..]
        && let Some((day, _)) = word.rmatch_indices(':').nth(2).map(|(at, _)| word.split_at(at))
        && day.contains(':')
    {
        return (day.to_owned(), Some(word[day.len() + 1..].to_owned()));
    }
    // "2026:08:22" (AAT, EXIF) is a date.
    let clock = words.iter().position(|word| word.find(':').is_some_and(|at| at != 4));
    if let Some(at) = clock {
        let is_half = |word: &&str| ["AM", "PM"].iter().any(|half| half.eq_ignore_ascii_case(word));
        let end = at + 1 + usize::from(words.get(at + 1).is_some_and(is_half));
        let time = words.drain(at..end).collect::<Vec<&str>>().join(" ");
        // "Sat Aug 22 03:15:00 UTC 2026"
        words.retain(|word| !without_universal(word).is_empty());
        return (words.join(" "), Some(time));
    }
    match words[..] {
        [day, ref time @ ..] if !time.is_empty() && day.len() >= 8 && bytes[0].is_ascii_digit() => {
            (day.to_owned(), Some(time.join(":")))
        }
        _ => (words.join(" "), None),
    }
}

/// Parses a date without a time. `is_of_standard` is true for a date of the FITS standard with slashes.
fn parse_day(text: &str, is_of_standard: bool, scale: TimeScale) -> DateText {
    // "22Aug2026"
    let mut spaced = String::new();
    for c in text.chars() {
        if spaced.ends_with(|last: char| last.is_ascii_digit() != c.is_ascii_digit()) {
            spaced.push(' ');
        }
        spaced.push(c);
    }
    let listed = |list: &str, word: &str| {
        list.split(' ').position(|name| word.get(..3).is_some_and(|start| start.eq_ignore_ascii_case(name)))
    };
    // Numbers with the count of their digits.
    let (mut numbers, mut month): (Vec<(usize, u32)>, Option<u32>) = (Vec::new(), None);
    for word in spaced.split(['-', '/', '.', ':', ',', ' ']).filter(|word| !word.is_empty()) {
        match (word.parse(), listed(MONTHS, word)) {
            (Ok(number), _) => numbers.push((word.len(), number)),
            (_, Some(name)) if month.is_none() => month = Some(name as u32 + 1),
            _ if listed(WEEKDAYS, word).is_some() => {}
            _ => return DateText::Unreadable,
        }
    }
    let exists = |day: &[u32; 3]| at(*day, [0, 0], 0.0, scale).is_some();
    let one = |date: Option<[u32; 3]>| date.filter(exists).map_or(DateText::Unreadable, DateText::Day);
    let (orders, digits) = match (&numbers[..], month) {
        (&[(8, date)], None) => return one(Some([date / 10_000, date / 100 % 100, date % 100])),
        (&[(7, date)], None) => return one(day_of_year(date / 1000, date % 1000, scale)),
        // "2026.234" is a decimal year.
        (&[(4, year), (3, day)], None) if !text.contains('.') => return one(day_of_year(year, day, scale)),
        (&[(4, year), (1 | 2, month), (1 | 2, day)], None) | (&[(4, year), (1 | 2, day)], Some(month)) => {
            return one(Some([year, month, day]));
        }
        (&[(1 | 2, day), (digits @ 1..=4, year)], Some(month)) => (vec![[year, month, day]], digits),
        (&[(1 | 2, a), (1 | 2, b), (digits @ 1..=4, year)], None) => (vec![[year, b, a], [year, a, b]], digits),
        _ => return DateText::Unreadable,
    };
    let is_short = digits < 4;
    let full = |[year, month, day]: [u32; 3]| [if is_short { 1900 + year } else { year }, month, day];
    let readings = orders.into_iter().map(full).filter(|day| exists(day) && day[0] >= FIRST_YEAR);
    let mut readings: Vec<[u32; 3]> = readings.collect();
    readings.dedup();
    match readings[..] {
        [date] => DateText::Day(date),
        [date, _] if is_short && is_of_standard => DateText::Day(date),
        _ => DateText::Unclear,
    }
}

/// Returns the date of a day of the year, as in `2026-234`.
fn day_of_year(year: u32, day: u32, scale: TimeScale) -> Option<[u32; 3]> {
    // Noon, because a day may have a leap second.
    let noon = seconds_after(at([year, 1, 1], [12, 0], 0.0, scale)?, (f64::from(day) - 1.0) * DAY_S);
    let (found, month, day, ..) = noon.to_gregorian(scale);
    (u32::try_from(found) == Ok(year)).then_some([year, month.into(), day.into()])
}

/// Parses `hh:mm:ss.sss`, also with a decimal comma, AM or PM, and other signs or none between the numbers, as in
/// `03h15m00s`, `03 15 00` and `031500`. Returns hours and minutes, and the seconds with their fraction.
pub(super) fn parse_time(text: &str) -> Option<([u32; 2], f64)> {
    let lower = without_universal(text).to_ascii_lowercase().replace(',', ".");
    let half = ["am", "pm"].iter().position(|half| lower.ends_with(half));
    let mut text = lower.trim_end_matches(['a', 'p', 'm', ' ']).to_owned();
    if !text.contains(':') {
        let is_basic = text.len() >= 6 && text.split('.').next().is_some_and(|digits| digits.len() == 6);
        text = if is_basic && text.is_char_boundary(2) && text.is_char_boundary(4) {
            format!("{}:{}:{}", &text[..2], &text[2..4], &text[4..])
        } else if text.matches('.').count() == 2 {
            text.replace('.', ":")
        } else {
            let numbers = text.trim_end_matches('s').split(['h', 'm', ' ', '-']).map(str::trim);
            numbers
                .enumerate()
                .filter(|(at, number)| *at == 0 || !number.is_empty())
                .map(|(_, number)| number)
                .collect::<Vec<_>>()
                .join(":")
        };
        if text.matches(':').count() != 2 {
            return None;
        }
    }
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [hours, minutes, ref rest @ ..] = parts[..] else { return None };
    let seconds = match rest {
        [] => 0.0,
        [seconds] => seconds.parse::<f64>().ok()?,
        _ => return None,
    };
    let hours = match (hours.parse::<u32>().ok()?, half) {
        (12, Some(0)) => 0,
        (hours @ 1..12, Some(1)) => hours + 12,
        (hours @ 1..12, Some(0)) | (hours @ 12..24, Some(1)) | (hours, None) => hours,
        // "0:15 PM", "13:15 AM"
        _ => return None,
    };
    let clock = [hours, minutes.parse().ok()?];
    let is_end_of_day = clock == [24, 0] && seconds == 0.0;
    let exists = clock[0] < 24 && clock[1] < 60 && (0.0..61.0).contains(&seconds);
    (exists || is_end_of_day).then_some((clock, seconds))
}

/// Returns the epoch of a date and a time; `None` for a date that does not exist. 24:00:00 is 0 h of the next day.
pub(super) fn at(day: [u32; 3], clock: [u32; 2], seconds: f64, scale: TimeScale) -> Option<Epoch> {
    if clock[0] == 24 {
        // Noon, because a day may have a leap second.
        let (year, month, day, ..) = seconds_after(at(day, [12, 0], 0.0, scale)?, DAY_S).to_gregorian(scale);
        return at([u32::try_from(year).ok()?, month.into(), day.into()], [0, 0], 0.0, scale);
    }
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

/// Returns the beginning of a day that is after a start, such as the last night of a stack.
pub(super) fn late_day(start: Epoch, day: [u32; 3], scale: TimeScale) -> Option<Epoch> {
    at(day, [0, 0], 0.0, scale).filter(|midnight| *midnight > start)
}

/// Returns the epoch of a time of day that is within half a day of a start.
pub(super) fn near(start: Epoch, time: &str, scale: TimeScale) -> Option<Epoch> {
    let (clock, seconds) = parse_time(time)?;
    let (year, month, day, ..) = start.to_gregorian(scale);
    let epoch = at([u32::try_from(year).ok()?, month.into(), day.into()], clock, seconds, scale)?;
    let late_days = (seconds_between(epoch, start) / DAY_S).round();
    Some(seconds_after(epoch, late_days * DAY_S))
}

/// Returns the error of a value that cannot be read.
pub(super) fn unreadable(keyword: String, value: &str, allowed: &str) -> Error {
    Error::invalid(keyword, format!("{value:?}"), allowed)
}

/// Headers in order of precedence: first the header of the image, then the primary header.
#[derive(Copy, Clone)]
pub(super) struct Keywords<'a>(pub &'a [&'a Header]);

impl<'a> Keywords<'a> {
    /// Returns the cards of all headers. A header that is given twice, that of an image in the primary HDU, is read
    /// once.
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

    /// Returns the spellings of a keyword that are in the headers, as [`find`](Self::find) reads them.
    pub fn spellings(self, keyword: &str) -> Vec<String> {
        let names = [keyword.to_owned(), keyword.replace('-', "_"), keyword.replace('-', "")];
        names.into_iter().filter(|name| self.0.iter().any(|header| header.contains(name))).collect()
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

    /// Returns the different texts of a keyword in the headers.
    pub fn texts(self, keyword: &str) -> Vec<String> {
        let mut texts: Vec<String> = Vec::new();
        for header in self.0 {
            let text = Keywords(std::slice::from_ref(header)).text(&[keyword]).map(|(_, text)| text);
            texts.extend(text.filter(|text| !texts.contains(text)));
        }
        texts
    }

    /// Returns a sentence about a keyword that has different values in the headers, of which the first is used. A date
    /// may be without its time in one of them.
    pub fn difference(self, keyword: &str) -> Option<String> {
        let value = |header: &&Header| match (header.number(keyword), header.text(keyword)) {
            (Some(number), _) => Some(number.to_string()),
            (None, text) => text.map(|text| format!("{:?}", text.trim())),
        };
        let values: Vec<String> = self.0.iter().filter_map(value).collect();
        let [first, other] = [values.first()?, values.last()?];
        let [first_text, other_text] = [first, other].map(|text| text.trim_matches('"'));
        let is_same = if first.starts_with('"') {
            first_text.starts_with(other_text) || other_text.starts_with(first_text)
        } else {
            first == other
        };
        (!is_same).then(|| {
            format!(
                "{keyword} is {first} in the header of the image, and {other} in the primary header: the first is used"
            )
        })
    }

    /// Returns the comment of a card; without one, that of the card with this value in another header.
    pub fn remark(self, header: &Header, name: &str) -> String {
        let own = header.comment(name);
        if !own.is_empty() {
            return own;
        }
        let value = header.card(name).and_then(Card::value);
        let is_same = |other: &&&Header| other.card(name).and_then(Card::value) == value;
        let others = self.0.iter().filter(is_same).map(|other| other.comment(name));
        others.into_iter().find(|comment| !comment.is_empty()).unwrap_or_default()
    }

    /// Returns the comment of a keyword, with the COMMENT cards that begin with its name.
    pub fn comment(self, header: &Header, name: &str) -> Comment {
        let mut text = self.remark(header, name);
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
            let comment = self.remark(header, &name);
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
            "Mar 6, 2020 00:04:15.410235",
            "06Mar2020 12:04:15.410235 AM",
            "Fri Mar  6 00:04:15.410235 2020",
            "Fri, 6 March 2020 00:04:15.410235 GMT",
            "2020-066T00:04:15.410235",
            "2020:066:00:04:15.410235",
            "2020066T000415.410235",
            "2020-03-06 00 04 15.410235",
            "2020-03-06T00h04m15.410235s",
            "2020-03-05 17:04:15.410235 UTC-7",
            "2020-03-06 00:04:15.410235 [UTC]",
            "Fri Mar 06 00:04:15.410235 UTC 2020",
            "00:04:15.410235 2020-03-06",
            "00:04:15.410235 GMT 06 Mar 2020",
            "20200306-000415.410235",
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
            ("2024-366", [2024, 12, 31]),
        ] {
            assert_eq!(at(text), DateText::Day(day), "{text}");
        }
        assert_eq!(parse_date("05/06/92", TimeScale::UTC), DateText::Unclear);
        for text in ["2026-08-22T03:15:00 UTC", "2026-08-22_03:15:00+02:00", "2026-08-22T03:15:00z"] {
            assert!(has_zone(text), "{text}");
        }
        assert!(!has_zone(" 2026-08-22T03:15:00"));
        for text in ["06/03/2020", "06.03.2020 00:04:15", "20-12-09", "26/10/20", "05-06-92", "22-Aug-26"] {
            assert_eq!(at(text), DateText::Unclear, "{text}");
        }
        for text in [
            "",
            "yesterday",
            "2020-13-01",
            "2020-02-30",
            "2020-03-06T25:00:00",
            "2020-03-06T00:61:00",
            "2020-03",
            "2023-366",
            "2020.066",
            "2020-03-06T24:00:01",
            "2020-03-06 0:15:00 PM",
            "2020-03-06 late",
            "Mar Apr 2020",
        ] {
            assert_eq!(at(text), DateText::Unreadable, "{text}");
        }
        assert_eq!(parse_time("19:36:37.5"), Some(([19, 36], 37.5)));
        for text in ["2020-03-05T24:00:00", "2020-03-06 0:00:00", "24:00:00 2020-03-05"] {
            assert_eq!(at(text), DateText::Moment(Epoch::from_gregorian_utc(2020, 3, 6, 0, 0, 0, 0)), "{text}");
        }
        assert_eq!(parse_time("3h 15m 0s"), Some(([3, 15], 0.0)));
        assert_eq!(parse_time("3 h 15 m 0.5 s"), Some(([3, 15], 0.5)));
        assert_eq!(parse_time("13:15:00 PM"), Some(([13, 15], 0.0)));
        assert_eq!(parse_time("19:36"), Some(([19, 36], 0.0)));
        for (text, clock) in
            [("7:36:37 PM", [19, 36]), ("12:36:37am", [0, 36]), ("19 36 37", [19, 36]), ("193637", [19, 36])]
        {
            assert_eq!(parse_time(text), Some((clock, 37.0)), "{text}");
        }
        for text in ["70577.1", "19h36", "-19 36 37", "late", "3.25", "0:15:00 PM", "13:15:00 AM", "0:15:00 am"] {
            assert_eq!(parse_time(text), None, "{text}");
        }
    }
}
