//! Clear windows: intervals of shutter opening times for which no blocking satellite crosses an exposure of a target.

use hifitime::Epoch;

use crate::error::Error;
use crate::frames::{OrientationTable, seconds_after, seconds_between};
use crate::geometry::{Observer, SunTable};
use crate::orbit::LeftOut;
use crate::passes::{Chord, Exposure, FieldCrossing, Pass, Viewpoint};

use super::blockers::intervals;
use super::flag_request::FlagRequest;
use super::horizon::{margin_rad, sampling_interval_s, sun_of_limits};
use super::report::{GUARD_S, TICK_S, lateness_allowance_s, pass_options};
use super::shift::{Interval, clear_starts};
use super::starts::{LONGEST_ALLOWANCE_S, reason_for_unknown_starts};
use super::verdict_rules::blocks;

/// Sky, policy and constraints for clear windows.
pub struct WindowRequest<'a> {
    /// Sky, field, telescope, photometry and policy: blocking satellites, magnitude limits, margin and probability are
    /// applied; `max_cost_s` and `max_delay_s` are not.
    pub conditions: FlagRequest<'a>,
    /// Lowest altitude of the target while the shutter is open, radians, without refraction; for a telescope in orbit,
    /// the angle above the Earth's limb. The limits of such a telescope on its pointings also apply.
    pub min_altitude_rad: f64,
    /// Highest altitude of the Sun while the shutter is open, radians; `None` for no limit.
    pub max_sun_altitude_rad: Option<f64>,
}

/// Target with its exposure. The `start` of `exposure` is not used.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowTarget {
    /// Name, duration and pointing.
    pub exposure: Exposure,
    /// Band of the exposure; selects limits by band.
    pub band: Option<String>,
}

/// Closed interval of shutter opening times for which an exposure of the target is clear.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ClearWindow {
    /// Earliest opening, rounded to the millisecond.
    pub first: Epoch,
    /// Latest opening, rounded to the millisecond.
    pub last: Epoch,
}

/// Windows of one target.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TargetWindows {
    /// Clear windows in time order.
    pub windows: Vec<ClearWindow>,
    /// Opening times allowed by the altitudes of target and Sun, and by the limits of a telescope in orbit; satellites
    /// are not considered.
    pub observable: Vec<ClearWindow>,
    /// Longest time within the range in which these conditions allow an open shutter, seconds.
    pub longest_s: f64,
    /// Passes that block a part of the times allowed by these conditions, in order of entry.
    pub blocking_passes: Vec<Pass>,
    /// Reason why windows of a part of the range, or all of them, are unknown and omitted; `None` if there is none.
    pub unknown: Option<String>,
}

/// Windows of all targets.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct WindowReport {
    /// Windows of each target, in the order of the targets.
    pub by_target: Vec<TargetWindows>,
    /// Satellites whose position cannot be computed.
    pub left_out: Vec<LeftOut>,
}

/// Computes all clear windows of shutter opening times of exposures that begin at `from` or later and end by `to`.
///
/// No satellite selected by the policy's `blocking` crosses an exposure that opens in a window. The margin of the
/// policy applies before and after the exposure, so the shutter may also open late by up to the margin. With a
/// `min_probability`, near misses count, and blocked intervals are extended by three sigmas for early and late
/// satellites. A blocking pass blocks from its entry to its exit, also while the satellite is faint or in shadow.
///
/// Windows at times at which the positions of the satellites are unknown are omitted, and so are those of exposures of
/// which nominal tracks predict less than half of the crossings. A `min_probability` extends the margin by three
/// sigmas.
///
/// The altitudes of target and Sun are sampled once a minute, those above the limb and the limits of a telescope in
/// orbit every 10 s: a target within its limits for less than that may have no window. Margins outside the ephemeris of
/// such a telescope are not searched.
///
/// # Errors
/// Passes cannot be computed, or if a Sun altitude limit is given for a telescope in orbit, which has
/// no horizon.
pub fn clear_windows(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
) -> Result<WindowReport, Error> {
    windows_of(targets, from, to, request, true)
}

