//! What several verbs let type: satellites, site, camera, exposure, rules, output.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use streakcast::config::{FieldSetup, OneOrMany, PolicySetup, Quantity, Setup, SiteSetup, TelescopeSetup};
use streakcast::schedule::MagnitudeLimit;

use crate::output::Output;

/// No clock is farther from UTC, hours.
const FARTHEST_CLOCK_H: f64 = 14.0;

/// Catalogue numbers have nine digits at most.
const MOST_NORAD: u32 = 999_999_999;

/// Satellites, site, camera and output: the same for every verb.
#[derive(Args)]
pub struct SharedArguments {
    /// Element sets: TLE, 2LE, 3LE, OMM as JSON, CSV, XML or KVN, plain or gzipped
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = "Satellites")]
    pub elements: Vec<PathBuf>,
    /// Synthetic constellations (streakcast shells lists them), or a TOML file of one's own
    #[arg(long, value_name = "NAME", num_args = 1.., value_delimiter = ',', help_heading = "Satellites")]
    pub shells: Vec<String>,
    /// Take element sets with a wrong checksum
    #[arg(long, help_heading = "Satellites")]
    pub accept_bad_checksums: bool,
    /// Standard magnitudes in the form of McCants' qs.mag
    #[arg(long, value_name = "FILE", help_heading = "Satellites")]
    pub qs_mag: Option<PathBuf>,
    #[command(flatten)]
    pub place: PlaceArguments,
    /// A telescope in orbit instead of a site: a file with its element set
    #[arg(long, value_name = "FILE", help_heading = "Site")]
    pub observer_elements: Option<PathBuf>,
    /// NORAD number of the telescope in orbit, in that file, or where none is named among --elements
    #[arg(long, value_name = "ID", value_parser = norad_id, help_heading = "Site")]
    pub observer_norad: Option<u32>,
    /// Height of the air, km, that hides what a telescope in orbit would see behind it; 0 where unsaid
    #[arg(long, value_name = "KM", allow_hyphen_values = true, help_heading = "Site")]
    pub limb_height_km: Option<f64>,
    /// The Earth's shadow: geometric (the solid Earth), or atmosphere (bent and reddened light too)
    #[arg(long, value_name = "MODEL", help_heading = "Satellites")]
    pub shadow: Option<String>,
    /// Full diameter of a circular field with its unit, as 3.5deg or 40arcmin
    #[arg(long, value_name = "ANGLE", help_heading = "Camera")]
    pub fov: Option<String>,
    /// Field of any shape: a JSON file of circles, rectangles and polygons
    #[arg(long, value_name = "FILE", help_heading = "Camera")]
    pub field: Option<PathBuf>,
    /// Position angle of the field's y axis, degrees from north through east
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Camera")]
    pub rotation: Option<f64>,
    /// Telescope: atlas, decam, pan-starrs, rubin, small, vst, ztf, or a TOML file
    #[arg(long, value_name = "NAME", help_heading = "Camera")]
    pub telescope: Option<String>,
    #[command(flatten, next_help_heading = "Camera")]
    pub magnitudes: MagnitudeArguments,
    /// Extinction of the site in the band, mag per airmass: magnitudes below the air
    #[arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Camera")]
    pub extinction: Option<f64>,
    /// Magnitudes with the Sun's distance of the day (up to 0.04 mag), not at 1 au
    #[arg(long, help_heading = "Camera")]
    pub sun_distance: bool,
    /// Near misses count too where they are at least this probable
    #[arg(long, value_name = "P", help_heading = "Camera")]
    pub min_probability: Option<f64>,
    /// Scale of times that name none: utc, tai or tt
    #[arg(long, value_name = "SCALE", help_heading = "Time")]
    pub time_scale: Option<String>,
    /// UT1 and polar motion: an IERS finals2000A file
    #[arg(long, value_name = "FILE", help_heading = "Time")]
    pub eop: Option<PathBuf>,
    /// Configuration file: these flags by name; flags that are typed win
    #[arg(long, value_name = "FILE", help_heading = "Run")]
    pub config: Option<PathBuf>,
    /// Threads, 1 to 1024; all cores where unsaid
    #[arg(long, value_name = "N", help_heading = "Run")]
    pub threads: Option<usize>,
    /// No warnings, no progress
    #[arg(long, short, help_heading = "Run")]
    pub quiet: bool,
}

