//! What can be typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use streakcast::schedule::{MagnitudeLimit, Shard};

use crate::doctor_arguments::DoctorArguments;
#[cfg(feature = "fetch")]
use crate::fetch_arguments::FetchArguments;
#[cfg(feature = "fit")]
use crate::fit_arguments::FitArguments;
use crate::forecast_arguments::ForecastArguments;
use crate::gate_arguments::GateArguments;
use crate::identify_arguments::IdentifyArguments;
#[cfg(feature = "fits")]
use crate::inject_arguments::InjectArguments;
use crate::map_arguments::MapArguments;
#[cfg(feature = "plot")]
use crate::plot_arguments::PlotArguments;
#[cfg(feature = "serve")]
use crate::serve_arguments::ServeArguments;
use crate::shared_arguments::{ExposureArguments, OutputArguments, RulesArguments, SharedArguments};
use crate::statistics_arguments::{ReproduceArguments, StatisticsArguments};
use crate::window_arguments::WindowsArguments;

/// Satellites crossing astronomers' exposures: which, when, where and how bright.
#[derive(Parser)]
#[command(name = "streakcast", version, arg_required_else_help = true, propagate_version = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand)]
pub enum Verb {
    /// Every satellite that crosses the field during one exposure, with times, track and magnitude
    Passes(Box<PassesArguments>),
    /// One verdict for each exposure of a schedule, with reasons and the next clear start
    Flag(Box<FlagArguments>),
    /// The schedule file again, every cell as it was, with flags and streaks beside
    Annotate(Box<AnnotateArguments>),
    /// From when to when targets can be exposed without any satellite that matters
    Windows(Box<WindowsArguments>),
    /// Every visible pass of a night: rise, culmination, set, shadow, peak magnitude
    Forecast(Box<ForecastArguments>),
    /// Waits until an exposure can start clear: before each frame of Ekos, N.I.N.A. or a script
    Gate(Box<GateArguments>),
    /// Which satellite a measured streak is of: ranked candidates
    Identify(Box<IdentifyArguments>),
    /// Maps of magnitude over a satellite's own sky and over that of a site
    Map(MapArguments),
    /// Pictures: nights, fields, light curves, skies, fits, as PNG and SVG with their data beside
    #[cfg(feature = "plot")]
    Plot(Box<PlotArguments>),
    /// Streaks of satellites, or random ones, put into frames, with masks and their truth
    #[cfg(feature = "fits")]
    Inject(Box<InjectArguments>),
    /// Element sets from CelesTrak, Space-Track or SatChecker into a cache, politely
    #[cfg(feature = "fetch")]
    Fetch(Box<FetchArguments>),
    /// From photometry to a brightness model
    #[cfg(feature = "fit")]
    Fit(Box<FitArguments>),
    /// A page and an HTTP API on this machine: the schedule's night, and what another start would meet
    #[cfg(feature = "serve")]
    Serve(Box<ServeArguments>),
    /// How many satellites are lit over a site, how bright, and how many trails an exposure gets
    Statistics(Box<StatisticsArguments>),
    /// A paper's counts beside ours
    Reproduce(ReproduceArguments),
    /// The brightness models: list, show, check
    Model(ModelArguments),
    /// What would be wrong tonight: element ages, Earth orientation, clock, site, models, cache
    Doctor(Box<DoctorArguments>),
    /// The observatories known by name and MPC code
    Sites(ListArguments),
    /// The synthetic constellations for --shells
    Shells(ListArguments),
}

#[derive(Args)]
pub struct PassesArguments {
    #[command(flatten)]
    pub exposure: ExposureArguments,
    /// Crossings of satellites in the Earth's shadow too
    #[arg(long)]
    pub include_dark: bool,
    /// Tell how many of the crossings are brighter than this, in the band asked for; all of them are listed
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<MagnitudeLimit>,
    /// Points along each track
    #[arg(long, value_name = "N")]
    pub samples: Option<usize>,
    #[command(flatten)]
    pub shared: SharedArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

#[derive(Args)]
pub struct FlagArguments {
    /// The schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON, VOTable or Parquet
    #[arg(long, value_name = "FILE")]
    pub schedule: PathBuf,
    #[command(flatten)]
    pub rules: RulesArguments,
    /// The nights of one share of a batch alone, as 3/100: all shares together are the whole answer
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// End with exit code 1 where any exposure is streaked (or worse), or one to avoid
    #[arg(long, value_name = "VERDICT")]
    pub fail_on: Option<FailOn>,
    #[command(flatten)]
    pub shared: SharedArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum FailOn {
    Streaked,
    Avoid,
}

#[derive(Args)]
pub struct AnnotateArguments {
    /// The schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON, VOTable or Parquet
    #[arg(long, value_name = "FILE")]
    pub schedule: PathBuf,
    #[command(flatten)]
    pub rules: RulesArguments,
    /// File to write; it may be the schedule itself
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// The nights of one share of a batch alone, as 3/100: the rows of all shares together are the whole file
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Take the place of an earlier annotation
    #[arg(long)]
    pub replace: bool,
    #[command(flatten)]
    pub shared: SharedArguments,
}

#[derive(Args)]
pub struct ModelArguments {
    #[command(subcommand)]
    pub verb: ModelVerb,
}

#[derive(Subcommand)]
pub enum ModelVerb {
    /// All models by name
    List(ModelListArguments),
    /// One model: its file, with coefficients, covariance and provenance
    Show(ModelShowArguments),
    /// Holds models, those shipped or those named, to the rules, to published means and phase curves, and to photometry
    #[cfg(feature = "fit")]
    Check(ModelCheckArguments),
}

#[cfg(feature = "fit")]
#[derive(Args)]
pub struct ModelCheckArguments {
    /// Model files; a name that begins with that of a shipped model (visorsat-mine) says which satellites
    pub files: Vec<PathBuf>,
    /// Folder of published photometry (see docs/models.md); without it, what was published alone
    #[arg(long, value_name = "FOLDER")]
    pub data: Option<PathBuf>,
    /// No word on standard error but errors
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

#[derive(Args)]
pub struct ModelListArguments {
    /// Configuration file with models of one's own
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArguments,
}

#[derive(Args)]
pub struct ModelShowArguments {
    /// Name or alias
    pub name: String,
    #[command(flatten)]
    pub list: ModelListArguments,
}

#[derive(Args)]
pub struct ListArguments {
    /// Only those whose name or code holds this
    pub search: Option<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}
