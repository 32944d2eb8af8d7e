//! Flags of `fit`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use streakcast::config::SiteConfig;

use crate::arguments::OutputArguments;
use crate::help::{Typed, help};

#[derive(Args)]
pub struct FitArguments {
    #[command(subcommand)]
    pub verb: FitVerb,
}

help! {
    FitArguments, "fit",
    "reduce --photometry pomenis.csv --height-km 550 -o pixels.ecsv",
    "run --photometry pomenis.csv --height-km 550 --model starlink-v1.5 -o fitted.json"
}

#[derive(Subcommand)]
pub enum FitVerb {
    /// Fit a model to photometry, with covariance, report and pictures
    Run(Typed<FitRunArguments>),
    /// Compare forms of the model on held-out points, with the tests of Lu (2024): panel offset, sail gloss, earthshine
    Compare(Typed<FitCompareArguments>),
    /// Reduce photometry to pixels of the body frame, or to single points
    Reduce(Typed<FitReduceArguments>),
    /// Identify the satellite of each track by range, phase and time offset, for --identified
    Identify(Typed<FitIdentifyArguments>),
}

/// Tables of photometry, and the site of the observer.
#[derive(Args)]
pub struct TableArguments {
    /// Tables of photometry, plain or gzipped
    #[arg(long, value_name = "FILE", num_args = 1.., required = true, help_heading = "Photometry")]
    pub photometry: Vec<PathBuf>,
    /// Layout of the tables: pomenis, mmt, score, slingshot, csv; detected from the header if omitted
    #[arg(long, value_name = "NAME", help_heading = "Photometry")]
    pub format_name: Option<String>,
    /// Column mapping for a custom table, for example time=Date,time_scale=utc,magnitude=Mag, or a TOML or JSON file
    /// with the mapping
    #[arg(long, value_name = "PAIRS", help_heading = "Photometry")]
    pub columns: Option<String>,
    /// Filters to use; if omitted, Clear for MMT-9, otherwise the only filter of the file
    #[arg(long, value_name = "NAME", num_args = 1.., help_heading = "Photometry")]
    pub filter: Vec<String>,
    /// Keep duplicate rows
    #[arg(long, help_heading = "Photometry")]
    pub keep_duplicates: bool,
    #[command(flatten)]
    pub site: SiteConfig,
    /// Number of threads; all cores if omitted
    #[arg(long, value_name = "N", help_heading = "Run")]
    pub threads: Option<usize>,
    /// Suppress warnings, summaries and progress
    #[arg(long, short, help_heading = "Run")]
    pub quiet: bool,
}

/// Photometry, its geometry, and its selection.
#[derive(Args)]
pub struct PhotometryArguments {
    #[command(flatten)]
    pub tables: TableArguments,
    /// Element sets with their history: positions are computed from the closest one in time
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = "Geometry")]
    pub elements: Vec<PathBuf>,
    /// Satellites of the tracks: CSV with columns track and norad, for tables without satellite names
    #[arg(long, value_name = "FILE", requires = "elements", help_heading = "Geometry")]
    pub identified: Option<PathBuf>,
    /// Fit a time offset of each track to its ranges, at most this many seconds (with --elements)
    #[arg(long, value_name = "S", requires = "elements", help_heading = "Geometry")]
    pub fit_offset_s: Option<f64>,
    /// Use recorded distance and phase with the orbital radius of --elements, for satellites with large along-track
    /// errors
    #[arg(long, requires = "elements", conflicts_with = "fit_offset_s", help_heading = "Geometry")]
    pub elements_radius: bool,
    /// Largest age of an element set, days
    #[arg(long, requires = "elements", value_name = "DAYS", default_value_t = 14.0, help_heading = "Geometry")]
    pub max_element_age_days: f64,
    /// Height of the orbits, km, for rows of distance and phase without element sets
    #[arg(long, value_name = "KM", help_heading = "Geometry")]
    pub height_km: Option<f64>,
    /// Use only satellites that hold their final orbit (needs --elements with a history)
    #[arg(long, requires = "elements", help_heading = "Selection")]
    pub on_station: bool,
    /// Smallest height of a final orbit above the equatorial radius, km
    #[arg(long, requires = "on_station", value_name = "KM", default_value_t = 530.0, help_heading = "Selection")]
    pub station_height_km: f64,
    /// Largest rate of change of the semi-major axis of a final orbit, m/day
    #[arg(long, requires = "on_station", value_name = "M", default_value_t = 100.0, help_heading = "Selection")]
    pub station_rate_m_day: f64,
    /// Smallest height above the ground at which the sunlight passes the Earth, km
    #[arg(long, value_name = "KM", default_value_t = 100.0, allow_hyphen_values = true, help_heading = "Selection")]
    pub least_grazing_km: f64,
    /// Smallest altitude at the site, degrees; rows with a lower computed altitude are misidentified satellites
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, help_heading = "Selection")]
    pub least_altitude_deg: f64,
    /// Largest difference between recorded and computed range, km
    #[arg(long, value_name = "KM", default_value_t = 100.0, help_heading = "Selection")]
    pub max_range_difference_km: f64,
    /// Largest difference between recorded and computed phase angle, degrees; unlimited if omitted
    #[arg(long, value_name = "DEG", help_heading = "Selection")]
    pub max_phase_difference_deg: Option<f64>,
    /// Keep rows that the survey flags as in the penumbra
    #[arg(long, help_heading = "Selection")]
    pub keep_penumbra_flag: bool,
    /// Correct magnitudes to the mean distance of the Sun (up to 0.04 mag, not done in Lu 2024)
    #[arg(long, help_heading = "Selection")]
    pub sun_distance: bool,
}

