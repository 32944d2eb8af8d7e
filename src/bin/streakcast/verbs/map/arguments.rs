//! Flags of `map`.

use std::path::PathBuf;

use clap::ValueEnum;
use clap::{Args, Subcommand};
use streakcast::config::{Config, LightConfig, RunConfig, SiteConfig};

use crate::help::{Typed, help};

#[derive(Args)]
pub struct MapArguments {
    #[command(subcommand)]
    pub verb: MapVerb,
}

help! {
    MapArguments, "map",
    "sky --model starlink-v1.5 --sun-altitude-deg=-15 --step-deg 5",
    "body --model visorsat --sun-latitude-deg 20 --step-deg 5"
}

#[derive(Subcommand)]
pub enum MapVerb {
    /// Map the magnitude at 1000 km over the directions below a satellite
    Body(Typed<MapBodyArguments>),
    /// Map the apparent magnitude over the sky of a site, for satellites at one height
    Sky(Typed<MapSkyArguments>),
    /// Draw the twelve maps of figures 6 to 9 of Lu (2024) as four pictures
    Paper(Typed<MapPaperArguments>),
}

/// Options of the magnitudes and of the run.
#[derive(Args)]
pub struct LightArguments {
    #[command(flatten)]
    pub magnitudes: LightConfig,
    #[command(flatten)]
    pub run: RunConfig,
}

/// Grid of directions, and outputs.
#[derive(Args)]
pub struct MapOutputArguments {
    /// Step of the grid, degrees, 0.1 to 5, a divisor of 90; 2 if omitted
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, conflicts_with = "nside", help_heading = "Output")]
    pub step_deg: Option<f64>,
    /// HEALPix resolution (RING order) instead of --step-deg, 1 to 1024; 64 for the format fits
    #[arg(long, value_name = "N", help_heading = "Output")]
    pub nside: Option<u32>,
    /// Output format: table, csv, ecsv, json, jsonl, fits (HEALPix, needs -o); by the extension of -o if omitted
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub format: Option<String>,
    /// Output file of the table; if omitted standard output, or no table if --picture is given
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
    /// Picture of the map: a file with the extension .png or .svg
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub picture: Option<PathBuf>,
    /// Size and resolution of the picture, which plot sets.
    #[arg(skip)]
    pub file_options: streakcast::plot::FileOptions,
}

/// Parameters of a map over the directions around a satellite.
#[derive(Args)]
pub struct BodyViewArguments {
    /// Brightness model: name (listed by streakcast model list) or model file
    #[arg(long, value_name = "NAME")]
    pub model: String,
    /// Latitude of the Sun above the plane of the chassis, degrees (negative below)
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

help! {
    MapBodyArguments, "map body",
    "--model visorsat --sun-latitude-deg 20 --step-deg 5",
    "--model visorsat --sun-latitude-deg 20 --picture body.png"
}

/// Parameters of a map over the sky of a site.
#[derive(Args)]
pub struct SkyViewArguments {
    /// Brightness model: name (listed by streakcast model list) or model file
    #[arg(long, value_name = "NAME")]
    pub model: String,
    /// Altitude of the Sun, degrees (negative below the horizon)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub sun_altitude_deg: f64,
    /// Azimuth of the Sun from north through east, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub sun_azimuth_deg: f64,
    /// Height of the satellites above 6378.137 km, km
    #[arg(long, value_name = "KM", default_value_t = 550.0, allow_hyphen_values = true)]
    pub height_km: f64,
    /// Model of the Earth's shadow: atmosphere (refraction and extinction; default) or geometric (solid Earth)
    #[arg(long, value_name = "MODEL")]
    pub shadow: Option<String>,
    /// Atmospheric extinction, mag per airmass; magnitudes outside the atmosphere if omitted
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

help! {
    MapSkyArguments, "map sky",
    "--model visorsat --sun-altitude-deg=-15 --step-deg 5",
    "--model visorsat --sun-altitude-deg=-15 --site Paranal --picture sky.png"
}

/// Format of the pictures.
#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum PictureName {
    Png,
    Svg,
}

#[derive(Args)]
pub struct MapPaperArguments {
    /// Folder for the pictures figure-6 to figure-9; created if missing
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Picture format
    #[arg(long, value_name = "FORMAT", default_value = "png")]
    pub format: PictureName,
    /// Brightness model: name (listed by streakcast model list) or model file
    #[arg(long, value_name = "NAME", default_value = "starlink-v1.5")]
    pub model: String,
    #[command(flatten)]
    pub light: LightArguments,
}

help! { MapPaperArguments, "map paper", "-o figures", "-o figures --format svg" }

impl LightArguments {
    /// Returns the configuration of these flags and a site, with omitted keys taken from the configuration file.
    pub fn config(&self, site: SiteConfig) -> anyhow::Result<Config> {
        let flags = Config { light: self.magnitudes.clone(), run: self.run.clone(), site, ..Config::default() };
        Ok(flags.with_file()?)
    }
}