/// Computes the same windows without blocking passes: [`TargetWindows::blocking_passes`] is empty. It is faster for
/// many targets, because magnitudes and probabilities are computed only if the policy needs them.
///
/// # Errors
/// Same as [`clear_windows`].
pub fn clear_windows_without_passes(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
) -> Result<WindowReport, Error> {
    windows_of(targets, from, to, request, false)
}

fn windows_of(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
    with_passes: bool,
) -> Result<WindowReport, Error> {
    let FlagRequest { sky, field, policy, .. } = request.conditions;
    let margin_s = policy.margin_or_default_s();
    let span_s = seconds_between(from, to);
    if span_s < 0.0 {
        return Ok(WindowReport { by_target: vec![TargetWindows::default(); targets.len()], left_out: Vec::new() });
    }
    for target in targets {
        Exposure { start: from, duration_s: span_s, ..target.exposure.clone() }.check()?;
    }
    let constraint = ObservabilityConstraint::new(request, from, span_s)?;
    let allowed: Vec<Vec<Interval>> = targets
        .iter()
        .map(|target| {
            sky.watch().check()?;
            Ok(constraint.observable(&target.exposure))
        })
        .collect::<Result<_, Error>>()?;
    // Satellites that may be late or early are also searched before and after the observable times and their margins.
    let beyond_s = margin_s + if policy.min_probability.is_some() { LONGEST_ALLOWANCE_S } else { 0.0 };
    let searched_around = |interval: &Interval| {
        let around = [interval.start_s, interval.end_s].map(|time_s| seconds_after(from, time_s));
        let known = sky.viewpoint().known_part(around, beyond_s, beyond_s).unwrap_or(around);
        let [start_s, end_s] = known.map(|epoch| seconds_between(from, epoch));
        Interval { start_s, end_s }
    };
    let (owners, exposures): (Vec<usize>, Vec<Exposure>) = targets
        .iter()
        .zip(&allowed)
        .enumerate()
        .flat_map(|(owner, (target, allowed))| {
            let long =
                allowed.iter().filter(|interval| interval.end_s - interval.start_s >= target.exposure.duration_s);
            let searched = joined(long.map(searched_around)).into_iter();
            searched.map(move |Interval { start_s, end_s }| {
                let start = seconds_after(from, start_s);
                (owner, Exposure { start, duration_s: end_s - start_s, ..target.exposure.clone() })
            })
        })
        .unzip();
    let (found, left_out) = if request.conditions.every_crossing_blocks(policy.blocking) && !with_passes {
        crossings(from, &exposures, request)?
    } else {
        let targets: Vec<&WindowTarget> = owners.iter().map(|owner| &targets[*owner]).collect();
        passes(&targets, from, &exposures, request)?
    };
    let mut blocked: Vec<Blocked> = targets.iter().map(|_| Blocked::default()).collect();
    for (owner, Blocked { intervals, blocking_passes }) in owners.into_iter().zip(found) {
        blocked[owner].intervals.extend(intervals);
        blocked[owner].blocking_passes.extend(blocking_passes);
    }
    let by_target = targets
        .iter()
        .zip(allowed)
        .zip(blocked)
        .map(|((target, allowed), Blocked { intervals, mut blocking_passes })| {
            sky.watch().check()?;
            let exposure = &target.exposure;
            let longest_s = allowed.iter().map(|interval| interval.end_s - interval.start_s).fold(0.0, f64::max);
            blocking_passes.retain(|pass| {
                let [enter_s, exit_s] = [&pass.enter, &pass.exit].map(|point| seconds_between(from, point.epoch));
                let allowance_s = margin_s + lateness_allowance_s(pass, policy);
                let is_then = |interval: &Interval| {
                    enter_s - allowance_s <= interval.end_s && exit_s + allowance_s >= interval.start_s
                };
                with_passes && allowed.iter().any(is_then)
            });
            let observable: Vec<Interval> = allowed
                .into_iter()
                .filter_map(|interval| {
                    // The interval must contain the whole exposure: s >= a and s + D <= b.
                    let end_s = interval.end_s - exposure.duration_s;
                    (interval.start_s <= end_s).then_some(Interval { start_s: interval.start_s, end_s })
                })
                .collect();
            let clear = observable
                .iter()
                .flat_map(|interval| clear_starts(&intervals, exposure.duration_s, margin_s, GUARD_S, *interval));
            let mut unknown = None;
            let mut windows: Vec<ClearWindow> = clear.filter_map(|interval| window(from, interval)).collect();
            windows.retain(|window| {
                let reason = [window.first, window.last]
                    .into_iter()
                    .find_map(|epoch| reason_for_unknown_starts(sky, field, policy, epoch, exposure.duration_s));
                unknown = unknown.take().or(reason.clone());
                reason.is_none()
            });
            Ok(TargetWindows {
                windows,
                unknown,
                longest_s,
                observable: observable.iter().filter_map(|interval| window(from, *interval)).collect(),
                blocking_passes,
            })
        })
        .collect::<Result<_, Error>>()?;
    Ok(WindowReport { by_target, left_out })
}

