//! Coordinates of a site as text: decimal degrees, or degrees with minutes and the letter of a hemisphere.

use serde::de::{Deserialize, Deserializer, Error};

use crate::frames::degrees_of;
use crate::message::Quoted;

/// Units of heights, and their lengths in metres.
const HEIGHT_UNITS: [(&str, f64); 3] = [("km", 1000.0), ("ft", 0.3048), ("m", 1.0)];

/// Parses a latitude, degrees north: `-33.9`, `33.9S`, `33°54'S` or `-33:54`. The range is not checked.
///
/// # Errors
/// Text of another form, or both a sign and a letter.
pub fn parse_latitude_deg(text: &str) -> Result<f64, String> {
    let wrong = || angle_error("latitude", text, "south", "-33.9, 33.9S or 33°54'S");
    degrees_with_letter(text, ['N', 'S']).ok_or_else(wrong)
}

/// Parses a longitude, degrees east: `-70.75`, `70.75W`, `70°45'W` or `-70:45`. The range is not checked.
///
/// # Errors
/// Same as [`parse_latitude_deg`].
pub fn parse_longitude_deg(text: &str) -> Result<f64, String> {
    let wrong = || angle_error("longitude", text, "west", "-70.75, 70.75W or 70°45'W");
    degrees_with_letter(text, ['E', 'W']).ok_or_else(wrong)
}

/// Parses a height, metres: `430`, `430m`, `0.43km` or `1411ft`. The range is not checked.
///
/// # Errors
/// Text of another form.
pub fn parse_height_m(text: &str) -> Result<f64, String> {
    let plain = text.trim().replace('−', "-");
    let with_unit = || {
        HEIGHT_UNITS.iter().find_map(|(unit, length_m)| {
            let number: f64 = plain.strip_suffix(unit)?.trim_end().parse().ok()?;
            Some(number * length_m)
        })
    };
    plain
        .parse()
        .ok()
        .or_else(with_unit)
        .ok_or_else(|| format!("not a height; allowed: metres with a decimal point (430 or 430m){}", comma_hint(text)))
}

/// Latitude and longitude, degrees, and height, metres.
type Coordinates = (f64, f64, Option<f64>);

/// Parses latitude, longitude and an optional height, separated by commas or blanks: `47.37,8.54,430` or
/// `47°22'N 8°32'E`. Returns `None` for text of another form, which may be a name.
///
/// # Errors
/// Commas may be decimal ones or separators, or the height is not a height.
pub fn parse_coordinates(text: &str) -> Option<Result<Coordinates, String>> {
    let text = text.trim();
    let by_comma = text.contains(',');
    let is_letter = |part: &str| ["N", "S", "E", "W"].iter().any(|letter| letter.eq_ignore_ascii_case(part));
    let mut parts: Vec<String> = Vec::new();
    let mut letters_are_first = false;
    for part in text.split(|mark: char| if by_comma { mark == ',' } else { mark.is_whitespace() }) {
        let part = part.trim();
        letters_are_first |= parts.is_empty() && is_letter(part);
        // Minutes and seconds after a blank.
        let continues = part.ends_with(['\'', '′', '"', '″'])
            && !part.contains(|mark: char| matches!(mark, '°' | '-' | '+' | '−') || mark.is_alphabetic());
        match parts.last_mut() {
            _ if part.is_empty() => {}
            Some(last) if !by_comma && is_letter(last) => *last += part,
            Some(last) if !by_comma && continues => *last += part,
            // A blank before an S distinguishes the hemisphere from seconds.
            Some(last) if !by_comma && !letters_are_first && is_letter(part) => *last = format!("{last} {part}"),
            _ => parts.push(part.to_owned()),
        }
    }
    let is_plain = |mark: char| mark.is_ascii_digit() || matches!(mark, ',' | ' ' | '-' | '+' | '−');
    if by_comma && text.chars().all(is_plain) {
        let is_number = |part: &String| part.chars().all(|mark| mark.is_ascii_digit());
        match &parts[..] {
            // A blank after the comma, or a sign, separates two numbers.
            [lat, lon] if text == format!("{lat},{lon}") && is_number(lon) => {
                return Some(Err(format!(
                    "'{text}' is ambiguous: latitude {lat} and longitude {lon}, or {lat}.{lon} with a decimal comma; \
                     allowed: decimal points, as in {lat}.0,{lon}.0 or {lat}.{lon},8.54"
                )));
            }
            parts if parts.len() > 3 || parts.iter().any(|part| part.contains(' ')) => {
                return Some(Err(format!(
                    "'{text}' is ambiguous, because commas separate the numbers; allowed: decimal points, as in 47.37,8.54"
                )));
            }
            _ => {}
        }
    }
    let (lat, lon, height) = match &parts[..] {
        [lat, lon] => (lat, lon, None),
        [lat, lon, height] => (lat, lon, Some(height)),
        _ => return None,
    };
    let (lat_deg, lon_deg) = (parse_latitude_deg(lat).ok()?, parse_longitude_deg(lon).ok()?);
    Some(match height.map(|height| parse_height_m(height)) {
        None => Ok((lat_deg, lon_deg, None)),
        Some(Ok(height_m)) => Ok((lat_deg, lon_deg, Some(height_m))),
        Some(Err(error)) => Err(format!("'{text}': height {error}")),
    })
}

