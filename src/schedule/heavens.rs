//! When a target is up and the Sun is down.

use hifitime::Epoch;

use super::horizon::{altitude_rad, look_every_s};
use super::shift::Interval;
use super::windows::WindowRequest;
use crate::frames::{OrientationTable, seconds_after};
use crate::geometry::{Observer, SunTable};
use crate::passes::{Exposure, SkyError, Viewpoint};

/// Risings and settings are found to this, seconds, and never given too early or too late.
const SETTING_TOLERANCE_S: f64 = 1e-3;

/// Target and Sun over a site, or target and limb.
pub(super) struct Heavens<'a> {
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
    pub fn new(request: &WindowRequest<'a>, from: Epoch, span_s: f64) -> Result<Self, SkyError> {
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
    pub fn observable(&self, exposure: &Exposure) -> Vec<Interval> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
