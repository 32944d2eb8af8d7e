//! Parsing of the UTC epochs of element sets: a year with a fractional day, or an ISO 8601 date.
//!
//! Times are whole nanoseconds, so that the same instant in two syntaxes gives the same `Epoch`. A day has 86,400 s, as
//! in SGP4 and its element sets: an epoch within a leap second (23:59:60) is read as the first second of the next day.

use hifitime::{Duration, Epoch, TimeScale};

/// Nanoseconds in a day of 86,400 s.
pub(super) const DAY_NS: i64 = 86_400_000_000_000;

/// Returns the days from 1900-01-01, the zero point of hifitime's UTC, to the first day of a Gregorian month.
fn days_to_month(year: i32, month: u32) -> i64 {
    // Years are counted from March, so that the leap day is the last day; five months from March have 153 days.
    let (shifted_year, shifted_month) =
        if month > 2 { (i64::from(year), month - 3) } else { (i64::from(year) - 1, month + 9) };
    let (era, year_of_era) = (shifted_year.div_euclid(400), shifted_year.rem_euclid(400));
    let day_of_year = i64::from((153 * shifted_month + 2) / 5);
    // 693,901 days from 0000-03-01 to 1900-01-01.
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 693_901
}

/// Returns true for a leap year.
pub(super) fn is_leap(year: i32) -> bool {
    year % 4 == 0 && (year % 100 != 0 || year % 400 == 0)
}

/// Returns the number of days in a month (1-12).
fn days_in_month(year: i32, month: u32) -> u32 {
    match month {
        2 if is_leap(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Returns the time `nanosecond` ns after the start of day `day_of_year` (1 is 1 January; larger values may extend into
/// the next year).
pub(super) fn from_day_of_year(year: i32, day_of_year: i64, nanosecond: i64) -> Epoch {
    let days = days_to_month(year, 1) + day_of_year - 1;
    let total = i128::from(days) * i128::from(DAY_NS) + i128::from(nanosecond);
    Epoch::from_duration(Duration::from_total_nanoseconds(total), TimeScale::UTC)
}

/// Returns the year of an epoch, its day of the year (1 is 1 January) and the nanosecond of that day, in UTC.
pub(super) fn to_day_of_year(epoch: Epoch) -> (i32, i64, i64) {
    let total = epoch.to_utc_duration().total_nanoseconds();
    let days = total.div_euclid(i128::from(DAY_NS)) as i64;
    let nanosecond = total.rem_euclid(i128::from(DAY_NS)) as i64;
    let mut year = 1900 + days.div_euclid(366) as i32;
    while days_to_month(year + 1, 1) <= days {
        year += 1;
    }
    (year, days - days_to_month(year, 1) + 1, nanosecond)
}

/// Parses `2026-07-08T17:37:14.092032` or `2007-064T10:34:41.4264` (day of year); a blank may replace the `T`, and a
/// `Z` may follow.
///
/// Digits beyond nanoseconds are ignored. Returns `None` for other text or an invalid date.
pub(crate) fn parse_iso(text: &str) -> Option<Epoch> {
    let bytes = text.trim().as_bytes();
    let bytes = bytes.strip_suffix(b"Z").unwrap_or(bytes);
    let split = bytes.iter().position(|&byte| byte == b'T' || byte == b' ');
    let (date, time) = match split {
        Some(at) => (&bytes[..at], &bytes[at + 1..]),
        None => (bytes, &b"00:00:00"[..]),
    };
    let (year, day_of_year) = match date {
        [year @ .., b'-', m1, m2, b'-', d1, d2] if year.len() == 4 => {
            let (year, month, day) = (digits(year)? as i32, digits(&[*m1, *m2])?, digits(&[*d1, *d2])?);
            if !(1..=12).contains(&month) || day < 1 || day > days_in_month(year, month) {
                return None;
            }
            (year, days_to_month(year, month) - days_to_month(year, 1) + i64::from(day))
        }
        [year @ .., b'-', d1, d2, d3] if year.len() == 4 => {
            let (year, day) = (digits(year)? as i32, digits(&[*d1, *d2, *d3])?);
            if day < 1 || day > 365 + u32::from(is_leap(year)) {
                return None;
            }
            (year, i64::from(day))
        }
        _ => return None,
    };
    Some(from_day_of_year(year, day_of_year, nanosecond_of_day(time)?))
}

/// Parses a date and time as [`parse_iso`]; `None` for a date alone.
pub(super) fn parse_iso_with_time(text: &str) -> Option<Epoch> {
    (text.trim().contains(['T', ' ']) && text.matches(':').count() == 2).then(|| parse_iso(text)).flatten()
}

/// Parses `17:37:14.092032` as nanoseconds after midnight.
fn nanosecond_of_day(time: &[u8]) -> Option<i64> {
    let [h1, h2, b':', m1, m2, rest @ ..] = time else { return None };
    let (hour, minute) = (digits(&[*h1, *h2])?, digits(&[*m1, *m2])?);
    let (second, fraction) = match rest {
        [] => (0, &[][..]),
        [b':', s1, s2] => (digits(&[*s1, *s2])?, &[][..]),
        [b':', s1, s2, b'.', fraction @ ..] => (digits(&[*s1, *s2])?, fraction),
        _ => return None,
    };
    if hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let mut nanosecond = 0;
    let mut unit = 100_000_000;
    for &byte in fraction {
        if !byte.is_ascii_digit() {
            return None;
        }
        nanosecond += unit * i64::from(byte - b'0');
        unit /= 10;
    }
    Some((i64::from(hour) * 3600 + i64::from(minute) * 60 + i64::from(second)) * 1_000_000_000 + nanosecond)
}

/// Parses an unsigned number of at most nine digits.
pub(super) fn digits(bytes: &[u8]) -> Option<u32> {
    if bytes.is_empty() || bytes.len() > 9 {
        return None;
    }
    bytes.iter().try_fold(0, |value, byte| byte.is_ascii_digit().then(|| value * 10 + u32::from(byte - b'0')))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_dates_against_hifitime() {
        for year in [1957, 1999, 2000, 2001, 2024, 2026, 2100] {
            for month in 1..=12 {
                for day in [1, 15, days_in_month(year, month)] {
                    let expected = Epoch::from_gregorian_utc(year, month as u8, day as u8, 12, 34, 56, 789_000_001);
                    let text = format!("{year}-{month:02}-{day:02}T12:34:56.789000001");
                    assert_eq!(parse_iso(&text), Some(expected), "{text}");
                    let (y, day_of_year, nanosecond) = to_day_of_year(expected);
                    assert_eq!(y, year);
                    assert_eq!(from_day_of_year(y, day_of_year, nanosecond), expected);
                    let text = format!("{y}-{day_of_year:03} 12:34:56.789000001Z");
                    assert_eq!(parse_iso(&text), Some(expected), "{text}");
                }
            }
        }
    }

    #[test]
    fn verif_impossible_dates_are_rejected() {
        for text in [
            "",
            "T",
            "2026",
            "2026-13-01",
            "2026-02-29T00:00:00",
            "2025-366T00:00:00",
            "2026-00-10",
            "26-01-01",
            "2026-01-01T24:00:00",
            "2026-01-01T00:61:00",
            "2026-01-01T00:00:00.1x",
            "2026-01-01T00:00:00+01:00",
        ] {
            assert_eq!(parse_iso(text), None, "{text:?}");
        }
        assert_eq!(parse_iso("2016-12-31T23:59:60"), parse_iso("2017-01-01T00:00:00"));
    }
}
