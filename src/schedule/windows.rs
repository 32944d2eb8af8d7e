//! Clear windows: from when to when a shutter may open on a target so that nothing that matters crosses the exposure.

use hifitime::{Epoch, TimeScale, Unit};

use crate::frames::{mjd_utc, seconds_after, seconds_between};
use crate::orbit::LeftOut;
use crate::passes::{Chord, Exposure, FieldCrossing, FieldPass, SkyError};

use super::camera::Camera;
use super::heavens::Heavens;
use super::judge::{CameraLimits, Rules, counts, is_dodged, is_to_avoid};
use super::report::{FlagRequest, GUARD_S, TICK_S, intervals, late_s, pass_options};
use super::shift::{Interval, clear_starts};

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
    windows_of(targets, from, to, request, Named::Yes)
}

/// The same windows without the passes that part them: [`TargetWindows::dodged`] stays empty, and where no magnitude and no probability is asked for,
/// none is computed. For who plans with many targets.
///
/// # Errors
/// As [`clear_windows`].
pub fn clear_windows_alone(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
) -> Result<WindowReport, SkyError> {
    windows_of(targets, from, to, request, Named::No)
}

/// Whether the passes that part the windows are wanted.
#[derive(Copy, Clone, PartialEq, Eq)]
enum Named {
    Yes,
    No,
}

fn windows_of(
    targets: &[WindowTarget],
    from: Epoch,
    to: Epoch,
    request: &WindowRequest<'_>,
    named: Named,
) -> Result<WindowReport, SkyError> {
    let margin_s = request.against.policy.margin_or_default_s();
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
    // Every lit crossing parts the windows: nothing else of it is asked for.
    let bare = request.blocking == Blocking::Any && request.against.policy.min_probability.is_none();
    let (blocked, left_out) =
        if bare && named == Named::No { crossings(&looks, request)? } else { passes(targets, from, &looks, request)? };
    let longest_s = targets.iter().map(|target| target.exposure.duration_s).fold(0.0, f64::max);
    let heavens = Heavens::new(request, from, span_s + longest_s)?;
    let by_target = targets
        .iter()
        .zip(blocked)
        .map(|(target, Blocked { intervals, mut dodged })| {
            let exposure = &target.exposure;
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
                .flat_map(|stretch| clear_starts(&intervals, exposure.duration_s, margin_s, GUARD_S, *stretch));
            if named == Named::No {
                dodged.clear();
            }
            TargetWindows {
                windows: clear.filter_map(|stretch| window(from, stretch)).collect(),
                observable: observable.iter().filter_map(|stretch| window(from, *stretch)).collect(),
                dodged,
            }
        })
        .collect();
    Ok(WindowReport { by_target, left_out })
}

/// What stands in one target's way, seconds after the range's beginning.
struct Blocked {
    intervals: Vec<Interval>,
    dodged: Vec<FieldPass>,
}

/// What blocks each target, from passes with their light.
fn passes(
    targets: &[WindowTarget],
    from: Epoch,
    looks: &[Exposure],
    request: &WindowRequest<'_>,
) -> Result<(Vec<Blocked>, Vec<LeftOut>), SkyError> {
    let FlagRequest { sky, field, policy, telescope, photometry } = request.against;
    let margin_s = policy.margin_or_default_s();
    let answer = sky.field_passes(looks, field, &pass_options(&request.against))?;
    let camera = telescope.map(|telescope| Camera { telescope, sky, photometry });
    let rules = Rules { policy, camera: camera.as_ref().map(|camera| camera as &dyn CameraLimits) };
    let blocks = |pass: &FieldPass, band: Option<&str>| match request.blocking {
        Blocking::Any => counts(pass, policy),
        Blocking::Avoided => is_to_avoid(pass, band, &rules),
        Blocking::Limits => is_dodged(pass, band, &rules),
    };
    let of = |(target, passes): (&WindowTarget, Vec<FieldPass>)| {
        let dodged: Vec<FieldPass> = passes.into_iter().filter(|pass| blocks(pass, target.band.as_deref())).collect();
        let asked = Exposure { start: from, ..target.exposure.clone() };
        let intervals =
            dodged.iter().flat_map(|pass| intervals(pass, &asked, margin_s, late_s(pass, policy))).collect();
        Blocked { intervals, dodged }
    };
    Ok((targets.iter().zip(answer.by_exposure).map(of).collect(), answer.left_out))
}

/// What blocks each target where every lit crossing does.
fn crossings(looks: &[Exposure], request: &WindowRequest<'_>) -> Result<(Vec<Blocked>, Vec<LeftOut>), SkyError> {
    let FlagRequest { sky, field, policy, .. } = request.against;
    let margin_s = policy.margin_or_default_s();
    let answer = sky.field_crossings(looks, field)?;
    let of = |crossings: Vec<FieldCrossing>| {
        let chords = crossings.iter().flat_map(|one| &one.chords);
        let interval = |chord: &Chord| Interval { start_s: chord.enter_s - margin_s, end_s: chord.exit_s - margin_s };
        Blocked { intervals: chords.map(interval).collect(), dodged: Vec::new() }
    };
    Ok((answer.by_exposure.into_iter().map(of).collect(), answer.left_out))
}

/// To the millisecond, inwards; none where nothing is left.
fn window(from: Epoch, stretch: Interval) -> Option<ClearWindow> {
    let tick = |seconds: f64, round: fn(f64) -> f64| round(seconds / TICK_S) * TICK_S;
    // A stretch that begins with the range begins there, whatever the last digit of the division says.
    let (first_s, last_s) = (tick(stretch.start_s - 1e-9, f64::ceil), tick(stretch.end_s + 1e-9, f64::floor));
    (first_s <= last_s).then(|| ClearWindow { first: seconds_after(from, first_s), last: seconds_after(from, last_s) })
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
    use crate::output::format_utc;

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
