//! The run: what the host says, where the mount points, when the field is clear, and what is left behind.

use std::path::Path;
use std::time::{Duration, SystemTime};

use anyhow::anyhow;
use hifitime::Epoch;
use serde_json::{Map, Value, json};
use streakcast::config::{Config, ConfigError, NameOrTable, OLD_ELEMENTS_DAYS, PreparedSky, SiteConfig, SiteTable};
use streakcast::elements::{ElementsError, share_of_stale};
use streakcast::frames::{Direction, Gcrs, seconds_after, seconds_between};
use streakcast::geometry::Site;
use streakcast::output::format_utc;
use streakcast::passes::{Exposure, Pass};
use streakcast::schedule::{
    Blocking, ClearWindow, TargetWindows, WindowRequest, WindowTarget, clear_windows, next_window,
};

use super::arguments::GateArguments;
use super::arguments::Request;
use super::status::{Fault, FaultKind};
use super::{ekos, indi, places, status};
use crate::failure::Outcome;
use crate::notices::Notices;

/// A mount farther than this from the site that was given stands elsewhere, km.
const SAME_SITE_KM: f64 = 1.0;
/// A file of elements written less than this ago may still be being written.
const FRESH: Duration = Duration::from_secs(10);
/// One that has stayed so long as it is, is meant to be so.
const SETTLED: Duration = Duration::from_secs(600);
/// How often, and how long apart, elements are read again that could not be read, seconds.
const TRIES: usize = 4;
const TRY_AGAIN_S: f64 = 0.3;
/// A clock that is off by more than this after a wait was set meanwhile, seconds.
const CLOCK_STEP_S: f64 = 1.0;
/// Passes named in the status file.
const NAMED: usize = 5;

/// How it ended.
enum VerdictKind {
    /// The field is clear, after a wait or at once.
    Clear { waited_s: f64, until: Epoch },
    /// Not within the longest wait.
    NotClear,
    /// No light frame.
    Skipped(String),
}

pub fn run(typed: GateArguments) -> anyhow::Result<Outcome> {
    let request = Request::new(typed)?;
    let notices = super::super::judged::begin(&request.config)?;
    let began = request.clock.now();
    let before = status::read(request.status_file.as_deref());
    let mut said = Map::new();
    let answer = answer(&request, before.satellites, &mut said, &notices);

    let mut counters = before.counters;
    counters.runs += 1;
    let (verdict, outcome) = match &answer {
        Ok(VerdictKind::Clear { waited_s, .. }) => {
            let counter = if *waited_s > 0.0 { &mut counters.waited } else { &mut counters.clear };
            *counter += 1;
            counters.waited_s += waited_s;
            ("clear", Ok(Outcome::Done))
        }
        Ok(VerdictKind::NotClear) => {
            counters.not_clear += 1;
            ("not_clear", Ok(if request.strict { Outcome::No } else { Outcome::Done }))
        }
        Ok(VerdictKind::Skipped(_)) => {
            counters.skipped += 1;
            ("skipped", Ok(Outcome::Done))
        }
        Err(fault) => {
            *counters.faults.entry(fault.kind.name().to_owned()).or_default() += 1;
            said.insert("fault".into(), fault.kind.name().into());
            ("fault", if request.strict { Err(anyhow!("{fault}")) } else { Ok(Outcome::Done) })
        }
    };
    let line = line(&answer, request.max_wait_s);
    let code = match &outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::No) => 1,
        Err(_) => 2,
    };
    state(&mut said, "verdict", verdict);
    state(&mut said, "exit_code", code);
    state(&mut said, "message", line.as_str());
    state(&mut said, "began_utc", format_utc(began, 3));
    state(&mut said, "ended_utc", format_utc(request.clock.now(), 3));
    if let (None, Some(satellites)) = (said.get("satellites"), before.satellites) {
        state(&mut said, "satellites", satellites);
    }
    state(&mut said, "counters", json!(counters));
    if outcome.is_ok() {
        notices.say(&line);
    }
    let written = request.status_file.as_ref().map(|path| (path, status::write(path, &said)));
    match (written, outcome) {
        (Some((path, Err(error))), Ok(_)) if request.strict => Err(anyhow!("cannot write {}: {error}", path.display())),
        (Some((path, Err(error))), outcome) => {
            notices.warn(&[format!("cannot write {}: {error}", path.display())]);
            outcome
        }
        (_, outcome) => outcome,
    }
}

