//! Sites on the Earth, by name, MPC code or coordinates, and observers at them.

use std::sync::OnceLock;

use hifitime::Epoch;
use nalgebra::Vector3;

use super::sun::{SunState, SunTable};
use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING, EARTH_ROTATION_RAD_S};
use crate::error::{Error, ErrorKind};
use crate::frames::{
    Gcrs, Horizontal, Itrs, Orientation, OrientationTable, Position, Rotation, Velocity, itrs_to_horizontal,
};
use crate::message::{Quoted, in_ascii};

/// Table of sites. Fields: `name;aliases separated by |;MPC code;latitude;longitude;height`. The head of the file lists
/// the sources.
const TABLE: &str = include_str!("sites.csv");

/// A position on (or above) the WGS84 ellipsoid.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Site {
    /// Name for display.
    pub name: String,
    /// Minor Planet Center observatory code, if any.
    pub mpc_code: Option<String>,
    /// Geodetic latitude, radians, north positive.
    pub latitude_rad: f64,
    /// Longitude, radians in [-π, π], east positive.
    pub longitude_rad: f64,
    /// Height above the ellipsoid (not above the sea, which differs by up to 100 m), metres.
    pub height_m: f64,
}

/// Number of letters that two names must share, at the beginning or as a whole name, to be called similar.
const LEAST_COMMON_LETTERS: usize = 4;

/// Largest distance of two sites that count as the same, km: satellites 500 km away move by 40 arcsec.
pub(crate) const SAME_SITE_KM: f64 = 0.1;

struct Entry {
    site: Site,
    /// Names and aliases in lower case, without blanks and punctuation.
    keys: Vec<String>,
}