/// Joins intervals that overlap. They are in order of time.
fn joined(intervals: impl Iterator<Item = Interval>) -> Vec<Interval> {
    let mut joined: Vec<Interval> = Vec::new();
    for interval in intervals {
        match joined.last_mut() {
            Some(last) if interval.start_s <= last.end_s => last.end_s = last.end_s.max(interval.end_s),
            _ => joined.push(interval),
        }
    }
    joined
}

/// Intervals in which satellites block one target, seconds after the start of the range, and the blocking passes.
#[derive(Default)]
struct Blocked {
    intervals: Vec<Interval>,
    blocking_passes: Vec<Pass>,
}

/// Returns blocked intervals and passes of each exposure of a target, with magnitudes and probabilities.
fn passes(
    targets: &[&WindowTarget],
    from: Epoch,
    exposures: &[Exposure],
    request: &WindowRequest<'_>,
) -> Result<(Vec<Blocked>, Vec<LeftOut>), Error> {
    let FlagRequest { sky, field, policy, .. } = request.conditions;
    let passes = sky.field_passes(exposures, field, &pass_options(&request.conditions))?;
    let of = |((target, searched), passes): ((&&WindowTarget, &Exposure), Vec<Pass>)| {
        sky.watch().check()?;
        let limits = request.conditions.limits(target.band.as_deref(), target.exposure.duration_s);
        let blocking_passes: Vec<Pass> =
            passes.into_iter().filter(|pass| blocks(pass, &limits, policy.blocking, policy)).collect();
        let shifted = Exposure { start: from, ..target.exposure.clone() };
        let lead_s = seconds_between(searched.start, from);
        let intervals = blocking_passes
            .iter()
            .flat_map(|pass| intervals(pass, &shifted, lead_s, lateness_allowance_s(pass, policy)))
            .collect();
        Ok(Blocked { intervals, blocking_passes })
    };
    let blocked = targets.iter().zip(exposures).zip(passes.by_exposure).map(of).collect::<Result<_, Error>>()?;
    Ok((blocked, passes.left_out))
}

