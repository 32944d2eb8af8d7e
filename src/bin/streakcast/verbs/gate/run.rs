//! Run of the gate: reads the job of the host and the pointing of the mount, waits for a clear field, and writes the
//! status file. Everything that may block runs in other threads, with a deadline.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use hifitime::Epoch;
use serde_json::{Map, Value, json};
use streakcast::Error;
use streakcast::config::PreparedSky;
use streakcast::frames::{Direction, Gcrs, seconds_after, seconds_between};
use streakcast::geometry::Site;
use streakcast::output::format_utc;
use streakcast::passes::{Exposure, Pass};
use streakcast::schedule::{
    Blocking, COMPARED_STARTS, ClearWindow, FlagRequest, Policy, ScheduledExposure, TargetWindows, WindowRequest,
    WindowTarget, best_start, clear_windows, delayed_costs_s, next_window, reason_for_unknown_starts,
};

use super::arguments::{Flags, GateArguments, Request};
use super::deadline::{NoResult, Step, left, within};
use super::report::{Counted, GateVerdict, SUN_ALTITUDE, daylight, line, rounded, state, write_final, write_waiting};
use super::sky::prepare;
use super::status_file::{Fault, FaultKind};
use super::{ekos, indi, targets};
use crate::failure::Outcome;
use crate::notices::Notices;

/// Largest accepted distance between the given site and that of the mount, km.
const SAME_SITE_KM: f64 = 1.0;
/// Least time for the status file.
const STATUS: Duration = Duration::from_secs(2);
/// Error of the clock after a wait, seconds, above which the clock is taken to have been changed during the wait.
const CLOCK_STEP_S: f64 = 1.0;
/// Largest number of avoided passes listed in the status file.
const NAMED: usize = 5;

/// Result of a run, and what is stated about it in the status file.
struct Decision {
    result: Result<GateVerdict, Fault>,
    status: Map<String, Value>,
    /// Writer of messages, with the options of the configuration file.
    notices: Option<Notices>,
}

/// Runs the verb. `file_error` is an error in the configuration file, in a key of a verb: a fault, like any error in a
/// file.
pub fn run(typed: GateArguments, file_error: Option<anyhow::Error>) -> anyhow::Result<Outcome> {
    let flags = Flags::new(typed, file_error.is_some())?;
    let began = flags.clock.now();
    let step = Step::default();
    let decided = match file_error {
        Some(error) => {
            let result = Err(Fault::new(FaultKind::Setup, error));
            Ok(Decision { result, status: Map::new(), notices: None })
        }
        None => {
            let (flags, step) = (flags.clone(), step.clone());
            within(flags.deadline, move || decide(&flags, &step))
        }
    };
    let timeout_s = flags.timeout.as_secs_f64();
    let fault = match decided {
        Ok(_) => None,
        Err(NoResult::Late) => {
            let message = format!("no result within {timeout_s} s (--timeout), after the start of: {}", step.last());
            Some(Fault::new(FaultKind::Timeout, message))
        }
        Err(NoResult::Failed) => Some(Fault::new(FaultKind::Setup, format!("internal error while {}", step.last()))),
    };
    let nothing =
        |_| Decision { result: Ok(GateVerdict::NotClear { most_s: None }), status: Map::new(), notices: None };
    let decision = decided.unwrap_or_else(nothing);
    let notices = decision.notices.unwrap_or_else(|| Notices::from_config(&flags.config));
    let (mut status, mut result) = (decision.status, fault.map_or(decision.result, Err));
    let rest = left(flags.deadline, flags.timeout).max(STATUS);
    if let Some((waited_s, first, until)) = result.as_ref().ok().and_then(GateVerdict::start)
        && waited_s > 0.0
    {
        if let Some(path) = flags.host.status_file.clone() {
            let of_wait = status.clone();
            // If writing fails, the error is reported when the final status is written.
            if let Ok(Ok(lost)) = within(Instant::now() + rest, move || write_waiting(&path, of_wait)) {
                notices.warn(lost.as_slice());
            }
        }
        flags.clock.sleep_until(first);
        if let Some(fault) = fault_after_wait(first, until, flags.clock.now()) {
            result = Err(fault);
        }
    }
    let line = line(&result, &flags) + &daylight(&status);
    let verdict = match &result {
        Ok(GateVerdict::Clear { .. }) => "clear",
        Ok(GateVerdict::Best { .. }) => "start",
        Ok(GateVerdict::NotClear { .. }) => "not_clear",
        Ok(GateVerdict::Skipped(_)) => "skipped",
        Err(_) => "fault",
    };
    let outcome = match &result {
        Err(fault) if flags.strict => Err(anyhow!("{fault}")),
        Ok(GateVerdict::NotClear { .. }) if flags.strict => Ok(Outcome::No),
        _ => Ok(Outcome::Done),
    };
    let code = match &outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::No) => 1,
        Err(_) => 2,
    };
    if let Err(fault) = &result {
        state(&mut status, "fault", fault.kind.name());
    }
    state(&mut status, "verdict", verdict);
    state(&mut status, "exit_code", code);
    state(&mut status, "message", line.as_str());
    state(&mut status, "began_utc", format_utc(began, 3));
    state(&mut status, "ended_utc", format_utc(flags.clock.now(), 3));
    if outcome.is_ok() {
        notices.info(&line);
    }
    let Some(path) = flags.host.status_file.clone() else { return outcome };
    let counted = Counted::from_result(&result);
    let written = within(Instant::now() + rest, {
        let path = path.clone();
        move || write_final(&path, status, &counted)
    });
    let error = match written {
        Ok(Ok(lost)) => {
            notices.warn(lost.as_slice());
            return outcome;
        }
        Ok(Err(error)) => error.to_string(),
        Err(_) => format!("no result within {:.0} s", rest.as_secs_f64()),
    };
    let message = format!("cannot write {}: {error}", path.display());
    if flags.strict && outcome.is_ok() {
        return Err(anyhow!(message));
    }
    notices.warn(&[message]);
    outcome
}

