//! Column map for custom tables: which column contains which quantity, with units and time scale.
//!
//! ```text
//! time=Date,time_scale=utc,magnitude=Mag,filter=Filter,distance=Range,phase=Phase,track=Track
//! latitude=43.65,longitude=41.43,site_height=2030
//! ```
//!
//! The same map may be given as a small TOML file (`time = "Date"`) or as JSON. Keys:
//!
//! | key | column of |
//! |---|---|
//! | `time`, `time_of_day` | ISO 8601, MJD or JD; date and time of day if they are in two columns |
//! | `magnitude`, `sigma` | apparent magnitude and its one sigma, mag |
//! | `filter`, `penumbra` | name of the filter; 0 or 1 |
//! | `norad`, `track` | catalogue number; name of the track |
//! | `altitude`, `azimuth`, `height` | satellite: above the horizon; from north through east; above the ground |
//! | `distance`, `phase` | distance from the observer; angle Sun-satellite-observer |
//! | `right_ascension`, `declination` | satellite, ICRS; requires `distance` |
//! | `sun_altitude`, `azimuth_from_sun` | Sun's altitude; satellite's azimuth less the Sun's; without time and site |
//! | `latitude`, `longitude`, `site_height` | site, degrees north and east, m; a number applies to all rows |
//!
//! and settings: `time_scale` (utc, tai, tt), `angle_unit` (deg, rad), `distance_unit` and `height_unit` (km, m).

use std::collections::BTreeMap;

use hifitime::TimeScale;

use crate::error::{Error, ErrorKind};
use crate::input::json_error;
use crate::message::Quoted;

/// Quantity that a column contains.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Field {
    Time,
    TimeOfDay,
    Magnitude,
    Sigma,
    Filter,
    Penumbra,
    Norad,
    Track,
    Altitude,
    Azimuth,
    Height,
    Distance,
    Phase,
    RightAscension,
    Declination,
    SunAltitude,
    AzimuthFromSun,
    Latitude,
    Longitude,
    SiteHeight,
}

impl Field {
    pub(super) const ALL: [(Self, &'static str); 20] = [
        (Self::Time, "time"),
        (Self::TimeOfDay, "time_of_day"),
        (Self::Magnitude, "magnitude"),
        (Self::Sigma, "sigma"),
        (Self::Filter, "filter"),
        (Self::Penumbra, "penumbra"),
        (Self::Norad, "norad"),
        (Self::Track, "track"),
        (Self::Altitude, "altitude"),
        (Self::Azimuth, "azimuth"),
        (Self::Height, "height"),
        (Self::Distance, "distance"),
        (Self::Phase, "phase"),
        (Self::RightAscension, "right_ascension"),
        (Self::Declination, "declination"),
        (Self::SunAltitude, "sun_altitude"),
        (Self::AzimuthFromSun, "azimuth_from_sun"),
        (Self::Latitude, "latitude"),
        (Self::Longitude, "longitude"),
        (Self::SiteHeight, "site_height"),
    ];
}

/// Number of quantities.
pub(super) const FIELDS: usize = Field::ALL.len();

/// Map from quantities to columns.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnMap {
    /// Name of the column of each [`Field`], or a number for the site.
    pub(super) columns: [Option<String>; FIELDS],
    /// Quantities whose columns may be missing.
    pub(super) optional: Vec<Field>,
    /// Time scale of all times.
    pub(super) time_scale: Option<TimeScale>,
    /// Unit of angles, in radians.
    pub(super) angle_rad: f64,
    /// Unit of distances, in km.
    pub(super) distance_km: f64,
    /// Unit of heights, in km.
    pub(super) height_km: f64,
}

impl Default for ColumnMap {
    /// Returns a map without columns, with degrees and kilometres as units.
    fn default() -> Self {
        Self {
            columns: [const { None }; FIELDS],
            optional: Vec::new(),
            time_scale: None,
            angle_rad: 1_f64.to_radians(),
            distance_km: 1.0,
            height_km: 1.0,
        }
    }
}