fn state(said: &mut Map<String, Value>, name: &str, value: impl Into<Value>) {
    said.insert(name.to_owned(), value.into());
}

/// One line of log.
fn line(answer: &Result<VerdictKind, Fault>, max_wait_s: f64) -> String {
    match answer {
        Ok(VerdictKind::Clear { waited_s, until }) if *waited_s > 0.0 => {
            format!("gate: clear after {waited_s:.1} s, starts until {}", format_utc(*until, 0))
        }
        Ok(VerdictKind::Clear { until, .. }) => format!("gate: clear now, starts until {}", format_utc(*until, 0)),
        Ok(VerdictKind::NotClear) => {
            format!("warning: gate: no clear start within {max_wait_s} s; go on and be streaked")
        }
        Ok(VerdictKind::Skipped(why)) => format!("gate: {why}: nothing to wait for"),
        Err(fault) => format!("warning: gate: {fault}; nothing was checked, go on"),
    }
}

fn answer(
    request: &Request,
    satellites_before: Option<usize>,
    said: &mut Map<String, Value>,
    notices: &Notices,
) -> Result<VerdictKind, Fault> {
    let job = match request.stdin {
        Some(_) => ekos::read_job(request.timeout)?,
        None => None,
    };
    if let Some(job) = job.as_ref().filter(|job| !job.is_light()) {
        return Ok(VerdictKind::Skipped(format!("a {} frame", job.kind.as_deref().unwrap_or_default().trim())));
    }
    let band = job.as_ref().and_then(ekos::Job::band);
    let name = job.as_ref().and_then(|job| job.target_name.clone()).or_else(|| request.target.clone());
    let duration_s = job.as_ref().and_then(|job| job.exposure).or(request.duration_s);
    let duration_s = duration_s.filter(|duration_s| (0.0..=86_400.0).contains(duration_s)).ok_or_else(|| {
        Fault::new(FaultKind::Host, format!("no length of the exposure (0 to 86400 s): {duration_s:?}"))
    })?;
    let (pointing, site) = place(request, name.as_deref(), said)?;
    let exposure = Exposure {
        id: name.unwrap_or_else(|| "1".to_owned()),
        start: request.clock.now(),
        duration_s,
        pointing,
        rotation_rad: request.plan.rotation_rad,
    };
    let round = |radians: f64| (radians.to_degrees() * 1e6).round() / 1e6;
    state(said, "target", exposure.id.as_str());
    state(said, "ra_deg", round(pointing.longitude_rad()));
    state(said, "dec_deg", round(pointing.latitude_rad()));
    state(said, "exposure_s", duration_s);
    state(said, "band", band.clone());
    state(said, "limit_mag", request.plan.policy.limit_mag.as_ref().and_then(|limit| limit.of(band.as_deref())));

    let prepared = prepare(request, &site, satellites_before, said, notices)?;
    let now = request.clock.now();
    let window_request = WindowRequest {
        against: request.plan.request(&prepared.sky),
        blocking: Blocking::Limits,
        min_altitude_rad: 0.0,
        max_sun_altitude_rad: None,
    };
    let target = WindowTarget { exposure, band };
    let setup_fault = |error: &dyn std::fmt::Display| Fault::new(FaultKind::Setup, error);
    // The windows reach beyond the longest wait, so that it can be said until when the field stays clear.
    let horizon = seconds_after(now, request.max_wait_s + duration_s.max(60.0));
    let report = clear_windows(std::slice::from_ref(&target), now, horizon, &window_request)
        .map_err(|error| setup_fault(&error))?;
    prepared.left_out_warning(&report.left_out, now).map_err(|error| Fault::new(FaultKind::Elements, error))?;
    let found = report.by_target.into_iter().next().unwrap_or_default();
    if found.observable.first().is_none_or(|window| seconds_between(now, window.first) > request.max_wait_s) {
        let message = format!("target {} is below the horizon of {}", target.exposure.id, site.name);
        return Err(Fault::new(FaultKind::Target, message));
    }
    // The reading took its time.
    let now = request.clock.now();
    let last = seconds_after(now, request.max_wait_s);
    name_passes(&found, &prepared, now, seconds_after(last, duration_s), said);
    let Some(ClearWindow { first, last: until }) = next_window(&found.windows, now, last) else {
        return Ok(VerdictKind::NotClear);
    };
    let waited_s = seconds_between(now, first).max(0.0);
    state(said, "waited_s", (waited_s * 1e3).round() / 1e3);
    state(said, "start_utc", format_utc(first, 3));
    state(said, "clear_until_utc", format_utc(until, 3));
    if waited_s > 0.0 {
        tell_waiting(request, said);
        request.clock.sleep_until(first);
        let now = request.clock.now();
        let late_s = seconds_between(first, now);
        if late_s < -CLOCK_STEP_S || now > until && late_s > CLOCK_STEP_S {
            let message = format!(
                "the clock was set, or the machine slept, during the wait: {late_s:+.1} s from the clear start"
            );
            return Err(Fault::new(FaultKind::Clock, message));
        }
    }
    Ok(VerdictKind::Clear { waited_s, until })
}