/// Returns the fault of a wait that did not end within the starts that were judged, from `first` to `until`: the clock
/// was changed, or the machine slept.
fn fault_after_wait(first: Epoch, until: Epoch, now: Epoch) -> Option<Fault> {
    let late_s = seconds_between(first, now);
    (late_s < -CLOCK_STEP_S || now > until && late_s > CLOCK_STEP_S).then(|| {
        let message = format!(
            "the clock was set, or the machine was suspended, during the wait: {late_s:+.1} s from the start that was judged"
        );
        Fault::new(FaultKind::Clock, message)
    })
}

/// Reads all inputs and decides whether and when the exposure can start, without waiting.
fn decide(flags: &Flags, step: &Step) -> Decision {
    let mut status = Map::new();
    step.begin("reading the configuration, policy, field and telescope");
    let setup = |error: anyhow::Error| Fault::new(FaultKind::Setup, error);
    let request = match Request::new(flags).and_then(|request| Ok((crate::start::begin(&request.config)?, request))) {
        Ok((notices, request)) => (notices, request),
        Err(error) => return Decision { result: Err(setup(error)), status, notices: None },
    };
    let (notices, request) = request;
    let result = verdict(flags, &request, step, &mut status, &notices);
    Decision { result, status, notices: Some(notices) }
}

