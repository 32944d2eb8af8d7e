//! The configuration document, filled from command line flags, configuration files and plugins.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::json;

use super::coordinates::{height, latitude, longitude};
#[cfg(feature = "cli")]
use super::coordinates::{parse_height_m, parse_latitude_deg, parse_longitude_deg};
use super::error;
use super::values::{
    FieldChoice, ModelAssignment, ModelSource, ModelsTable, NameOrFile, NameOrTable, PolicyChoice, Quantity,
    SiteChoice, TelescopeChoice, model_assignments, one_or_many,
};
use crate::elements::{Constellation, sha256_hex};
use crate::error::Error;
use crate::input;
use crate::schedule::MagnitudeLimit;

/// Largest accepted NORAD catalogue number (nine digits).
#[cfg(feature = "cli")]
const MOST_NORAD: u32 = 999_999_999;

/// Smallest similarity of two names for a suggestion.
const SIMILAR: f64 = 0.85;

/// Satellites, site, camera, policy and run options of a request. `None` and an empty list mean an omitted key.
///
/// The command line fills it from flags, [`Config::read`] from TOML, and plugins from JSON. [`Config::over`] fills
/// omitted keys from another configuration. In TOML, keys may have hyphens or underscores, and `site`, `telescope`,
/// `field` and `policy` are either the value of the flag or a table.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct Config {
    /// Element sets (TLE, 2LE, 3LE, OMM as JSON, CSV, XML or KVN) and ephemerides of operators (OEM, Modified ITC),
    /// plain or gzipped, or folders of such files; sets of earlier days improve the positions of Starlinks
    #[serde(deserialize_with = "one_or_many")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Satellites"))]
    pub elements: Vec<PathBuf>,
    /// Simulated constellations or sets of them by name (listed by streakcast shells), or a TOML file
    #[serde(deserialize_with = "one_or_many")]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "NAME", num_args = 1.., value_delimiter = ',', help_heading = "Satellites")
    )]
    pub shells: Vec<NameOrFile>,
    /// Accept element sets with a wrong checksum
    #[cfg_attr(feature = "cli", arg(long, num_args = 0, default_missing_value = "true", help_heading = "Satellites"))]
    pub accept_bad_checksums: Option<bool>,
    /// Table of standard magnitudes in the format of McCants' qs.mag
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Satellites"))]
    pub qs_mag: Option<PathBuf>,
    /// Brightness model for all satellites, or for one kind of satellite as KIND=MODEL (--model oneweb=oneweb-panels);
    /// MODEL is a name listed by streakcast model list, or a JSON file
    #[serde(deserialize_with = "model_assignments")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "[KIND=]MODEL", help_heading = "Satellites"))]
    pub model: Vec<ModelAssignment>,
    /// Corrections of magnitudes and delays that streakcast learn wrote
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Satellites"))]
    pub learned: Option<PathBuf>,
    /// Table of streakcast measure (CSV): its magnitudes correct those of the same pass, and mask also uses its tracks
    /// and light
    #[serde(deserialize_with = "one_or_many")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Satellites"))]
    pub measured: Vec<PathBuf>,
    /// Drag of satellites that hold their orbits by thrust: station-keeping (no drag; default) or published (as in the
    /// element set)
    #[cfg_attr(feature = "cli", arg(long, value_name = "MODEL", help_heading = "Satellites"))]
    pub drag: Option<String>,
    /// Model of the Earth's shadow: atmosphere (refraction and extinction; default) or geometric (solid Earth)
    #[cfg_attr(feature = "cli", arg(long, value_name = "MODEL", help_heading = "Satellites"))]
    pub shadow: Option<String>,
    /// Model files, standard magnitudes, and models by generation.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub models: Option<ModelsTable>,
    /// Site on the ground.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", command(flatten))]
    pub site: SiteConfig,
    /// Telescope in orbit instead of a site: file or folder with its element set or ephemerides (OEM, Modified ITC)
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Site"))]
    pub observer_elements: Option<PathBuf>,
    /// NORAD catalogue number of the telescope in orbit, in --observer-elements or else in --elements
    #[cfg_attr(feature = "cli", arg(long, value_name = "ID", value_parser = norad_id, help_heading = "Site"))]
    pub observer_norad: Option<u32>,
    /// Height of the Earth's limb for a telescope in orbit, km: lower lines of sight are rejected; 0 if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "KM", allow_hyphen_values = true, help_heading = "Site"))]
    pub limb_height_km: Option<f64>,
    /// Largest angle between the pointing of a telescope in orbit and its zenith, degrees
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Site"))]
    pub max_zenith_angle: Option<f64>,
    /// Smallest angle between the pointing of a telescope in orbit and the Sun, degrees
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Site"))]
    pub min_sun_angle: Option<f64>,
    /// Smallest angle between the pointing of a telescope in orbit and the Earth's limb, degrees
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Site"))]
    pub min_limb_angle: Option<f64>,
    /// Field of view: diameter of a circle (3.5deg, 40arcmin), width and height (1.5x1.0deg), or sensor and focal
    /// length (36x24mm@400mm)
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", help_heading = "Camera"))]
    pub fov: Option<Quantity>,
    /// Field of view of any shape: JSON file of circles, rectangles and polygons
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Camera"))]
    pub field: Option<FieldChoice>,
    /// Position angle of the field's y axis, degrees from north through east; 0 if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Camera"))]
    pub rotation: Option<f64>,
    /// Telescope: atlas, decam, pan-starrs, rubin, small, vst, ztf, or a TOML file
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME", help_heading = "Camera"))]
    pub telescope: Option<TelescopeChoice>,
    /// Share of an exposure that is lost to a bright streak across the whole field, 0 to 100; that of the telescope,
    /// 0.08 by default, if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "SHARE", help_heading = "Camera"))]
    pub bright_share: Option<f64>,
    /// Band, magnitude system and light sources.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", command(flatten, next_help_heading = "Camera"))]
    pub light: LightConfig,
    /// Atmospheric extinction in the band, mag per airmass; magnitudes outside the atmosphere if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Camera"))]
    pub extinction: Option<f64>,
    /// Correct magnitudes for the Sun's distance of the day (up to 0.04 mag) instead of 1 au
    #[cfg_attr(feature = "cli", arg(long, num_args = 0, default_missing_value = "true", help_heading = "Camera"))]
    pub sun_distance: Option<bool>,
    /// Include near misses with at least this probability of a crossing, above 0, at most 1; in verdicts also the
    /// probability of a bright crossing that gives avoid (0.5 if omitted)
    #[cfg_attr(feature = "cli", arg(long, value_name = "P", help_heading = "Camera"))]
    pub min_probability: Option<f64>,
    /// Time scale of times that have none: utc, tai or tt
    #[cfg_attr(feature = "cli", arg(long, value_name = "SCALE", help_heading = "Time"))]
    pub time_scale: Option<String>,
    /// Time scale from the configuration file for times without a scale. A scale in the column name of a schedule
    /// overrides it; the flag `--time-scale` overrides both.
    #[serde(skip)]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub default_time_scale: Option<String>,
    /// Earth orientation (UT1 and polar motion): IERS finals2000A file; bundled table if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Time"))]
    pub eop: Option<PathBuf>,
    /// Files and threads of the run.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", command(flatten))]
    pub run: RunConfig,
    /// Home file.
    #[serde(skip)]
    #[cfg_attr(feature = "cli", command(flatten))]
    pub home: HomeConfig,
    /// Exposure, for requests with a single exposure.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub exposure: ExposureConfig,
    /// Policy and the limits that override it.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", arg(skip))]
    pub rules: RulesConfig,
    /// Include crossings in the Earth's shadow.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub include_dark: Option<bool>,
    /// Number of points along each track.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub samples: Option<usize>,
    /// Output format.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub format: Option<String>,
    /// Time zone of local times in tables and charts of the command line, which checks it.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub time_zone: Option<String>,
}

