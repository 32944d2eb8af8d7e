//! Types of values in a configuration: quantities with units, lists, and names or tables.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::ops::Deref;
use std::path::PathBuf;
use std::str::FromStr;

use hifitime::TimeScale;
use serde::de::{DeserializeOwned, Deserializer, Error as _};
use serde::{Deserialize, Serialize};
use toml::Value;

use crate::constants::LONGEST_EXPOSURE_S;
use crate::elements::Generation;
use crate::error::{Error, ErrorKind};
use crate::images::Telescope;
use crate::message::Quoted;
use crate::schedule::Policy;

/// Text of a quantity: a number with a unit, a time or an angle. A number in a document is converted to text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity(pub String);

impl Quantity {
    /// Returns the text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl From<String> for Quantity {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "invalid type; allowed: a number or a text")]
        enum Written {
            Text(String),
            Number(f64),
        }
        Ok(Self(match Written::deserialize(deserializer)? {
            Written::Text(text) => text,
            Written::Number(number) => number.to_string(),
        }))
    }
}

/// Deserializes one value or a list of values.
pub(super) fn one_or_many<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "invalid type; allowed: one value or a list of values")]
    enum Written<T> {
        One(T),
        Many(Vec<T>),
    }
    Ok(match Option::deserialize(deserializer)? {
        Some(Written::One(value)) => vec![value],
        Some(Written::Many(values)) => values,
        None => Vec::new(),
    })
}

/// Input given as a name or path, or as a table of all its keys. A table with the single key `preset` is equivalent to
/// a name.
#[derive(Clone, Debug, PartialEq)]
pub enum NameOrTable<N, T> {
    /// Name or file.
    Name(N),
    /// Table with the keys of the corresponding file.
    Table(T),
}

/// Name in a bundled table, or the path of a file: a text with a separator of folders, or a dot before a letter.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct NameOrFile(String);

impl NameOrFile {
    /// Returns true for the path of a file.
    pub fn is_file(&self) -> bool {
        let is_extension = |end: &str| end.starts_with(|c: char| c.is_ascii_alphabetic());
        self.contains(std::path::is_separator) || self.split('.').skip(1).any(is_extension)
    }
}

impl Deref for NameOrFile {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

impl From<String> for NameOrFile {
    fn from(text: String) -> Self {
        Self(text)
    }
}

/// Site: a name in the bundled table, or a table `[site]`.
pub type SiteChoice = NameOrTable<String, SiteTable>;
/// Field of view: a JSON file, or a table `[field]` with the keys of such a file or the key of one shape.
pub type FieldChoice = NameOrTable<PathBuf, toml::Table>;
/// Telescope: a preset name or a TOML file, or a table `[telescope]` with all keys of such a file.
pub type TelescopeChoice = NameOrTable<NameOrFile, Box<Telescope>>;
/// Policy: a TOML file, or a table `[policy]`.
pub type PolicyChoice = NameOrTable<PathBuf, Policy>;

impl<'de, N: From<String>, T: DeserializeOwned> Deserialize<'de> for NameOrTable<N, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::String(name) => Ok(Self::Name(name.into())),
            Value::Table(keys) if keys.len() == 1 && keys.contains_key("preset") => {
                let name = keys.get("preset").and_then(Value::as_str);
                Ok(Self::Name(
                    name.ok_or_else(|| D::Error::custom("preset is not a text; allowed: the name of a preset"))?
                        .to_owned()
                        .into(),
                ))
            }
            // The error of the table type has details that the error of an untagged enum lacks.
            value => match value.try_into() {
                Ok(table) => Ok(Self::Table(table)),
                Err(error) => Err(D::Error::custom(toml::de::Error::message(&error))),
            },
        }
    }
}

impl<N: From<String>, T> From<String> for NameOrTable<N, T> {
    fn from(name: String) -> Self {
        Self::Name(name.into())
    }
}

impl<T> From<OsString> for NameOrTable<PathBuf, T> {
    fn from(path: OsString) -> Self {
        Self::Name(path.into())
    }
}

