//! Flags of `map`.

use std::path::PathBuf;

#[cfg(feature = "plot")]
use clap::ValueEnum;
use clap::{Args, Subcommand};
use streakcast::config::{Config, LightConfig, RunConfig, SiteConfig};

#[derive(Args)]
pub struct MapArguments {
    #[command(subcommand)]
    pub verb: MapVerb,
}

#[derive(Subcommand)]
pub enum MapVerb {
    /// Magnitude at 1000 km in every direction below a satellite
    Body(Box<MapBodyArguments>),
    /// Apparent magnitude over the sky of a site, for satellites of one height
    Sky(Box<MapSkyArguments>),
    /// The twelve maps of figures 6 to 9 of Lu (2024) as four pictures
    #[cfg(feature = "plot")]
    Paper(Box<MapPaperArguments>),
}

/// Light of the magnitudes, and the run.
#[derive(Args)]
pub struct LightArguments {
    #[command(flatten)]
    pub magnitudes: LightConfig,
    #[command(flatten)]
    pub run: RunConfig,
}

/// Which directions, and where the map goes.
#[derive(Args)]
pub struct MapOutputArguments {
    /// Steps of the grid in degrees, 0.1 to 5, a whole number of them in 90; 2 where unsaid
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with = "nside", help_heading = "Output")]
    pub step_deg: Option<f64>,
    /// HEALPix cells in RING order instead of steps: 1 to 1024; 64 where the format is fits
    #[arg(long, value_name = "N", help_heading = "Output")]
    pub nside: Option<u32>,
    /// table (on a terminal), csv (anywhere else), ecsv, json, jsonl, fits (HEALPix, needs -o); by the end of -o where unsaid
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub format: Option<String>,
    /// File to write, whole or not at all; standard output where unsaid, nothing there where only a picture is wanted
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
    /// Picture of the same map: a file that ends in .png or .svg
    #[cfg(feature = "plot")]
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub picture: Option<PathBuf>,
}

/// What a map of a satellite's own sky shows.
#[derive(Args)]
pub struct BodyViewArguments {
    /// Brightness model by name (streakcast model list), or a model file
    #[arg(long, value_name = "NAME")]
    pub model: String,
    /// The Sun above the plane of the chassis, degrees (negative below it)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub sun_latitude_deg: f64,
    /// Height of the satellite above 6378.137 km, km
    #[arg(long, value_name = "KM", default_value_t = 550.0, allow_hyphen_values = true)]
    pub height_km: f64,
    #[command(flatten)]
    pub light: LightArguments,
}

#[derive(Args)]
pub struct MapBodyArguments {
    #[command(flatten)]
    pub view: BodyViewArguments,
    #[command(flatten)]
    pub output: MapOutputArguments,
}

/// What a map of a site's sky shows.
#[derive(Args)]
pub struct SkyViewArguments {
    /// Brightness model by name (streakcast model list), or a model file
    #[arg(long, value_name = "NAME")]
    pub model: String,
    /// The Sun above the horizon, degrees (negative below it)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub sun_altitude_deg: f64,
    /// Azimuth of the Sun from north through east, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub sun_azimuth_deg: f64,
    /// Height of the satellites above 6378.137 km, km
    #[arg(long, value_name = "KM", default_value_t = 550.0, allow_hyphen_values = true)]
    pub height_km: f64,
    /// The Earth's shadow: geometric (the solid Earth), or atmosphere (bent and reddened light too)
    #[arg(long, value_name = "MODEL")]
    pub shadow: Option<String>,
    /// Extinction of the air, mag per airmass; magnitudes above the air where unsaid
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub extinction: Option<f64>,
    #[command(flatten)]
    pub site: SiteConfig,
    #[command(flatten)]
    pub light: LightArguments,
}

#[derive(Args)]
pub struct MapSkyArguments {
    #[command(flatten)]
    pub view: SkyViewArguments,
    #[command(flatten)]
    pub output: MapOutputArguments,
}

/// Which pictures.
#[cfg(feature = "plot")]
#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum PictureName {
    Png,
    Svg,
}

#[cfg(feature = "plot")]
#[derive(Args)]
pub struct MapPaperArguments {
    /// Folder for figure-6 to figure-9; it is made where it is missing
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Pixels or lines
    #[arg(long, value_name = "FORMAT", default_value = "png")]
    pub format: PictureName,
    /// Brightness model by name (streakcast model list), or a model file
    #[arg(long, value_name = "NAME", default_value = "starlink-v1.5")]
    pub model: String,
    #[command(flatten)]
    pub light: LightArguments,
}

impl LightArguments {
    /// Returns the configuration of these flags and of a site, laid over the configuration file.
    pub fn config(&self, site: SiteConfig) -> anyhow::Result<Config> {
        let flags = Config { light: self.magnitudes.clone(), run: self.run.clone(), site, ..Config::default() };
        Ok(flags.with_file()?)
    }
}