/// Returns blocked intervals of each exposure if every lit crossing blocks.
fn crossings(
    from: Epoch,
    exposures: &[Exposure],
    request: &WindowRequest<'_>,
) -> Result<(Vec<Blocked>, Vec<LeftOut>), Error> {
    let FlagRequest { sky, field, .. } = request.conditions;
    let crossings = sky.field_crossings(exposures, field)?;
    let of = |(crossings, searched): (Vec<FieldCrossing>, &Exposure)| {
        let lead_s = seconds_between(searched.start, from);
        let chords = crossings.iter().flat_map(|crossing| &crossing.chords);
        let interval = |chord: &Chord| Interval { start_s: chord.enter_s - lead_s, end_s: chord.exit_s - lead_s };
        Blocked { intervals: chords.map(interval).collect(), blocking_passes: Vec::new() }
    };
    Ok((crossings.by_exposure.into_iter().zip(exposures).map(of).collect(), crossings.left_out))
}

/// Rounds an interval inwards to milliseconds; `None` if it becomes empty.
fn window(from: Epoch, interval: Interval) -> Option<ClearWindow> {
    let tick = |seconds: f64, round: fn(f64) -> f64| round(seconds / TICK_S) * TICK_S;
    // Floating point rounding must not move the ends inwards by a millisecond.
    let (first_s, last_s) = (tick(interval.start_s - 1e-9, f64::ceil), tick(interval.end_s + 1e-9, f64::floor));
    (first_s <= last_s).then(|| ClearWindow { first: seconds_after(from, first_s), last: seconds_after(from, last_s) })
}

/// Accuracy of rising and setting times, which are rounded inwards, seconds.
const SETTING_TOLERANCE_S: f64 = 1e-3;

/// Limits on the altitude of the target (above horizon or limb) and of the Sun, and those of a telescope in orbit.
struct ObservabilityConstraint<'a> {
    viewpoint: &'a Viewpoint,
    min_altitude_rad: f64,
    orientation: OrientationTable,
    sun: Option<SunLimit<'a>>,
    sun_of_limits: Option<SunTable>,
    span_s: f64,
}

/// Upper limit on the altitude of the Sun.
struct SunLimit<'a> {
    observer: &'a Observer,
    sun: SunTable,
    most_rad: f64,
}

impl<'a> ObservabilityConstraint<'a> {
    fn new(request: &WindowRequest<'a>, from: Epoch, span_s: f64) -> Result<Self, Error> {
        let viewpoint = request.conditions.sky.viewpoint();
        let end = seconds_after(from, span_s);
        let limit = |most_rad: f64| -> Result<_, Error> {
            let observer = viewpoint.required_site()?;
            Ok(SunLimit { observer, sun: SunTable::new(from, end), most_rad })
        };
        Ok(Self {
            viewpoint,
            min_altitude_rad: request.min_altitude_rad,
            orientation: request.conditions.sky.orientation_over(from, end),
            sun: request.max_sun_altitude_rad.map(limit).transpose()?,
            sun_of_limits: sun_of_limits(viewpoint, from, end),
            span_s,
        })
    }

    /// Returns the intervals in which the target is above and the Sun below its limit, and within the limits of a
    /// telescope in orbit, seconds after the start of the range.
    fn observable(&self, exposure: &Exposure) -> Vec<Interval> {
        let tables = (&self.orientation, self.sun_of_limits.as_ref());
        let target_rad = |seconds: f64| margin_rad(exposure, self.viewpoint, self.min_altitude_rad, tables, seconds);
        let every_s = sampling_interval_s(self.viewpoint);
        let up = nonnegative_intervals(target_rad, Interval { start_s: 0.0, end_s: self.span_s }, every_s);
        let Some(SunLimit { observer, sun, most_rad }) = &self.sun else { return up };
        let sun_rad = |seconds: f64| most_rad - observer.sun_altitude_rad(&self.orientation, sun, seconds);
        up.into_iter().flat_map(|interval| nonnegative_intervals(sun_rad, interval, every_s)).collect()
    }
}