fn degrees_with_letter(text: &str, [plus, minus]: [char; 2]) -> Option<f64> {
    let text = text.trim();
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let is_letter = |mark: &char| mark.eq_ignore_ascii_case(&plus) || mark.eq_ignore_ascii_case(&minus);
    // The s of 33d54m12s, in lower case directly after a digit, is the unit of the seconds.
    let is_unit = text.strip_suffix('s').is_some_and(|before| {
        before.ends_with(|mark: char| mark.is_ascii_digit() || mark == '.') && before.contains(['d', 'D', 'm', 'M'])
    });
    let (first, last) = (text.chars().next().filter(is_letter), text.chars().next_back().filter(is_letter));
    let (letter, bare) = match (first, last.filter(|_| !is_unit)) {
        (None, None) => return degrees_of(text),
        (Some(letter), None) => (letter, text.strip_prefix(letter)?.trim()),
        (None, Some(letter)) => (letter, text.strip_suffix(letter)?.trim()),
        (Some(_), Some(_)) => return None,
    };
    let value = degrees_of(bare).filter(|_| !bare.starts_with(['-', '+', '−']))?;
    Some(if letter.eq_ignore_ascii_case(&minus) { -value } else { value })
}

fn angle_error(what: &str, text: &str, negative: &str, examples: &str) -> String {
    let hint = comma_hint(text);
    format!("not a {what}; allowed: decimal degrees with a point, {negative} negative ({examples}){hint}")
}

/// Returns a hint if a number has a decimal comma.
fn comma_hint(text: &str) -> String {
    let point = text.trim().replacen(',', ".", 1).replace('−', "-");
    let is_decimal = text.contains(',') && point.parse::<f64>().is_ok();
    if is_decimal { format!("; with a decimal point: {point}") } else { String::new() }
}

/// Deserializes an optional number, or its text.
fn number_or_text<'de, D: Deserializer<'de>>(
    deserializer: D,
    parse: fn(&str) -> Result<f64, String>,
) -> Result<Option<f64>, D::Error> {
    #[derive(serde::Deserialize)]
    #[serde(untagged, expecting = "invalid type; allowed: a number or a text")]
    enum Written {
        Number(f64),
        Text(String),
    }
    match Option::deserialize(deserializer)? {
        Some(Written::Number(number)) => Ok(Some(number)),
        Some(Written::Text(text)) => {
            parse(&text).map(Some).map_err(|error| D::Error::custom(format!("'{}' is {error}", Quoted::new(&text))))
        }
        None => Ok(None),
    }
}

/// Deserializes a latitude.
pub(super) fn latitude<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    number_or_text(deserializer, parse_latitude_deg)
}

/// Deserializes a longitude.
pub(super) fn longitude<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    number_or_text(deserializer, parse_longitude_deg)
}

