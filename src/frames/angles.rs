//! Parsing of right ascensions and declinations in decimal degrees or sexagesimal form, and names of compass points.

use super::vector::{Direction, Gcrs};
use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

const RIGHT_ASCENSION: &str =
    "a right ascension; allowed: degrees from -180 to 360 (188.5), or hours as 12h34m56.7s or 12:34:56.7";
const DECLINATION: &str = "a declination; allowed: degrees from -90 to 90 (-30.5), or -30d12m34.5s or -30:12:34.5";

/// Parses a right ascension and returns degrees in [0, 360). A plain number is degrees; `12h34m56.7s`, `12h34m`,
/// `12:34:56.7` and `12 34 56.7` are hours; `188.5deg`, `188.5d` and `188d30m` are degrees. Degrees can be negative, to
/// -180, as in schedules.
///
/// # Errors
/// Text of another form, minutes or seconds of 60 or more, or an angle outside [-180, 360].
pub fn parse_right_ascension_deg(text: &str) -> Result<f64, Error> {
    let bad = || Error::new(ErrorKind::Invalid, format!("{:?} is not {}", Quoted::new(text), RIGHT_ASCENSION));
    let angle = parse(text).ok_or_else(bad)?;
    let factor = match angle.unit {
        Unit::Hours | Unit::Colons => 15.0,
        Unit::Degrees | Unit::Plain => 1.0,
    };
    let degrees = angle.value * factor;
    let limit_deg = match (angle.negative, factor == 1.0) {
        (false, _) => 360.0,
        (true, true) => 180.0,
        (true, false) => 0.0,
    };
    if degrees > limit_deg {
        return Err(bad());
    }
    let signed = if angle.negative { -degrees } else { degrees };
    let degrees = signed.rem_euclid(360.0);
    // The sum of 360 and a very small negative angle is rounded to 360.
    Ok(if degrees == 360.0 { 0.0 } else { degrees })
}

/// Parses a declination and returns degrees in [-90, 90]. A plain number is degrees; so are `-30d12m34.5s`,
/// `-30:12:34.5`, `-30 12 34.5` and `-30°12'34.5"`.
///
/// # Errors
/// Text of another form, hours, minutes or seconds of 60 or more, or an angle beyond the poles.
pub fn parse_declination_deg(text: &str) -> Result<f64, Error> {
    let bad = || Error::new(ErrorKind::Invalid, format!("{:?} is not {}", Quoted::new(text), DECLINATION));
    let angle = parse(text).ok_or_else(bad)?;
    if angle.unit == Unit::Hours || angle.value > 90.0 {
        return Err(bad());
    }
    Ok(if angle.negative { -angle.value } else { angle.value })
}

/// Parses an angle in degrees of any size: `47.37`, `47d22m12s`, `47:22:12` or `-47°22'12"`; `None` for other forms.
pub(crate) fn degrees_of(text: &str) -> Option<f64> {
    let angle = parse(text).filter(|angle| angle.unit != Unit::Hours)?;
    Some(if angle.negative { -angle.value } else { angle.value })
}

#[derive(Copy, Clone, PartialEq)]
enum Unit {
    Plain,
    Degrees,
    Hours,
    Colons,
}

struct Angle {
    negative: bool,
    value: f64,
    unit: Unit,
}

/// Parses a sign and up to three numbers separated by `h d ° : ' m " s` or blanks.
fn parse(text: &str) -> Option<Angle> {
    let text = text.trim().replace("deg", "d");
    let (negative, text) = match text.strip_prefix(['-', '−']) {
        Some(rest) => (true, rest),
        None => (false, text.strip_prefix('+').unwrap_or(&text)),
    };
    let mut unit = Unit::Plain;
    let mut numbers: Vec<&str> = Vec::new();
    let mut marks: Vec<char> = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        if end == 0 || numbers.len() == 3 {
            return None;
        }
        numbers.push(&rest[..end]);
        rest = &rest[end..];
        let after = rest.trim_start();
        let blank = after.len() < rest.len();
        match after.chars().next() {
            Some(mark @ ('h' | 'H' | 'd' | 'D' | '°' | ':' | 'm' | 'M' | '\'' | '′' | 's' | 'S' | '"' | '″')) => {
                marks.push(mark);
                rest = after[mark.len_utf8()..].trim_start();
                // A colon separates two numbers and cannot end the text.
                if mark == ':' && rest.is_empty() {
                    return None;
                }
            }
            Some(digit) if blank && digit.is_ascii_digit() => {
                marks.push(':');
                rest = after;
            }
            Some(_) => return None,
            None => rest = after,
        }
    }
    for (index, mark) in marks.iter().enumerate() {
        match (index, mark) {
            (0, 'h' | 'H') => unit = Unit::Hours,
            (0, 'd' | 'D' | '°') => unit = Unit::Degrees,
            (0, ':') => unit = Unit::Colons,
            (1, ':') if unit == Unit::Colons => {}
            (1, 'm' | 'M' | '\'' | '′') if unit != Unit::Colons => {}
            (2, 's' | 'S' | '"' | '″') if unit != Unit::Colons => {}
            _ => return None,
        }
    }
    let mut value = 0.0;
    for (index, number) in numbers.iter().enumerate() {
        let part: f64 = number.parse().ok()?;
        let last = index + 1 == numbers.len();
        // Only the last number may have a fraction, and minutes and seconds are below 60.
        if (!last && number.contains('.')) || (index > 0 && part >= 60.0) {
            return None;
        }
        value += part / [1.0, 60.0, 3600.0][index];
    }
    (!numbers.is_empty()).then_some(Angle { negative, value, unit })
}