/// Where the field lies and where the telescope stands: typed, by the target's name, or by asking the mount.
fn place(
    request: &Request,
    name: Option<&str>,
    said: &mut Map<String, Value>,
) -> Result<(Direction<Gcrs>, Site), Fault> {
    let named = match (&request.targets, name) {
        (Some(path), Some(name)) if request.pointing.is_none() => Some(places::look_up(path, name)),
        _ => None,
    };
    let mount = match &request.indi {
        Some(address) => {
            let mount = indi::ask(address, request.indi_device.as_deref(), request.timeout, &request.clock)?;
            state(said, "mount", mount.device.as_str());
            if let Some(wrong_s) = mount.clock_wrong_s {
                let message = format!(
                    "the clock of the INDI server is {wrong_s:+.1} s from this machine's (37 s: one of them tells TAI for UTC)"
                );
                return Err(Fault::new(FaultKind::Clock, message));
            }
            Some(mount)
        }
        None => None,
    };
    let pointing = match (request.pointing, named, &mount) {
        (Some(pointing), ..) | (None, Some(Ok(pointing)), _) => pointing,
        // A name that the file lacks is no matter where the mount itself can say.
        (None, _, Some(mount)) => mount.pointing,
        (None, Some(Err(fault)), None) => return Err(fault),
        (None, None, None) => {
            return Err(Fault::new(FaultKind::Target, "the host names no target, and nothing else says where it is"));
        }
    };
    let mount_site = mount.and_then(|mount| mount.site);
    let site = match (&request.site, mount_site) {
        (Some(site), Some(theirs)) => {
            let apart_km = (site.itrs() - theirs.itrs()).norm_km();
            if apart_km > SAME_SITE_KM {
                let message = format!("the mount {} stands {apart_km:.1} km from {}", theirs.name, site.name);
                return Err(Fault::new(FaultKind::Site, message));
            }
            site.clone()
        }
        (Some(site), None) => site.clone(),
        (None, Some(theirs)) => theirs,
        (None, None) => return Err(Fault::new(FaultKind::Site, "the mount does not say where it stands; say --site")),
    };
    Ok((pointing, site))
}