/// Site on the ground.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct SiteConfig {
    /// Observatory by name (listed by streakcast sites)
    #[serde(rename = "site")]
    #[cfg_attr(feature = "cli", arg(id = "site", long, value_name = "NAME", help_heading = "Site"))]
    pub named: Option<SiteChoice>,
    /// Observatory by code of the Minor Planet Center
    #[cfg_attr(feature = "cli", arg(long, value_name = "CODE", help_heading = "Site"))]
    pub mpc: Option<String>,
    /// Latitude, degrees north (WGS84): -33.9, 33.9S or 33°54'S
    #[serde(deserialize_with = "latitude")]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = parse_latitude_deg, help_heading = "Site")
    )]
    pub lat: Option<f64>,
    /// Longitude, degrees east: -70.75, 70.75W or 70°45'W
    #[serde(deserialize_with = "longitude")]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = parse_longitude_deg, help_heading = "Site")
    )]
    pub lon: Option<f64>,
    /// Height above the ellipsoid, metres; 0 if omitted
    #[serde(deserialize_with = "height")]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "M", allow_hyphen_values = true, value_parser = parse_height_m, help_heading = "Site")
    )]
    pub height: Option<f64>,
}

impl SiteConfig {
    /// Returns true if any key of a site is given.
    pub fn is_given(&self) -> bool {
        *self != Self::default()
    }
}

