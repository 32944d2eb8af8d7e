//! Clear windows: intervals of shutter openings on a target without a blocking crossing.

use hifitime::Epoch;

use crate::frames::{OrientationTable, seconds_after, seconds_between};
use crate::geometry::{Observer, SunTable};
use crate::orbit::LeftOut;
use crate::passes::{Chord, Exposure, FieldCrossing, Pass, SkyError, Viewpoint};

use super::horizon::{altitude_rad, sampling_interval_s};
use super::judge::{CameraLimits, Rules, counts, is_dodged, is_to_avoid};
use super::report::{Camera, FlagRequest, GUARD_S, TICK_S, intervals, late_s, pass_options};
use super::shift::{Interval, clear_starts};

/// Satellites that block an exposure.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Blocking {
    /// All lit satellites: the verdict of an exposure in a window is `clear`.
    #[default]
    Any,
    /// Satellites for any of which the verdict would be `avoid` by a magnitude limit of the policy.
    Avoided,
    /// Satellites brighter than a limit with a probability of at least 0.5, every nominal crossing taken as certain, or
    /// with a `min_probability` that cross and are brighter with at least this probability; all lit satellites if no
    /// limit applies to the band.
    Limits,
}

/// Sky, rules and constraints for windows.
pub struct WindowRequest<'a> {
    /// Sky, field, telescope, and the rules: magnitude limits, margin and probability. The expected loss of all
    /// satellites (`max_lost_fraction`) and the longest delay (`max_delay_s`) are not applied.
    pub against: FlagRequest<'a>,
    /// Satellites that block an exposure.
    pub blocking: Blocking,
    /// Lowest altitude of the target while the shutter is open, radians, without refraction; above the Earth's limb for
    /// a telescope in orbit.
    pub min_altitude_rad: f64,
    /// Highest altitude of the Sun while the shutter is open, radians; `None` for day and night.
    pub max_sun_altitude_rad: Option<f64>,
}

/// Exposure to be started in a window; the `start` of `exposure` is not used.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowTarget {
    /// Name, length and pointing.
    pub exposure: Exposure,
    /// Band of the exposure, for limits by band.
    pub band: Option<String>,
}

/// Interval of shutter openings, both ends included, for which an exposure of the target is clear.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ClearWindow {
    /// Earliest opening, to the millisecond.
    pub first: Epoch,
    /// Latest opening, to the millisecond.
    pub last: Epoch,
}

/// Windows of one target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetWindows {
    /// The windows in time order.
    pub windows: Vec<ClearWindow>,
    /// Openings allowed by the altitudes of target and Sun, regardless of satellites.
    pub observable: Vec<ClearWindow>,
    /// Passes between the windows, in order of entry.
    pub dodged: Vec<Pass>,
}

/// Windows of all targets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindowReport {
    /// Windows by target, in the order of the targets.
    pub by_target: Vec<TargetWindows>,
    /// Satellites without a position.
    pub left_out: Vec<LeftOut>,
}

/// Computes all clear windows of shutter openings from `from` to `to`; none if `to` is before `from`.
///
/// No satellite of `blocking` crosses an exposure that opens in a window. The margin of the policy applies at both
/// ends, so the shutter may open late by up to the margin. With a `min_probability` near misses count, and an allowance
/// of three sigmas is made for early and late satellites. A pass counts as a whole: a window ends before a satellite
/// enters, even if it is faint or dark until the shutter closes.
///
/// Target and Sun are sampled once a minute (the limb every 10 s): a target above its limit for less than that has no
/// window.
///
/// # Errors
/// [`SkyError`] if passes cannot be computed, or for a limit on the Sun with a telescope in orbit, which has no
/// horizon.
pub fn clear_windows(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
) -> Result<WindowReport, SkyError> {
    windows_of(targets, from, to, request, true)
}

/// Computes the same windows without the passes between them, for plans with many targets: [`TargetWindows::dodged`] is
/// empty, and magnitudes and probabilities are computed only if the policy needs them.
///
/// # Errors
/// The errors of [`clear_windows`].
pub fn clear_windows_without_passes(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
) -> Result<WindowReport, SkyError> {
    windows_of(targets, from, to, request, false)
}

