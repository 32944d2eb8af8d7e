//! What was asked, checked before anything is read: an error here is one of usage.

use std::cell::Cell;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::anyhow;
use streakcast::config::{PolicySetup, Setup, parse_duration_s, parse_moment};
use streakcast::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};
use streakcast::geometry::Site;
use streakcast::images::Telescope;
use streakcast::passes::Field;
use streakcast::photometry::PhotometryOptions;
use streakcast::schedule::Policy;

use super::clock::Clock;
use crate::gate_arguments::{GateArguments, Host};

/// How long a host may take from the end of this command to the opening of the shutter where nobody says another, seconds.
const DEFAULT_MARGIN_S: f64 = 2.0;

/// A question to the gate.
pub struct Request {
    pub setup: Setup,
    pub clock: Clock,
    pub field: Field,
    pub telescope: Option<Telescope>,
    /// With the margin in it.
    pub policy: Policy,
    pub photometry: PhotometryOptions,
    pub pointing: Option<Direction<Gcrs>>,
    pub duration_s: Option<f64>,
    pub rotation_rad: f64,
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
    /// From what was typed and what the configuration says.
    pub fn new(typed: GateArguments) -> anyhow::Result<Self> {
        let setup = typed.shared.setup(Setup {
            policy: typed.policy.map(PolicySetup::File),
            limit_mag: typed.limit_mag,
            ..Setup::default()
        })?;
        let text = |typed: &Option<String>, said: &Option<streakcast::config::Quantity>| {
            typed.clone().or_else(|| said.as_ref().map(|value| value.text()))
        };
        let mut policy = setup.policy()?;
        if policy.max_lost_fraction.is_some() {
            return Err(anyhow!(
                "the policy's max_lost_fraction cannot be waited for; allowed: limit_mag, saturation_mag, crosstalk_mag, min_probability, margin_s"
            ));
        }
        let margin_s = typed.margin.map(|margin| parse_duration_s("margin", &margin)).transpose()?;
        policy.margin_s = margin_s.or(policy.margin_s).or(Some(DEFAULT_MARGIN_S));
        policy.validate()?;
        let pointing = match (text(&typed.ra, &setup.ra), text(&typed.dec, &setup.dec)) {
            (Some(ra), Some(dec)) => Some(Direction::from_lon_lat_rad(
                parse_right_ascension_deg(&ra)?.to_radians(),
                parse_declination_deg(&dec)?.to_radians(),
            )),
            _ => None,
        };
        let duration = text(&typed.exposure, &setup.exposure);
        let duration_s = duration.map(|exposure| parse_duration_s("exposure", &exposure)).transpose()?;
        let names = typed.targets.is_some() && (typed.target.is_some() || typed.stdin.is_some());
        if pointing.is_none() && !names && typed.indi.is_none() {
            return Err(anyhow!(
                "no pointing; say --ra and --dec, --targets with --target or --stdin ekos, or --indi localhost"
            ));
        }
        if duration_s.is_none() && typed.stdin.is_none() {
            return Err(anyhow!("no length of the exposure; say --exposure 300s, or --stdin ekos"));
        }
        let said_site = setup.site.is_some() || setup.mpc.is_some() || setup.lat.is_some() || setup.lon.is_some();
        if setup.observer_elements.is_some() || setup.observer_norad.is_some() {
            return Err(anyhow!("a telescope in orbit has no gate; say a site"));
        }
        // Said wrongly, or neither said nor to be asked for.
        let site = if said_site || typed.indi.is_none() { Some(setup.site()?) } else { None };
        if setup.elements.is_none() && setup.shells.is_none() {
            return Err(anyhow!("no satellites; say --elements FILE..."));
        }
        let max_wait_s = parse_duration_s("max-wait", &typed.max_wait)?;
        if max_wait_s > Policy::LONGEST_DELAY_S {
            return Err(anyhow!("max-wait {max_wait_s} s: allowed 0 to {} s", Policy::LONGEST_DELAY_S));
        }
        let timeout_s = parse_duration_s("timeout", &typed.timeout)?;
        if !(0.1..=600.0).contains(&timeout_s) {
            return Err(anyhow!("timeout {timeout_s} s: allowed 0.1 to 600 s"));
        }
        let clock = match &typed.now {
            Some(now) => Clock::Rehearsal(Cell::new(parse_moment(now, setup.time_scale()?)?)),
            None => Clock::Machine,
        };
        Ok(Self {
            field: setup.field_of_view()?,
            telescope: setup.telescope()?,
            photometry: setup.photometry()?,
            rotation_rad: setup.schedule_options()?.default_rotation_rad,
            policy,
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
            setup,
        })
    }
}
