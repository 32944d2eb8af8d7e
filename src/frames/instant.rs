//! Parsing of times. A bare number, or a time without `Z` or offset, requires a time scale.

use hifitime::{Epoch, TimeScale, Unit, is_gregorian_valid};

use super::error;
use super::time::{epoch_from_jd, epoch_from_mjd};
use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

/// First supported year: that of the first satellite.
pub const FIRST_YEAR: i32 = 1957;
/// Last supported year. SOFA's ephemeris of the Earth, `epv00`, is valid from 1900 to 2100.
pub const LAST_YEAR: i32 = 2099;

/// Smallest bare number that is read as a Julian date; smaller ones are modified Julian dates (MJD 10^6 is the year
/// 4596, JD 10^6 is 1976 BC).
const FIRST_JD: f64 = 1e6;

/// Parses an ISO 8601 time or, with a scale, a bare MJD or JD.
///
/// # Errors
/// The errors of [`parse_instant`], and a bare number outside the range of Julian dates.
pub fn parse_moment(text: &str, scale: Option<TimeScale>) -> Result<Epoch, Error> {
    match (text.trim().parse::<f64>(), scale) {
        (Ok(number), Some(scale)) if number < FIRST_JD => Ok(epoch_from_mjd(number, scale)?),
        (Ok(number), Some(scale)) => Ok(epoch_from_jd(number, scale)?),
        (Ok(_), None) => Err(error::no_scale(text)),
        (Err(_), _) => parse_instant(text, scale),
    }
}

/// Parses the start of an exposure: a moment with the time of day.
///
/// # Errors
/// The errors of [`parse_moment`], and a date without a time.
pub fn parse_start(text: &str, scale: Option<TimeScale>) -> Result<Epoch, Error> {
    let start = parse_moment(text, scale)?;
    if text.trim().parse::<f64>().is_err() {
        check_time_of_day(text)?;
    }
    Ok(start)
}

/// Checks that a valid ISO 8601 text is not a date alone, which would be read as midnight.
///
/// # Errors
/// It has no time of day.
pub fn check_time_of_day(text: &str) -> Result<(), Error> {
    if text.contains(':') { Ok(()) } else { Err(error::without_time_of_day(text)) }
}

/// Parses an ISO 8601 time such as `2024-08-14T00:30:00.000Z`. A blank may replace the `T`, and an offset such as
/// `+02:00` the `Z`; seconds and their fraction are optional.
///
/// Without `Z` or offset the time is taken to be in `scale`. Second 60 is valid only in a leap second of UTC.
///
/// # Errors
/// - The text has another form, or a field is out of range.
/// - A second 60 is given without a leap second.
/// - There is no `Z`, no offset and no `scale`.
pub fn parse_instant(text: &str, scale: Option<TimeScale>) -> Result<Epoch, Error> {
    let text = text.trim();
    let (body, offset_minutes) = split_zone(text)?;
    let scale = match (offset_minutes, scale) {
        (Some(_), _) => TimeScale::UTC,
        (None, Some(scale)) => scale,
        (None, None) => {
            // An invalid text is reported as invalid. The missing scale is reported only for valid times and numbers.
            if body.parse::<f64>().is_err() {
                calendar(text, body)?;
            }
            return Err(error::no_scale(text));
        }
    };
    let fields = calendar(text, body)?;
    let is_leap = fields.second == 60;
    let nanoseconds = fields.nanoseconds_of_day - if is_leap { 1_000_000_000 } else { 0 };
    let midnight = Epoch::from_gregorian_at_midnight(fields.year, fields.month, fields.day, scale);
    let epoch = midnight + Unit::Nanosecond * nanoseconds - Unit::Minute * i64::from(offset_minutes.unwrap_or(0));
    if is_leap { leap_second(epoch, text) } else { Ok(epoch) }
}

/// Returns the time one second after second 59 of a minute with a leap second.
fn leap_second(second_59: Epoch, text: &str) -> Result<Epoch, Error> {
    let missing = || error::no_leap_second(text);
    if second_59.time_scale != TimeScale::UTC {
        return Err(missing());
    }
    let second = Unit::Second * 1_i64;
    let here = second_59.to_time_scale(TimeScale::TAI);
    let next = (second_59 + second).to_time_scale(TimeScale::TAI);
    if next - here > second { Ok(here + second) } else { Err(missing()) }
}

/// Returns true for a text that ends in `Z` or an offset from UTC, whether or not the time is valid.
pub(crate) fn has_zone(text: &str) -> bool {
    split_zone(text.trim()).is_ok_and(|(_, offset_minutes)| offset_minutes.is_some())
}

