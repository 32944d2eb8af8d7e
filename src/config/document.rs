//! The configuration document, filled from command line flags, configuration files and plugins.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::json;

use super::coordinates::{height, latitude, longitude};
#[cfg(feature = "cli")]
use super::coordinates::{parse_height_m, parse_latitude_deg, parse_longitude_deg};
use super::values::{
    FieldChoice, ModelAssignment, ModelsTable, NameOrFile, NameOrTable, PolicyChoice, Quantity, SiteChoice,
    TelescopeChoice, model_assignments, one_or_many,
};
use crate::elements::sha256_hex;
use crate::error::Error;
use crate::input;
use crate::schedule::MagnitudeLimit;

/// Largest accepted NORAD catalogue number (nine digits).
#[cfg(feature = "cli")]
const MOST_NORAD: u32 = 999_999_999;

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

/// Largest number of threads.
const MAX_THREADS: usize = 1024;

impl Config {
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
