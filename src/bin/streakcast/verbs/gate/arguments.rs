//! Flags of `gate`, and the request that they define, with checks that precede the reading of elements.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::anyhow;
use clap::{Args, ValueEnum};
use streakcast::config::{
    Config, ExposureConfig, ObservationPlan, PolicyChoice, Quantity, RulesConfig, SiteConfig, parse_duration_s,
};
use streakcast::frames::{Direction, Gcrs, parse_moment};
use streakcast::geometry::Site;
use streakcast::input::{check_regular, is_stream};
use streakcast::schedule::MagnitudeLimit;

use super::clock::Clock;
use crate::required::Required;

#[derive(Args)]
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
    /// Read the job from standard input: ekos (JSON that Ekos sends to its pre-capture script)
    #[arg(long, value_name = "HOST", help_heading = "Host")]
    pub stdin: Option<Host>,
    /// File of target coordinates by name (TOML), for hosts that send only the name
    #[arg(long, value_name = "FILE", help_heading = "Host")]
    pub targets: Option<PathBuf>,
    /// Name of the target in --targets, overridden by the host with --stdin; without --targets a Messier or Caldwell
    /// object
    #[arg(long, value_name = "NAME", help_heading = "Host")]
    pub target: Option<String>,
    /// Read the pointing from a mount on an INDI server, for example localhost or 10.0.0.2:7624
    #[arg(long, value_name = "HOST:PORT", help_heading = "Host")]
    pub indi: Option<String>,
    /// Name of the mount, if the INDI server has several
    #[arg(long, value_name = "NAME", requires = "indi", help_heading = "Host")]
    pub indi_device: Option<String>,
    /// Timeout of standard input and the INDI server, with its unit
    #[arg(long, value_name = "TIME", default_value = "5s", help_heading = "Host")]
    pub timeout: String,
    /// File of the result and of counters over all runs (JSON), for hosts that show neither output nor log
    #[arg(long, value_name = "FILE", help_heading = "Host")]
    pub status_file: Option<PathBuf>,
    /// Rehearse a run at this time instead of now; waits take no time
    #[arg(long, value_name = "TIME", help_heading = "Time")]
    pub now: Option<String>,
    #[command(flatten)]
    pub config: Config,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum Host {
    Ekos,
}

/// Default margin, seconds. It covers the time between the end of this command and the shutter opening.
const DEFAULT_MARGIN_S: f64 = 2.0;

/// Returns the error for a pipe or other stream as input file: reading it could block.
fn stream_error(path: &Path) -> anyhow::Error {
    anyhow!("{} is a stream, for which gate could wait without end; allowed: a file", path.display())
}

/// A request to the gate.
pub struct Request {
    pub config: Config,
    pub clock: Clock,
    /// Field, telescope, photometry, and policy including the margin.
    pub plan: ObservationPlan,
    pub pointing: Option<Direction<Gcrs>>,
    pub duration_s: Option<f64>,
    pub site: Option<Site>,
    pub max_wait_s: f64,
    pub timeout: Duration,
    pub strict: bool,
    pub stdin: Option<Host>,
    pub targets: Option<PathBuf>,
    pub target: Option<String>,
    pub indi: Option<String>,
    pub indi_device: Option<String>,
    pub status_file: Option<PathBuf>,
}

impl Request {
    /// Checks flags and configuration, and returns the request.
    pub fn new(typed: GateArguments) -> anyhow::Result<Self> {
        let flags = Config {
            exposure: ExposureConfig {
                start: None,
                duration: typed.exposure,
                target: if typed.targets.is_none() { typed.target.clone() } else { None },
                ra: typed.ra,
                dec: typed.dec,
            },
            rules: RulesConfig {
                policy: typed.policy,
                limit_mag: typed.limit_mag,
                blocking: typed.blocking,
                max_delay: None,
            },
            ..typed.config
        };
        let config_file = flags.run.file.clone();
        if let Some(path) = config_file.iter().chain(&typed.targets).find(|path| is_stream(path)) {
            return Err(stream_error(path));
        }
        let config = flags.with_file()?;
        if let Some(path) = config.files().iter().find(|path| is_stream(path)) {
            return Err(stream_error(path));
        }
        // A named pipe is an error: opening it would block until it is read.
        if let Some(path) = typed.status_file.as_ref().filter(|path| path.exists()) {
            check_regular(path).map_err(|error| anyhow!("status file {}: {error}", path.display()))?;
        }
        let has_name = typed.targets.is_some() && (typed.target.is_some() || typed.stdin.is_some());
        let has_pointing = config.exposure.target.is_some() || config.exposure.ra.is_some();
        let required = Required::of(&config)
            .input(
                has_pointing || has_name || typed.indi.is_some(),
                "pointing",
                "--ra and --dec, --target M31, --targets with --target or --stdin ekos, or --indi localhost",
            )
            .input(
                config.exposure.duration.is_some() || typed.stdin.is_some(),
                "exposure time",
                "--exposure TIME, for example 300s, or --stdin ekos",
            )
            .satellites()
            .field();
        // The site may come from an INDI server.
        if typed.indi.is_some() { required } else { required.site() }.check()?;
        let mut policy = config.policy()?;
        if policy.max_lost_fraction.is_some() {
            return Err(anyhow!("the policy has max_lost_fraction, which gate does not support; remove this key"));
        }
        let margin_s = typed.margin.map(|margin| parse_duration_s("margin", &margin)).transpose()?;
        policy.margin_s = margin_s.or(policy.margin_s).or(Some(DEFAULT_MARGIN_S));
        policy.validate()?;
        let text = |value: &Option<Quantity>| value.as_ref().map(|value| value.0.clone());
        let pointing = config.pointing()?;
        let duration = text(&config.exposure.duration);
        let duration_s = duration.map(|exposure| parse_duration_s("exposure", &exposure)).transpose()?;
        if config.is_in_orbit() {
            return Err(anyhow!("gate does not support a telescope in orbit; allowed: a site"));
        }
        let SiteConfig { named, mpc, lat, lon, .. } = &config.site;
        let has_site = named.is_some() || mpc.is_some() || lat.is_some() || lon.is_some();
        let site = if has_site || typed.indi.is_none() { Some(config.site()?) } else { None };
        let max_wait_s = parse_duration_s("max-wait", &typed.max_wait)?;
        let timeout_s = parse_duration_s("timeout", &typed.timeout)?;
        if !(0.1..=600.0).contains(&timeout_s) {
            return Err(anyhow!("timeout is {timeout_s} s; allowed: 0.1 to 600 s"));
        }
        let clock = match &typed.now {
            Some(now) => Clock::Rehearsal(Cell::new(parse_moment(now, config.time_scale()?)?)),
            None => Clock::Machine,
        };
        Ok(Self {
            plan: ObservationPlan { policy, ..config.observation()? },
            pointing,
            duration_s,
            site,
            max_wait_s,
            timeout: Duration::from_secs_f64(timeout_s),
            strict: typed.strict,
            stdin: typed.stdin,
            targets: typed.targets,
            target: typed.target,
            indi: typed.indi,
            indi_device: typed.indi_device,
            status_file: typed.status_file,
            clock,
            config,
        })
    }
}