/// Deserializes a height.
pub(super) fn height<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    number_or_text(deserializer, parse_height_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_of_coordinates() {
        let expected = 47.0 + 22.0 / 60.0 + 12.0 / 3600.0;
        for text in
            ["47:22:12", "47°22'12\"N", "47d22m12s", "47°22′12″ n", "N 47°22'12\"", "47d22m12sN", "47.37N", "47.37"]
        {
            assert!((parse_latitude_deg(text).expect(text) - expected).abs() < 1e-12, "{text}");
        }
        for (text, degrees) in [
            ("33.9S", -33.9),
            ("−33.9", -33.9),
            ("-33°54'", -33.9),
            ("s33.9", -33.9),
            ("4.7e1", 47.0),
            ("33.9s", -33.9),
        ] {
            assert!((parse_latitude_deg(text).expect(text) - degrees).abs() < 1e-12, "{text}");
        }
        // A capital S, or an s after a blank or a unit, is the hemisphere.
        for text in [
            "33d54m12S",
            "33d54m12 S",
            "33d54m12 s",
            "33d54m12sS",
            "33°54m12S",
            "33°54'12\"s",
            "S33d54m12s",
            "S 33d54m12s",
            "-33d54m12s",
        ] {
            assert!((parse_latitude_deg(text).expect(text) + 33.0 + 54.2 / 60.0).abs() < 1e-12, "{text}");
        }
        for (text, degrees) in
            [("33d54S", -33.9), ("33d54'S", -33.9), ("33d54mS", -33.9), ("33dS", -33.0), ("33d54N", 33.9)]
        {
            assert!((parse_latitude_deg(text).expect(text) - degrees).abs() < 1e-12, "{text}");
        }
        for (text, degrees) in [("70°45'W", -70.75), ("8.54E", 8.54), ("289:15", 289.25), ("−70.75", -70.75)] {
            assert!((parse_longitude_deg(text).expect(text) - degrees).abs() < 1e-12, "{text}");
        }
        for text in
            ["47,37", "-33.9S", "47.37E", "47h", "47°61'", "N", "", "N47S", "33d54s", "N33d54m12S", "-33d54m12S"]
        {
            assert!(parse_latitude_deg(text).is_err(), "{text}");
        }
        let error = parse_latitude_deg("47,37").unwrap_err();
        assert!(error.contains("with a point, south negative") && error.ends_with("decimal point: 47.37"), "{error}");
        for (text, metres) in [("430", 430.0), ("430m", 430.0), ("0.43 km", 430.0), ("−5m", -5.0), ("1000ft", 304.8)]
        {
            assert!((parse_height_m(text).expect(text) - metres).abs() < 1e-9, "{text}");
        }
        assert!(parse_height_m("430 mi").is_err() && parse_height_m("2,6km").is_err());
    }

    #[test]
    fn pairs_of_coordinates_and_ambiguous_commas() {
        for (text, expected) in [
            ("47.37,8.54", (47.37, 8.54, None)),
            ("47.37N, 8.54E", (47.37, 8.54, None)),
            ("47.37 N 8.54 E 430m", (47.37, 8.54, Some(430.0))),
            ("47°30' N, 8°30' E", (47.5, 8.5, None)),
            ("47° 30' N 8° 30' E", (47.5, 8.5, None)),
            ("N 47° 30' E 8° 30'", (47.5, 8.5, None)),
            ("N47°30', E8°30'", (47.5, 8.5, None)),
            ("47°30' 8°30'", (47.5, 8.5, None)),
            ("-33°54', 18°30'", (-33.9, 18.5, None)),
            ("-33°54' -18°30' 20m", (-33.9, -18.5, Some(20.0))),
            ("33d54m S 18d30m E", (-33.9, 18.5, None)),
            ("30d30m36 S 18d30m36 E", (-30.51, 18.51, None)),
            ("-30,-70,2600", (-30.0, -70.0, Some(2600.0))),
            ("47, 8", (47.0, 8.0, None)),
            ("47.5,8", (47.5, 8.0, None)),
            ("47,-37", (47.0, -37.0, None)),
        ] {
            let (lat, lon, height) = parse_coordinates(text).expect(text).expect(text);
            assert!((lat - expected.0).abs() < 1e-12 && (lon - expected.1).abs() < 1e-12, "{text}: {lat} {lon}");
            assert_eq!(height, expected.2, "{text}");
        }
        let error = parse_coordinates("47,37").unwrap().unwrap_err();
        assert!(error.contains("latitude 47 and longitude 37, or 47.37 with a decimal comma"), "{error}");
        for text in ["47,37,8,54", "47,37 8,54"] {
            assert!(parse_coordinates(text).expect(text).is_err(), "{text}");
        }
        for text in ["Zurich", "Vienna, US", "500", "6 October", "47.37"] {
            assert!(parse_coordinates(text).is_none(), "{text}");
        }
    }
}
