//! Clear windows: from when to when a shutter may open on a target so that nothing that matters crosses the exposure.

use hifitime::{Epoch, TimeScale, Unit};

use crate::frames::{OrientationTable, mjd_utc, seconds_after, seconds_between};
use crate::geometry::{Observer, SunTable};
use crate::orbit::LeftOut;
use crate::passes::{Exposure, FieldPass, SkyError, Viewpoint};

use super::camera::Camera;
use super::horizon::{altitude_rad, look_every_s};
use super::judge::{CameraLimits, Rules, counts, is_dodged, is_to_avoid};
use super::report::{FlagRequest, GUARD_S, TICK_S, intervals, late_s, pass_options};
use super::shift::{Interval, clear_starts};

/// Risings and settings are found to this, seconds, and never given too early or too late.
const SETTING_TOLERANCE_S: f64 = 1e-3;

/// Which satellites keep an exposure from being clear.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Blocking {
    /// Every one that is lit: the verdict of an exposure in a window is `clear`.
    #[default]
    Any,
    /// Those that the policy's limits of magnitude forbid: the verdict is not `avoid` for any single satellite.
    Avoided,
    /// Those brighter than a limit, however improbable unless the policy says; every lit one where no limit applies to the band.
    Limits,
}

/// What windows are looked for against.
pub struct WindowRequest<'a> {
    /// Sky, field, telescope, and the rules: the magnitude limits, the margin, the probability. What is expected of all satellites together
    /// (`max_lost_fraction`) and the longest wait (`max_delay_s`) make no windows and are not looked at.
    pub against: FlagRequest<'a>,
    /// Which satellites matter.
    pub blocking: Blocking,
    /// The target's lowest altitude while the shutter is open, radians, without refraction; above the Earth's limb for a telescope in orbit.
    pub min_altitude_rad: f64,
    /// The Sun's highest altitude while the shutter is open, radians; `None` for day and night.
    pub max_sun_altitude_rad: Option<f64>,
}

/// One exposure that may be started at many times; the `start` of `exposure` means nothing here.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowTarget {
    /// Name, length and pointing.
    pub exposure: Exposure,
    /// Its band, for limits by band.
    pub band: Option<String>,
}

/// A stretch of shutter openings, both ends included: an exposure of the target's length that begins in it is clear.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ClearWindow {
    /// Earliest opening, to the millisecond.
    pub first: Epoch,
    /// Latest opening, to the millisecond.
    pub last: Epoch,
}

/// What was found for one target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetWindows {
    /// The windows in time order.
    pub windows: Vec<ClearWindow>,
    /// Openings that altitude and Sun allow, satellites or not.
    pub observable: Vec<ClearWindow>,
    /// The passes that part the windows, in order of entry.
    pub dodged: Vec<FieldPass>,
}

/// The answer for all targets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindowReport {
    /// For each target, in its place.
    pub by_target: Vec<TargetWindows>,
    /// Satellites without a position.
    pub left_out: Vec<LeftOut>,
}