fn verdict(
    flags: &Flags,
    request: &Request,
    step: &Step,
    status: &mut Map<String, Value>,
    notices: &Notices,
) -> Result<GateVerdict, Fault> {
    let job = match flags.host.stdin {
        Some(_) => {
            step.begin("reading standard input");
            ekos::read_job(left(flags.deadline, flags.timeout / 2))?
        }
        None => None,
    };
    if let Some(job) = job.as_ref().filter(|job| !job.is_light()) {
        return Ok(GateVerdict::Skipped(format!("a {} frame", job.kind.as_deref().unwrap_or_default().trim())));
    }
    let band = job.as_ref().and_then(ekos::Job::band);
    let name = job.as_ref().and_then(|job| job.target_name.clone()).or_else(|| flags.host.target.clone());
    let duration_s = job.as_ref().and_then(|job| job.exposure).or(request.duration_s);
    let duration_s = match duration_s {
        Some(duration_s) if duration_s > 0.0 && duration_s <= 86_400.0 => duration_s,
        given => {
            let given = given.map_or("missing exposure time".to_owned(), |given| format!("exposure time is {given} s"));
            return Err(Fault::new(FaultKind::Host, format!("{given}; allowed: above 0 s, at most 86400 s")));
        }
    };
    let (pointing, site) = pointing_and_site(flags, request, name.as_deref(), step, status)?;
    let exposure = Exposure {
        id: name.unwrap_or_else(|| "1".to_owned()),
        start: flags.clock.now(),
        duration_s,
        pointing,
        rotation_rad: request.plan.rotation_rad,
    };
    let round = |radians: f64| (radians.to_degrees() * 1e6).round() / 1e6;
    state(status, "target", exposure.id.as_str());
    state(status, "ra_deg", round(pointing.longitude_rad()));
    state(status, "dec_deg", round(pointing.latitude_rad()));
    state(status, "exposure_s", duration_s);
    state(status, "band", band.clone());
    let by_cost = request.decides_by_cost(band.as_deref());
    state(status, "blocking", if by_cost { "cost" } else { request.plan.policy.blocking.name() });
    let Policy { limit_mag, limit_surface_brightness, .. } = &request.plan.policy;
    for (key, limit) in [("limit_mag", limit_mag), ("limit_surface_brightness", limit_surface_brightness)] {
        state(status, key, limit.as_ref().and_then(|limit| limit.limit_in(band.as_deref())));
    }

    let prepared = prepare(flags, request, &site, step, status, notices)?;
    let now = flags.clock.now();
    let setup_fault = |error: &dyn std::fmt::Display| Fault::new(FaultKind::Setup, error);
    let sun = prepared.sky.sun_altaz(now).map_err(|error| setup_fault(&error))?;
    state(status, SUN_ALTITUDE, rounded(sun.altitude_rad.to_degrees(), 2));
    step.begin("computing the crossings");
    let policy = &request.plan.policy;
    notices.warn(&policy.band_warnings(&BTreeSet::from([band.as_deref()])));
    let is_limited = policy.blocking == Blocking::Avoid && policy.has_limit_in(band.as_deref());
    let window_request = WindowRequest {
        conditions: request.plan.request(&prepared.sky),
        min_altitude_rad: 0.0,
        max_sun_altitude_rad: None,
    };
    let target = WindowTarget { exposure, band };
    let known = prepared.sky.predictability(now, None);
    let unknown = reason_for_unknown_starts(&prepared.sky, &request.plan.field, policy, now, duration_s);
    state(status, "positions_known", unknown.is_none());
    state(status, "elements_age_days", rounded(known.element_age_days, 2));
    state(status, "late_s", known.late_s.and_then(|late_s| rounded(late_s, 2)));
    if let Some(reason) = unknown {
        return Err(Fault::new(FaultKind::StaleElements, reason));
    }
    let below = || {
        let message = format!(
            "target {} is below the horizon of {}, or sets during the exposure; allowed: a target above the horizon",
            target.exposure.id, site.name
        );
        Fault::new(FaultKind::Target, message)
    };
    if by_cost {
        let best = best_start(&row_of(&target, now), flags.max_wait_s, &window_request.conditions)
            .map_err(|error| setup_fault(&error))?;
        let Some(best) = best else { return Err(below()) };
        state(status, "scheduled_cost_s", rounded(best.scheduled_cost_s, 3));
        if policy.max_cost_s.is_some_and(|most_s| best.streak_cost_s > most_s) {
            return Ok(GateVerdict::NotClear { most_s: policy.max_cost_s });
        }
        let first = seconds_after(now, best.delay_s);
        let until = seconds_after(first, policy.margin_or_default_s());
        let waited_s = seconds_between(flags.clock.now(), first).max(0.0);
        state(status, "waited_s", (waited_s * 1e3).round() / 1e3);
        state(status, "start_utc", format_utc(first, 3));
        state(status, "cost_until_utc", format_utc(until, 3));
        state(status, "streak_cost_s", rounded(best.streak_cost_s, 3));
        return Ok(GateVerdict::Best { waited_s, first, until, best });
    }
    // The windows extend beyond the longest wait, so that the end of the clear interval is known.
    let horizon = seconds_after(now, flags.max_wait_s + duration_s.max(60.0) + duration_s);
    let report = clear_windows(std::slice::from_ref(&target), now, horizon, &window_request)
        .map_err(|error| setup_fault(&error))?;
    prepared.left_out_warning(&report.left_out, now).map_err(|error| Fault::new(FaultKind::Elements, error))?;
    let found = report.by_target.into_iter().next().unwrap_or_default();
    if found.observable.first().is_none_or(|window| seconds_between(now, window.first) > flags.max_wait_s) {
        return Err(below());
    }
    // The clock is read again, because reading the elements took some time.
    let now = flags.clock.now();
    let last = seconds_after(now, flags.max_wait_s);
    add_blocking_passes(&found, &prepared, now, seconds_after(last, duration_s), status);
    let most_s = policy.max_cost_s;
    let next = match most_s {
        Some(most_s) => affordable_start(&found.windows, (now, last), &target, most_s, &window_request.conditions)
            .map_err(|error| setup_fault(&error))?,
        None => next_window(&found.windows, now, last),
    };
    let Some(ClearWindow { first, last: until }) = next else { return Ok(GateVerdict::NotClear { most_s }) };
    let waited_s = seconds_between(now, first).max(0.0);
    state(status, "waited_s", (waited_s * 1e3).round() / 1e3);
    state(status, "start_utc", format_utc(first, 3));
    state(status, "clear_until_utc", format_utc(until, 3));
    Ok(GateVerdict::Clear { waited_s, first, until, most_s, is_limited })
}

