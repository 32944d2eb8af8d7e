//! Flags of `fit`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use streakcast::config::SiteConfig;

use crate::arguments::OutputArguments;

#[derive(Args)]
pub struct FitArguments {
    #[command(subcommand)]
    pub verb: FitVerb,
}

#[derive(Subcommand)]
pub enum FitVerb {
    /// A model file fitted to photometry, with covariance, report and pictures
    Run(Box<FitRunArguments>),
    /// The paper's tests (panel offset by layer, sail gloss, earthshine) and forms of law against one another on unseen points
    Compare(Box<FitCompareArguments>),
    /// Photometry placed, selected and reduced to pixels of the body frame, or point by point
    Reduce(Box<FitReduceArguments>),
    /// Which satellite each track is of, by range, phase and lateness: what --identified reads
    Identify(Box<FitIdentifyArguments>),
}

/// Tables of photometry, and who observed.
#[derive(Args)]
pub struct TableArguments {
    /// Tables of photometry, plain or gzipped
    #[arg(long, value_name = "FILE", num_args = 1.., required = true, help_heading = "Photometry")]
    pub photometry: Vec<PathBuf>,
    /// Layout: pomenis, mmt, score, slingshot, csv; by the header where unsaid
    #[arg(long, value_name = "NAME", help_heading = "Photometry")]
    pub format_name: Option<String>,
    /// Columns of a table of one's own: pairs such as time=Date,time_scale=utc,magnitude=Mag, or a file of them (TOML, JSON)
    #[arg(long, value_name = "PAIRS", help_heading = "Photometry")]
    pub columns: Option<String>,
    /// Filters that are wanted; Clear for MMT-9, elsewhere the only one of the file
    #[arg(long, value_name = "NAME", num_args = 1.., help_heading = "Photometry")]
    pub filter: Vec<String>,
    /// Keep rows that are the same as an earlier one
    #[arg(long, help_heading = "Photometry")]
    pub keep_duplicates: bool,
    #[command(flatten)]
    pub site: SiteConfig,
    /// Threads; all cores where unsaid
    #[arg(long, value_name = "N", help_heading = "Run")]
    pub threads: Option<usize>,
    /// No warnings, no progress
    #[arg(long, short, help_heading = "Run")]
    pub quiet: bool,
}

/// Which photometry, how its geometry is found, and what is used of it.
#[derive(Args)]
pub struct PhotometryArguments {
    #[command(flatten)]
    pub tables: TableArguments,
    /// Element sets, with their history: satellites stand where the nearest one has them
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = "Geometry")]
    pub elements: Vec<PathBuf>,
    /// Which satellite each track is of: a CSV with columns track and norad, for tables that name none
    #[arg(long, value_name = "FILE", requires = "elements", help_heading = "Geometry")]
    pub identified: Option<PathBuf>,
    /// Shift each track along its orbit until its ranges fit, by at most so many seconds (with --elements)
    #[arg(long, value_name = "S", requires = "elements", help_heading = "Geometry")]
    pub fit_offset_s: Option<f64>,
    /// Distance and phase of the rows, on the orbit's radius as the element sets have it: where satellites are minutes late (with --elements)
    #[arg(long, requires = "elements", conflicts_with = "fit_offset_s", help_heading = "Geometry")]
    pub elements_radius: bool,
    /// An element set farther away in time is not used, days
    #[arg(long, requires = "elements", value_name = "DAYS", default_value_t = 14.0, help_heading = "Geometry")]
    pub max_element_age_days: f64,
    /// Height of the orbits, km: for rows of distance and phase without element sets
    #[arg(long, value_name = "KM", help_heading = "Geometry")]
    pub height_km: Option<f64>,
    /// Satellites on station only (needs --elements with a history)
    #[arg(long, requires = "elements", help_heading = "Selection")]
    pub on_station: bool,
    /// On station: least height above the equatorial radius, km
    #[arg(long, requires = "on_station", value_name = "KM", default_value_t = 530.0, help_heading = "Selection")]
    pub station_height_km: f64,
    /// On station: greatest rate of the semi-major axis, m/day
    #[arg(long, requires = "on_station", value_name = "M", default_value_t = 100.0, help_heading = "Selection")]
    pub station_rate_m_day: f64,
    /// Sunlight that passes lower above the ground than this, km, is no full sunlight
    #[arg(long, value_name = "KM", default_value_t = 100.0, allow_hyphen_values = true, help_heading = "Selection")]
    pub least_grazing_km: f64,
    /// What stands lower at the site was another satellite, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, help_heading = "Selection")]
    pub least_altitude_deg: f64,
    /// Rows whose recorded range is farther off that of the named satellite are of another one, km
    #[arg(long, value_name = "KM", default_value_t = 100.0, help_heading = "Selection")]
    pub max_range_difference_km: f64,
    /// The same of the recorded phase angle, degrees; no such limit where unsaid
    #[arg(long, value_name = "DEG", help_heading = "Selection")]
    pub max_phase_difference_deg: Option<f64>,
    /// Keep rows that the survey flags as in the penumbra
    #[arg(long, help_heading = "Selection")]
    pub keep_penumbra_flag: bool,
    /// Magnitudes brought to the Sun's mean distance (the paper leaves up to 0.04 mag in)
    #[arg(long, help_heading = "Selection")]
    pub sun_distance: bool,
}