/// Band, magnitude system and light sources of the magnitudes.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct LightConfig {
    /// Passband of the magnitudes: B V R I u g r i z y G J H K W1 W2; V if omitted; or
    /// a file of a response curve with the columns wavelength_um and response (AB)
    #[cfg_attr(feature = "cli", arg(long, value_name = "BAND"))]
    pub band: Option<NameOrFile>,
    /// Zero point of the magnitudes: Vega or AB; the usual one of the band if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "SYSTEM"))]
    pub mag_system: Option<String>,
    /// Only sunlight on the panels of models: ignore earthshine and the diffuse body
    #[cfg_attr(feature = "cli", arg(long = "no-earthshine", num_args = 0, default_missing_value = "true", value_parser = parse_opposite))]
    pub earthshine: Option<bool>,
}

/// Files and threads of the run.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct RunConfig {
    /// Configuration file (TOML) with the names of flags as keys; flags on the command line override it
    #[serde(skip)]
    #[cfg_attr(feature = "cli", arg(long = "config", value_name = "FILE", help_heading = "Run"))]
    pub file: Option<PathBuf>,
    /// Number of threads, 1 to 1024; all cores if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Run"))]
    pub threads: Option<usize>,
    /// Suppress warnings, summaries and progress
    #[cfg_attr(feature = "cli", arg(long, short, num_args = 0, default_missing_value = "true", help_heading = "Run"))]
    pub quiet: Option<bool>,
    /// List all element sets that cannot be propagated, with reasons
    #[cfg_attr(
        feature = "cli",
        arg(long, num_args = 0, default_missing_value = "true", conflicts_with = "quiet", help_heading = "Run")
    )]
    pub verbose: Option<bool>,
}

/// Home file: a configuration file with values for omitted flags and keys, which the command line finds by itself.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct HomeConfig {
    /// Path of the home file; `None` if it is not read.
    #[cfg_attr(feature = "cli", arg(id = "home", long = "home", value_name = "FILE", hide = true))]
    pub file: Option<PathBuf>,
    /// Do not read the home file (see streakcast setup)
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Run"))]
    pub no_home: bool,
    /// The site is that of the home file. The site in the header of a frame has precedence.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub gives_site: bool,
    /// The time zone is that of the home file.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub gives_time_zone: bool,
}

/// One exposure.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct ExposureConfig {
    /// Shutter opening, for example 2024-08-14T00:30:00.000Z; or now
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub start: Option<Quantity>,
    /// Exposure time with its unit, for example 30s or 2min
    #[serde(rename = "exposure")]
    #[cfg_attr(feature = "cli", arg(id = "exposure", long, value_name = "TIME", allow_hyphen_values = true))]
    pub duration: Option<Quantity>,
    /// Field's centre by name instead of --ra and --dec: a Messier or Caldwell object, also by NGC or IC number
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME"))]
    pub target: Option<String>,
    /// Right ascension of the field's centre (ICRS): 188.5 (degrees) or 12h34m
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", allow_hyphen_values = true))]
    pub ra: Option<Quantity>,
    /// Declination of the field's centre (ICRS): -30.5 or -30d30m
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", allow_hyphen_values = true))]
    pub dec: Option<Quantity>,
}