/// Returns the target as a row of a schedule at a start.
fn row_of(target: &WindowTarget, start: Epoch) -> ScheduledExposure {
    let WindowTarget { exposure, band } = target;
    let exposure = Exposure { start, ..exposure.clone() };
    ScheduledExposure { id: exposure.id.clone(), row: 0, band: band.clone(), open_s: None, exposure: Ok(exposure) }
}

/// Returns the first start in the windows at which the streaks cost at most `most_s`, with the last start for which
/// they were computed: of the beginnings of the windows and of starts at equal intervals from the first to the last
/// time.
fn affordable_start(
    windows: &[ClearWindow],
    (now, last): (Epoch, Epoch),
    target: &WindowTarget,
    most_s: f64,
    request: &FlagRequest<'_>,
) -> Result<Option<ClearWindow>, Error> {
    let step_s = seconds_between(now, last) / f64::from(COMPARED_STARTS);
    let regular = (0..=COMPARED_STARTS).map(|number| seconds_after(now, step_s * f64::from(number)));
    let window_from = |start: Epoch| {
        let window = windows.iter().find(|window| (window.first..=window.last).contains(&start))?;
        (now..=last).contains(&start).then_some(ClearWindow { first: start, last: window.last })
    };
    let starts = windows.iter().map(|window| window.first).chain(regular);
    let mut starts: Vec<ClearWindow> = starts.filter_map(window_from).collect();
    starts.sort_by_key(|window| window.first);
    starts.dedup_by_key(|window| window.first);
    let delays_s: Vec<f64> = starts.iter().map(|window| seconds_between(now, window.first)).collect();
    let costs_s = delayed_costs_s(&row_of(target, now), &delays_s, request)?;
    let is_affordable = |cost_s: &Option<f64>| cost_s.is_some_and(|cost_s| cost_s <= most_s);
    let found = starts.into_iter().zip(costs_s).find(|(_, cost_s)| is_affordable(cost_s));
    Ok(found.map(|(ClearWindow { first, last }, _)| {
        let judged_until = seconds_after(first, request.policy.margin_or_default_s());
        ClearWindow { first, last: last.min(judged_until) }
    }))
}