impl Site {
    /// Creates a site from coordinates: degrees, east longitude positive (up to 360 is accepted), metres above the
    /// ellipsoid. If `name` is empty, the name of the site is its latitude and longitude.
    ///
    /// # Errors
    /// A latitude beyond ±90, a longitude beyond -180..360, a height beyond -11 km..100 km, or a number that is not
    /// finite.
    pub fn new_deg(name: &str, latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Result<Self, Error> {
        // Adding 0 changes a negative zero to 0.
        let rounded = |angle_deg: f64| (1e3 * angle_deg).round() / 1e3 + 0.0;
        let name = match name {
            "" => format!("latitude {:.3}, longitude {:.3} deg", rounded(latitude_deg), rounded(longitude_deg)),
            name => name.to_owned(),
        };
        let checks = [
            ("latitude", latitude_deg, "deg", -90.0, 90.0),
            ("longitude", longitude_deg, "deg", -180.0, 360.0),
            ("height", height_m, "m", -11_000.0, 100_000.0),
        ];
        for (what, value, unit, first, last) in checks {
            if !(first..=last).contains(&value) {
                return Err(Error::new(
                    ErrorKind::Invalid,
                    format!("{what} of site {:?} is {value} {unit}", Quoted::new(name)),
                )
                .allowing(format!("{first} to {last} {unit}")));
            }
        }
        let longitude_deg = if longitude_deg > 180.0 { longitude_deg - 360.0 } else { longitude_deg };
        Ok(Self {
            name,
            mpc_code: None,
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: longitude_deg.to_radians(),
            height_m,
        })
    }

    /// Creates a site from its Earth-fixed position (ITRS), metres.
    ///
    /// tan φ = (z + e'² b sin³ β) / (p - e² a cos³ β),  tan β = z / ((1 - f) p): Bowring 1976, Survey Review 23, 323.
    /// The error is below 0.1 mm near the ground.
    ///
    /// # Errors
    /// A height beyond -11 km..100 km, or a number that is not finite.
    pub fn from_itrs_m(name: &str, [x_m, y_m, z_m]: [f64; 3]) -> Result<Self, Error> {
        let a_m = EARTH_EQUATORIAL_RADIUS_KM * 1e3;
        let e2 = EARTH_FLATTENING * (2.0 - EARTH_FLATTENING);
        let (b_m, second_e2) = (a_m * (1.0 - EARTH_FLATTENING), e2 / (1.0 - e2));
        let axis_m = x_m.hypot(y_m);
        let (sin_beta, cos_beta) = z_m.atan2((1.0 - EARTH_FLATTENING) * axis_m).sin_cos();
        let latitude_rad = (z_m + second_e2 * b_m * sin_beta.powi(3)).atan2(axis_m - e2 * a_m * cos_beta.powi(3));
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        // h = p cos φ + z sin φ - a √(1 - e² sin² φ)
        let height_m = axis_m * cos_lat + z_m * sin_lat - a_m * (1.0 - e2 * sin_lat * sin_lat).sqrt();
        Self::new_deg(name, latitude_rad.to_degrees(), y_m.atan2(x_m).to_degrees(), height_m)
    }

    /// Returns a site of the bundled table by one of its names or its MPC code; case, accents, blanks, hyphens
    /// and other punctuation are ignored.
    ///
    /// # Errors
    /// A name that is unknown, where the error lists similar names, if any; or the name of several sites, such as a
    /// network (ATLAS) or a mountain (Cerro Pachon).
    pub fn by_name(name: &str) -> Result<Self, Error> {
        match Self::candidates(name).as_slice() {
            [] => Err(match &nearest_names(&key_of(name))[..] {
                [] => Error::unknown("site", name, "a name of the bundled table, or latitude, longitude and height"),
                nearest => Error::new(
                    ErrorKind::Invalid,
                    format!("unknown site {:?}: similar names: {}", Quoted::new(name), nearest.join(", ")),
                ),
            }),
            [site] => Ok((*site).clone()),
            sites => Err(Error::new(
                ErrorKind::Invalid,
                format!(
                    "site name {:?} fits several sites: {}; specify one of them",
                    Quoted::new(name),
                    sites.iter().map(|site| site.name.as_str()).collect::<Vec<_>>().join(", ")
                ),
            )),
        }
    }

    /// Returns the sites that a name can mean: none, one, or several more than [`SAME_SITE_KM`] apart that have the
    /// name, or whose names begin with it.
    pub(crate) fn candidates(name: &str) -> Vec<&'static Self> {
        let key = key_of(name);
        let is_full_name = |entry: &&Entry| entry.keys.first() == Some(&key);
        let full = table().iter().find(is_full_name);
        let begins = |entry: &&Entry| begins_with(&entry.site.name, &key) || entry.keys.contains(&key);
        let begun: Vec<&Self> = table().iter().filter(begins).map(|entry| &entry.site).collect();
        let is_spread = begun.iter().any(|site| site.distance_km(begun[0]) > SAME_SITE_KM);
        if full.is_none() && is_spread {
            return begun;
        }
        let found = full.or_else(|| table().iter().find(|entry| entry.keys.contains(&key))).map(|entry| &entry.site);
        let code = name.trim();
        let is_code = |site: &&Self| site.mpc_code.as_ref().is_some_and(|known| known.eq_ignore_ascii_case(code));
        found.or_else(|| Self::all().find(is_code)).into_iter().collect()
    }

    /// Returns the sites with exactly this name or alias, which may not be an MPC code or the beginning of a name.
    pub(crate) fn with_key(name: &str) -> Vec<&'static Self> {
        let key = key_of(name);
        table().iter().filter(|entry| entry.keys.contains(&key)).map(|entry| &entry.site).collect()
    }

    /// Returns the distance from another site, km, in a straight line.
    pub(crate) fn distance_km(&self, other: &Self) -> f64 {
        (self.itrs() - other.itrs()).norm_km()
    }

    /// Returns a site of the bundled table by its Minor Planet Center observatory code, in upper or lower case.
    ///
    /// # Errors
    /// An unknown code.
    pub fn from_mpc(code: &str) -> Result<Self, Error> {
        let requested = code.trim();
        let matches =
            |entry: &&Entry| entry.site.mpc_code.as_ref().is_some_and(|known| known.eq_ignore_ascii_case(requested));
        match table().iter().find(matches) {
            Some(entry) => Ok(entry.site.clone()),
            None => {
                let known = table().iter().filter(|entry| entry.site.mpc_code.is_some()).count();
                let allowed = format!("the {known} codes of the bundled table, or latitude, longitude and height");
                Err(Error::unknown("MPC observatory code", code, allowed))
            }
        }
    }

    /// Returns all sites of the bundled table.
    pub fn all() -> impl Iterator<Item = &'static Site> {
        table().iter().map(|entry| &entry.site)
    }

    /// Returns the Earth-fixed position, km.
    ///
    /// N = a / √(1 - e² sin² φ),  x = (N + h) cos φ cos λ,  z = (N (1 - e²) + h) sin φ
    pub fn itrs(&self) -> Position<Itrs> {
        let e2 = EARTH_FLATTENING * (2.0 - EARTH_FLATTENING);
        let (sin_lat, cos_lat) = self.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = self.longitude_rad.sin_cos();
        let normal_km = EARTH_EQUATORIAL_RADIUS_KM / (1.0 - e2 * sin_lat * sin_lat).sqrt();
        let height_km = self.height_m * 1e-3;
        let across_km = (normal_km + height_km) * cos_lat;
        Position::new(across_km * cos_lon, across_km * sin_lon, (normal_km * (1.0 - e2) + height_km) * sin_lat)
    }

    /// Returns the rotation from Earth-fixed axes to north, east and zenith; the zenith is the normal of the ellipsoid.
    pub fn horizon(&self) -> Rotation<Itrs, Horizontal> {
        itrs_to_horizontal(self.longitude_rad, self.latitude_rad)
    }
}