/// In which band magnitudes are told, and of what light.
#[derive(Args)]
pub struct MagnitudeArguments {
    /// Passband of the magnitudes: B V R I u g r i z y G
    #[arg(long, value_name = "BAND")]
    pub band: Option<String>,
    /// Zero point of the magnitudes: Vega or AB; each band has its usual one
    #[arg(long, value_name = "SYSTEM")]
    pub mag_system: Option<String>,
    /// Sunlight alone on models made of panels, without the light that the Earth throws on them
    #[arg(long)]
    pub no_earthshine: bool,
}

impl MagnitudeArguments {
    /// What of them a setup holds.
    pub fn setup(&self) -> Setup {
        Setup {
            band: self.band.clone(),
            mag_system: self.mag_system.clone(),
            earthshine: self.no_earthshine.then_some(false),
            ..Setup::default()
        }
    }
}

/// One exposure.
#[derive(Args)]
pub struct ExposureArguments {
    /// Shutter opening, as 2024-08-14T00:30:00.000Z
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub start: Option<String>,
    /// Length of the exposure with its unit, as 30s or 2min
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub exposure: Option<String>,
    /// Right ascension of the field's centre (ICRS): 188.5 (degrees) or 12h34m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    pub ra: Option<String>,
    /// Declination of the field's centre (ICRS): -30.5 or -30d30m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    pub dec: Option<String>,
}

impl ExposureArguments {
    /// What of it a setup holds.
    pub fn setup(&self) -> Setup {
        let text = |value: &Option<String>| value.clone().map(Quantity::Text);
        Setup {
            start: text(&self.start),
            exposure: text(&self.exposure),
            ra: text(&self.ra),
            dec: text(&self.dec),
            ..Setup::default()
        }
    }
}

#[derive(Args)]
pub struct OutputArguments {
    /// table (on a terminal), csv (anywhere else), ecsv, json, jsonl, votable; parquet in builds that have it
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub format: Option<String>,
    /// File to write, whole or not at all; standard output where unsaid
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
}

impl OutputArguments {
    /// Where the answer goes, and how; what a configuration says counts where nothing was typed.
    pub fn open(self, setup: &Setup) -> anyhow::Result<Output> {
        Output::new(self.format.as_deref().or(setup.format.as_deref()), self.output)
    }
}

/// What makes an exposure bad.
#[derive(Args)]
pub struct RulesArguments {
    /// Policy file (TOML)
    #[arg(long, value_name = "FILE")]
    pub policy: Option<PathBuf>,
    /// Crossings brighter than this, in the band asked for, make an exposure one to avoid: 7, or by the exposure's band g=7,y=5,default=6
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<MagnitudeLimit>,
    /// The longest wait for a clear field with its unit, as 10min
    #[arg(long, value_name = "TIME")]
    pub max_delay: Option<String>,
}

impl SharedArguments {
    /// Flags of a camera say nothing where there is none; that is better said than passed over. `of_what` they change nothing, for the message.
    ///
    /// # Errors
    /// One of them was typed.
    pub fn no_camera(&self, of_what: &str) -> anyhow::Result<()> {
        let said = [
            ("--fov", self.fov.is_some()),
            ("--field", self.field.is_some()),
            ("--rotation", self.rotation.is_some()),
            ("--telescope", self.telescope.is_some()),
            ("--min-probability", self.min_probability.is_some()),
        ];
        match said.iter().find(|(_, is_said)| *is_said) {
            Some((flag, _)) => Err(anyhow!("{flag} changes nothing of {of_what}; leave it out")),
            None => Ok(()),
        }
    }

    /// What was typed, over what the configuration file says.
    pub fn setup(&self, typed: Setup) -> anyhow::Result<Setup> {
        let many = |paths: &[PathBuf]| (!paths.is_empty()).then(|| OneOrMany::Many(paths.to_vec()));
        let shared = Setup {
            elements: many(&self.elements),
            shells: (!self.shells.is_empty()).then(|| OneOrMany::Many(self.shells.clone())),
            accept_bad_checksums: self.accept_bad_checksums.then_some(true),
            qs_mag: self.qs_mag.clone(),
            observer_elements: self.observer_elements.clone(),
            observer_norad: self.observer_norad,
            limb_height_km: self.limb_height_km,
            shadow: self.shadow.clone(),
            fov: self.fov.clone().map(Quantity::Text),
            field: self.field.clone().map(FieldSetup::File),
            rotation: self.rotation,
            telescope: self.telescope.clone().map(TelescopeSetup::Name),
            extinction: self.extinction,
            sun_distance: self.sun_distance.then_some(true),
            min_probability: self.min_probability,
            time_scale: self.time_scale.clone(),
            eop: self.eop.clone(),
            threads: self.threads,
            quiet: self.quiet.then_some(true),
            ..self.place.setup()
        };
        let said = typed.over(shared).over(self.magnitudes.setup());
        Ok(match &self.config {
            Some(path) => said.over(Setup::read(path)?),
            None => said,
        })
    }
}