/// Rules for verdicts: the policy, and limits that override those in it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct RulesConfig {
    /// Policy file (TOML)
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    pub policy: Option<PolicyChoice>,
    /// Limiting magnitude: brighter crossings give the verdict avoid; 7, or by band g=7,y=5,default=6
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true))]
    pub limit_mag: Option<MagnitudeLimit>,
    /// Limiting surface brightness, mag/arcsec2: brighter streaks give the verdict avoid (with --telescope); 22, or by
    /// band W1=20,default=22
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true))]
    pub limit_surface_brightness: Option<MagnitudeLimit>,
    /// Satellites that block a start: any (all lit ones) or avoid (those that exceed a limit; default)
    #[cfg_attr(feature = "cli", arg(long, value_name = "CHOICE"))]
    pub blocking: Option<String>,
    /// Longest delay in the search for the next clear start, with its unit, for example 10min
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME"))]
    pub max_delay: Option<Quantity>,
}

/// Verbs of the command line that have a table in a configuration file.
#[rustfmt::skip]
const VERBS: [&str; 18] = [
    "passes", "flag", "annotate", "windows", "forecast", "ephemeris", "gate", "identify", "map", "plot", "inject",
    "measure", "mask", "learn", "serve", "statistics", "model", "doctor",
];

/// Largest size of a configuration file, bytes.
const LARGEST_BYTES: u64 = 1_000_000;

/// Largest number of threads.
const MAX_THREADS: usize = 1024;

