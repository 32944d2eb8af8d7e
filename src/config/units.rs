//! Durations, angles and moments as people type them: a number with its unit.

use hifitime::{Epoch, TimeScale};

use crate::frames::{epoch_from_jd, epoch_from_mjd};
use crate::schedule::{InstantError, parse_instant};

use super::error::SetupError;

const DURATION_UNITS: &[(&str, f64)] =
    &[("ms", 1e-3), ("sec", 1.0), ("s", 1.0), ("min", 60.0), ("hours", 3600.0), ("hour", 3600.0), ("h", 3600.0)];
const ANGLE_UNITS: &[(&str, f64)] = &[
    ("degrees", 1.0),
    ("degree", 1.0),
    ("deg", 1.0),
    ("°", 1.0),
    ("arcmin", 1.0 / 60.0),
    ("'", 1.0 / 60.0),
    ("arcsec", 1.0 / 3600.0),
    ("\"", 1.0 / 3600.0),
];
/// Below this a bare number is a modified Julian date, from it on a Julian date (MJD 10^6 is the year 4596, JD 10^6 1976 BC).
const FIRST_JD: f64 = 1e6;

/// A length of time like `30s`, `30.0s`, `2.5min`, `1h`, seconds, 0 or more. A bare number is refused: it may be minutes.
///
/// # Errors
/// Another form, a unit that is not known, a number that is negative or not finite.
pub fn parse_duration_s(what: &'static str, text: &str) -> Result<f64, SetupError> {
    let allowed = "a number with its unit: 30s, 2.5min, 1h";
    let seconds = with_unit(what, text, DURATION_UNITS, allowed)?;
    in_range(what, seconds, "s", "0 s or more", |seconds| seconds >= 0.0)
}

/// An angle like `3.5deg`, `210arcmin`, `30arcsec`, degrees, above 0, at most 180. A bare number is refused: it may be a radius in other units.
///
/// # Errors
/// Another form, a unit that is not known, a number out of range.
pub fn parse_angle_deg(what: &'static str, text: &str) -> Result<f64, SetupError> {
    let allowed = "a number with its unit: 3.5deg, 210arcmin, 30arcsec";
    let degrees = with_unit(what, text, ANGLE_UNITS, allowed)?;
    in_range(what, degrees, "deg", "above 0 deg, at most 180 deg", |degrees| degrees > 0.0 && degrees <= 180.0)
}

fn with_unit(what: &'static str, text: &str, units: &[(&str, f64)], allowed: &'static str) -> Result<f64, SetupError> {
    let text = text.trim();
    if text.parse::<f64>().is_ok() {
        return Err(SetupError::NoUnit { what, given: text.to_owned(), allowed });
    }
    let found = units.iter().find_map(|(unit, factor)| {
        let number: f64 = text.strip_suffix(unit)?.trim_end().parse().ok()?;
        Some(number * factor)
    });
    found.filter(|value| value.is_finite()).ok_or_else(|| bad(what, text, allowed))
}

/// A number that is allowed; what is not a number is refused by every range.
pub(super) fn in_range(
    what: &'static str,
    value: f64,
    unit: &str,
    allowed: &'static str,
    is_allowed: impl Fn(f64) -> bool,
) -> Result<f64, SetupError> {
    if is_allowed(value) {
        return Ok(value);
    }
    Err(SetupError::OutOfRange { what, given: format!("{value} {unit}").trim_end().to_owned(), allowed })
}

fn bad(what: &'static str, given: &str, allowed: &'static str) -> SetupError {
    SetupError::Value { what, given: given.to_owned(), allowed }
}

/// A time scale by name: `utc`, `tai` or `tt`, in any case.
///
/// # Errors
/// Any other name.
pub fn parse_time_scale(text: &str) -> Result<TimeScale, SetupError> {
    match text.trim().to_ascii_lowercase().as_str() {
        "utc" => Ok(TimeScale::UTC),
        "tai" => Ok(TimeScale::TAI),
        "tt" => Ok(TimeScale::TT),
        _ => Err(bad("time scale", text, "utc, tai, tt")),
    }
}

/// A moment: ISO 8601, or, where a scale is said, a bare MJD or JD.
///
/// # Errors
/// As [`parse_instant`]; a number that is no date.
pub fn parse_moment(text: &str, scale: Option<TimeScale>) -> Result<Epoch, SetupError> {
    match (text.trim().parse::<f64>(), scale) {
        (Ok(number), Some(scale)) if number < FIRST_JD => Ok(epoch_from_mjd(number, scale)?),
        (Ok(number), Some(scale)) => Ok(epoch_from_jd(number, scale)?),
        (Ok(_), None) => Err(InstantError::NoScale(text.to_owned()).into()),
        (Err(_), _) => Ok(parse_instant(text, scale)?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::format_utc;

    #[test]
    fn durations_and_angles_carry_their_unit() {
        for (text, seconds) in [
            ("30s", 30.0),
            ("30.0s", 30.0),
            ("30 s", 30.0),
            ("2.5min", 150.0),
            ("1h", 3600.0),
            ("500ms", 0.5),
            ("0s", 0.0),
        ] {
            assert_eq!(parse_duration_s("exposure", text).unwrap(), seconds, "{text}");
        }
        for (text, degrees) in
            [("3.5deg", 3.5), ("210arcmin", 3.5), ("3600arcsec", 1.0), ("3.5 deg", 3.5), ("3.5°", 3.5)]
        {
            assert!((parse_angle_deg("fov", text).unwrap() - degrees).abs() < 1e-12, "{text}");
        }
    }

    #[test]
    fn bare_numbers_are_told_what_they_lack() {
        let message = parse_duration_s("exposure", "30").unwrap_err().to_string();
        assert_eq!(message, "exposure 30 has no unit; allowed: a number with its unit: 30s, 2.5min, 1h");
        for text in ["", "s", "30m", "30x", "-1s", "nan s", "infs", "1e400s"] {
            assert!(parse_duration_s("exposure", text).is_err(), "{text}");
        }
        for text in ["3.5", "0deg", "-1deg", "3.5rad", "nandeg"] {
            assert!(parse_angle_deg("fov", text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_out_of_range_is_told_the_range() {
        let message = |answer: Result<f64, SetupError>| answer.unwrap_err().to_string();
        assert_eq!(message(parse_duration_s("exposure", "-5s")), "exposure -5 s: allowed 0 s or more");
        for (text, given) in [("0deg", "0"), ("-1deg", "-1"), ("181deg", "181")] {
            let expected = format!("fov {given} deg: allowed above 0 deg, at most 180 deg");
            assert_eq!(message(parse_angle_deg("fov", text)), expected);
        }
    }

    #[test]
    fn bare_dates_need_a_scale() {
        for text in ["60536.25", "2460536.75"] {
            assert!(matches!(parse_moment(text, None), Err(SetupError::Instant(InstantError::NoScale(_)))), "{text}");
            let moment = parse_moment(text, Some(TimeScale::TAI)).unwrap();
            assert_eq!(format_utc(moment, 3), "2024-08-14T05:59:23.000Z");
        }
        assert!(parse_moment("nan", Some(TimeScale::UTC)).is_err());
    }
}