impl RulesArguments {
    /// What of them a setup holds.
    pub fn setup(&self) -> Setup {
        Setup {
            policy: self.policy.clone().map(PolicySetup::File),
            limit_mag: self.limit_mag.clone(),
            max_delay: self.max_delay.clone().map(Quantity::Text),
            ..Setup::default()
        }
    }
}

/// A NORAD catalogue number.
pub fn norad_id(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (1..=MOST_NORAD).contains(number));
    number.ok_or_else(|| format!("allowed: NORAD catalogue numbers, 1 to {MOST_NORAD}, as 25544"))
}

/// Hours ahead of UTC: `+01:00`, `-4:30`, `+5`, `5.75`, `Z`.
pub fn utc_offset_h(text: &str) -> Result<f64, String> {
    let hours = if text.eq_ignore_ascii_case("z") { Some(0.0) } else { signed_hours(text) };
    hours
        .filter(|hours| (-FARTHEST_CLOCK_H..=FARTHEST_CLOCK_H).contains(hours))
        .ok_or_else(|| "allowed: hours ahead of UTC from -14:00 to +14:00, as +01:00 or -4.5".to_owned())
}

fn signed_hours(text: &str) -> Option<f64> {
    let (sign, rest) = match (text.strip_prefix('+'), text.strip_prefix(['-', '\u{2212}'])) {
        (Some(rest), _) => (1.0, rest),
        (_, Some(rest)) => (-1.0, rest),
        _ => (1.0, text),
    };
    let (hours, minutes) = rest.split_once(':').unwrap_or((rest, "0"));
    let whole = |text: &str| text.parse::<u8>().ok().filter(|_| text.bytes().all(|byte| byte.is_ascii_digit()));
    if let Some(hours) = whole(hours) {
        return Some(sign * (f64::from(hours) + f64::from(whole(minutes).filter(|minutes| *minutes < 60)?) / 60.0));
    }
    // With a part of an hour after the point, no minutes.
    let is_decimal = rest.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    rest.parse::<f64>().ok().filter(|_| is_decimal).map(|hours| sign * hours)
}

/// A configuration file, or nothing said.
pub fn setup_of(config: Option<&Path>) -> anyhow::Result<Setup> {
    Ok(config.map(Setup::read).transpose()?.unwrap_or_default())
}

/// Where the observer stands.
#[derive(Args)]
pub struct PlaceArguments {
    /// Observatory by name (streakcast sites lists them)
    #[arg(long, value_name = "NAME", help_heading = "Site")]
    pub site: Option<String>,
    /// Observatory by MPC code
    #[arg(long, value_name = "CODE", help_heading = "Site")]
    pub mpc: Option<String>,
    /// Latitude, degrees north (WGS84)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Site")]
    pub lat: Option<f64>,
    /// Longitude, degrees east
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Site")]
    pub lon: Option<f64>,
    /// Height above the ellipsoid, metres
    #[arg(long, value_name = "M", allow_hyphen_values = true, help_heading = "Site")]
    pub height: Option<f64>,
}

impl PlaceArguments {
    /// What was said of the place, and nothing else.
    pub fn setup(&self) -> Setup {
        Setup {
            site: self.site.clone().map(SiteSetup::Name),
            mpc: self.mpc.clone(),
            lat: self.lat,
            lon: self.lon,
            height: self.height,
            ..Setup::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_of_clocks() {
        for (text, hours) in [
            ("+01:00", 1.0),
            ("-4", -4.0),
            ("5:45", 5.75),
            ("Z", 0.0),
            ("-03:30", -3.5),
            ("+14:00", 14.0),
            ("-4.5", -4.5),
        ] {
            assert_eq!(utc_offset_h(text), Ok(hours), "{text}");
        }
        for text in ["", "+", "CET", "+15:00", "+1:60", "1:2:3", "+-1", "1.5:30", "inf", "1e0", "14.1"] {
            assert!(utc_offset_h(text).is_err(), "{text}");
        }
    }
}