impl ColumnMap {
    /// Parses a column map: pairs `key=column` separated by commas or line ends, TOML, or JSON (text that begins with a
    /// brace).
    ///
    /// # Errors
    /// * the text is invalid, or a key is unknown or repeated;
    /// * a unit or time scale is unknown;
    /// * the magnitude is missing, or a time has no scale;
    /// * a pair of coordinates is incomplete.
    pub fn from_text(text: &str) -> Result<Self, Error> {
        let mut map = Self::default();
        for (key, value) in pairs(text)? {
            map.set(&key, &value)?;
        }
        map.checked()
    }

    /// Creates a map of fixed columns with times in UTC.
    pub(super) fn fixed(columns: &[(Field, &str)]) -> Self {
        let mut map = Self { time_scale: Some(TimeScale::UTC), ..Self::default() };
        for (field, column) in columns {
            map.columns[*field as usize] = Some((*column).to_owned());
        }
        map
    }

    pub(super) fn column(&self, field: Field) -> Option<&str> {
        self.columns[field as usize].as_deref()
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), Error> {
        let unit = |allowed: &[(&str, f64)]| {
            let found = allowed.iter().find(|(name, _)| name.eq_ignore_ascii_case(value)).map(|(_, size)| *size);
            let names: Vec<_> = allowed.iter().map(|(name, _)| *name).collect();
            found.ok_or_else(|| wrong(format!("{key} is '{value}'; allowed: {}", names.join(", "))))
        };
        let lengths = [("km", 1.0), ("m", 1e-3)];
        match key {
            "time_scale" => {
                let scale = match value.to_ascii_lowercase().as_str() {
                    "utc" => TimeScale::UTC,
                    "tai" => TimeScale::TAI,
                    "tt" => TimeScale::TT,
                    _ => return Err(wrong(format!("time_scale is '{value}'; allowed: utc, tai, tt"))),
                };
                self.time_scale = Some(scale);
            }
            "angle_unit" => self.angle_rad = unit(&[("deg", 1_f64.to_radians()), ("rad", 1.0)])?,
            "distance_unit" => self.distance_km = unit(&lengths)?,
            "height_unit" => self.height_km = unit(&lengths)?,
            _ => {
                let Some((field, _)) = Field::ALL.iter().find(|(_, name)| *name == key) else {
                    let known: Vec<_> = Field::ALL.iter().map(|(_, name)| *name).collect();
                    let known = known.join(", ");
                    let settings = "time_scale, angle_unit, distance_unit, height_unit";
                    return Err(wrong(format!("unknown key '{key}'; allowed: {known}, {settings}")));
                };
                let column = &mut self.columns[*field as usize];
                if column.replace(value.to_owned()).is_some() {
                    return Err(wrong(format!("repeated key '{key}'")));
                }
            }
        }
        Ok(())
    }

    fn checked(self) -> Result<Self, Error> {
        let has = |field: Field| self.column(field).is_some();
        if !has(Field::Magnitude) {
            return Err(wrong("missing key 'magnitude'".to_owned()));
        }
        if let (Some(column), None) = (self.column(Field::Time), self.time_scale) {
            return Err(Error::new(
                ErrorKind::NoTimeScale,
                format!("column map: the times of column '{}' have no scale", Quoted::new(column)),
            )
            .allowing("time_scale = utc, tai or tt"));
        }
        let together: [&[Field]; 5] = [
            &[Field::Latitude, Field::Longitude, Field::SiteHeight],
            &[Field::RightAscension, Field::Declination],
            &[Field::SunAltitude, Field::AzimuthFromSun],
            &[Field::Time, Field::TimeOfDay],
            &[Field::Distance, Field::Phase],
        ];
        for fields in &together[..3] {
            let there = fields.iter().filter(|field| has(**field)).count();
            if there != 0 && there != fields.len() {
                let names: Vec<_> = fields.iter().map(|field| Field::ALL[*field as usize].1).collect();
                return Err(wrong(format!("{} are incomplete; allowed: all of them, or none", names.join(", "))));
            }
        }
        for fields in &together[3..] {
            if has(fields[1]) && !has(fields[0]) {
                let [first, second] = [0, 1].map(|at: usize| Field::ALL[fields[at] as usize].1);
                return Err(wrong(format!("{second} requires {first}")));
            }
        }
        Ok(self)
    }
}