/// How points become pixels.
#[derive(Args)]
pub struct ReductionArguments {
    /// Single measurements instead of reduced pixels
    #[arg(long, help_heading = "Reduction")]
    pub raw_points: bool,
    /// Width of a layer of the Sun's latitude, degrees
    #[arg(long, value_name = "DEG", default_value_t = 1.0, help_heading = "Reduction")]
    pub layer_deg: f64,
    /// HEALPix division of the observer's directions
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 32, help_heading = "Reduction")]
    pub nside: u32,
    /// How a pixel's densest magnitude is found
    #[arg(long, conflicts_with = "raw_points", value_name = "MODE", value_enum, default_value_t = ModeName::HalfSample, help_heading = "Reduction")]
    pub mode: ModeName,
    /// Pixels of fewer points are not kept
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 80, help_heading = "Reduction")]
    pub min_count: u32,
    /// Pixels of fewer tracks are not kept: several tell a wrongly identified one from the others
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 1, help_heading = "Reduction")]
    pub min_tracks: u32,
    /// Pixels of wider spread are not kept, mag
    #[arg(long, conflicts_with = "raw_points", value_name = "MAG", default_value_t = 0.4, help_heading = "Reduction")]
    pub max_iqr: f64,
    /// Both sides of the Sun's plane apart (rows of distance and phase know one side only)
    #[arg(long, conflicts_with = "raw_points", help_heading = "Reduction")]
    pub no_fold: bool,
}