/// Returns the height of an Earth-fixed position above the WGS84 ellipsoid, km, by Fukushima's method (Journal of
/// Geodesy 79, 689, 2006) as in the IAU SOFA function `gc2gde`.
pub fn ellipsoidal_height_km(position: &Position<Itrs>) -> f64 {
    // Fails only for an ellipsoid with an impossible radius or flattening.
    let geodetic = sofars::coords::gc2gde(EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING, (*position.vector()).into());
    geodetic.map_or(f64::NAN, |(_, _, height_km)| height_km)
}

fn table() -> &'static [Entry] {
    static ENTRIES: OnceLock<Vec<Entry>> = OnceLock::new();
    ENTRIES.get_or_init(|| TABLE.lines().filter_map(read_entry).collect())
}

/// Parses a line of the table; `None` for a comment. An invalid line is treated as a comment, because the table is part
/// of the library and covered by its tests.
fn read_entry(line: &str) -> Option<Entry> {
    let fields: Vec<&str> = line.split(';').map(str::trim).collect();
    let &[name, aliases, code, latitude, longitude, height] = fields.as_slice() else { return None };
    let mut site = Site::new_deg(name, latitude.parse().ok()?, longitude.parse().ok()?, height.parse().ok()?).ok()?;
    site.mpc_code = (!code.is_empty()).then(|| code.to_owned());
    let keys = std::iter::once(name).chain(aliases.split('|')).map(key_of).filter(|key| !key.is_empty()).collect();
    Some(Entry { site, keys })
}

fn key_of(name: &str) -> String {
    in_ascii(name).chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Returns true if the first words of a name, but not all of its words, are the key.
fn begins_with(name: &str, key: &str) -> bool {
    let words: Vec<String> = name.split(|c: char| !c.is_alphanumeric()).map(key_of).collect();
    !key.is_empty() && (1..words.len()).any(|count| words[..count].concat() == key)
}

/// Returns up to four similar names: first those that contain the text or are contained in it, then by edit distance.
/// Any other name is similar if at most a third of its letters differ, or if it begins with the same four letters.
fn nearest_names(key: &str) -> Vec<String> {
    let mut ranked: Vec<(usize, &str)> = table()
        .iter()
        .filter_map(|entry| {
            let distance = |known: &String| {
                if is_within(key, known) || is_within(known, key) {
                    return Some(0);
                }
                let changes = strsim::levenshtein(key, known);
                let letters = key.chars().count().max(known.chars().count());
                let alike = key.chars().zip(known.chars()).take_while(|(a, b)| a == b).count();
                (3 * changes <= letters || alike >= LEAST_COMMON_LETTERS).then_some(changes)
            };
            Some((entry.keys.iter().filter_map(distance).min()?, entry.site.name.as_str()))
        })
        .collect();
    ranked.sort_by_key(|&(distance, _)| distance);
    ranked.iter().take(4).map(|&(_, name)| name.to_owned()).collect()
}

/// Returns true if a part long enough to be significant occurs in a text.
fn is_within(part: &str, whole: &str) -> bool {
    part.chars().count() >= LEAST_COMMON_LETTERS && whole.contains(part)
}

/// Observer at a site, with its Earth-fixed quantities computed once.
#[derive(Clone, Debug, PartialEq)]
pub struct Observer {
    site: Site,
    itrs: Position<Itrs>,
    horizon: Rotation<Itrs, Horizontal>,
}

/// Position, velocity and horizon of an observer at one moment.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ObserverState {
    /// Geocentric position, km.
    pub position: Position<Gcrs>,
    /// Geocentric velocity, km/s: the Earth's rotation, at most 0.465.
    pub velocity: Velocity<Gcrs>,
    /// Rotation from the celestial axes to north, east, zenith.
    pub horizon: Rotation<Gcrs, Horizontal>,
}

