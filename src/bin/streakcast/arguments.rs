//! What can be typed.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, ValueEnum};
use streakcast::schedule::{MagnitudeLimit, Shard};
use streakcast::setup::{FieldSetup, OneOrMany, PolicySetup, Quantity, Setup, SiteSetup, TelescopeSetup};

use crate::doctor_arguments::DoctorArguments;
#[cfg(feature = "fetch")]
use crate::fetch_arguments::FetchArguments;
use crate::fit_arguments::FitArguments;
use crate::forecast_arguments::ForecastArguments;
use crate::gate_arguments::GateArguments;
use crate::identify_arguments::IdentifyArguments;
#[cfg(feature = "fits")]
use crate::inject_arguments::InjectArguments;
use crate::map_arguments::MapArguments;
use crate::output::Output;
#[cfg(feature = "plot")]
use crate::plot_arguments::PlotArguments;
#[cfg(feature = "serve")]
use crate::serve_arguments::ServeArguments;
use crate::statistics_arguments::{ReproduceArguments, StatisticsArguments};
use crate::window_arguments::WindowsArguments;

/// Catalogue numbers have nine digits at most.
const MOST_NORAD: u32 = 999_999_999;

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
    /// Passband of the magnitudes: B V R I u g r i z y G
    #[arg(long, value_name = "BAND", help_heading = "Camera")]
    pub band: Option<String>,
    /// Zero point of the magnitudes: Vega or AB; each band has its usual one
    #[arg(long, value_name = "SYSTEM", help_heading = "Camera")]
    pub mag_system: Option<String>,
    /// Sunlight alone on models made of panels, without the light that the Earth throws on them
    #[arg(long, help_heading = "Camera")]
    pub no_earthshine: bool,
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

#[derive(Args)]
pub struct PassesArguments {
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
    Check(ModelCheckArguments),
}

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

impl SharedArguments {
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
            band: self.band.clone(),
            mag_system: self.mag_system.clone(),
            earthshine: self.no_earthshine.then_some(false),
            extinction: self.extinction,
            sun_distance: self.sun_distance.then_some(true),
            min_probability: self.min_probability,
            time_scale: self.time_scale.clone(),
            eop: self.eop.clone(),
            threads: self.threads,
            quiet: self.quiet.then_some(true),
            ..self.place.setup()
        };
        let said = typed.over(shared);
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