/// Reduction of points to pixels.
#[derive(Args)]
pub struct ReductionArguments {
    /// Use single measurements instead of reduced pixels
    #[arg(long, help_heading = "Reduction")]
    pub raw_points: bool,
    /// Width of a layer in the latitude of the Sun, degrees
    #[arg(long, value_name = "DEG", default_value_t = 1.0, help_heading = "Reduction")]
    pub layer_deg: f64,
    /// HEALPix resolution of the directions of the observer
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 32, help_heading = "Reduction")]
    pub nside: u32,
    /// Estimator of the mode of the magnitudes in a pixel
    #[arg(long, conflicts_with = "raw_points", value_name = "MODE", value_enum, default_value_t = ModeName::HalfSample, help_heading = "Reduction")]
    pub mode: ModeName,
    /// Smallest number of points in a pixel
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 80, help_heading = "Reduction")]
    pub min_count: u32,
    /// Smallest number of tracks in a pixel; a value above 1 limits the effect of a wrong identification
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 1, help_heading = "Reduction")]
    pub min_tracks: u32,
    /// Largest interquartile range of a pixel, mag
    #[arg(long, conflicts_with = "raw_points", value_name = "MAG", default_value_t = 0.4, help_heading = "Reduction")]
    pub max_iqr: f64,
    /// Do not combine directions mirrored at the plane through the Sun (rows of distance and phase have only one side)
    #[arg(long, conflicts_with = "raw_points", help_heading = "Reduction")]
    pub no_fold: bool,
}

/// Weights of single measurements.
#[derive(Args)]
pub struct WeightArguments {
    /// Scatter of single measurements in addition to their errors, mag (with --raw-points)
    #[arg(long, requires = "raw_points", value_name = "MAG", default_value_t = 0.3, help_heading = "Reduction")]
    pub scatter_mag: f64,
    /// Give equal weights to all measurements instead of weights by the correlation within a track, night or pass
    /// (with --raw-points)
    #[arg(long, requires = "raw_points", help_heading = "Reduction")]
    pub equal_weights: bool,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum ModeName {
    /// Half-sample mode
    HalfSample,
    /// Maximum of a Gaussian kernel density
    Kernel,
}

/// Form of the model, and its free parameters.
#[derive(Args)]
pub struct FormArguments {
    /// Brightness model to fit: name (listed by streakcast model list) or model file
    #[arg(long, value_name = "NAME", help_heading = "Model")]
    pub model: String,
    /// Free parameters, for example c1,c2,n_sail or panel_offset_deg; all coefficients if omitted
    #[arg(long, value_name = "NAME", value_delimiter = ',', help_heading = "Model")]
    pub free: Vec<String>,
    /// Fixed parameters with their values, for example c1=0
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',', help_heading = "Model")]
    pub hold: Vec<String>,
    /// Ignore earthshine
    #[arg(long, help_heading = "Model")]
    pub no_earthshine: bool,
    /// Loss function of the residuals
    #[arg(long, value_name = "LOSS", value_enum, help_heading = "Model")]
    pub loss: Option<LossName>,
    /// Number of folds for cross-validation, by track or night; 0 for none
    #[arg(long, value_name = "N", default_value_t = 5, help_heading = "Model")]
    pub folds: usize,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum LossName {
    /// Least squares (default for pixels)
    Squares,
    /// Quadratic for small residuals, linear for large ones (default for single measurements)
    SoftL1,
    /// Student's t distribution with four degrees of freedom
    Student,
}