/// Returns the intervals in which a function is at least 0, from samples every `every_s`. Their ends are found by
/// bisection and lie inside the exact intervals.
fn nonnegative_intervals(value: impl Fn(f64) -> f64, within: Interval, every_s: f64) -> Vec<Interval> {
    let is_in = |seconds: f64| value(seconds) >= 0.0;
    // Last time inside the interval, within the tolerance.
    let border = |mut inside: f64, mut outside: f64| {
        while (inside - outside).abs() > SETTING_TOLERANCE_S {
            let middle = 0.5 * (inside + outside);
            if is_in(middle) { inside = middle } else { outside = middle }
        }
        inside
    };
    let steps = ((within.end_s - within.start_s) / every_s).ceil().max(1.0);
    let sample_s = |step: f64| within.start_s + (within.end_s - within.start_s) * step / steps;
    let mut found = Vec::new();
    let mut began = is_in(within.start_s).then_some(within.start_s);
    for step in 1..=steps as u64 {
        let (before_s, now_s) = (sample_s(step as f64 - 1.0), sample_s(step as f64));
        match (began, is_in(now_s)) {
            (None, true) => began = Some(border(now_s, before_s)),
            (Some(start_s), false) => {
                found.push(Interval { start_s, end_s: border(before_s, now_s) });
                began = None;
            }
            _ => {}
        }
    }
    found.extend(began.map(|start_s| Interval { start_s, end_s: within.end_s }));
    found
}

/// Returns the remaining part of the first window that is open at `now` or opens by `last`; `None` if there is none.
pub fn next_window(windows: &[ClearWindow], now: Epoch, last: Epoch) -> Option<ClearWindow> {
    let window = windows.iter().find(|window| window.last >= now)?;
    (window.first <= last).then(|| ClearWindow { first: window.first.max(now), last: window.last })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::format_utc;

    #[test]
    fn windows_are_rounded_inwards() {
        let from = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let found = window(from, Interval { start_s: 1.000_2, end_s: 2.000_9 }).unwrap();
        assert_eq!(format_utc(found.first, 4), "2024-08-14T00:00:01.0010Z");
        assert_eq!(format_utc(found.last, 4), "2024-08-14T00:00:02.0000Z");
        assert_eq!(window(from, Interval { start_s: 1.000_2, end_s: 1.000_9 }), None);
    }

    #[test]
    fn intervals_lie_inside_and_reach_their_borders() {
        let within = Interval { start_s: 0.0, end_s: 3000.0 };
        // Sine with a half period of 600 s: positive from 100 to 700, from 1300 to 1900, and so on.
        let found = nonnegative_intervals(|s| ((s - 100.0) / 600.0 * std::f64::consts::PI).sin(), within, 60.0);
        let expected = [(100.0, 700.0), (1300.0, 1900.0), (2500.0, 3000.0)];
        assert_eq!(found.len(), expected.len());
        for (interval, (start_s, end_s)) in found.iter().zip(expected) {
            assert!((0.0..2e-3).contains(&(interval.start_s - start_s)), "{interval:?}");
            assert!((0.0..2e-3).contains(&(end_s - interval.end_s)), "{interval:?}");
        }
        assert_eq!(nonnegative_intervals(|_| 1.0, within, 60.0), [within]);
        assert!(nonnegative_intervals(|_| -1.0, within, 60.0).is_empty());
    }

    #[test]
    fn next_window_is_the_first_that_has_not_ended() {
        let zero = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let at = |seconds| seconds_after(zero, seconds);
        let windows = [(0.0, 10.0), (20.0, 30.0), (90.0, 95.0)]
            .map(|(first, last)| ClearWindow { first: at(first), last: at(last) });
        let wait = |now, last| {
            next_window(&windows, at(now), at(last))
                .map(|window| (seconds_between(zero, window.first), seconds_between(zero, window.last)))
        };
        assert_eq!(wait(5.0, 5.0), Some((5.0, 10.0)));
        assert_eq!(wait(10.5, 100.0), Some((20.0, 30.0)));
        assert_eq!(wait(31.0, 89.0), None);
        assert_eq!(wait(31.0, 90.0), Some((90.0, 95.0)));
        assert_eq!(wait(96.0, 900.0), None);
    }
}