/// Returns the text without `Z` or offset, and the offset in minutes; `None` without a zone.
fn split_zone(text: &str) -> Result<(&str, Option<i32>), Error> {
    if let Some(body) = text.strip_suffix(['Z', 'z']) {
        return Ok((body.trim_end(), Some(0)));
    }
    // Hyphens before the T belong to the date, so a sign is searched only after the T.
    let Some(time_at) = text.find(['T', 't', ' ']) else { return Ok((text, None)) };
    let Some(sign_at) = text[time_at..].find(['+', '-']).map(|at| at + time_at) else { return Ok((text, None)) };
    let digits: String = text[sign_at + 1..].chars().filter(|c| *c != ':').collect();
    let not_a_time = || error::not_a_time(text);
    if !matches!(digits.len(), 2 | 4) || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(not_a_time());
    }
    let hours: i32 = digits[..2].parse().map_err(|_| not_a_time())?;
    let minutes: i32 = if digits.len() == 4 { digits[2..].parse().map_err(|_| not_a_time())? } else { 0 };
    let sign = if text.as_bytes()[sign_at] == b'-' { -1 } else { 1 };
    let offset_minutes = sign * (hours * 60 + minutes);
    if minutes > 59 || !(-12 * 60..=14 * 60).contains(&offset_minutes) {
        return Err(error::no_offset(text, &text[sign_at..]));
    }
    Ok((&text[..sign_at], Some(offset_minutes)))
}

struct Calendar {
    year: i32,
    month: u8,
    day: u8,
    nanoseconds_of_day: i64,
    second: u32,
}

fn calendar(text: &str, body: &str) -> Result<Calendar, Error> {
    let not_a_time = || error::not_a_time(text);
    let (date, time) = body.split_once(['T', 't', ' ']).unwrap_or((body, "00:00:00"));
    let mut date_parts = date.split('-');
    let year = number(date_parts.next(), 4).ok_or_else(not_a_time)?;
    let month = number(date_parts.next(), 2).ok_or_else(not_a_time)?;
    let day = number(date_parts.next(), 2).ok_or_else(not_a_time)?;
    let (clock, fraction) = time.split_once('.').unwrap_or((time, ""));
    let mut clock_parts = clock.split(':');
    let hour = number(clock_parts.next(), 2).ok_or_else(not_a_time)?;
    let minute = number(clock_parts.next(), 2).ok_or_else(not_a_time)?;
    let second = match clock_parts.next() {
        Some(text) => number(Some(text), 2).ok_or_else(not_a_time)?,
        None if fraction.is_empty() => 0,
        None => return Err(not_a_time()),
    };
    if date_parts.next().is_some() || clock_parts.next().is_some() {
        return Err(not_a_time());
    }
    if !fraction.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(not_a_time());
    }
    let out_of_range = |field, value, allowed| {
        Error::new(ErrorKind::Invalid, format!("invalid time '{}': {field} {value} is out of range", Quoted::new(text)))
            .allowing(allowed)
    };
    if !(1..=12).contains(&month) {
        return Err(out_of_range("month", month, "1 to 12"));
    }
    if !is_gregorian_valid(year as i32, month as u8, day as u8, 0, 0, 0, 0) {
        return Err(out_of_range("day", day, "the days of the month"));
    }
    if hour > 23 {
        return Err(out_of_range("hour", hour, "0 to 23"));
    }
    if minute > 59 {
        return Err(out_of_range("minute", minute, "0 to 59"));
    }
    if second > 60 {
        return Err(out_of_range("second", second, "0 to 59, and 60 in a leap second"));
    }
    // Nine digits are nanoseconds; further digits are ignored.
    let digits: String = fraction.chars().chain("000000000".chars()).take(9).collect();
    let nanoseconds: i64 = digits.parse().map_err(|_| not_a_time())?;
    Ok(Calendar {
        year: year as i32,
        month: month as u8,
        day: day as u8,
        nanoseconds_of_day: i64::from(hour * 3600 + minute * 60 + second) * 1_000_000_000 + nanoseconds,
        second,
    })
}

/// Parses exactly `digits` decimal digits.
fn number(text: Option<&str>, digits: usize) -> Option<u32> {
    text.filter(|text| text.len() == digits && text.bytes().all(|byte| byte.is_ascii_digit()))?.parse().ok()
}

