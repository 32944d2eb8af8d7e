//! Flags of `gate`, checked without files, and the request that they and the files define.

use std::cell::Cell;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use clap::{Args, ValueEnum};
use hifitime::TimeScale;
use streakcast::config::{
    Config, ExposureConfig, FIELD, Mark, ObservationPlan, PolicyChoice, Quantity, RequiredInput, RulesConfig,
    SATELLITES, SITE, SiteConfig, parse_duration_s, parse_exposure_s,
};
use streakcast::frames::{Direction, Gcrs, parse_moment};
use streakcast::geometry::Site;
use streakcast::input::is_stream;
use streakcast::schedule::{Blocking, MagnitudeLimit};

use super::clock::Clock;
use super::deadline::within;
use super::indi::Address;
use crate::help::{VerbFlags, help};

#[derive(Clone, Args)]
pub struct GateArguments {
    /// Right ascension of the field's centre (ICRS): 188.5 (degrees) or 12h34m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "dec")]
    pub ra: Option<Quantity>,
    /// Declination of the field's centre (ICRS): -30.5 or -30d30m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "ra")]
    pub dec: Option<Quantity>,
    /// Exposure time with its unit, for example 300s; overridden by the host with --stdin
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub exposure: Option<Quantity>,
    /// Limiting magnitude of crossings to avoid: 7, or by filter L=7,Ha=3,default=6; all lit crossings if omitted
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<MagnitudeLimit>,
    /// Limiting surface brightness of streaks to avoid, mag/arcsec2 (with --telescope): 22, or by filter
    /// L=22,default=21; with --limit-mag, either suffices
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_surface_brightness: Option<MagnitudeLimit>,
    /// Policy file (TOML): limits by magnitude, probability, margin
    #[arg(long, value_name = "FILE")]
    pub policy: Option<PolicyChoice>,
    /// Satellites to avoid: avoid (those that exceed a limit, or all lit ones if no limit is set; default) or any (all
    /// lit ones)
    #[arg(long, value_name = "CHOICE")]
    pub blocking: Option<String>,
    /// Longest wait with its unit
    #[arg(long, value_name = "TIME", default_value = "90s")]
    pub max_wait: String,
    /// Margin kept clear before and after the exposure, with its unit; if omitted that of the policy, or else 2s
    #[arg(long, value_name = "TIME")]
    pub margin: Option<String>,
    /// Exit with code 1 if no clear start is within --max-wait, 2 on a fault; without this flag both are only logged,
    /// with exit code 0
    #[arg(long)]
    pub strict: bool,
    #[command(flatten)]
    pub host: HostArguments,
    /// Rehearse a run at this time instead of now; waits take no time
    #[arg(long, value_name = "TIME", help_heading = "Time")]
    pub now: Option<String>,
    #[command(flatten)]
    pub config: Config,
}

/// Flags of the host: its job, its mount and the time and file that it grants.
#[derive(Clone, Args)]
#[command(next_help_heading = "Host")]
pub struct HostArguments {
    /// Read the job from standard input: ekos (JSON that Ekos sends to its pre-capture script)
    #[arg(long, value_name = "HOST")]
    pub stdin: Option<Host>,
    /// File of target coordinates by name (TOML), for hosts that send only the name
    #[arg(long, value_name = "FILE")]
    pub targets: Option<PathBuf>,
    /// Name of the target in --targets, overridden by the host with --stdin; without --targets a Messier or Caldwell
    /// object
    #[arg(long, value_name = "NAME")]
    pub target: Option<String>,
    /// Read the pointing from a mount on an INDI server, for example localhost or 10.0.0.2:7624
    #[arg(long, value_name = "HOST:PORT")]
    pub indi: Option<Address>,
    /// Name of the mount, if the INDI server has several
    #[arg(long, value_name = "NAME", requires = "indi")]
    pub indi_device: Option<String>,
    /// Longest time of the run without the wait, with its unit: files, standard input, server and computation; standard
    /// input and the server may each take half of it
    #[arg(long, value_name = "TIME", default_value = "10s")]
    pub timeout: String,
    /// File of the result and of counters over all runs (JSON), for hosts that show neither output nor log
    #[arg(long, value_name = "FILE")]
    pub status_file: Option<PathBuf>,
}