fn windows_of(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
    with_passes: bool,
) -> Result<WindowReport, SkyError> {
    let margin_s = request.against.policy.margin_or_default_s();
    let span_s = seconds_between(from, to);
    if span_s < 0.0 {
        return Ok(WindowReport { by_target: vec![TargetWindows::default(); targets.len()], left_out: Vec::new() });
    }
    let exposures: Vec<Exposure> = targets
        .iter()
        .map(|target| Exposure {
            start: seconds_after(from, -margin_s),
            duration_s: span_s + target.exposure.duration_s + 2.0 * margin_s,
            ..target.exposure.clone()
        })
        .collect();
    // Every lit crossing blocks, so magnitudes and probabilities are not needed.
    let bare = request.blocking == Blocking::Any && request.against.policy.min_probability.is_none();
    let (blocked, left_out) = if bare && !with_passes {
        crossings(&exposures, request)?
    } else {
        passes(targets, from, &exposures, request)?
    };
    let longest_s = targets.iter().map(|target| target.exposure.duration_s).fold(0.0, f64::max);
    let constraint = ObservabilityConstraint::new(request, from, span_s + longest_s)?;
    let by_target = targets
        .iter()
        .zip(blocked)
        .map(|(target, Blocked { intervals, mut dodged })| {
            let exposure = &target.exposure;
            let observable: Vec<Interval> = constraint
                .observable(exposure)
                .into_iter()
                .filter_map(|interval| {
                    // The whole exposure lies in the interval: s >= a and s + D <= b.
                    let end_s = (interval.end_s - exposure.duration_s).min(span_s);
                    (interval.start_s <= end_s).then_some(Interval { start_s: interval.start_s, end_s })
                })
                .collect();
            let clear = observable
                .iter()
                .flat_map(|interval| clear_starts(&intervals, exposure.duration_s, margin_s, GUARD_S, *interval));
            if !with_passes {
                dodged.clear();
            }
            TargetWindows {
                windows: clear.filter_map(|interval| window(from, interval)).collect(),
                observable: observable.iter().filter_map(|interval| window(from, *interval)).collect(),
                dodged,
            }
        })
        .collect();
    Ok(WindowReport { by_target, left_out })
}

/// Intervals in which satellites block one target, seconds after the start of the range, and their passes.
struct Blocked {
    intervals: Vec<Interval>,
    dodged: Vec<Pass>,
}

/// Returns the blocking passes of each target, with their magnitudes.
fn passes(
    targets: &[WindowTarget],
    from: Epoch,
    exposures: &[Exposure],
    request: &WindowRequest<'_>,
) -> Result<(Vec<Blocked>, Vec<LeftOut>), SkyError> {
    let FlagRequest { sky, field, policy, telescope, photometry } = request.against;
    let margin_s = policy.margin_or_default_s();
    let answer = sky.field_passes(exposures, field, &pass_options(&request.against))?;
    let camera = telescope.map(|telescope| Camera { telescope, sky, photometry });
    let rules = Rules { policy, camera: camera.as_ref().map(|camera| camera as &dyn CameraLimits) };
    let blocks = |pass: &Pass, band: Option<&str>| match request.blocking {
        Blocking::Any => counts(pass, policy),
        Blocking::Avoided => is_to_avoid(pass, band, &rules),
        Blocking::Limits => is_dodged(pass, band, &rules),
    };
    let of = |(target, passes): (&WindowTarget, Vec<Pass>)| {
        let dodged: Vec<Pass> = passes.into_iter().filter(|pass| blocks(pass, target.band.as_deref())).collect();
        let shifted = Exposure { start: from, ..target.exposure.clone() };
        let intervals =
            dodged.iter().flat_map(|pass| intervals(pass, &shifted, margin_s, late_s(pass, policy))).collect();
        Blocked { intervals, dodged }
    };
    Ok((targets.iter().zip(answer.by_exposure).map(of).collect(), answer.left_out))
}