/// All clear windows of shutter openings from `from` to `to`; none where `to` is before `from`.
///
/// An exposure that opens in a window meets no satellite that `blocking` names. The margin of the policy is kept at both ends, so that a shutter
/// that opens up to a margin late is still clear. With a `min_probability` near misses count, and every satellite may be three sigmas early or late.
/// A pass counts whole: a window ends before a satellite enters even where it would be faint or dark until the shutter closes.
///
/// Target and Sun are looked at once a minute (the limb every 10 s): a target that culminates above its limit for less than that has no window.
///
/// # Errors
/// [`SkyError`] where the sky cannot answer; a limit for the Sun, where a telescope in orbit has no horizon.
pub fn clear_windows(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
) -> Result<WindowReport, SkyError> {
    let FlagRequest { sky, field, policy, telescope, photometry } = request.against;
    let margin_s = policy.margin_or_default_s();
    let span_s = seconds_between(from, to);
    if span_s < 0.0 {
        return Ok(WindowReport { by_target: vec![TargetWindows::default(); targets.len()], left_out: Vec::new() });
    }
    let looks: Vec<Exposure> = targets
        .iter()
        .map(|target| Exposure {
            start: seconds_after(from, -margin_s),
            duration_s: span_s + target.exposure.duration_s + 2.0 * margin_s,
            ..target.exposure.clone()
        })
        .collect();
    let answer = sky.field_passes(&looks, field, &pass_options(&request.against))?;
    let camera = telescope.map(|telescope| Camera { telescope, sky, photometry });
    let rules = Rules { policy, camera: camera.as_ref().map(|camera| camera as &dyn CameraLimits) };
    let blocks = |pass: &FieldPass, band: Option<&str>| match request.blocking {
        Blocking::Any => counts(pass, policy),
        Blocking::Avoided => is_to_avoid(pass, band, &rules),
        Blocking::Limits => is_dodged(pass, band, &rules),
    };
    let longest_s = targets.iter().map(|target| target.exposure.duration_s).fold(0.0, f64::max);
    let heavens = Heavens::new(request, from, span_s + longest_s)?;
    let by_target = targets
        .iter()
        .zip(answer.by_exposure)
        .map(|(target, passes)| {
            let dodged: Vec<FieldPass> =
                passes.into_iter().filter(|pass| blocks(pass, target.band.as_deref())).collect();
            let exposure = &target.exposure;
            let asked = Exposure { start: from, ..exposure.clone() };
            let blocked: Vec<Interval> =
                dodged.iter().flat_map(|pass| intervals(pass, &asked, margin_s, late_s(pass, policy))).collect();
            let observable: Vec<Interval> = heavens
                .observable(exposure)
                .into_iter()
                .filter_map(|stretch| {
                    // The whole exposure lies in the stretch: s >= a and s + D <= b.
                    let end_s = (stretch.end_s - exposure.duration_s).min(span_s);
                    (stretch.start_s <= end_s).then_some(Interval { start_s: stretch.start_s, end_s })
                })
                .collect();
            let clear = observable
                .iter()
                .flat_map(|stretch| clear_starts(&blocked, exposure.duration_s, margin_s, GUARD_S, *stretch));
            TargetWindows {
                windows: clear.filter_map(|stretch| window(from, stretch)).collect(),
                observable: observable.iter().filter_map(|stretch| window(from, *stretch)).collect(),
                dodged,
            }
        })
        .collect();
    Ok(WindowReport { by_target, left_out: answer.left_out })
}

/// To the millisecond, inwards; none where nothing is left.
fn window(from: Epoch, stretch: Interval) -> Option<ClearWindow> {
    let tick = |seconds: f64, round: fn(f64) -> f64| round(seconds / TICK_S) * TICK_S;
    // A stretch that begins with the range begins there, whatever the last digit of the division says.
    let (first_s, last_s) = (tick(stretch.start_s - 1e-9, f64::ceil), tick(stretch.end_s + 1e-9, f64::floor));
    (first_s <= last_s).then(|| ClearWindow { first: seconds_after(from, first_s), last: seconds_after(from, last_s) })
}

/// Target and Sun over a site, or target and limb.
struct Heavens<'a> {
    viewpoint: &'a Viewpoint,
    min_altitude_rad: f64,
    orientation: OrientationTable,
    sun: Option<SunLimit<'a>>,
    span_s: f64,
}

/// How high the Sun may stand.
struct SunLimit<'a> {
    observer: &'a Observer,
    sun: SunTable,
    most_rad: f64,
}