/// Table `[site]`: a name in the bundled table, an MPC code, or coordinates with an optional name.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SiteTable {
    /// Name of the site.
    pub name: Option<String>,
    /// Observatory code of the Minor Planet Center.
    pub mpc: Option<String>,
    /// Geodetic latitude, degrees.
    pub latitude_deg: Option<f64>,
    /// Longitude, degrees, east positive.
    pub longitude_deg: Option<f64>,
    /// Height above the ellipsoid, metres.
    pub height_m: Option<f64>,
}

/// Table `[models]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModelsTable {
    /// Model files. Each replaces the bundled model of the same name.
    pub files: Vec<PathBuf>,
    /// Table of standard magnitudes; equivalent to the flag `--qs-mag`.
    pub qs_mag: Option<PathBuf>,
    /// Model name for a generation of satellites (`starlink-v1.5`, `oneweb`, ...), which replaces the default model.
    pub generations: BTreeMap<String, String>,
}

/// Brightness model of `--model`, for all satellites or for one generation.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelAssignment {
    /// Generation of satellites; `None` for all satellites.
    pub kind: Option<Generation>,
    /// Brightness model.
    pub model: ModelSource,
}

/// Brightness model given by its name in the library or by a file.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelSource {
    /// Name in the library.
    Name(String),
    /// Path of a model file: text that has the extension `.json` or contains a folder.
    File(PathBuf),
}

impl FromStr for ModelAssignment {
    type Err = String;

    /// Parses `MODEL` or `KIND=MODEL`. The part before `=` must be a known generation, so that a misspelt one is not
    /// taken as part of a file name.
    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, model) = match text.split_once('=') {
            Some((kind, model)) => {
                let known = || Generation::ALL.map(Generation::name).join(", ");
                let found = Generation::by_name(kind.trim());
                (Some(found.ok_or_else(|| format!("unknown kind of satellite '{kind}'; allowed: {}", known()))?), model)
            }
            None => (None, text),
        };
        let model = model.trim();
        if model.is_empty() {
            return Err("empty name of a model; allowed: MODEL or KIND=MODEL".to_owned());
        }
        let path = PathBuf::from(model);
        let is_file = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("json"))
            || model.contains(std::path::is_separator);
        let model = if is_file { ModelSource::File(path) } else { ModelSource::Name(model.to_owned()) };
        Ok(Self { kind, model })
    }
}

/// Deserializes one model assignment or a list of them.
pub(super) fn model_assignments<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<ModelAssignment>, D::Error> {
    let texts: Vec<String> = one_or_many(deserializer)?;
    texts.iter().map(|text| text.parse().map_err(D::Error::custom)).collect()
}

/// List of numbers: separated by commas on the command line, an array in a document.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Numbers(pub Vec<f64>);

impl Numbers {
    /// Parses between `LEAST` and `MOST` finite numbers.
    #[cfg(all(feature = "cli", feature = "fits", unix))]
    pub(super) fn parse<const LEAST: usize, const MOST: usize>(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> = text
            .split(',')
            .map(|number| number.trim().parse().ok().filter(|number: &f64| number.is_finite()))
            .collect();
        let count = if LEAST == MOST { LEAST.to_string() } else { format!("{LEAST} to {MOST}") };
        match numbers {
            Some(numbers) if (LEAST..=MOST).contains(&numbers.len()) => Ok(Self(numbers)),
            _ => Err(format!("invalid list; allowed: {count} numbers separated by commas, without blanks")),
        }
    }
}

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
const LENGTH_UNITS: &[(&str, f64)] = &[("mm", 1.0), ("cm", 10.0), ("m", 1000.0)];