impl Observer {
    /// Creates an observer at a site.
    pub fn new(site: Site) -> Self {
        let (itrs, horizon) = (site.itrs(), site.horizon());
        Self { site, itrs, horizon }
    }

    /// Returns the site.
    pub fn site(&self) -> &Site {
        &self.site
    }

    /// Returns the Earth-fixed position, km.
    pub fn itrs(&self) -> Position<Itrs> {
        self.itrs
    }

    /// Returns the geocentric celestial position.
    pub fn position(&self, orientation: &Orientation) -> Position<Gcrs> {
        orientation.itrs_to_gcrs * self.itrs
    }

    /// Returns the geocentric celestial position and velocity, and the rotation to the horizon.
    ///
    /// The velocity is ω × r about the pole of date. Changes of the length of day (10⁻⁸) and polar motion are
    /// neglected, with an error below 0.01 mm/s.
    pub fn state(&self, orientation: &Orientation) -> ObserverState {
        let in_teme = (orientation.itrs_to_teme * self.itrs).vector().to_owned();
        let turn = Vector3::new(-in_teme.y, in_teme.x, 0.0) * EARTH_ROTATION_RAD_S;
        ObserverState {
            position: self.position(orientation),
            velocity: orientation.teme_to_gcrs * Velocity::from_vector(turn),
            horizon: self.horizon * orientation.itrs_to_gcrs.inverse(),
        }
    }

    /// Returns the altitude of the Sun's centre, radians, without refraction. Both tables must have the same reference.
    pub(crate) fn sun_altitude_rad(&self, orientation: &OrientationTable, sun: &SunTable, seconds: f64) -> f64 {
        let state = self.state(&orientation.at_s(seconds));
        state.sine_of_altitude(&(sun.at_s(seconds).sun - state.position)).clamp(-1.0, 1.0).asin()
    }
}

impl ObserverState {
    /// Returns the altitude and azimuth of a vector from the observer, radians, without refraction. Azimuth is measured
    /// from north through east, in [0, 2π). `None` for a vector of length 0.
    pub fn altitude_azimuth_rad(&self, geometric: &Position<Gcrs>) -> Option<(f64, f64)> {
        let direction = (self.horizon * *geometric).direction()?;
        Some((direction.latitude_rad(), direction.longitude_rad()))
    }

    /// Returns the altitude and azimuth of the Sun's centre, radians, as
    /// [`altitude_azimuth_rad`](Self::altitude_azimuth_rad), without aberration (20"); `None` outside the years 1900 to
    /// 2100.
    pub fn sun_altitude_azimuth_rad(&self, moment: Epoch) -> Option<(f64, f64)> {
        let seen = self.altitude_azimuth_rad(&(SunState::at(moment).sun - self.position));
        seen.filter(|(altitude, _)| altitude.is_finite())
    }

