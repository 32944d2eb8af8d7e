//! Intervals in which one satellite is above a site's horizon, with rise, culmination and set.
//!
//! Altitudes are geometric (without refraction) and relative to the WGS84 horizon of the site. The satellite's position
//! is computed in steps so short that three successive steps contain at most one extremum of the altitude. Every
//! maximum that could reach the lowest altitude is refined, and rise and set are found as roots on both sides of it.
//! Steps in which the satellite cannot come near the site are skipped. Their number follows from its geocentric angle
//! to the site, which changes at most as fast as at the perigee.

use super::crossing::root;
use super::scene::Scene;
use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING, WGS72_MU_KM3_S2};
use crate::error::Error;
use crate::frames::{Gcrs, Position};
use crate::geometry::Observer;
use crate::math::minimum::minimum;
use crate::orbit::{Propagator, State};

/// Number of search steps per orbital period; a step is at most [`LONGEST_STEP_S`] long.
const STEPS_PER_REVOLUTION: f64 = 72.0;
/// Longest step of the search, seconds.
const LONGEST_STEP_S: f64 = 300.0;
/// Tolerance of the time of a culmination, seconds.
const TOP_S: f64 = 2.5e-4;
/// Largest angular speed of a site due to the Earth's rotation and precession, rad/s.
const SITE_TURNING_RAD_S: f64 = 7.3e-5;
/// Margin of angles in the search, radians. It covers the largest angle between the geodetic and the geocentric
/// vertical (0.193°) and the displacement of a satellite by the short-period terms of SGP4.
const VERTICAL_SLOP_RAD: f64 = 0.0125;
/// Margins for the short-period terms of SGP4: km for the radius of the orbit, and a factor for the angular speed.
const RADIUS_SLOP_KM: f64 = 35.0;
const SPEED_SLOP: f64 = 1.1;

/// Search for the intervals in which one satellite is above an altitude, with SGP4 at every step.
pub(super) struct HorizonSearch<'a> {
    pub scene: &'a Scene,
    pub propagator: &'a Propagator,
    /// Time from the epoch of the elements to the start of the scene, minutes.
    pub minutes: f64,
    pub observer: &'a Observer,
}

/// Position and altitude of one satellite at one time.
pub(super) struct Sample {
    pub time_s: f64,
    pub sine: f64,
    pub state: State<Gcrs>,
    here: Position<Gcrs>,
}

impl Sample {
    /// Returns an upper bound of the angular speed about the Earth's centre, rad/s.
    fn turning_rad_s(&self) -> f64 {
        self.state.velocity.norm_km_s() / self.state.position.norm_km()
    }
}

/// Interval in which the satellite is above the lowest altitude. Times are seconds after the start of the scene.
pub(super) struct AboveHorizon {
    pub rise_s: Option<f64>,
    pub top_s: f64,
    pub set_s: Option<f64>,
    /// Largest angular speed about the Earth's centre, rad/s.
    pub turning_rad_s: f64,
}

/// Treatment of an interval above the lowest altitude, decided from its samples.
#[derive(Copy, Clone, PartialEq, Eq)]
pub(super) enum Treatment {
    /// The interval is computed.
    Compute,
    /// The interval is only counted.
    Count,
    /// The interval is skipped.
    Skip,
}

/// Bounds on the motion of a satellite, from which the time that it stays below the lowest altitude is computed.
struct Near {
    /// Geocentric angle to the site within which the satellite may be above the lowest altitude, radians.
    reach_rad: f64,
    /// Upper bound of the rate of the geocentric angle to the site, rad/s.
    fastest_rad_s: f64,
}