/// Parses a duration such as `30s`, `30.0s`, `2.5min` or `1h` into seconds, at least 0 and at most one day, the longest
/// exposure. A number without a unit is rejected.
///
/// # Errors
/// The form is invalid, the unit is unknown, or the number is negative, above a day or not finite.
pub fn parse_duration_s(what: &'static str, text: &str) -> Result<f64, Error> {
    let allowed = "a number with its unit: 30s, 2.5min, 1h";
    let seconds = with_unit(what, text, DURATION_UNITS, allowed)?;
    in_range(what, seconds, "s", "0 to 86400 s", |seconds| (0.0..=LONGEST_EXPOSURE_S).contains(&seconds))
}

/// Parses the exposure time of a frame or a visit: a duration above 0.
///
/// # Errors
/// The errors of [`parse_duration_s`], and a duration of 0, in which nothing can cross.
pub fn parse_exposure_s(text: &str) -> Result<f64, Error> {
    let seconds = with_unit("exposure", text, DURATION_UNITS, "a number with its unit: 30s, 2.5min, 1h")?;
    let is_allowed = |seconds: f64| seconds > 0.0 && seconds <= LONGEST_EXPOSURE_S;
    in_range("exposure", seconds, "s", "above 0 s, at most 86400 s", is_allowed)
}

/// Parses an angle such as `3.5deg`, `210arcmin` or `30arcsec` into degrees, above 0, at most 180. A number without a
/// unit is rejected.
///
/// # Errors
/// The form is invalid, the unit is unknown, or the number is out of range.
pub fn parse_angle_deg(what: &'static str, text: &str) -> Result<f64, Error> {
    let allowed = "a number with its unit: 3.5deg, 210arcmin, 30arcsec";
    let degrees = with_unit(what, text, ANGLE_UNITS, allowed)?;
    in_range(what, degrees, "deg", "above 0 deg, at most 180 deg", |degrees| degrees > 0.0 && degrees <= 180.0)
}

fn with_unit(what: &'static str, text: &str, units: &[(&str, f64)], allowed: &'static str) -> Result<f64, Error> {
    let text = text.trim();
    if text.parse::<f64>().is_ok() {
        return Err(Error::new(ErrorKind::Invalid, format!("{what} is {text}, without a unit")).allowing(allowed));
    }
    let found = units.iter().find_map(|(unit, factor)| {
        let number: f64 = text.strip_suffix(unit)?.trim_end().parse().ok()?;
        Some(number * factor)
    });
    found.filter(|value| value.is_finite()).ok_or_else(|| Error::malformed(what, text, allowed))
}

/// Parses the size of a field into degrees: a diameter such as `3.5deg`, width and height such as `1.5x1.0deg`, or the
/// size of a sensor and the focal length, such as `36x24mm@400mm` or, for a circle, `24mm@400mm`. Widths and heights
/// are lengths on the tangent plane, as those of [`Field::rectangle_deg`](crate::passes::Field::rectangle_deg).
///
/// # Errors
/// Same as [`parse_angle_deg`], for each angle and length.
pub fn parse_size_deg(what: &'static str, text: &str) -> Result<(f64, Option<f64>), Error> {
    let size_deg = parse_parts_deg(what, text);
    // Errors of a part name the whole value too.
    if text.contains(['@', 'x', '×']) {
        size_deg.map_err(|error| error.at(format_args!("{what} '{}'", Quoted::new(text))))
    } else {
        size_deg
    }
}

fn parse_parts_deg(what: &'static str, text: &str) -> Result<(f64, Option<f64>), Error> {
    if let Some((sensor, focal_length)) = text.split_once('@') {
        let focal_mm = parse_length_mm(what, focal_length)?;
        return Ok(match width_and_height(sensor, |length| parse_length_mm(what, length))? {
            // d / f on the tangent plane
            (width_mm, Some(height_mm)) => {
                ((width_mm / focal_mm).to_degrees(), Some((height_mm / focal_mm).to_degrees()))
            }
            // 2 arctan(d / 2f)
            (diameter_mm, None) => (2.0 * (0.5 * diameter_mm / focal_mm).atan().to_degrees(), None),
        });
    }
    if LENGTH_UNITS.iter().any(|(unit, _)| text.trim_end().ends_with(unit)) {
        return Err(Error::malformed(
            what,
            text,
            "the size of a sensor with the focal length, for example 23.5x15.6mm@400mm",
        ));
    }
    width_and_height(text, |angle| parse_angle_deg(what, angle))
}