#[derive(Args)]
pub struct FitRunArguments {
    #[command(flatten)]
    pub photometry: PhotometryArguments,
    #[command(flatten)]
    pub reduction: ReductionArguments,
    #[command(flatten)]
    pub weights: WeightArguments,
    #[command(flatten)]
    pub form: FormArguments,
    /// Number of jackknife sets of tracks for the errors of a fit to pixels, more than free parameters; 0 for none
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 24, help_heading = "Model")]
    pub jackknife: usize,
    /// Sample the posterior with this number of steps
    #[arg(long, value_name = "STEPS", help_heading = "Posterior")]
    pub mcmc: Option<usize>,
    /// Number of walkers, an even number
    #[arg(long, requires = "mcmc", value_name = "N", default_value_t = 32, help_heading = "Posterior")]
    pub walkers: usize,
    /// Number of discarded steps at the beginning
    #[arg(long, requires = "mcmc", value_name = "N", default_value_t = 200, help_heading = "Posterior")]
    pub burn_in: usize,
    /// Seed of the random numbers
    #[arg(long, requires = "mcmc", value_name = "N", default_value_t = 1, help_heading = "Posterior")]
    pub seed: u64,
    /// File of the posterior samples (.ecsv), saved regularly; an interrupted run continues from it
    #[arg(long, value_name = "FILE", requires = "mcmc", help_heading = "Posterior")]
    pub chains: Option<PathBuf>,
    /// Name of the fitted model; the name of --model followed by -fit if omitted
    #[arg(long, value_name = "NAME", help_heading = "Output")]
    pub name: Option<String>,
    /// Source of the data, for the provenance of the model
    #[arg(long, value_name = "TEXT", help_heading = "Output")]
    pub data: Option<String>,
    /// Month of the fit for the provenance of the model, for example 2026-11; the current month if omitted
    #[arg(long, value_name = "DATE", help_heading = "Output")]
    pub date: Option<String>,
    /// Output model file
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: PathBuf,
    /// Report: .md with separate pictures, or .html with embedded ones
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub report: Option<PathBuf>,
}

help! {
    FitRunArguments, "fit run",
    "--photometry pomenis.csv --height-km 550 --model starlink-v1.5 -o fitted.json --report fit.html",
    "--photometry mmt.csv --elements history.tle --model starlink-v1.5 --raw-points --mcmc 2000 --chains chains.ecsv -o fitted.json"
}

#[derive(Args)]
pub struct FitCompareArguments {
    #[command(flatten)]
    pub photometry: PhotometryArguments,
    #[command(flatten)]
    pub reduction: ReductionArguments,
    #[command(flatten)]
    pub weights: WeightArguments,
    #[command(flatten)]
    pub form: FormArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    FitCompareArguments, "fit compare",
    "--photometry pomenis.csv --height-km 550 --model starlink-v1.5",
    "--photometry mmt.csv --elements history.tle --model starlink-v1.5 --raw-points --folds 10"
}

#[derive(Args)]
pub struct FitReduceArguments {
    #[command(flatten)]
    pub photometry: PhotometryArguments,
    #[command(flatten)]
    pub reduction: ReductionArguments,
    /// Draw magnitude, number and spread for the layer at this latitude of the Sun, degrees (figure 2 of Lu 2024)
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, requires = "picture", help_heading = "Output")]
    pub layer: Option<f64>,
    /// Picture, .png or .svg: one layer with --layer, otherwise number against spread of all pixels (figure 3 of
    /// Lu 2024)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub picture: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    FitReduceArguments, "fit reduce",
    "--photometry pomenis.csv --height-km 550 -o pixels.ecsv",
    "--photometry mmt.csv --elements history.tle --raw-points -o points.ecsv"
}

#[derive(Args)]
pub struct FitIdentifyArguments {
    #[command(flatten)]
    pub tables: TableArguments,
    /// Element sets of all candidate satellites
    #[arg(long, value_name = "FILE", num_args = 1.., required = true, help_heading = "Association")]
    pub elements: Vec<PathBuf>,
    /// Largest age of an element set, days
    #[arg(long, value_name = "DAYS", default_value_t = 50.0, help_heading = "Association")]
    pub max_element_age_days: f64,
    /// Largest time offset of a satellite, seconds
    #[arg(long, value_name = "S", default_value_t = 120.0, help_heading = "Association")]
    pub max_offset_s: f64,
    /// Largest RMS difference of the ranges after the fit of the time offset, km
    #[arg(long, value_name = "KM", default_value_t = 10.0, help_heading = "Association")]
    pub max_range_rms_km: f64,
    /// Largest RMS difference of the phase angles, degrees
    #[arg(long, value_name = "DEG", default_value_t = 3.0, help_heading = "Association")]
    pub max_phase_rms_deg: f64,
    /// Smallest difference in chi square to the next best satellite
    #[arg(long, value_name = "N", default_value_t = 9.0, help_heading = "Association")]
    pub least_lead: f64,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    FitIdentifyArguments, "fit identify",
    "--photometry pomenis.csv --elements history.tle -o identified.csv",
    "--photometry slingshot.csv --elements history.tle --site Paranal --max-offset-s 60 -o identified.csv"
}
