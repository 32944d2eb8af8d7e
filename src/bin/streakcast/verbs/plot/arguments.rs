//! Flags of `plot`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use streakcast::config::{Config, ExposureConfig, LightConfig, Quantity, RulesConfig, norad_id, parse_night};
use streakcast::plot::{FileOptions, PictureSize};

use crate::help::{Typed, examples, help};
use crate::local_time::ZoneArguments;
use crate::verbs::map::{BodyViewArguments, SkyViewArguments};

#[derive(Args)]
#[command(arg_required_else_help = true, args_conflicts_with_subcommands = true)]
pub struct PlotArguments {
    /// List all plots with their required flags
    #[arg(long)]
    pub list: bool,
    #[command(subcommand)]
    pub verb: Option<PlotVerb>,
}

help! { PlotArguments, "plot", "--list", "body --model visorsat --sun-latitude-deg 20 -o body.png" }

#[derive(Subcommand)]
pub enum PlotVerb {
    /// Plot a timeline of a night: streaked exposures, coloured by the brightest streak
    Night(Typed<PlotNightArguments>),
    /// Plot the streaks in a field (gnomonic, north up, east left), with entry, exit and magnitude
    Field(Typed<PlotFieldArguments>),
    /// Plot the magnitude along a track with its error, and the interval inside the field
    LightCurve(Typed<PlotLightCurveArguments>),
    /// Plot passes of a forecast over the sky of their site, from rise to set, with times and magnitudes
    SkyChart(Typed<PlotSkyChartArguments>),
    /// Plot the expected number of streaks per exposure over the sky of a site
    SkyRate(Typed<PlotSkyRateArguments>),
    /// Plot trails per exposure against the Sun's altitude, for a schedule or for a grid over the sky during a night
    SunAltitude(Typed<PlotSunAltitudeArguments>),
    /// Plot magnitudes over the sky of a site, for satellites at one height
    Sky(Typed<PlotSkyArguments>),
    /// Plot magnitudes at 1000 km over the directions around a satellite
    Body(Typed<PlotBodyArguments>),
    /// Plot the posterior of a fit: each parameter, and each pair of parameters
    Corner(Typed<PlotCornerArguments>),
    /// Plot observed minus computed magnitudes against the angles of the geometry
    Residuals(Typed<PlotResidualsArguments>),
    /// Plot a histogram of observed minus computed magnitudes
    #[command(after_help = examples("plot histogram", ["--from pixels.ecsv --model visorsat -o histogram.png", "--from points.ecsv --model fitted.json -o histogram.svg"]))]
    Histogram(Typed<PlotResidualsArguments>),
    /// Plot observed and computed magnitudes against the phase angle
    #[command(after_help = examples("plot phase-curve", ["--from pixels.ecsv --model visorsat -o phase.png", "--from points.ecsv --model fitted.json -o phase.svg"]))]
    PhaseCurve(Typed<PlotResidualsArguments>),
}

/// Outputs: pictures and their data.
#[derive(Args)]
pub struct PictureArguments {
    /// Output picture, .png or .svg; may be repeated
    #[arg(long, short, value_name = "FILE", help_heading = "Picture (required: -o)")]
    pub output: Vec<PathBuf>,
    /// Data of the picture: a .ecsv, .csv, .json or .jsonl file; NAME-data.ecsv for the picture NAME.png if omitted
    #[arg(long, value_name = "FILE", conflicts_with = "no_data", help_heading = "Picture (required: -o)")]
    pub data: Option<PathBuf>,
    /// Write no data file
    #[arg(long, help_heading = "Picture (required: -o)")]
    pub no_data: bool,
    /// Size of the picture in pixels (1600x900), inches (8x5in) or centimetres (20x12cm); fonts and lines are scaled;
    /// the size of the chart at 96 dots per inch if omitted
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, help_heading = "Picture (required: -o)")]
    pub size: Option<PictureSize>,
    /// Dots per inch of PNG files, 10 to 1200; 96 if omitted
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(10..=1200), help_heading = "Picture (required: -o)")]
    pub dpi: Option<u32>,
}

impl PictureArguments {
    /// Returns size and resolution of the picture files, which are checked.
    pub fn file_options(&self) -> anyhow::Result<FileOptions> {
        let options = FileOptions { size: self.size, dpi: self.dpi, provenance: None };
        options.check()?;
        Ok(options)
    }
}

/// Title of a plot.
#[derive(Args)]
pub struct TitleArguments {
    /// Title of the picture
    #[arg(long, value_name = "TEXT", help_heading = "Picture (required: -o)")]
    pub title: Option<String>,
}