impl<'a> Heavens<'a> {
    fn new(request: &WindowRequest<'a>, from: Epoch, span_s: f64) -> Result<Self, SkyError> {
        let viewpoint = request.against.sky.viewpoint();
        let end = seconds_after(from, span_s);
        let limit = |most_rad: f64| {
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

    /// When the target is up and the Sun is down, seconds.
    fn observable(&self, exposure: &Exposure) -> Vec<Interval> {
        let target_rad =
            |seconds: f64| altitude_rad(exposure, self.viewpoint, &self.orientation, seconds) - self.min_altitude_rad;
        let every_s = look_every_s(self.viewpoint);
        let up = stretches(target_rad, Interval { start_s: 0.0, end_s: self.span_s }, every_s);
        let Some(SunLimit { observer, sun, most_rad }) = &self.sun else { return up };
        let sun_rad = |seconds: f64| {
            let state = observer.state(&self.orientation.at_s(seconds));
            let sine = state.sine_of_altitude(&(sun.at_s(seconds).sun - state.position));
            most_rad - sine.clamp(-1.0, 1.0).asin()
        };
        up.into_iter().flat_map(|stretch| stretches(sun_rad, stretch, every_s)).collect()
    }
}

/// Where a function is 0 or more, seen every so many seconds, its borders bisected and given on the inner side.
fn stretches(value: impl Fn(f64) -> f64, within: Interval, every_s: f64) -> Vec<Interval> {
    let is_in = |seconds: f64| value(seconds) >= 0.0;
    // The last point on the side of `inside` that is still in.
    let border = |mut inside: f64, mut outside: f64| {
        while (inside - outside).abs() > SETTING_TOLERANCE_S {
            let middle = 0.5 * (inside + outside);
            if is_in(middle) { inside = middle } else { outside = middle }
        }
        inside
    };
    let steps = ((within.end_s - within.start_s) / every_s).ceil().max(1.0);
    let look = |step: f64| within.start_s + (within.end_s - within.start_s) * step / steps;
    let mut found = Vec::new();
    let mut began = is_in(within.start_s).then_some(within.start_s);
    for step in 1..=steps as u64 {
        let (before_s, now_s) = (look(step as f64 - 1.0), look(step as f64));
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

/// The night that begins on the evening of a date at a longitude (east positive, radians): from local mean noon to the next.
pub fn night_of(evening: Epoch, longitude_rad: f64) -> (Epoch, Epoch) {
    let (year, month, day, ..) = evening.to_gregorian_utc();
    let longitude_rad = (longitude_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    let day_s = Unit::Day.in_seconds();
    // UTC of local mean noon: 12 h - λ / 15 deg/h
    let noon_s = day_s * (0.5 - longitude_rad / std::f64::consts::TAU);
    let noon = seconds_after(Epoch::from_gregorian_utc_at_midnight(year, month, day), noon_s);
    (noon, seconds_after(noon, day_s).to_time_scale(TimeScale::UTC))
}

/// The evening's date of the night that a moment belongs to, as MJD: nights last from local mean noon to noon at a longitude (east positive, radians).
pub fn evening_mjd(moment: Epoch, longitude_rad: f64) -> i64 {
    // Local mean time runs ahead of UTC by λ / 2π days; a night is the day that its evening belongs to.
    (mjd_utc(moment) + longitude_rad / std::f64::consts::TAU - 0.5).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::format_utc;

    #[test]
    fn stretches_lie_inside_and_reach_their_borders() {
        let within = Interval { start_s: 0.0, end_s: 3000.0 };
        // Up from 100 to 700, and from 1300 to 1900, and so on: a sine of half period 600 s.
        let found = stretches(|s| ((s - 100.0) / 600.0 * std::f64::consts::PI).sin(), within, 60.0);
        let expected = [(100.0, 700.0), (1300.0, 1900.0), (2500.0, 3000.0)];
        assert_eq!(found.len(), expected.len());
        for (stretch, (start_s, end_s)) in found.iter().zip(expected) {
            assert!((0.0..2e-3).contains(&(stretch.start_s - start_s)), "{stretch:?}");
            assert!((0.0..2e-3).contains(&(end_s - stretch.end_s)), "{stretch:?}");
        }
        assert_eq!(stretches(|_| 1.0, within, 60.0), [within]);
        assert!(stretches(|_| -1.0, within, 60.0).is_empty());
    }

    #[test]
    fn nights_begin_at_the_local_noon_of_their_evening() {
        let date = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        for (longitude_deg, noon) in [
            (0.0, "2024-08-14T12:00:00Z"),
            (-70.75, "2024-08-14T16:43:00Z"),
            (289.25, "2024-08-14T16:43:00Z"),
            (150.0, "2024-08-14T02:00:00Z"),
        ] {
            let (first, last) = night_of(date, f64::to_radians(longitude_deg));
            assert_eq!(format_utc(first, 0), noon, "{longitude_deg}");
            assert_eq!(seconds_between(first, last), 86_400.0);
        }
    }

    #[test]
    fn windows_are_rounded_inwards() {
        let from = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let found = window(from, Interval { start_s: 1.000_2, end_s: 2.000_9 }).unwrap();
        assert_eq!(format_utc(found.first, 4), "2024-08-14T00:00:01.0010Z");
        assert_eq!(format_utc(found.last, 4), "2024-08-14T00:00:02.0000Z");
        assert_eq!(window(from, Interval { start_s: 1.000_2, end_s: 1.000_9 }), None);
    }
}