const GATE_POINTING: RequiredInput = RequiredInput {
    mark: Mark::Usage,
    ..RequiredInput::new(
        "pointing",
        &[
            &["--ra ANGLE", "--dec ANGLE"],
            &["--target NAME"],
            &["--targets FILE", "--target NAME"],
            &["--targets FILE", "--stdin ekos"],
            &["--indi HOST:PORT"],
        ],
    )
};
const GATE_EXPOSURE: RequiredInput = RequiredInput {
    example: "--exposure 300s",
    ..RequiredInput::new("exposure time", &[&["--exposure TIME"], &["--stdin ekos"]])
};

help! {
    GateArguments, "gate", asks [GATE_POINTING, GATE_EXPOSURE, SATELLITES, SITE, FIELD],
    "--ra 280 --dec=-30 --exposure 30s --shells oneweb --mpc X05 --fov 1deg --now 2024-08-14T03:30:00Z",
    "--stdin ekos --indi localhost --elements active.tle --fov 1deg --limit-mag 7 --status-file gate.json"
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum Host {
    Ekos,
}

/// Default margin, seconds. It covers the time between the end of this command and the shutter opening.
const DEFAULT_MARGIN_S: f64 = 2.0;

/// Longest time allowed with --timeout, seconds.
const MOST_TIMEOUT_S: f64 = 600.0;

/// Flags of a run that are valid whatever the files hold.
#[derive(Clone)]
pub struct Flags {
    /// Configuration of the flags, without the configuration file.
    pub config: Config,
    pub clock: Clock,
    margin_s: Option<f64>,
    pub max_wait_s: f64,
    /// Time for everything except the wait for a clear start.
    pub timeout: Duration,
    /// Time at which the result must be known.
    pub deadline: Instant,
    pub strict: bool,
    pub host: HostArguments,
}

impl Flags {
    /// Checks everything that does not depend on files. `has_invalid_file` is true if a file of settings has an error,
    /// so that it may have what the flags lack.
    ///
    /// # Errors
    /// A flag is invalid or missing. Everything else is a fault, which does not stop a sequence.
    pub fn new(typed: GateArguments, has_invalid_file: bool) -> anyhow::Result<Self> {
        let timeout_s = parse_duration_s("timeout", &typed.host.timeout)?;
        if !(0.1..=MOST_TIMEOUT_S).contains(&timeout_s) {
            return Err(anyhow!("timeout is {timeout_s} s; allowed: 0.1 to {MOST_TIMEOUT_S} s"));
        }
        let timeout = Duration::from_secs_f64(timeout_s);
        let deadline = Instant::now() + timeout;
        if let Some(exposure) = &typed.exposure {
            parse_exposure_s(exposure.as_str())?;
        }
        let config = Config {
            exposure: ExposureConfig {
                start: None,
                duration: typed.exposure,
                target: if typed.host.targets.is_none() { typed.host.target.clone() } else { None },
                ra: typed.ra,
                dec: typed.dec,
            },
            rules: RulesConfig {
                policy: typed.policy,
                limit_mag: typed.limit_mag,
                limit_surface_brightness: typed.limit_surface_brightness,
                blocking: typed.blocking,
                max_delay: None,
            },
            ..typed.config
        };
        let bare = config.without_files();
        check(&bare)?;
        // The time scale may be given in the configuration file, which is needed only for a rehearsal.
        let scale = || -> Option<TimeScale> {
            let config = config.clone();
            within(deadline, move || config.with_file().ok()?.time_scale().ok()?).ok().flatten()
        };
        let clock = match &typed.now {
            Some(now) => Clock::Rehearsal(Cell::new(parse_moment(now, scale())?)),
            None => Clock::Machine,
        };
        let flags = Self {
            clock,
            margin_s: typed.margin.map(|margin| parse_duration_s("margin", &margin)).transpose()?,
            max_wait_s: parse_duration_s("max-wait", &typed.max_wait)?,
            timeout,
            deadline,
            strict: typed.strict,
            host: typed.host,
            config,
        };
        // A configuration file or the home file may have what the flags lack.
        if !has_invalid_file && flags.config.run.file.is_none() && flags.config.home.file.is_none() {
            flags.check_required(&flags.config)?;
        }
        Ok(flags)
    }

    fn check_required(&self, config: &Config) -> anyhow::Result<()> {
        let HostArguments { stdin, targets, target, indi, .. } = &self.host;
        let has_name = targets.is_some() && (target.is_some() || stdin.is_some());
        let has_pointing = config.exposure.target.is_some() || config.exposure.ra.is_some();
        let answers = [
            (&GATE_POINTING, has_pointing || has_name || indi.is_some()),
            (&GATE_EXPOSURE, config.exposure.duration.is_some() || stdin.is_some()),
            // The site may come from an INDI server.
            (&SITE, indi.is_some() || config.has_viewpoint()),
        ];
        GateArguments::HELP.check(config, &answers)
    }
}

/// Checks the values of flags that no argument parser checks.
///
/// # Errors
/// The errors of [`Flags::new`].
pub fn check_values(typed: &GateArguments) -> anyhow::Result<()> {
    Flags::new(typed.clone(), false).map(|_| ())
}

/// Checks the flags that are not names of files.
fn check(bare: &Config) -> anyhow::Result<()> {
    bare.pointing()?;
    bare.photometry()?;
    bare.schedule_options()?;
    bare.telescope()?;
    // A limit of the camera may be that of a telescope file, and the telescope may be in a file.
    if bare.rules.limit_mag.is_none() && bare.rules.limit_surface_brightness.is_none() {
        bare.policy()?;
    }
    if bare.fov.is_some() {
        bare.field_of_view()?;
    }
    if bare.site.is_given() {
        bare.site()?;
    }
    if !bare.shells.is_empty() {
        bare.load()?;
    }
    if bare.is_in_orbit() {
        return Err(anyhow!("gate does not support a telescope in orbit; allowed: a site"));
    }
    Ok(())
}

/// A request to the gate: the flags, completed by files.
pub struct Request {
    pub config: Config,
    /// Field, telescope, photometry, and policy including the margin.
    pub plan: ObservationPlan,
    pub pointing: Option<Direction<Gcrs>>,
    pub duration_s: Option<f64>,
    pub site: Option<Site>,
    /// The site is that of the home file. The site of a mount has precedence.
    pub is_home_site: bool,
}

impl Request {
    /// Returns true if the start is chosen by cost plus wait: a telescope is given, no magnitude limit applies to the
    /// band, and not all lit satellites block.
    pub fn decides_by_cost(&self, band: Option<&str>) -> bool {
        let ObservationPlan { telescope, policy, .. } = &self.plan;
        telescope.is_some() && !policy.has_limit_in(band) && policy.blocking == Blocking::Avoid
    }

    /// Reads the configuration, policy, field and telescope.
    ///
    /// # Errors
    /// A file is missing or invalid, or contradicts the flags.
    pub fn new(flags: &Flags) -> anyhow::Result<Self> {
        let stream = |paths: &[PathBuf]| match paths.iter().find(|path| is_stream(path)) {
            Some(path) => Err(anyhow!("{} is a stream; allowed: a file", path.display())),
            None => Ok(()),
        };
        let Config { run, home, .. } = &flags.config;
        stream(&run.file.iter().chain(&home.file).chain(&flags.host.targets).cloned().collect::<Vec<_>>())?;
        let config = flags.config.clone().with_file()?;
        stream(&config.files())?;
        flags.check_required(&config)?;
        if config.is_in_orbit() {
            return Err(anyhow!("gate does not support a telescope in orbit; allowed: a site"));
        }
        let mut policy = config.policy()?;
        policy.margin_s = flags.margin_s.or(policy.margin_s).or(Some(DEFAULT_MARGIN_S));
        policy.validate()?;
        let duration = config.exposure.duration.as_ref();
        let duration_s = duration.map(|exposure| parse_exposure_s(exposure.as_str())).transpose()?;
        let SiteConfig { named, mpc, lat, lon, .. } = &config.site;
        let has_site = named.is_some() || mpc.is_some() || lat.is_some() || lon.is_some();
        let site = if has_site || flags.host.indi.is_none() { Some(config.site()?) } else { None };
        Ok(Self {
            plan: ObservationPlan { policy, ..config.observation()? },
            pointing: config.pointing()?,
            duration_s,
            site,
            is_home_site: config.home.gives_site,
            config,
        })
    }
}