/// How single measurements are weighed.
#[derive(Args)]
pub struct WeightArguments {
    /// Scatter of single measurements beyond their own errors, mag (with --raw-points)
    #[arg(long, requires = "raw_points", value_name = "MAG", default_value_t = 0.5, help_heading = "Reduction")]
    pub scatter_mag: f64,
    /// Every measurement weighs the same, however many its track or night has (with --raw-points)
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

/// What is fitted.
#[derive(Args)]
pub struct FormArguments {
    /// Brightness model whose shape and laws are fitted, by name (streakcast model list) or a model file
    #[arg(long, value_name = "NAME", help_heading = "Model")]
    pub model: String,
    /// Parameters that may move, as c1,c2,n_sail; panel_offset_deg is one more. All coefficients where unsaid
    #[arg(long, value_name = "NAME", value_delimiter = ',', help_heading = "Model")]
    pub free: Vec<String>,
    /// Hold a parameter at a value, as c1=0
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',', help_heading = "Model")]
    pub hold: Vec<String>,
    /// Sunlight alone, without the light that the Earth throws on the satellite
    #[arg(long, help_heading = "Model")]
    pub no_earthshine: bool,
    /// What a residual costs
    #[arg(long, value_name = "LOSS", value_enum, help_heading = "Model")]
    pub loss: Option<LossName>,
    /// Folds that are held out in turn, by track or night; 0: none
    #[arg(long, value_name = "N", default_value_t = 5, help_heading = "Model")]
    pub folds: usize,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum LossName {
    /// Least squares (pixels, where unsaid)
    Squares,
    /// Squares near, lines far off (single measurements, where unsaid)
    SoftL1,
    /// Student's distribution of four degrees of freedom
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
    /// Sets of tracks that are left out in turn for the errors of a fit to pixels, more than the free parameters; 0: pixels count as independent
    #[arg(long, conflicts_with = "raw_points", value_name = "N", default_value_t = 24, help_heading = "Model")]
    pub jackknife: usize,
    /// Draw the posterior with so many steps of walkers
    #[arg(long, value_name = "STEPS", help_heading = "Posterior")]
    pub mcmc: Option<usize>,
    /// Walkers, an even number
    #[arg(long, requires = "mcmc", value_name = "N", default_value_t = 32, help_heading = "Posterior")]
    pub walkers: usize,
    /// Steps at the beginning that are not looked at
    #[arg(long, requires = "mcmc", value_name = "N", default_value_t = 200, help_heading = "Posterior")]
    pub burn_in: usize,
    /// Seed of the walkers
    #[arg(long, requires = "mcmc", value_name = "N", default_value_t = 1, help_heading = "Posterior")]
    pub seed: u64,
    /// Chains as .npz, saved on the way; a run that was cut short goes on from it
    #[arg(long, value_name = "FILE", requires = "mcmc", help_heading = "Posterior")]
    pub chains: Option<PathBuf>,
    /// Name of the fitted model; that of its shape with -fit where unsaid
    #[arg(long, value_name = "NAME", help_heading = "Output")]
    pub name: Option<String>,
    /// Whose data these are, for the model's provenance
    #[arg(long, value_name = "TEXT", help_heading = "Output")]
    pub data: Option<String>,
    /// Month of the fit for the model's provenance, as 2026-11; this month where unsaid
    #[arg(long, value_name = "DATE", help_heading = "Output")]
    pub date: Option<String>,
    /// The model file to write
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: PathBuf,
    /// Report to write, .md with its pictures beside or .html in one piece
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub report: Option<PathBuf>,
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

#[derive(Args)]
pub struct FitReduceArguments {
    #[command(flatten)]
    pub photometry: PhotometryArguments,
    #[command(flatten)]
    pub reduction: ReductionArguments,
    /// Picture of magnitude, number and spread of one layer (figure 2), the layer that holds this latitude of the Sun, degrees
    #[cfg(feature = "plot")]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, requires = "picture", help_heading = "Output")]
    pub layer: Option<f64>,
    /// Picture to draw, .png or .svg: of one layer with --layer, else of number against spread of all pixels (figure 3)
    #[cfg(feature = "plot")]
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub picture: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArguments,
}

#[derive(Args)]
pub struct FitIdentifyArguments {
    #[command(flatten)]
    pub tables: TableArguments,
    /// Element sets of all satellites that it may be
    #[arg(long, value_name = "FILE", num_args = 1.., required = true, help_heading = "Association")]
    pub elements: Vec<PathBuf>,
    /// An element set farther away in time is not used, days
    #[arg(long, value_name = "DAYS", default_value_t = 50.0, help_heading = "Association")]
    pub max_element_age_days: f64,
    /// Satellites may be early or late by so much, seconds
    #[arg(long, value_name = "S", default_value_t = 120.0, help_heading = "Association")]
    pub max_offset_s: f64,
    /// A satellite whose ranges are farther off (root mean square, once its lateness is taken out) is not the one, km
    #[arg(long, value_name = "KM", default_value_t = 10.0, help_heading = "Association")]
    pub max_range_rms_km: f64,
    /// A satellite whose phase angles are farther off is not the one, degrees
    #[arg(long, value_name = "DEG", default_value_t = 3.0, help_heading = "Association")]
    pub max_phase_rms_deg: f64,
    /// The next best must explain a track worse by so much (chi square)
    #[arg(long, value_name = "N", default_value_t = 9.0, help_heading = "Association")]
    pub least_lead: f64,
    #[command(flatten)]
    pub output: OutputArguments,
}