/// Returns pointing and site. The pointing is, in this order, that of the flags, of the target name, or of the mount.
fn pointing_and_site(
    flags: &Flags,
    request: &Request,
    name: Option<&str>,
    step: &Step,
    status: &mut Map<String, Value>,
) -> Result<(Direction<Gcrs>, Site), Fault> {
    let named = match (&flags.host.targets, name) {
        (Some(path), Some(name)) if request.pointing.is_none() => {
            step.begin(format!("reading {}", path.display()));
            Some(targets::look_up(path, name))
        }
        _ => None,
    };
    let mount = match &flags.host.indi {
        Some(address) => {
            step.begin(format!("reading the INDI server {address}"));
            let timeout = left(flags.deadline, flags.timeout / 2);
            let mount = indi::read_mount(address, flags.host.indi_device.as_deref(), timeout, &flags.clock)?;
            state(status, "mount", mount.device.as_str());
            if let Some(error_s) = mount.clock_error_s {
                let message = format!(
                    "the clock of the INDI server differs by {error_s:+.1} s from that of this machine (37 s: one of them is in TAI)"
                );
                return Err(Fault::new(FaultKind::Clock, message));
            }
            Some(mount)
        }
        None => None,
    };
    let pointing = match (request.pointing, named, &mount) {
        (Some(pointing), ..) | (None, Some(Ok(pointing)), _) => pointing,
        // If the file lacks the name, the pointing of the mount is used.
        (None, _, Some(mount)) => mount.pointing,
        (None, Some(Err(fault)), None) => return Err(fault),
        (None, None, None) => {
            return Err(Fault::new(
                FaultKind::Target,
                "missing coordinates of the target; specify --ra and --dec, --targets with a target name, or --indi",
            ));
        }
    };
    let mount_site = mount.and_then(|mount| mount.site);
    let site = match (&request.site, mount_site) {
        (Some(_), Some(mount_site)) if request.is_home_site => mount_site,
        (Some(site), Some(mount_site)) => {
            let apart_km = (site.itrs() - mount_site.itrs()).norm_km();
            if apart_km > SAME_SITE_KM {
                let message = format!(
                    "the site of the mount {} is {apart_km:.1} km from {}; allowed: at most 1 km",
                    mount_site.name, site.name
                );
                return Err(Fault::new(FaultKind::Site, message));
            }
            site.clone()
        }
        (Some(site), None) => site.clone(),
        (None, Some(mount_site)) => mount_site,
        (None, None) => {
            return Err(Fault::new(FaultKind::Site, "missing site, which the mount does not send; specify --site"));
        }
    };
    Ok((pointing, site))
}

/// Adds the passes that the wait avoids to the status file.
fn add_blocking_passes(
    found: &TargetWindows,
    prepared: &PreparedSky,
    from: Epoch,
    to: Epoch,
    status: &mut Map<String, Value>,
) {
    let ahead: Vec<&Pass> =
        found.blocking_passes.iter().filter(|pass| pass.exit.epoch >= from && pass.enter.epoch <= to).collect();
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
    state(status, "n_dodged", ahead.len());
    state(status, "dodged", named);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_that_ends_outside_the_judged_starts_is_a_fault() {
        let first = streakcast::frames::parse_instant("2026-08-14T23:29:24Z", None).unwrap();
        let message = |margin_s: f64, late_s: f64| {
            let fault = fault_after_wait(first, seconds_after(first, margin_s), seconds_after(first, late_s))?;
            assert_eq!(fault.kind.name(), "clock");
            Some(fault.to_string())
        };
        // The second condition: a command that is woken late by less than a second is no change of the clock.
        for (margin_s, late_s) in [(2.0, 0.0), (2.0, 1.9), (2.0, -0.9), (0.0, 0.9)] {
            assert_eq!(message(margin_s, late_s), None, "{late_s} s");
        }
        for (margin_s, late_s, text) in
            [(2.0, 2.1, "+2.1 s"), (0.0, 1.1, "+1.1 s"), (2.0, -1.5, "-1.5 s"), (2.0, 3600.0, "+3600.0 s")]
        {
            assert!(message(margin_s, late_s).is_some_and(|message| message.contains(text)), "{late_s} s");
        }
    }
}