/// Returns the blocking intervals of each target if every lit crossing blocks.
fn crossings(exposures: &[Exposure], request: &WindowRequest<'_>) -> Result<(Vec<Blocked>, Vec<LeftOut>), SkyError> {
    let FlagRequest { sky, field, policy, .. } = request.against;
    let margin_s = policy.margin_or_default_s();
    let answer = sky.field_crossings(exposures, field)?;
    let of = |crossings: Vec<FieldCrossing>| {
        let chords = crossings.iter().flat_map(|one| &one.chords);
        let interval = |chord: &Chord| Interval { start_s: chord.enter_s - margin_s, end_s: chord.exit_s - margin_s };
        Blocked { intervals: chords.map(interval).collect(), dodged: Vec::new() }
    };
    Ok((answer.by_exposure.into_iter().map(of).collect(), answer.left_out))
}

/// Rounds an interval inwards to the millisecond; `None` if it becomes empty.
fn window(from: Epoch, interval: Interval) -> Option<ClearWindow> {
    let tick = |seconds: f64, round: fn(f64) -> f64| round(seconds / TICK_S) * TICK_S;
    // The tolerance keeps the start of the range in spite of rounding.
    let (first_s, last_s) = (tick(interval.start_s - 1e-9, f64::ceil), tick(interval.end_s + 1e-9, f64::floor));
    (first_s <= last_s).then(|| ClearWindow { first: seconds_after(from, first_s), last: seconds_after(from, last_s) })
}

/// Tolerance of risings and settings, which are rounded inwards, seconds.
const SETTING_TOLERANCE_S: f64 = 1e-3;

/// Limits on the altitudes of target and Sun over a site, or on the height above the limb.
struct ObservabilityConstraint<'a> {
    viewpoint: &'a Viewpoint,
    min_altitude_rad: f64,
    orientation: OrientationTable,
    sun: Option<SunLimit<'a>>,
    span_s: f64,
}

/// Highest altitude of the Sun.
struct SunLimit<'a> {
    observer: &'a Observer,
    sun: SunTable,
    most_rad: f64,
}

impl<'a> ObservabilityConstraint<'a> {
    fn new(request: &WindowRequest<'a>, from: Epoch, span_s: f64) -> Result<Self, SkyError> {
        let viewpoint = request.against.sky.viewpoint();
        let end = seconds_after(from, span_s);
        let limit = |most_rad: f64| -> Result<_, SkyError> {
            let no_horizon = || SkyError::NoHorizon { observer: viewpoint.name().to_string() };
            let observer = viewpoint.site().ok_or_else(no_horizon)?;
            Ok(SunLimit { observer, sun: SunTable::new(from, end), most_rad })
        };
        Ok(Self {
            viewpoint,
            min_altitude_rad: request.min_altitude_rad,
            orientation: request.against.sky.orientation_over(from, end),
            sun: request.max_sun_altitude_rad.map(limit).transpose()?,
            span_s,
        })
    }

    /// Returns the intervals in which the target is above and the Sun below its altitude limit, seconds.
    fn observable(&self, exposure: &Exposure) -> Vec<Interval> {
        let target_rad =
            |seconds: f64| altitude_rad(exposure, self.viewpoint, &self.orientation, seconds) - self.min_altitude_rad;
        let every_s = sampling_interval_s(self.viewpoint);
        let up = nonnegative_intervals(target_rad, Interval { start_s: 0.0, end_s: self.span_s }, every_s);
        let Some(SunLimit { observer, sun, most_rad }) = &self.sun else { return up };
        let sun_rad = |seconds: f64| most_rad - observer.sun_altitude_rad(&self.orientation, sun, seconds);
        up.into_iter().flat_map(|interval| nonnegative_intervals(sun_rad, interval, every_s)).collect()
    }
}

/// Returns the intervals in which a function is not negative, from samples every `every_s`; their ends are found by
/// bisection and lie inside.
fn nonnegative_intervals(value: impl Fn(f64) -> f64, within: Interval, every_s: f64) -> Vec<Interval> {
    let is_in = |seconds: f64| value(seconds) >= 0.0;
    // Last point inside the interval, within the tolerance.
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

/// Returns the rest of the first window that is open at `now` or opens until `last`; `None` if no window does.
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
        // Positive from 100 to 700, from 1300 to 1900, and so on: a sine with a half period of 600 s.
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