impl Near {
    fn new(propagator: &Propagator, min_altitude_rad: f64) -> Self {
        let (perigee_km, apogee_km) = propagator.perigee_apogee_km();
        let (perigee_km, apogee_km) = (perigee_km - RADIUS_SLOP_KM, apogee_km + RADIUS_SLOP_KM);
        // The geocentric angle between a site at radius R and a satellite at radius r and altitude h is
        // acos(R cos h / r) - h. It is largest at the apogee and for the lowest site.
        let lowest_km = EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING) - 11.0;
        let share = (lowest_km * min_altitude_rad.cos() / apogee_km).min(1.0);
        let reach_rad = share.acos() - min_altitude_rad + VERTICAL_SLOP_RAD;
        // dν/dt = √(μ p) / r² is greatest at the perigee.
        let parameter_km = 2.0 * perigee_km * apogee_km / (perigee_km + apogee_km);
        let at_perigee_rad_s = (WGS72_MU_KM3_S2 * parameter_km).sqrt() / (perigee_km * perigee_km);
        Self { reach_rad, fastest_rad_s: at_perigee_rad_s * SPEED_SLOP + SITE_TURNING_RAD_S }
    }

    /// Returns the time after a sample for which the altitude stays below the limit, seconds; 0 if it may be above the
    /// limit.
    fn free_s(&self, sample: &Sample) -> f64 {
        let (satellite, site) = (sample.state.position.vector(), sample.here.vector());
        let angle_rad = satellite.cross(site).norm().atan2(satellite.dot(site));
        ((angle_rad - self.reach_rad) / self.fastest_rad_s).max(0.0)
    }
}