#[derive(Args)]
pub struct PlotNightArguments {
    /// Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON or VOTable
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// Input table: data of an earlier plot night, or, with --schedule, output of flag (CSV, ECSV or JSON)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["elements", "shells", "policy", "max_delay"])]
    pub from: Option<PathBuf>,
    /// Night of a longer schedule, by the evening's local date, for example 2024-08-13; the first if omitted
    #[arg(long, value_name = "DATE", value_parser = parse_night)]
    pub night: Option<String>,
    #[command(flatten)]
    pub rules: RulesConfig,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten, next_help_heading = "Picture (required: -o)")]
    pub zone: ZoneArguments,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotNightArguments, "plot night",
    "--schedule night.csv --elements active.tle --mpc X05 --telescope rubin -o night.png",
    "--from night-data.ecsv -o night.svg"
}

#[derive(Args)]
pub struct PlotFieldArguments {
    /// Input table: output of passes (CSV, ECSV or JSON)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["start", "exposure", "ra", "dec", "elements", "shells", "include_dark"])]
    pub from: Option<PathBuf>,
    #[command(flatten)]
    pub exposure: ExposureConfig,
    /// Include crossings of satellites in the Earth's shadow
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub include_dark: Option<bool>,
    /// Draw only streaks with a peak brighter than this
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<f64>,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotFieldArguments, "plot field",
    "--start 2024-08-14T03:30:00Z --exposure 30s --ra 280 --dec=-30 --shells oneweb --mpc X05 --fov 9deg -o field.png",
    "--from passes.csv -o field.svg"
}

#[derive(Args)]
pub struct PlotLightCurveArguments {
    /// Input table: data of an earlier plot light-curve, or output of forecast (--light-curves, or JSON with --samples
    /// N)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["exposure", "ra", "dec", "elements", "shells"])]
    pub from: Option<PathBuf>,
    #[command(flatten)]
    pub exposure: ExposureConfig,
    /// NORAD catalogue number of a crossing satellite, or of a pass of a forecast; the brightest if omitted. Of several
    /// passes of a forecast, --start selects the one at that time
    #[arg(long, value_name = "ID", value_parser = norad_id)]
    pub norad: Option<u32>,
    /// Time before entry and after exit, with its unit, at most 10min
    #[arg(long, value_name = "TIME", default_value = "30s")]
    pub around: String,
    /// Draw a line at this magnitude
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<f64>,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten, next_help_heading = "Picture (required: -o)")]
    pub zone: ZoneArguments,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotLightCurveArguments, "plot light-curve",
    "--start 2024-08-14T00:00:00Z --exposure 30s --ra 210 --dec=-30 --elements active.tle --mpc X05 --fov 9deg -o curve.png",
    "--from curves.ecsv -o curve.svg"
}

#[derive(Args)]
pub struct PlotSkyChartArguments {
    /// Input table: output of forecast (--light-curves, or JSON with --samples N)
    #[arg(long, value_name = "FILE")]
    pub from: PathBuf,
    /// NORAD catalogue numbers of satellites; the 22 brightest passes if omitted
    #[arg(long, value_name = "ID", num_args = 1.., value_delimiter = ',', value_parser = norad_id)]
    pub norad: Vec<u32>,
    /// Draw a finder chart for printing: one pass, the brightest, in black on white, with a table of times, altitudes,
    /// azimuths and magnitudes
    #[arg(long)]
    pub finder: bool,
    /// Suppress notes
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten, next_help_heading = "Picture (required: -o)")]
    pub zone: ZoneArguments,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotSkyChartArguments, "plot sky-chart",
    "--from curves.ecsv -o chart.png",
    "--from curves.ecsv --norad 25544 --time-zone Europe/Vienna -o chart.svg"
}