impl Config {
    /// Reads a configuration file. Relative paths in it are relative to the folder of the file.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or has an unknown key, an invalid value, or keys that exclude each other.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let shown = path.display().to_string();
        Self::check_size(path).map_err(|message| Error::format(message).in_file("configuration", path))?;
        let text = input::read_to_string(path).map_err(|source| error::unreadable("configuration", path, source))?;
        let mut config = Self::from_toml(&text, &shown)?;
        config.start_paths_from(path.parent().unwrap_or(Path::new("")));
        config.check().map_err(|error| {
            // The key without which the check succeeds, or has another error; of several the one that the error names.
            let message = error.to_string();
            let is_invalid =
                |key: &&str| config.without(key).check().map_or_else(|other| other.to_string() != message, |()| true);
            let keys: Vec<_> = config.given().into_iter().filter(is_invalid).collect();
            let named = keys.iter().find(|key| message.contains(&key.replace('_', "-")));
            let line = named.or(keys.first()).and_then(|key| input::toml_line(&text, &[key]));
            let place = line.map_or_else(String::new, |line| format!(": line {line}"));
            error.within(format_args!("configuration {shown}{place}"), path, line)
        })?;
        config.default_time_scale = config.time_scale.take();
        Ok(config)
    }

    /// Checks that a configuration file is not larger than 1,000,000 bytes. Parsing a much larger one takes seconds.
    ///
    /// # Errors
    /// The size, and what is allowed. A file without a size, such as a stream, is accepted.
    pub fn check_size(path: &Path) -> Result<(), String> {
        match path.metadata() {
            Ok(file) if file.len() > LARGEST_BYTES => {
                Err(format!("the file has {} bytes; allowed: at most {LARGEST_BYTES}", file.len()))
            }
            _ => Ok(()),
        }
    }

    /// Parses the text of a configuration file; `origin` is its name in errors.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown, or a value is invalid.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, Error> {
        let in_file = |error: Error| error.in_file("configuration", origin);
        let error = |message: String| in_file(Error::format(message));
        let of_toml = |error: &toml::de::Error| input::toml_error(error, text);
        let of_key = |error: Error, key: &str| {
            in_file(match input::toml_line(text, &[key]) {
                Some(line) => error.on_line(line),
                None => error,
            })
        };
        let keys: toml::Table = toml::from_str(text).map_err(|syntax| in_file(of_toml(&syntax)))?;
        // TOML keys may have hyphens or underscores; the fields have underscores.
        let mut renamed = toml::Table::new();
        for (key, value) in keys {
            let name = key.replace('-', "_");
            if renamed.insert(name.clone(), value).is_some() {
                return Err(error(format!("{name} is given twice, with hyphens and with underscores; allowed: once")));
            }
        }
        let mut keys = renamed;
        // The command line reads and checks the tables of verbs. It cannot read a stream twice.
        let is_table_of_verb = |key: &str, value: &toml::Value| value.is_table() && VERBS.contains(&key);
        if let Some((verb, _)) = keys.iter().find(|(key, value)| is_table_of_verb(key, value))
            && input::is_stream(Path::new(origin))
        {
            return Err(error(format!("[{verb}] is in a stream; allowed: tables of verbs in a regular file")));
        }
        keys.retain(|key, value| !is_table_of_verb(key, value));
        if let Some(unknown) = keys.keys().find(|key| Self::keys().all(|known| known != *key)) {
            let known = Self::keys().chain(VERBS);
            let similarity = |known: &&str| strsim::jaro_winkler(known, unknown);
            let nearest = known.max_by(|first, other| similarity(first).total_cmp(&similarity(other)));
            let hint = match nearest.filter(|known| similarity(known) > SIMILAR) {
                Some(known) => format!("did you mean {known}?"),
                None => format!("allowed: {}", Self::keys().collect::<Vec<_>>().join(", ")),
            };
            return Err(of_key(Error::format(format!("unknown key '{unknown}'; {hint}")), unknown));
        }
        Config::deserialize(keys.clone()).map_err(|value| {
            // The error of the TOML parser for an invalid value does not contain the key.
            let is_invalid = |(key, value): &(String, toml::Value)| {
                Config::deserialize(toml::Table::from_iter([(key.clone(), value.clone())])).is_err()
            };
            let key = keys.into_iter().find(is_invalid).map(|(key, _)| key).unwrap_or_default();
            of_key(of_toml(&value).at(&key), &key)
        })
    }

    /// Checks all values that need no other file, so that the error is that of this configuration alone.
    fn check(&self) -> Result<(), Error> {
        // A height of the limb without a telescope has no effect if flags give a site.
        let limb_height_km = self.limb_height_km.filter(|_| self.has_viewpoint());
        Config { limb_height_km, ..self.clone() }.check_viewpoint()?;
        self.check_field()?;
        self.check_limits()?;
        self.check_exposure()?;
        self.photometry()?;
        self.rotation_rad()?;
        self.samples()?;
        self.time_scale()?;
        self.drag()?;
        self.shadow()?;
        self.threads()?;
        self.check_names()
    }

    /// Checks the names of the bundled sites, telescopes, constellations and models.
    fn check_names(&self) -> Result<(), Error> {
        if self.site.is_given() {
            self.site()?;
        }
        if let Some(NameOrTable::Name(name)) = &self.telescope
            && !name.is_file()
        {
            self.telescope()?;
        }
        for name in self.shells.iter().filter(|name| !name.is_file()) {
            Constellation::by_name(name)?;
        }
        // Model files may have further names.
        if self.models.as_ref().is_none_or(|models| models.files.is_empty()) {
            let library = self.model_library()?;
            for assigned in &self.model {
                if let ModelSource::Name(name) = &assigned.model {
                    library.find(name)?;
                }
            }
        }
        Ok(())
    }

    /// Returns the number of threads; `None` for all cores.
    ///
    /// # Errors
    /// The number is 0 or above 1024: more threads take minutes to start.
    pub fn threads(&self) -> Result<Option<usize>, Error> {
        match self.run.threads {
            Some(threads) if !(1..=MAX_THREADS).contains(&threads) => {
                Err(Error::invalid("threads", threads, format!("1 to {MAX_THREADS}")))
            }
            threads => Ok(threads),
        }
    }

    /// Fills omitted keys from the configuration file, and then from the home file, if they are given.
    ///
    /// # Errors
    /// Same as [`Config::read`].
    pub fn with_file(self) -> Result<Self, Error> {
        self.with_configuration_file()?.with_home_file()
    }

    /// Fills omitted keys from the configuration file, if one is given, and not from the home file.
    ///
    /// # Errors
    /// Same as [`Config::read`].
    pub fn with_configuration_file(self) -> Result<Self, Error> {
        match &self.run.file {
            Some(path) => {
                let base = Config::read(path)?;
                Ok(self.over(base))
            }
            None => Ok(self),
        }
    }

    /// Fills omitted keys from the home file, if one is given. Its time zone is that of its site: it does not apply to
    /// another site.
    ///
    /// # Errors
    /// Same as [`Config::read`].
    pub fn with_home_file(mut self) -> Result<Self, Error> {
        let Some(path) = &self.home.file else { return Ok(self) };
        let mut base = Config::read(path)?;
        if self.has_viewpoint() {
            base.time_zone = None;
        }
        self.home.gives_site = !self.has_viewpoint() && base.has_viewpoint();
        self.home.gives_time_zone = self.time_zone.is_none() && base.time_zone.is_some();
        Ok(self.over(base))
    }

    /// Returns true if the site is not given, or only in the home file, so that the header of a frame can set it.
    pub fn takes_site_of_frame(&self) -> bool {
        !self.has_viewpoint() || self.home.gives_site
    }

    /// Returns true if a site or a telescope in orbit is given.
    pub fn has_viewpoint(&self) -> bool {
        self.site.is_given() || self.is_in_orbit()
    }

    /// Returns true if a telescope in orbit is given.
    pub fn is_in_orbit(&self) -> bool {
        self.observer_elements.is_some() || self.observer_norad.is_some()
    }

    /// Returns true if files of element sets or synthetic constellations are given.
    pub fn has_satellites(&self) -> bool {
        !self.elements.is_empty() || !self.shells.is_empty()
    }

    /// Returns the paths of all files in the configuration, except the configuration file itself.
    pub fn files(&self) -> Vec<PathBuf> {
        // `visit_paths` requires a mutable reference.
        let (mut copy, mut files) = (self.clone(), Vec::new());
        copy.visit_paths(&mut |path| files.push(path.clone()));
        files
    }

    /// Returns path and SHA-256 of each file with settings, which are all files but those of element sets, for the
    /// provenance. The SHA-256 of a stream is null.
    pub fn settings_json(&self) -> Vec<serde_json::Value> {
        let others = Config { elements: Vec::new(), observer_elements: None, ..self.clone() };
        let sha256 = |path: &Path| {
            let bytes = if input::is_stream(path) { None } else { input::read(path).ok() };
            bytes.map(|bytes| sha256_hex(&bytes))
        };
        let of_file = |path: PathBuf| json!({ "file": path.display().to_string(), "sha256": sha256(&path) });
        self.run.file.iter().cloned().chain(others.files()).map(of_file).collect()
    }

    /// Returns the configuration without the values that are read from files, so that it can be checked without them.
    pub fn without_files(&self) -> Config {
        let is_file = |telescope: &TelescopeChoice| matches!(telescope, NameOrTable::Name(name) if name.is_file());
        Config {
            elements: Vec::new(),
            shells: self.shells.iter().filter(|name| !name.is_file()).cloned().collect(),
            eop: None,
            observer_elements: None,
            qs_mag: None,
            learned: None,
            models: None,
            model: Vec::new(),
            field: None,
            telescope: self.telescope.clone().filter(|telescope| !is_file(telescope)),
            rules: RulesConfig { policy: None, ..self.rules.clone() },
            light: LightConfig { band: self.light.band.clone().filter(|band| !band.is_file()), ..self.light.clone() },
            ..self.clone()
        }
    }

    /// Returns the text of a value of `key`, with the path in it relative to `folder`.
    pub fn in_folder(key: &str, text: &str, folder: &Path) -> String {
        let config = Config::deserialize(toml::Table::from_iter([(key.to_owned(), text.into())]));
        let files = config.map_or_else(|_| Vec::new(), |config| config.files());
        let of_path = |path: &PathBuf| {
            let before = text.strip_suffix(path.to_str()?)?;
            Some(format!("{before}{}", folder.join(path).display()))
        };
        files.first().and_then(of_path).unwrap_or_else(|| text.to_owned())
    }

    fn start_paths_from(&mut self, folder: &Path) {
        self.visit_paths(&mut |path| *path = folder.join(&*path));
    }
}