/// Parses `WIDTHxHEIGHT`, or one size. The unit of the height applies to a width without a unit.
fn width_and_height(text: &str, parse: impl Fn(&str) -> Result<f64, Error>) -> Result<(f64, Option<f64>), Error> {
    let Some((width, height)) = text.split_once(['x', '×']) else { return Ok((parse(text)?, None)) };
    let unit = height.trim_start_matches(|mark: char| mark.is_ascii_digit() || mark == '.' || mark.is_whitespace());
    let width = if width.trim().parse::<f64>().is_ok() { format!("{width}{unit}") } else { width.to_owned() };
    Ok((parse(&width)?, Some(parse(height)?)))
}

fn parse_length_mm(what: &'static str, text: &str) -> Result<f64, Error> {
    let length_mm = with_unit(what, text, LENGTH_UNITS, "sensor and focal length with their units: 36x24mm@400mm")?;
    in_range(what, length_mm, "mm", "0.1 to 100000 mm", |length_mm| (0.1..=1e5).contains(&length_mm))
}

/// Returns `value` if it is inside a range, and an error otherwise. NaN is outside every range.
pub(super) fn in_range(
    what: &'static str,
    value: f64,
    unit: &str,
    allowed: &'static str,
    is_allowed: impl Fn(f64) -> bool,
) -> Result<f64, Error> {
    if is_allowed(value) {
        return Ok(value);
    }
    // Large numbers are written with an exponent: 1e300 has 301 digits.
    let number = if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") };
    Err(Error::invalid(what, format!("{number} {unit}").trim_end(), allowed))
}

/// Parses the name of a time scale: `utc`, `tai` or `tt`; case is ignored.
///
/// # Errors
/// The name is unknown.
pub fn parse_time_scale(text: &str) -> Result<TimeScale, Error> {
    match text.trim().to_ascii_lowercase().as_str() {
        "utc" => Ok(TimeScale::UTC),
        "tai" => Ok(TimeScale::TAI),
        "tt" => Ok(TimeScale::TT),
        _ => Err(Error::malformed("time scale", text, "utc, tai, tt")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn numbers_without_a_unit_are_rejected() {
        let message = parse_duration_s("exposure", "30").unwrap_err().to_string();
        assert_eq!(message, "exposure is 30, without a unit; allowed: a number with its unit: 30s, 2.5min, 1h");
        for text in ["", "s", "30m", "30x", "-1s", "nan s", "infs", "1e400s"] {
            assert!(parse_duration_s("exposure", text).is_err(), "{text}");
        }
        for text in ["3.5", "0deg", "-1deg", "3.5rad", "nandeg"] {
            assert!(parse_angle_deg("fov", text).is_err(), "{text}");
        }
    }

    #[test]
    fn errors_of_range_have_the_range() {
        let message = |result: Result<f64, Error>| result.unwrap_err().to_string();
        assert_eq!(message(parse_duration_s("exposure", "-5s")), "exposure is -5 s; allowed: 0 to 86400 s");
        assert_eq!(message(parse_exposure_s("0s")), "exposure is 0 s; allowed: above 0 s, at most 86400 s");
        assert_eq!(parse_duration_s("exposure", "24h").unwrap(), LONGEST_EXPOSURE_S);
        let above = message(parse_duration_s("exposure", "1e300s"));
        assert_eq!(above, "exposure is 1e300 s; allowed: 0 to 86400 s");
        for (text, given) in [("0deg", "0"), ("-1deg", "-1"), ("181deg", "181")] {
            let expected = format!("fov is {given} deg; allowed: above 0 deg, at most 180 deg");
            assert_eq!(message(parse_angle_deg("fov", text)), expected);
        }
    }
}