#[derive(Args)]
pub struct PlotSkyRateArguments {
    /// Input table: data of an earlier plot sky-rate
    #[arg(long, value_name = "FILE", conflicts_with_all = ["start", "exposure", "sun_altitude_deg", "elements", "shells", "equatorial"])]
    pub from: Option<PathBuf>,
    /// Plot over right ascension and declination: means over the dark hours of --night
    #[arg(long, requires = "night", conflicts_with_all = ["start", "sun_altitude_deg", "repeats", "over"])]
    pub equatorial: bool,
    /// Nights for --equatorial, by the local date of their evening
    #[arg(long, value_name = "DATE", num_args = 1.., value_delimiter = ',', value_parser = parse_night, requires = "equatorial")]
    pub night: Vec<String>,
    /// Highest altitude of the Sun for --equatorial, degrees
    #[arg(long, value_name = "DEG", default_value_t = -12.0, allow_hyphen_values = true, requires = "equatorial")]
    pub max_sun_altitude_deg: f64,
    /// Time between two exposures of a cell for --equatorial, with its unit
    #[arg(long, value_name = "TIME", default_value = "10min", requires = "equatorial")]
    pub step: String,
    /// Time of the plot, for example 2024-08-14T00:30:00Z; start of the search with --sun-altitude-deg
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub start: Option<Quantity>,
    /// Plot for the first time after --start at which the Sun has this altitude, degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub sun_altitude_deg: Option<f64>,
    /// Exposure time with its unit
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub exposure: Option<Quantity>,
    /// Count only streaks with a peak brighter than this
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<f64>,
    /// Lowest altitude of a field's centre, degrees, 0 to 80
    #[arg(long, value_name = "DEG", default_value_t = 20.0, allow_hyphen_values = true)]
    pub min_altitude: f64,
    /// HEALPix resolution, a power of 2 from 1 to 64: cells of 14.7, 7.3 or 3.7 degrees for 4, 8 or 16
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub nside: u32,
    /// Number of exposures averaged in each cell, at equal steps over --over
    #[arg(long, value_name = "N", default_value_t = 30)]
    pub repeats: usize,
    /// Time range of the averaged exposures, with its unit
    #[arg(long, value_name = "TIME", default_value = "20min")]
    pub over: String,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotSkyRateArguments, "plot sky-rate",
    "--start 2024-08-14T00:00:00Z --exposure 30s --shells oneweb --mpc X05 --fov 3.5deg --nside 4 --repeats 5 -o rate.png",
    "--from rate-data.ecsv -o rate.svg"
}

#[derive(Args)]
pub struct PlotSunAltitudeArguments {
    /// Schedule with the exposures; a grid over the sky for a night if omitted
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// Input table: data of an earlier plot sun-altitude or plot night
    #[arg(long, value_name = "FILE", conflicts_with_all = ["schedule", "start", "exposure", "elements", "shells"])]
    pub from: Option<PathBuf>,
    /// Start of the grid, which covers 24 hours
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
    /// Time step of the grid, with its unit
    #[arg(long, value_name = "TIME", default_value = "10min")]
    pub step: String,
    /// Width of the bins of the Sun's altitude, degrees
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

help! {
    PlotSunAltitudeArguments, "plot sun-altitude",
    "--schedule night.csv --elements active.tle --mpc X05 --telescope rubin -o trails.png",
    "--from night-data.ecsv -o trails.svg"
}

#[derive(Args)]
pub struct PlotSkyArguments {
    #[command(flatten)]
    pub view: SkyViewArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotSkyArguments, "plot sky",
    "--model visorsat --sun-altitude-deg=-15 -o sky.png",
    "--model visorsat --sun-altitude-deg=-15 --site Paranal --no-data -o sky.svg"
}

#[derive(Args)]
pub struct PlotBodyArguments {
    #[command(flatten)]
    pub view: BodyViewArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotBodyArguments, "plot body",
    "--model visorsat --sun-latitude-deg 20 -o body.png",
    "--model visorsat --sun-latitude-deg 20 --no-data -o body.svg"
}

#[derive(Args)]
pub struct PlotCornerArguments {
    /// Chains of fit run --mcmc (.ecsv)
    #[arg(long, value_name = "FILE")]
    pub chains: PathBuf,
    /// Number of discarded steps at the beginning; a quarter of all steps if omitted
    #[arg(long, value_name = "N")]
    pub burn_in: Option<usize>,
    /// Parameters to plot, 2 to 9; the first nine if omitted
    #[arg(long, value_name = "NAME", num_args = 1.., value_delimiter = ',')]
    pub parameters: Vec<String>,
    /// Suppress notes
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotCornerArguments, "plot corner",
    "--chains chains.ecsv -o corner.png",
    "--chains chains.ecsv --parameters c1,c2 -o corner.svg"
}

#[derive(Args)]
pub struct PlotResidualsArguments {
    /// Input table: output of fit reduce, with or without --raw-points (CSV, ECSV or JSON)
    #[arg(long, value_name = "FILE")]
    pub from: PathBuf,
    /// Brightness model: name (listed by streakcast model list) or model file
    #[arg(long, value_name = "NAME")]
    pub model: String,
    /// Configuration file with band and additional models
    #[arg(long, value_name = "FILE", help_heading = "Run")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub magnitudes: LightConfig,
    #[command(flatten)]
    pub title: TitleArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

help! {
    PlotResidualsArguments, "plot residuals",
    "--from pixels.ecsv --model visorsat -o residuals.png",
    "--from points.ecsv --model fitted.json -o residuals.svg"
}