/// Reads the value of a flag that switches something off.
#[cfg(feature = "cli")]
fn parse_opposite(text: &str) -> Result<bool, String> {
    text.parse().map(|is_off: bool| !is_off).map_err(|_| "allowed: true, false".to_owned())
}

/// Reads a NORAD catalogue number from the command line.
///
/// # Errors
/// The text is not a number of one to nine digits.
#[cfg(feature = "cli")]
pub fn norad_id(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (1..=MOST_NORAD).contains(number));
    number.ok_or_else(|| format!("not a NORAD catalogue number; allowed: 1 to {MOST_NORAD}, for example 25544"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_and_names_hyphens_and_underscores() {
        let config = Config::from_toml(
            "shells = 'starlink-gen1'\nlimit-mag = 7\nexposure = '30s'\nra = 188.5\n[site]\nmpc = 'X05'\n\
             [telescope]\npreset = 'rubin'\n[policy]\nmargin_s = 3\n[field]\ncircle_deg = 3.5\n",
            "t.toml",
        )
        .unwrap();
        assert_eq!(config.shells, ["starlink-gen1".to_owned().into()]);
        assert_eq!(config.rules.limit_mag, Some(MagnitudeLimit::All(7.0)));
        assert_eq!(config.exposure.ra.as_ref().unwrap().as_str(), "188.5");
        assert_eq!(config.telescope, Some("rubin".to_owned().into()));
        let mpc =
            |table: &SiteChoice| matches!(table, NameOrTable::Table(table) if table.mpc.as_deref() == Some("X05"));
        assert!(config.site.named.as_ref().is_some_and(mpc));
        let margin =
            |policy: &PolicyChoice| matches!(policy, NameOrTable::Table(policy) if policy.margin_s == Some(3.0));
        assert!(config.rules.policy.as_ref().is_some_and(margin));
        let names = "site = 'Rubin'\ntelescope = 'rubin'\nelements = ['a.tle', 'b.tle']\n";
        let names = Config::from_toml(names, "t.toml").unwrap();
        assert_eq!(names.site.named, Some(NameOrTable::Name("Rubin".into())));
        assert_eq!(names.elements.len(), 2);
    }

    #[test]
    fn unknown_keys_and_invalid_values_are_rejected() {
        for text in ["limitmag = 7\n", "[site]\nlatitude = 3\n", "samples = -1\n", "x", "[policy]\nlimit = 3\n"] {
            let message = Config::from_toml(text, "t.toml").unwrap_err().to_string();
            assert!(message.starts_with("configuration t.toml: ") && !message.contains('\n'), "{text}: {message}");
        }
        // Plugins pass JSON.
        assert!(serde_json::from_str::<Config>(r#"{"limitmag": 7}"#).is_err());
    }

    /// The home file lies below the configuration file. Its site is not that of a frame with another one.
    #[test]
    fn the_home_file_fills_what_is_omitted() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
            Some(folder.path().join(name))
        };
        let file = write("home.toml", "mpc = 'X05'\nfov = '1deg'\ntime_scale = 'tai'\n");
        let home = HomeConfig { file, ..HomeConfig::default() };
        let with = |file: Option<PathBuf>, site: SiteConfig| {
            let run = RunConfig { file, ..RunConfig::default() };
            Config { run, home: home.clone(), site, ..Config::default() }.with_file().unwrap()
        };
        let config = with(None, SiteConfig::default());
        assert_eq!((config.site.mpc.as_deref(), config.given_time_scale()), (Some("X05"), Some("tai")));
        assert!(config.takes_site_of_frame() && config.fov.is_some());
        let config = with(write("obs.toml", "lat = 1.0\nlon = 2.0\ntime_scale = 'tt'\n"), SiteConfig::default());
        assert_eq!((config.site.mpc.as_deref(), config.given_time_scale()), (None, Some("tt")));
        assert!(!config.takes_site_of_frame() && config.fov.is_some());
        let flag = SiteConfig { mpc: Some("W84".into()), ..SiteConfig::default() };
        assert!(!with(None, flag).takes_site_of_frame());
    }

    #[test]
    fn paths_start_from_the_folder_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("streakcast.toml");
        std::fs::write(&path, "elements = 'a.tle'\ntelescope = 'mine.toml'\nshells = ['oneweb']\n").unwrap();
        let config = Config::read(&path).unwrap();
        assert_eq!(config.elements, [folder.path().join("a.tle")]);
        let mine = folder.path().join("mine.toml").display().to_string();
        assert_eq!(config.telescope, Some(mine.into()));
        assert_eq!(config.shells, ["oneweb".to_owned().into()]);
        assert_eq!(config.files().len(), 2);
    }
}