/// Parses a direction from a right ascension and a declination, as [`parse_right_ascension_deg`] and
/// [`parse_declination_deg`] do.
///
/// # Errors
/// A text has another form, or a value is out of range.
pub fn parse_direction(ra: &str, dec: &str) -> Result<Direction<Gcrs>, Error> {
    Ok(Direction::from_lon_lat_rad(
        parse_right_ascension_deg(ra)?.to_radians(),
        parse_declination_deg(dec)?.to_radians(),
    ))
}

/// Returns the nearest of the 16 compass points, for example `NNE`, for an azimuth in radians.
pub fn compass(azimuth_rad: f64) -> &'static str {
    const POINTS: [&str; 16] =
        ["N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE", "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"];
    let point = (azimuth_rad.rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU * 16.0).round();
    POINTS[point as usize % 16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_the_compass() {
        for (degrees, point) in [
            (0.0, "N"),
            (11.2, "N"),
            (11.3, "NNE"),
            (95.0, "E"),
            (236.0, "SW"),
            (284.0, "WNW"),
            (359.0, "N"),
            (-90.0, "W"),
        ] {
            assert_eq!(compass(f64::to_radians(degrees)), point, "{degrees}");
        }
    }

    #[test]
    fn right_ascensions() {
        let expected = (12.0 + 34.0 / 60.0 + 56.7 / 3600.0) * 15.0;
        for text in ["12h34m56.7s", "12:34:56.7", "12 34 56.7", "12h 34m 56.7s", "+12H34M56.7S", "12h34m56.7"] {
            let degrees = parse_right_ascension_deg(text).expect(text);
            assert!((degrees - expected).abs() < 1e-12, "{text}: {degrees}");
        }
        for (text, degrees) in [
            ("188.5", 188.5),
            ("188d30m", 188.5),
            ("188.5deg", 188.5),
            ("188.5d", 188.5),
            ("12h34m", 188.5),
            ("0", 0.0),
            ("360", 0.0),
            ("24h", 0.0),
            ("-10", 350.0),
            ("-180", 180.0),
            ("-0.00000000000000000001", 0.0),
            ("1e1", f64::NAN),
        ] {
            match parse_right_ascension_deg(text) {
                Ok(value) => assert!((value - degrees).abs() < 1e-12, "{text}: {value}"),
                Err(_) => assert!(degrees.is_nan(), "{text}"),
            }
        }
        for text in [
            "",
            "-180.1",
            "-1h",
            "361",
            "25h",
            "12h60m",
            "12h34.5m10s",
            "nan",
            "inf",
            "12:",
            "12h34x",
            "1 2 3 4",
            "12m",
            "--1",
            "1..2",
            "12:34m",
        ] {
            assert!(parse_right_ascension_deg(text).is_err(), "{text}");
        }
    }

    #[test]
    fn declinations() {
        let expected = -(30.0 + 12.0 / 60.0 + 34.5 / 3600.0);
        for text in ["-30d12m34.5s", "-30:12:34.5", "-30 12 34.5", "-30°12'34.5\"", "−30°12′34.5″"] {
            let degrees = parse_declination_deg(text).expect(text);
            assert!((degrees - expected).abs() < 1e-12, "{text}: {degrees}");
        }
        // The sign counts even where the degrees are zero.
        assert!((parse_declination_deg("-00:30:00").expect("an angle") + 0.5).abs() < 1e-15);
        assert_eq!(parse_declination_deg("90").expect("the pole"), 90.0);
        for text in ["90.0001", "-91", "12h", "30d61m", "x", "-", "+-3"] {
            assert!(parse_declination_deg(text).is_err(), "{text}");
        }
        let error = parse_declination_deg("12h").expect_err("hours");
        assert!(error.to_string().starts_with("\"12h\" is not a declination; allowed: degrees"), "{error}");
    }
}
