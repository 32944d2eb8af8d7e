//! Flags of `plot`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use streakcast::config::{Config, ExposureConfig, LightConfig, Quantity, RulesConfig, norad_id};

use crate::arguments::utc_offset_h;
use crate::verbs::map::{BodyViewArguments, SkyViewArguments};

#[derive(Args)]
#[command(arg_required_else_help = true, args_conflicts_with_subcommands = true)]
pub struct PlotArguments {
    /// All plots, with what each of them needs
    #[arg(long)]
    pub list: bool,
    #[command(subcommand)]
    pub verb: Option<PlotVerb>,
}

#[derive(Subcommand)]
pub enum PlotVerb {
    /// Timeline of a night: exposures that are struck, in the colour of the brightest streak
    Night(Box<PlotNightArguments>),
    /// A field with its streaks: gnomonic, north up, east left, with entry, exit and magnitude
    Field(Box<PlotFieldArguments>),
    /// Magnitude along a track with its error, and when the satellite is in the field
    LightCurve(Box<PlotLightCurveArguments>),
    /// Passes of a forecast over the sky of their site, from rise to set, with times and magnitudes
    SkyChart(Box<PlotSkyChartArguments>),
    /// Expected streaks an exposure over the sky of a site at one moment
    SkyRate(Box<PlotSkyRateArguments>),
    /// Trails an exposure against the Sun's altitude, of a schedule or of a night
    SunAltitude(Box<PlotSunAltitudeArguments>),
    /// Magnitudes over the sky of a site, for satellites of one height
    Sky(Box<PlotSkyArguments>),
    /// Magnitudes at 1000 km over a satellite's own sky
    Body(Box<PlotBodyArguments>),
    /// Posterior of a fit: each parameter, and each pair of parameters
    #[cfg(feature = "fit")]
    Corner(Box<PlotCornerArguments>),
    /// Observed less computed magnitudes against the angles of the geometry
    Residuals(Box<PlotResidualsArguments>),
    /// Observed less computed magnitudes as a histogram
    Histogram(Box<PlotResidualsArguments>),
    /// Magnitudes against the phase angle, observed and computed
    PhaseCurve(Box<PlotResidualsArguments>),
}

/// Where the picture goes, and the numbers that are in it.
#[derive(Args)]
pub struct PictureArguments {
    /// Picture to write, by its end PNG or SVG; may be said again
    #[arg(long, short, value_name = "FILE", required = true, help_heading = "Picture")]
    pub output: Vec<PathBuf>,
    /// The numbers in the picture: a file that ends in .ecsv, .csv, .json or .jsonl; the picture's name with .ecsv where unsaid
    #[arg(long, value_name = "FILE", conflicts_with = "no_data", help_heading = "Picture")]
    pub data: Option<PathBuf>,
    /// The picture alone
    #[arg(long, help_heading = "Picture")]
    pub no_data: bool,
}

/// What stands above a chart.
#[derive(Args)]
pub struct TitleArguments {
    /// Words above the picture
    #[arg(long, value_name = "TEXT", help_heading = "Picture")]
    pub title: Option<String>,
}

/// The clock of the upper side.
#[derive(Args)]
pub struct ClockArguments {
    /// Local clock: so far ahead of UTC, as -4 or +05:45; local mean solar time of the site where unsaid
    #[arg(long, value_name = "OFFSET", allow_hyphen_values = true, value_parser = utc_offset_h, help_heading = "Picture")]
    pub utc_offset: Option<f64>,
}