    /// Returns the sine of the altitude of a vector from the observer, for comparisons that need no inverse function;
    /// NaN for a vector of length 0.
    pub fn sine_of_altitude(&self, geometric: &Position<Gcrs>) -> f64 {
        (self.horizon.matrix() * geometric.vector()).z / geometric.norm_km()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance of positions, metres: a campus is some hundred metres wide, and the entry of astropy is often another
    /// dome of it, or rounded to an arcminute. At 1000 km, 1 km is three arcminutes; better positions must be given as
    /// numbers.
    const CAMPUS_M: f64 = 1000.0;

    /// `name, latitude, longitude east, height` from astropy's site table (astropy-data, sites.json of 2025), with its
    /// sources.
    const PUBLISHED: [(&str, f64, f64, f64); 14] = [
        ("rubin", -30.244_633_33, 289.250_583_33, 2662.75),
        ("Cerro Tololo", -30.165_277_78, 289.185, 2215.0),   // IRAF
        ("paranal", -24.627_439_41, -70.404_986_88, 2669.0), // VLTI raw data
        ("lasilla", -29.256_666_67, 289.27, 2347.0),         // IRAF
        ("Subaru", 19.825_555_56, 204.523_888_89, 4139.0),   // Subaru
        ("irtf", 19.826_218_32, -155.471_998_79, 4168.0),    // IRTF
        ("Palomar", 33.356, 243.137, 1706.0),                // IRAF
        ("kpno", 31.963_333_33, 248.4, 2120.0),              // IRAF
        ("DCT", 34.744_305, 248.577_485, 2337.0),            // GPS 2013
        ("apo", 32.78, 254.18, 2798.0),                      // IRAF
        ("lapalma", 28.758_333_33, 342.12, 2327.0),          // IRAF
        ("CAHA", 37.223_611_11, 357.453_889, 2168.0),        // Wikipedia
        ("ohp", 43.930_833_33, 5.713_333_33, 650.0),         // OHP
        ("aao", -31.277_038_89, 149.066_086_11, 1164.0),     // IRAF
    ];

    #[test]
    fn valid_positions_against_astropy() {
        for (name, latitude, longitude, height) in PUBLISHED {
            let by_name = Site::by_name(name).expect(name);
            let by_coordinates = Site::new_deg(name, latitude, longitude, height).expect(name);
            let distance_m = (by_name.itrs() - by_coordinates.itrs()).norm_km() * 1e3;
            assert!(distance_m < CAMPUS_M, "{name}: {distance_m:.0} m");
        }
    }

    #[test]
    fn verif_positions_and_coordinates_agree() {
        for site in Site::all() {
            let itrs_m = site.itrs().vector() * 1e3;
            let back = Site::from_itrs_m(&site.name, [itrs_m.x, itrs_m.y, itrs_m.z]).unwrap();
            let distance_m = (back.itrs() - site.itrs()).norm_km() * 1e3;
            assert!(distance_m < 1e-4 && (back.height_m - site.height_m).abs() < 1e-4, "{}: {distance_m} m", site.name);
        }
        for out in [[0.0; 3], [f64::NAN, 1.0, 6.4e6], [7e6, 0.0, 0.0]] {
            assert!(Site::from_itrs_m("none", out).is_err(), "{out:?}");
        }
    }

    #[test]
    fn every_line_is_a_site_with_names_of_its_own() {
        let lines = TABLE.lines().filter(|line| !line.starts_with('#')).count();
        assert_eq!(Site::all().count(), lines);
        assert!(lines >= 120, "{lines}");
        let mut seen = std::collections::HashMap::new();
        let mut codes = std::collections::HashSet::new();
        for entry in table() {
            for key in &entry.keys {
                if let Some(other) = seen.insert(key, &entry.site.name) {
                    let is_shared = ["cerropachon", "pachon", "catalinaskysurvey", "css"].contains(&key.as_str());
                    assert!(is_shared || other == &entry.site.name, "{key} names two sites");
                }
            }
            if let Some(code) = &entry.site.mpc_code {
                assert!(codes.insert(code), "{code} twice");
            }
            assert!((-10.0..6000.0).contains(&entry.site.height_m), "{:?}", entry.site);
        }
    }

    #[test]
    fn names_are_found_as_people_write_them() {
        for name in
            ["rubin", "Rubin Observatory", "vera c rubin observatory", "RUBIN-Observatory", "lsst", "X05", "x05"]
        {
            assert_eq!(Site::by_name(name).expect(name).mpc_code.as_deref(), Some("X05"), "{name}");
        }
        assert_eq!(Site::from_mpc(" i41 ").expect("ZTF").name, "Palomar ZTF");
        assert_eq!(Site::by_name("ZTF/Palomar").expect("ZTF").name, "Palomar ZTF");
        for name in ["Ondřejov", "ONDŘEJOV", "Ondr\u{30c}ejov"] {
            assert_eq!(Site::by_name(name).expect(name).name, "Ondrejov");
        }
        for code in ["X05", "W84", "I41", "F51", "F52", "T05", "T08", "M22", "W68", "658", "568", "950"] {
            assert_eq!(Site::from_mpc(code).expect(code).mpc_code.as_deref(), Some(code));
        }
    }

    #[test]
    fn names_of_networks_are_ambiguous() {
        for (name, sites) in [
            ("ATLAS", 5),
            ("Gemini", 2),
            ("goto", 2),
            ("TRAPPIST", 2),
            ("SPECULOOS", 2),
            ("Lowell Observatory", 2),
            ("LCO", 6),
            ("Faulkes Telescope", 2),
            // Mountains with several observatories.
            ("Cerro Pachon", 3),
            ("Cerro Pachón", 3),
            ("Cerro Armazones", 2),
            ("Catalina Sky Survey", 2),
        ] {
            let error = Site::by_name(name).expect_err(name).to_string();
            assert!(error.starts_with(&format!("site name \"{name}\" fits several sites: ")), "{error}");
            assert!(error.matches(", ").count() + 1 >= sites, "{error}");
        }
        let pachon = Site::by_name("Cerro-Pachon").unwrap_err().to_string();
        assert!(pachon.contains("Rubin Observatory, Gemini South, SOAR; specify one of them"), "{pachon}");
        // Both telescopes are at one site, or the name is that of one site.
        assert_eq!(Site::by_name("Pan-STARRS").expect("two telescopes").mpc_code.as_deref(), Some("F51"));
        assert_eq!(Site::by_name("Palomar").expect("a full name").mpc_code.as_deref(), Some("675"));
    }

    #[test]
    fn unknown_names_list_similar_names() {
        let error = Site::by_name("Paranall").expect_err("no such site");
        assert!(error.to_string().starts_with("unknown site \"Paranall\": similar names: Paranal"), "{error}");
        for (name, near) in [("palomr", "Palomar"), ("la sila", "La Silla"), ("Mauna Koa", "Maunakea")] {
            let error = Site::by_name(name).expect_err(name).to_string();
            let names = error.split_once(": similar names: ").expect(&error).1;
            assert!(names.starts_with(near) && names.matches(", ").count() < 4, "{error}");
        }
        for name in ["Moon", "xyzzy", "q", "Gondwana Station", "北京", ""] {
            let error = Site::by_name(name).expect_err(name).to_string();
            assert!(error.starts_with(&format!("unknown site \"{name}\"; allowed: ")), "{error}");
        }
        let error = Site::from_mpc("ZZ9").expect_err("no such code").to_string();
        assert!(error.starts_with("unknown MPC observatory code \"ZZ9\"; allowed: the "), "{error}");
    }

    #[test]
    fn numbers_out_of_range() {
        for (latitude, longitude, height) in [
            (91.0, 0.0, 0.0),
            (0.0, -181.0, 0.0),
            (0.0, 361.0, 0.0),
            (f64::NAN, 0.0, 0.0),
            (0.0, f64::INFINITY, 0.0),
            (0.0, 0.0, 4e5),
        ] {
            assert!(Site::new_deg("here", latitude, longitude, height).is_err(), "{latitude} {longitude} {height}");
        }
        let error = Site::new_deg("here", -91.5, 0.0, 0.0).expect_err("beyond the pole");
        assert_eq!(error.to_string(), "latitude of site \"here\" is -91.5 deg; allowed: -90 to 90 deg");
        assert_eq!(Site::new_deg("a", 0.0, 289.0, 0.0).expect("a site").longitude_rad, (-71.0_f64).to_radians());
    }

    #[test]
    fn pole_and_equator_of_the_ellipsoid() {
        let pole = Site::new_deg("pole", 90.0, 0.0, 0.0).expect("a site").itrs();
        assert!((pole.vector().z - 6_356.752_314_245).abs() < 1e-9);
        let equator = Site::new_deg("equator", 0.0, 90.0, 1000.0).expect("a site").itrs();
        assert!((equator.vector().y - 6_379.137).abs() < 1e-9);
    }
}