/// The sky over the site, its elements read again where they were just being written.
fn prepare(
    request: &Request,
    site: &Site,
    satellites_before: Option<usize>,
    said: &mut Map<String, Value>,
    notices: &Notices,
) -> Result<PreparedSky, Fault> {
    let named = NameOrTable::Table(SiteTable {
        name: Some(site.name.clone()),
        mpc: None,
        latitude_deg: Some(site.latitude_rad.to_degrees()),
        longitude_deg: Some(site.longitude_rad.to_degrees()),
        height_m: Some(site.height_m),
    });
    let site = SiteConfig { named: Some(named), ..SiteConfig::default() };
    let config = Config { site, ..request.config.clone() };
    let now = request.clock.now();
    let files = &config.elements;
    let mut tries = 1;
    let prepared = loop {
        let prepared = config.prepare(now, seconds_after(now, request.max_wait_s));
        let is_done = match &prepared {
            Err(error) => !is_of_elements(error),
            Ok(prepared) => {
                rejected(prepared) == 0 || files.iter().all(|path| age(path).is_none_or(|age| age >= FRESH))
            }
        };
        if is_done || tries == TRIES {
            break prepared;
        }
        tries += 1;
        // Waiting for a file is real even where the clock is not.
        std::thread::sleep(Duration::from_secs_f64(TRY_AGAIN_S));
    };
    let prepared = prepared.map_err(|error| {
        Fault::new(if is_of_elements(&error) { FaultKind::Elements } else { FaultKind::Setup }, error)
    })?;
    notices.warn(&prepared.warnings);
    let (satellites, rejected) = (prepared.sky.elements().len(), rejected(&prepared));
    state(said, "elements_rejected", rejected);
    // Fewer than the last time, and not because somebody wanted it so.
    let cut_short = is_cut_short(&prepared);
    let least = |before: usize| if cut_short { before - before / 10 } else { before.div_ceil(2) };
    let meant = files.is_empty() || !cut_short && files.iter().all(|path| age(path).is_some_and(|age| age >= SETTLED));
    let shrank = satellites_before.filter(|before| satellites < least(*before) && !meant);
    if rejected > satellites || shrank.is_some() {
        let before = shrank.map_or_else(String::new, |before| format!(", {before} the last time"));
        let message = format!("half-written elements? {satellites} satellites, {rejected} records rejected{before}");
        return Err(Fault::new(FaultKind::Elements, message));
    }
    state(said, "satellites", satellites);
    let stale = share_of_stale(prepared.sky.elements(), now, OLD_ELEMENTS_DAYS);
    if stale > 0.5 {
        let message = format!("{:.0} % of the elements are more than {OLD_ELEMENTS_DAYS} days from now", 100.0 * stale);
        return Err(Fault::new(FaultKind::StaleElements, message));
    }
    Ok(prepared)
}

fn is_of_elements(error: &ConfigError) -> bool {
    use ElementsError::{ShellOutOfRange, ShellSyntax, ShellTotal, UnknownShells};
    match error {
        ConfigError::Elements(error) => {
            !matches!(error, UnknownShells { .. } | ShellSyntax(_) | ShellOutOfRange { .. } | ShellTotal { .. })
        }
        error => matches!(error, ConfigError::NothingPropagates { .. }),
    }
}

fn rejected(prepared: &PreparedSky) -> usize {
    let attached = prepared.provenance.attached().find(|(name, _)| *name == "rejected_count");
    attached.and_then(|(_, count)| count.as_u64()).map_or(0, |count| count as usize)
}

fn is_cut_short(prepared: &PreparedSky) -> bool {
    let attached = prepared.provenance.attached().find(|(name, _)| *name == "cut_short");
    attached.and_then(|(_, names)| names.as_array()).is_some_and(|names| !names.is_empty())
}

/// How long ago a file was changed, by its date; not known of times to come, which are another machine's.
fn age(path: &Path) -> Option<Duration> {
    let changed = std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok()?;
    SystemTime::now().duration_since(changed).ok()
}

/// The passes that are waited for, in the status file.
fn name_passes(found: &TargetWindows, prepared: &PreparedSky, from: Epoch, to: Epoch, said: &mut Map<String, Value>) {
    let ahead: Vec<&Pass> =
        found.dodged.iter().filter(|pass| pass.exit.epoch >= from && pass.enter.epoch <= to).collect();
    let named: Vec<Value> = ahead
        .iter()
        .take(NAMED)
        .map(|pass| {
            let brightness = pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
            json!({
                "norad_id": pass.norad_id.0,
                "name": &*prepared.sky.elements()[pass.element_index].name,
                "enter_utc": format_utc(pass.enter.epoch, 3),
                "exit_utc": format_utc(pass.exit.epoch, 3),
                "magnitude_peak": brightness.map(|brightness| (brightness.magnitude.0 * 1e3).round() / 1e3),
            })
        })
        .collect();
    state(said, "n_dodged", ahead.len());
    state(said, "dodged", named);
}

/// That it is waiting, for whoever looks meanwhile; the counters come at the end.
fn tell_waiting(request: &Request, said: &Map<String, Value>) {
    let Some(path) = &request.status_file else { return };
    let mut said = said.clone();
    state(&mut said, "verdict", "waiting");
    state(&mut said, "counters", json!(status::read(Some(path)).counters));
    // What cannot be written now is told at the end.
    let _ = status::write(path, &said);
}