#[derive(Args)]
pub struct PlotNightArguments {
    /// The schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON, VOTable or Parquet
    #[arg(long, value_name = "FILE", required_unless_present = "from")]
    pub schedule: Option<PathBuf>,
    /// A table instead of a question: the data of an earlier plot night, or, with --schedule, what flag wrote of it (CSV, ECSV or JSON)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["elements", "shells", "policy", "max_delay"])]
    pub from: Option<PathBuf>,
    /// Which night of a longer schedule, by the evening's local date, as 2024-08-13; the first where unsaid
    #[arg(long, value_name = "DATE")]
    pub night: Option<String>,
    #[command(flatten)]
    pub rules: RulesConfig,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub clock: ClockArguments,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotFieldArguments {
    /// A table instead of a question: what passes wrote (CSV, ECSV or JSON)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["start", "exposure", "ra", "dec", "elements", "shells", "include_dark"])]
    pub from: Option<PathBuf>,
    #[command(flatten)]
    pub exposure: ExposureConfig,
    /// Crossings of satellites in the Earth's shadow too
    #[arg(long)]
    pub include_dark: bool,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotLightCurveArguments {
    /// A table instead of a question: the data of an earlier plot light-curve, or what forecast wrote (--light-curves, or JSON with --samples N)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["start", "exposure", "ra", "dec", "elements", "shells"])]
    pub from: Option<PathBuf>,
    #[command(flatten)]
    pub exposure: ExposureConfig,
    /// Which of the satellites that cross, or of a forecast's passes; the brightest where unsaid
    #[arg(long, value_name = "ID", value_parser = norad_id)]
    pub norad: Option<u32>,
    /// So much of the track before entry and after exit, with its unit; at most 10min
    #[arg(long, value_name = "TIME", default_value = "30s")]
    pub around: String,
    /// A line at this magnitude
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<f64>,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub clock: ClockArguments,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotSkyChartArguments {
    /// What forecast wrote: the file of --light-curves, or JSON with --samples N
    #[arg(long, value_name = "FILE")]
    pub from: PathBuf,
    /// Passes of these satellites alone; else the 22 brightest
    #[arg(long, value_name = "ID", num_args = 1.., value_delimiter = ',', value_parser = norad_id)]
    pub norad: Vec<u32>,
    /// Times on a clock so far ahead of UTC, as -4 or +05:45; UTC where unsaid
    #[arg(long, value_name = "OFFSET", allow_hyphen_values = true, value_parser = utc_offset_h, help_heading = "Picture")]
    pub utc_offset: Option<f64>,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotSkyRateArguments {
    /// A table instead of a question: the data of an earlier plot sky-rate
    #[arg(long, value_name = "FILE", conflicts_with_all = ["start", "exposure", "sun_altitude_deg", "elements", "shells", "equatorial"])]
    pub from: Option<PathBuf>,
    /// Over right ascension and declination: means over the dark hours of nights, without moment
    #[arg(long, requires = "night", conflicts_with_all = ["start", "sun_altitude_deg", "repeats", "over"])]
    pub equatorial: bool,
    /// With --equatorial the nights, by their evening's local date; several show a season or a year
    #[arg(long, value_name = "DATE", num_args = 1.., value_delimiter = ',', requires = "equatorial")]
    pub night: Vec<String>,
    /// With --equatorial the highest altitude of the Sun, degrees
    #[arg(long, value_name = "DEG", default_value_t = -12.0, allow_hyphen_values = true, requires = "equatorial")]
    pub max_sun_altitude_deg: f64,
    /// With --equatorial the time between two exposures of every cell, with its unit
    #[arg(long, value_name = "TIME", default_value = "10min", requires = "equatorial")]
    pub step: String,
    /// The moment, as 2024-08-14T00:30:00Z; with --sun-altitude-deg the first time after it that the Sun stands there
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub start: Option<Quantity>,
    /// Altitude of the Sun, degrees: the first moment after --start
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub sun_altitude_deg: Option<f64>,
    /// Length of an exposure with its unit
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub exposure: Option<Quantity>,
    /// Streaks brighter than this alone, mag at their brightest
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<f64>,
    /// Lowest altitude of a field's centre, degrees, 0 to 80
    #[arg(long, value_name = "DEG", default_value_t = 20.0, allow_hyphen_values = true)]
    pub min_altitude: f64,
    /// HEALPix division of the sky, 1 to 64: cells of 14.7, 7.3 or 3.7 degrees for 4, 8 or 16
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub nside: u32,
    /// Exposures averaged in every cell, spread evenly over --over
    #[arg(long, value_name = "N", default_value_t = 30)]
    pub repeats: usize,
    /// Time about the moment over which they are spread, with its unit
    #[arg(long, value_name = "TIME", default_value = "20min")]
    pub over: String,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotSunAltitudeArguments {
    /// The exposures of a schedule; without it, a grid over the sky all night long
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// A table instead of a question: the data of an earlier plot sun-altitude or plot night
    #[arg(long, value_name = "FILE", conflicts_with_all = ["schedule", "start", "exposure", "elements", "shells"])]
    pub from: Option<PathBuf>,
    /// Where the grid begins: the day from this moment on
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, conflicts_with = "schedule")]
    pub start: Option<Quantity>,
    /// Length of an exposure of the grid with its unit
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, conflicts_with = "schedule")]
    pub exposure: Option<Quantity>,
    /// Lowest altitude of the grid, degrees, 0 to 80
    #[arg(long, value_name = "DEG", default_value_t = 30.0, allow_hyphen_values = true)]
    pub min_altitude: f64,
    /// Highest altitude of the Sun in the grid, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub max_sun_altitude_deg: f64,
    /// Between two visits of the grid, with its unit
    #[arg(long, value_name = "TIME", default_value = "10min")]
    pub step: String,
    /// Width of the bins, degrees
    #[arg(long, value_name = "DEG", default_value_t = 2.0, allow_hyphen_values = true)]
    pub bin: f64,
    #[command(flatten)]
    pub rules: RulesConfig,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotSkyArguments {
    #[command(flatten)]
    pub view: SkyViewArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotBodyArguments {
    #[command(flatten)]
    pub view: BodyViewArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[cfg(feature = "fit")]
#[derive(Args)]
pub struct PlotCornerArguments {
    /// Chains of fit run --mcmc (an .npz)
    #[arg(long, value_name = "FILE")]
    pub chains: PathBuf,
    /// Steps at the beginning that are left out; a quarter of them where unsaid
    #[arg(long, value_name = "N")]
    pub burn_in: Option<usize>,
    /// Which parameters, 2 to 9; the first nine where unsaid
    #[arg(long, value_name = "NAME", num_args = 1.., value_delimiter = ',')]
    pub parameters: Vec<String>,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

#[derive(Args)]
pub struct PlotResidualsArguments {
    /// Measurements or pixels: a table that fit reduce wrote, with --raw-points or without (CSV, ECSV or JSON)
    #[arg(long, value_name = "FILE")]
    pub from: PathBuf,
    /// Brightness model by name (streakcast model list), or a model file
    #[arg(long, value_name = "NAME")]
    pub model: String,
    /// Configuration file: band and models of one's own
    #[arg(long, value_name = "FILE", help_heading = "Run")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub magnitudes: LightConfig,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}