impl HorizonSearch<'_> {
    /// Returns position and altitude of the satellite at a time, in seconds after the start of the scene.
    fn sample(&self, time_s: f64) -> Result<Sample, Error> {
        let orientation = self.scene.orientation.at_s(time_s);
        let state = self.propagator.state_at_minutes(self.minutes + time_s / 60.0, &orientation.teme_to_gcrs)?;
        let here = self.observer.state(&orientation);
        let sine = here.sine_of_altitude(&(state.position - here.position));
        Ok(Sample { time_s, sine, state, here: here.position })
    }

    /// Returns the sine of the altitude at a time, in seconds after the start of the scene.
    fn sine_of_altitude(&self, time_s: f64) -> Result<f64, Error> {
        Ok(self.sample(time_s)?.sine)
    }

    /// Returns samples at every step at which the satellite may be above the limit, and the length of a step,
    /// seconds. Steps in which the satellite is still too far from the site are skipped.
    fn samples(&self, from_s: f64, until_s: f64, min_altitude_rad: f64) -> Result<(Vec<Sample>, f64), Error> {
        let span_s = until_s - from_s;
        let steps = (span_s / (self.propagator.period_s() / STEPS_PER_REVOLUTION).min(LONGEST_STEP_S)).ceil().max(2.0);
        let step_s = span_s / steps;
        let near = Near::new(self.propagator, min_altitude_rad);
        let mut samples = Vec::new();
        let mut step = 0.0;
        while step <= steps {
            let sample = self.sample(from_s + step_s * step)?;
            let free_steps = (near.free_s(&sample) / step_s).floor();
            samples.push(sample);
            // The last step is always computed.
            step = if step == steps { f64::INFINITY } else { (step + free_steps.max(1.0)).min(steps) };
        }
        Ok((samples, step_s))
    }

    /// Returns the intervals between two times in which the satellite is above an altitude, in order, and the number of
    /// intervals that were only counted.
    ///
    /// `treatment` receives the samples of one interval, from the last sample below the limit before the interval to
    /// the first sample below the limit after it. An interval without a sample above the limit is computed even if the
    /// treatment is [`Treatment::Count`].
    pub fn intervals(
        &self,
        (from_s, until_s): (f64, f64),
        min_altitude_rad: f64,
        treatment: &dyn Fn(&[Sample]) -> Treatment,
    ) -> Result<(Vec<AboveHorizon>, usize), Error> {
        let limit = min_altitude_rad.sin();
        let (samples, step_s) = self.samples(from_s, until_s, min_altitude_rad)?;
        let last = samples.len() - 1;
        let (mut found, mut counted) = (Vec::new(), 0);
        // End of the previous interval above the limit.
        let mut done_s = f64::NEG_INFINITY;
        for step in 0..=last {
            let Sample { time_s, sine, .. } = samples[step];
            let is_beside = |other: usize| (samples[other].time_s - time_s).abs() < 1.5 * step_s;
            // In skipped steps, and at the sample before them, the satellite is below the limit.
            if step < last && !is_beside(step + 1) {
                continue;
            }
            let before = if step > 0 && is_beside(step - 1) { samples[step - 1].sine } else { f64::NEG_INFINITY };
            let after = if step < last { samples[step + 1].sine } else { f64::NEG_INFINITY };
            if time_s < done_s || sine < before || sine < after || sine + reach(before, sine, after) < limit {
                continue;
            }
            // Search outwards from the maximum for the nearest samples below the limit.
            let below = |sample: &Sample| sample.sine < limit;
            let rise_step = (0..step).rev().find(|&at| below(&samples[at]));
            let set_step = (step + 1..=last).find(|&at| below(&samples[at]));
            let window = &samples[rise_step.unwrap_or(0)..=set_step.unwrap_or(last)];
            let treatment = treatment(window);
            if treatment == Treatment::Skip {
                continue;
            }
            // A maximum near the limit that lies between two samples must be computed before it can be counted.
            if treatment == Treatment::Count && sine >= limit {
                counted += 1;
                done_s = set_step.map_or(f64::INFINITY, |at| samples[at].time_s);
                continue;
            }
            let around = |step: usize| {
                [(samples[step].time_s - step_s).max(from_s), (samples[step].time_s + step_s).min(until_s)]
            };
            let (mut top_s, mut top) = self.highest(around(step), &samples[step])?;
            if top < limit {
                continue;
            }
            let first_top_s = top_s;
            // The refined maximum may lie on the other side of a sample below the limit.
            let rise_from = (0..=step).rev().find(|&at| samples[at].time_s < first_top_s && below(&samples[at]));
            let set_until = (step..=last).find(|&at| samples[at].time_s > first_top_s && below(&samples[at]));
            let rise_s = rise_from.map(|at| self.border(samples[at].time_s, first_top_s, limit)).transpose()?;
            let set_s = set_until.map(|at| self.border(samples[at].time_s, first_top_s, limit)).transpose()?;
            // An interval with several maxima (in a slow or eccentric orbit) culminates at the highest maximum.
            let end = set_until.unwrap_or(last + 1);
            for (at, sample) in samples.iter().enumerate().take(end).skip(step + 1) {
                if sample.sine > top {
                    (top_s, top) = self.highest(around(at), sample)?;
                }
            }
            done_s = set_until.map_or(f64::INFINITY, |at| samples[at].time_s);
            let turning_rad_s = window.iter().map(Sample::turning_rad_s).fold(0.0, f64::max);
            found.push(AboveHorizon { rise_s, top_s, set_s, turning_rad_s });
        }
        Ok((found, counted))
    }

    /// Returns the time of the highest point between two times and the sine of the altitude there; `start` is a sample
    /// between these times.
    fn highest(&self, ends_s: [f64; 2], start: &Sample) -> Result<(f64, f64), Error> {
        let mut failed = None;
        let depth = |time_s: f64| match self.sine_of_altitude(time_s) {
            Ok(sine) => -sine,
            Err(error) => {
                failed = Some(error);
                f64::INFINITY
            }
        };
        // The time of a maximum is accurate only to the square root of the rounding error; the altitude there is
        // accurate.
        let (top_s, depth) = minimum(depth, ends_s, (start.time_s, -start.sine), TOP_S);
        failed.map_or(Ok((top_s, -depth)), Err)
    }

    /// Returns the time at which the altitude passes the limit, between a time below and a time above the limit.
    fn border(&self, below_s: f64, above_s: f64, limit: f64) -> Result<f64, Error> {
        // If SGP4 fails between two times at which it did not fail, the sample at the root returns the error.
        let height = |time_s: f64| self.sine_of_altitude(time_s).map_or(f64::NAN, |sine| sine - limit);
        let ends = [below_s, above_s].map(|time_s| (time_s, height(time_s)));
        let border_s = root(height, ends[0], ends[1]);
        self.sample(border_s).map(|_| border_s)
    }
}

/// Returns by how much the maximum of a parabola through three samples exceeds the middle sample, with a margin for the
/// deviation of the altitude from a parabola.
fn reach(before: f64, sine: f64, after: f64) -> f64 {
    if !(before.is_finite() && after.is_finite()) {
        // At the ends of the searched time, no bound is known.
        return 2.0;
    }
    let bend = 2.0 * sine - before - after;
    let slope = 0.5 * (after - before);
    if bend > 0.0 { slope * slope / (2.0 * bend) + 0.25 * bend } else { 0.0 }
}