fn wrong(problem: String) -> Error {
    Error::new(ErrorKind::Invalid, format!("column map: {problem}"))
}

/// Returns the keys and values in a text.
fn pairs(text: &str) -> Result<Vec<(String, String)>, Error> {
    let plain = |value: &serde_json::Value| match value {
        serde_json::Value::String(text) => Some(text.clone()),
        serde_json::Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let listed = |map: BTreeMap<String, serde_json::Value>| {
        let pair = |(key, value): (String, serde_json::Value)| match plain(&value) {
            Some(text) => Ok((key, text)),
            None => Err(wrong(format!("{key} is {value}; allowed: the name of a column or a number"))),
        };
        map.into_iter().map(pair).collect()
    };
    if text.trim_start().starts_with('{') {
        let map = serde_json::from_str(text).map_err(|error| wrong(json_error(&error).to_string()))?;
        return listed(map);
    }
    if let Ok(map) = toml::from_str::<BTreeMap<String, serde_json::Value>>(text) {
        return listed(map);
    }
    let words = text.split([',', '\n']).map(str::trim).filter(|word| !word.is_empty() && !word.starts_with('#'));
    let pair = |word: &str| match word.split_once('=') {
        Some((key, value)) if !value.trim().is_empty() => {
            Ok((key.trim().to_owned(), unquoted(value.trim()).to_owned()))
        }
        _ => Err(wrong(format!("entry is '{word}'; allowed: key=column"))),
    };
    words.map(pair).collect()
}

fn unquoted(text: &str) -> &str {
    text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_same_map_in_three_syntaxes() {
        let pairs =
            ColumnMap::from_text("time=Date,time_scale=tai, magnitude=Mag,latitude=43.5,longitude=41,site_height=0");
        let toml =
            "time = 'Date'\ntime_scale = 'tai'\nmagnitude = 'Mag'\nlatitude = 43.5\nlongitude = 41\nsite_height = 0";
        let json = r#"{"time": "Date", "time_scale": "tai", "magnitude": "Mag", "latitude": 43.5, "longitude": 41, "site_height": 0}"#;
        let pairs = pairs.expect("pairs");
        assert_eq!(pairs.column(Field::Latitude), Some("43.5"));
        assert_eq!(pairs, ColumnMap::from_text(toml).expect("TOML"));
        assert_eq!(pairs, ColumnMap::from_text(json).expect("JSON"));
        for (index, (field, name)) in Field::ALL.iter().enumerate() {
            assert_eq!(*field as usize, index, "{name}");
        }
    }

    #[test]
    fn verif_invalid_maps_are_rejected() {
        for (text, expected) in [
            ("time=Date,magnitude=Mag", "have no scale"),
            ("time=Date,time_scale=utc", "missing key 'magnitude'"),
            ("magnitude=Mag,colour=B", "unknown key 'colour'"),
            ("magnitude=Mag,magnitude=B", "repeated key 'magnitude'"),
            ("magnitude=Mag,latitude=3", "allowed: all of them, or none"),
            ("magnitude=Mag,phase=3", "phase requires distance"),
            ("magnitude=Mag,angle_unit=hours", "allowed: deg, rad"),
            ("magnitude=Mag,time_scale=local", "allowed: utc, tai, tt"),
            ("magnitude", "allowed: key=column"),
            ("{\"magnitude\": [1]}", "allowed: the name of a column"),
        ] {
            let error = ColumnMap::from_text(text).expect_err(text).to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