/// Returns true for times from 1957 to the end of 2099, UTC, the years that this library supports.
pub fn is_covered(epoch: Epoch) -> bool {
    let year_start = |year| Epoch::from_gregorian_utc_at_midnight(year, 1, 1);
    (year_start(FIRST_YEAR)..year_start(LAST_YEAR + 1)).contains(&epoch)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(hour: u8, minute: u8, second: u8, nanoseconds: u32) -> Epoch {
        Epoch::from_gregorian_utc(2024, 8, 14, hour, minute, second, nanoseconds)
    }

    #[test]
    fn forms_of_one_moment() {
        for text in [
            "2024-08-14T00:30:00.000Z",
            "2024-08-14T00:30:00Z",
            "2024-08-14 00:30Z",
            " 2024-08-14t00:30:00.000000000999z ",
            "2024-08-14T02:30:00+02:00",
            "2024-08-13T20:00:00-0430",
            "2024-08-14T00:30:00+00",
        ] {
            assert_eq!(parse_instant(text, None).unwrap(), at(0, 30, 0, 0), "{text}");
        }
        assert_eq!(parse_instant("2024-08-14Z", None).unwrap(), at(0, 0, 0, 0));
    }

    #[test]
    fn offsets_are_those_of_clocks() {
        for text in ["2024-08-14T14:30+14:00", "2024-08-13T12:30-12:00"] {
            assert_eq!(parse_instant(text, None).unwrap(), at(0, 30, 0, 0), "{text}");
        }
        for offset in ["+14:30", "-12:01", "+99", "+01:60"] {
            let message = parse_instant(&format!("2024-08-14T00:30{offset}"), None).unwrap_err().to_string();
            let expected = format!("offset {offset} from UTC is out of range; allowed: -12:00 to +14:00");
            assert!(message.ends_with(&expected), "{message}");
        }
    }

    #[test]
    fn starts_have_a_time_of_day() {
        for text in ["2024-08-14T00:30Z", "2024-08-14 00:30:00", "60536.0208333333333", "2460536.5208333333"] {
            let error_s = (parse_start(text, Some(TimeScale::UTC)).unwrap() - at(0, 30, 0, 0)).to_seconds();
            assert!(error_s.abs() < 1e-3, "{text}: {error_s}");
        }
        for text in ["2024-08-14", "2024-08-14Z", "2024-08-14 Z"] {
            let error = parse_start(text, Some(TimeScale::UTC)).unwrap_err().to_string();
            assert!(error.contains("allowed: a date with the time of day"), "{error}");
        }
    }

    #[test]
    fn scales_differ_by_their_seconds() {
        let in_scale = |scale| parse_instant("2024-08-14T00:30:00.000", Some(scale)).unwrap();
        assert_eq!(in_scale(TimeScale::UTC), at(0, 30, 0, 0));
        assert_eq!(in_scale(TimeScale::TAI), at(0, 29, 23, 0));
        assert_eq!(in_scale(TimeScale::TT), at(0, 28, 50, 816_000_000));
    }

    #[test]
    fn bare_dates_need_a_scale() {
        for text in ["60536.25", "2460536.75"] {
            assert_eq!(parse_moment(text, None).unwrap_err().kind(), ErrorKind::NoTimeScale, "{text}");
            let moment = parse_moment(text, Some(TimeScale::TAI)).unwrap();
            assert!((moment - at(5, 59, 23, 0)).abs() < Unit::Microsecond * 1_i64, "{moment}");
        }
        assert!(parse_moment("nan", Some(TimeScale::UTC)).is_err());
    }

    #[test]
    fn a_time_without_scale_is_rejected_with_the_reason() {
        for text in ["2024-08-14T00:30:00", "60536.02", "2460536.52"] {
            let error = parse_instant(text, None).unwrap_err();
            assert_eq!((error.kind(), error.given()), (ErrorKind::NoTimeScale, Some(text)));
            assert!(error.to_string().contains("37 s"), "{error}");
        }
    }

    #[test]
    fn leap_seconds_are_a_second_of_their_own() {
        let sixty = parse_instant("2016-12-31T23:59:60.25Z", None).unwrap();
        let before = parse_instant("2016-12-31T23:59:59.25Z", None).unwrap().to_time_scale(TimeScale::TAI);
        let after = parse_instant("2017-01-01T00:00:00.25Z", None).unwrap().to_time_scale(TimeScale::TAI);
        assert_eq!((sixty - before, after - sixty), (Unit::Second * 1_i64, Unit::Second * 1_i64));
        for text in ["2024-08-14T23:59:60Z", "2016-12-31T22:59:60Z"] {
            assert_eq!(parse_instant(text, None).unwrap_err().to_string(), error::no_leap_second(text).to_string());
        }
        assert!(parse_instant("2016-12-31T23:59:60", Some(TimeScale::TAI)).is_err());
    }

    #[test]
    fn invalid_times_are_rejected() {
        for text in [
            "",
            "now",
            "2024-08-14T",
            "2024-8-14T00:00:00Z",
            "2024-13-01T00:00:00Z",
            "2023-02-29T00:00:00Z",
            "2024-08-14T24:00:00Z",
            "2024-08-14T00:60:00Z",
            "2024-08-14T00:00:61Z",
            "2024-08-14T00:00.5Z",
            "2024-08-14T00:00:00.x5Z",
            "2024-08-14T00:00:00+1",
            "2024-08-14-01T00:00:00Z",
            "ünï-08-14T00:00:00Z",
        ] {
            assert!(parse_instant(text, Some(TimeScale::UTC)).is_err(), "{text}");
        }
    }

    #[test]
    fn coverage_ends_with_the_ephemeris() {
        for (text, covered) in [
            ("1956-12-31T00:00:00Z", false),
            ("1957-10-04T19:28:34Z", true),
            ("2099-12-31T00:00:00Z", true),
            ("2100-06-01T00:00:00Z", false),
        ] {
            assert_eq!(is_covered(parse_instant(text, None).unwrap()), covered, "{text}");
        }
    }
}
