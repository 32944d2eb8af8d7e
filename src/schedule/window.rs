//! Clear windows: from when to when exposures of a target may start so that each of them is clear throughout.

use hifitime::Epoch;

use crate::frames::{seconds_after, seconds_between};
use crate::passes::{Exposure, SkyError};

use super::camera::Camera;
use super::horizon::times_below;
use super::judge::{CameraLimits, Rules, counts, is_to_avoid};
use super::report::{FlagRequest, GUARD_S, intervals, late_s, pass_options};
use super::shift::{Interval, clear_starts};

/// A long time is asked in parts of this length, seconds: they go to all threads.
const PART_S: f64 = 600.0;

/// Which satellites keep an exposure from being clear.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Blocking {
    /// Every lit one: the verdict is `clear`.
    #[default]
    Any,
    /// Those that the policy's limits of magnitude forbid: the verdict is not `avoid` for any single satellite.
    Avoided,
}

/// A target, and the time in which it could be exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Where to, and from when on: the shutter opens at `start` at the earliest and closes `duration_s` later at the latest.
    pub time: Exposure,
    /// The band, for limits by band.
    pub band: Option<String>,
    /// Length of the exposure, seconds.
    pub exposure_s: f64,
    /// The pointing must stand as high while the shutter is open, radians; above the Earth's limb for a telescope in orbit.
    pub min_altitude_rad: f64,
}

/// Exposures that start at any time from `first_start` to `last_start` are clear.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ClearWindow {
    /// The first start.
    pub first_start: Epoch,
    /// The last start, not before the first.
    pub last_start: Epoch,
}

/// The clear windows of each target, in order of time. The policy's margin is kept clear at both ends of the exposure, as by
/// [`flag_exposures`](super::flag_exposures); where it names a probability, satellites block for as long as they may be three sigmas early or late.
/// Its `max_lost_fraction` and `max_delay_s` have no part.
///
/// # Errors
/// [`SkyError`] only where the sky cannot answer at all.
pub fn clear_windows(
    targets: &[Target],
    blocking: Blocking,
    request: &FlagRequest<'_>,
) -> Result<Vec<Vec<ClearWindow>>, SkyError> {
    let margin_s = request.policy.margin_or_default_s();
    let parts: Vec<(usize, Exposure)> = targets
        .iter()
        .enumerate()
        .flat_map(|(of, target)| parts(&target.time, margin_s).map(move |part| (of, part)))
        .collect();
    let exposures: Vec<Exposure> = parts.iter().map(|(_, part)| part.clone()).collect();
    let answer = request.sky.field_passes(&exposures, request.field, &pass_options(request))?;
    let camera =
        request.telescope.map(|telescope| Camera { telescope, sky: request.sky, photometry: request.photometry });
    let rules = Rules { policy: request.policy, camera: camera.as_ref().map(|camera| camera as &dyn CameraLimits) };
    let mut blocked: Vec<Vec<Interval>> = vec![Vec::new(); targets.len()];
    for ((of, part), passes) in parts.iter().zip(&answer.by_exposure) {
        let target = &targets[*of];
        // Intervals count from the target's own start.
        let lead_s = seconds_between(part.start, target.time.start);
        for pass in passes {
            let blocks = match blocking {
                Blocking::Any => counts(pass, request.policy),
                Blocking::Avoided => is_to_avoid(pass, target.band.as_deref(), &rules),
            };
            if blocks {
                blocked[*of].extend(intervals(pass, &target.time, lead_s, late_s(pass, request.policy)));
            }
        }
    }
    let windows = |(target, mut blocked): (&Target, Vec<Interval>)| {
        let earth = |start, end| request.sky.orientation_over(start, end);
        let below = times_below(&target.time, request.sky.viewpoint(), &earth, target.min_altitude_rad);
        // The horizon needs no margin.
        let without_margin =
            |below: Interval| Interval { start_s: below.start_s + margin_s, end_s: below.end_s - margin_s };
        blocked.extend(below.into_iter().map(without_margin));
        let last_s = target.time.duration_s - target.exposure_s;
        clear_starts(&blocked, target.exposure_s, margin_s, GUARD_S, 0.0, last_s)
            .into_iter()
            .map(|stretch| ClearWindow {
                first_start: seconds_after(target.time.start, stretch.start_s),
                last_start: seconds_after(target.time.start, stretch.end_s),
            })
            .collect()
    };
    Ok(targets.iter().zip(blocked).map(windows).collect())
}

/// The time and the margins around it in parts.
fn parts(time: &Exposure, margin_s: f64) -> impl Iterator<Item = Exposure> {
    let whole_s = time.duration_s + 2.0 * margin_s;
    let count = (whole_s / PART_S).ceil().max(1.0);
    let part_s = whole_s / count;
    let begin = seconds_after(time.start, -margin_s);
    (0..count as u32).map(move |part| Exposure {
        start: seconds_after(begin, part_s * f64::from(part)),
        duration_s: part_s,
        ..time.clone()
    })
}
