//! Rise, culmination and set: the intervals of one satellite above a site's horizon.
//!
//! Altitudes are geometric (no refraction) against the WGS84 horizon of the site. The satellite is followed in steps
//! short enough that its altitude has one extreme in three of them; every maximum that could reach the lowest altitude
//! is closed in on, and rise and set are rooted on both sides of it. Steps in which a satellite cannot come near are
//! skipped: its angle to the site changes no faster than at its perigee.

use super::crossing::root;
use super::scene::Scene;
use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING, WGS72_MU_KM3_S2};
use crate::frames::{Gcrs, Position};
use crate::geometry::Observer;
use crate::math::minimum::minimum;
use crate::orbit::{OrbitError, Propagator, State};

/// Steps of the search are this share of the orbital period, at most [`LONGEST_STEP_S`].
const STEPS_PER_REVOLUTION: f64 = 72.0;
/// Longest step of the search, seconds.
const LONGEST_STEP_S: f64 = 300.0;
/// Tolerance of a culmination's time, seconds.
const TOP_S: f64 = 2.5e-4;
/// Largest rate at which the Earth turns a site, rad/s, with what its precession adds.
const SITE_TURNING_RAD_S: f64 = 7.3e-5;
/// A geodetic vertical leans from the geocentric one by 0.193° at most; with what short-period terms move a satellite,
/// radians.
const VERTICAL_SLOP_RAD: f64 = 0.0125;
/// Room for the short-period terms in radius, km, and in angular speed.
const RADIUS_SLOP_KM: f64 = 35.0;
const SPEED_SLOP: f64 = 1.1;

/// Search over the altitude of one satellite, from SGP4 itself.
pub(super) struct HorizonSearch<'a> {
    pub scene: &'a Scene,
    pub propagator: &'a Propagator,
    /// From the element epoch to the scene's start.
    pub minutes: f64,
    pub observer: &'a Observer,
}

/// One satellite at one time.
pub(super) struct Sample {
    pub time_s: f64,
    pub sine: f64,
    pub state: State<Gcrs>,
    here: Position<Gcrs>,
}

impl Sample {
    /// Largest rate at which it turns about the Earth's centre, rad/s.
    fn turning_rad_s(&self) -> f64 {
        self.state.velocity.norm_km_s() / self.state.position.norm_km()
    }
}

/// An interval above the lowest altitude, seconds of the scene.
pub(super) struct AboveHorizon {
    pub rise_s: Option<f64>,
    pub top_s: f64,
    pub set_s: Option<f64>,
    /// Largest rate at which the satellite turns about the Earth's centre, rad/s.
    pub turning_rad_s: f64,
}

/// What the search does with an interval above the lowest altitude, decided by its samples.
#[derive(Copy, Clone, PartialEq, Eq)]
pub(super) enum Treatment {
    /// Computes it.
    Compute,
    /// Counts it.
    Count,
    /// Skips it.
    Skip,
}

/// Time for which a satellite far from a site is sure to stay too low.
struct Near {
    /// Geocentric angle to the site within which it may be above the limit, radians.
    reach_rad: f64,
    /// Fastest change of that angle, rad/s.
    fastest_rad_s: f64,
}

impl Near {
    fn of(propagator: &Propagator, min_altitude_rad: f64) -> Self {
        let (perigee_km, apogee_km) = propagator.perigee_apogee_km();
        let (perigee_km, apogee_km) = (perigee_km - RADIUS_SLOP_KM, apogee_km + RADIUS_SLOP_KM);
        // The triangle Earth's centre, site, satellite: ψ = acos(R cos h / r) - h, largest at the apogee; the lowest
        // site reaches farthest.
        let lowest_km = EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING) - 11.0;
        let share = (lowest_km * min_altitude_rad.cos() / apogee_km).min(1.0);
        let reach_rad = share.acos() - min_altitude_rad + VERTICAL_SLOP_RAD;
        // dν/dt = √(μ p) / r² is greatest at the perigee.
        let parameter_km = 2.0 * perigee_km * apogee_km / (perigee_km + apogee_km);
        let at_perigee_rad_s = (WGS72_MU_KM3_S2 * parameter_km).sqrt() / (perigee_km * perigee_km);
        Self { reach_rad, fastest_rad_s: at_perigee_rad_s * SPEED_SLOP + SITE_TURNING_RAD_S }
    }

    /// Seconds from a sample on in which the altitude stays below the limit, 0 where it may be above it.
    fn free_s(&self, sample: &Sample) -> f64 {
        let (place, here) = (sample.state.position.vector(), sample.here.vector());
        let angle_rad = place.cross(here).norm().atan2(place.dot(here));
        ((angle_rad - self.reach_rad) / self.fastest_rad_s).max(0.0)
    }
}

impl HorizonSearch<'_> {
    /// The satellite at a time, seconds of the scene: its position and its altitude.
    fn sample(&self, time_s: f64) -> Result<Sample, OrbitError> {
        let orientation = self.scene.orientation.at_s(time_s);
        let state = self.propagator.state_at_minutes(self.minutes + time_s / 60.0, &orientation.teme_to_gcrs)?;
        let here = self.observer.state(&orientation);
        let sine = here.sine_of_altitude(&(state.position - here.position));
        Ok(Sample { time_s, sine, state, here: here.position })
    }

    /// Sine of the altitude at a time, seconds of the scene.
    fn sine_of_altitude(&self, time_s: f64) -> Result<f64, OrbitError> {
        Ok(self.sample(time_s)?.sine)
    }

    /// The satellite from step to step wherever it may be above the limit, and seldom elsewhere: far from the site, no
    /// more steps are skipped than it needs to come near.
    fn samples(&self, from_s: f64, until_s: f64, min_altitude_rad: f64) -> Result<(Vec<Sample>, f64), OrbitError> {
        let span_s = until_s - from_s;
        let steps = (span_s / (self.propagator.period_s() / STEPS_PER_REVOLUTION).min(LONGEST_STEP_S)).ceil().max(2.0);
        let step_s = span_s / steps;
        let near = Near::of(self.propagator, min_altitude_rad);
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

    /// Every interval above an altitude between two times, in order of time, and the number of those that are only
    /// counted. `treatment` decides by the samples from the last one below the limit to the first one below it again;
    /// an interval with no sample above the limit is always computed.
    pub fn intervals(
        &self,
        (from_s, until_s): (f64, f64),
        min_altitude_rad: f64,
        treatment: &dyn Fn(&[Sample]) -> Treatment,
    ) -> Result<(Vec<AboveHorizon>, usize), OrbitError> {
        let limit = min_altitude_rad.sin();
        let (samples, step_s) = self.samples(from_s, until_s, min_altitude_rad)?;
        let last = samples.len() - 1;
        let (mut found, mut counted) = (Vec::new(), 0);
        // Where the last stretch above the limit was seen to end.
        let mut done_s = f64::NEG_INFINITY;
        for step in 0..=last {
            let Sample { time_s, sine, .. } = samples[step];
            let is_beside = |other: usize| (samples[other].time_s - time_s).abs() < 1.5 * step_s;
            // Where steps were left out the satellite was too low: before a gap already at its sample, after it no
            // longer.
            if step < last && !is_beside(step + 1) {
                continue;
            }
            let before = if step > 0 && is_beside(step - 1) { samples[step - 1].sine } else { f64::NEG_INFINITY };
            let after = if step < last { samples[step + 1].sine } else { f64::NEG_INFINITY };
            if time_s < done_s || sine < before || sine < after || sine + reach(before, sine, after) < limit {
                continue;
            }
            // Outwards from the top, step by step, to the first time below the limit.
            let below = |sample: &Sample| sample.sine < limit;
            let rise_step = (0..step).rev().find(|&at| below(&samples[at]));
            let set_step = (step + 1..=last).find(|&at| below(&samples[at]));
            let window = &samples[rise_step.unwrap_or(0)..=set_step.unwrap_or(last)];
            let treatment = treatment(window);
            if treatment == Treatment::Skip {
                continue;
            }
            // What only comes near the limit between two steps has to be followed to be counted.
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
            // The top itself may lie on the other side of a sample that is below the limit.
            let rise_from = (0..=step).rev().find(|&at| samples[at].time_s < first_top_s && below(&samples[at]));
            let set_until = (step..=last).find(|&at| samples[at].time_s > first_top_s && below(&samples[at]));
            let rise_s = rise_from.map(|at| self.border(samples[at].time_s, first_top_s, limit)).transpose()?;
            let set_s = set_until.map(|at| self.border(samples[at].time_s, first_top_s, limit)).transpose()?;
            // An interval with several maxima (a slow or eccentric orbit) culminates at the highest of them.
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

    /// The highest point between two times, from a sample between them: its time and sine of altitude.
    fn highest(&self, ends_s: [f64; 2], start: &Sample) -> Result<(f64, f64), OrbitError> {
        let mut failed = None;
        let depth = |time_s: f64| match self.sine_of_altitude(time_s) {
            Ok(sine) => -sine,
            Err(error) => {
                failed = Some(error);
                f64::INFINITY
            }
        };
        // The top is flat: its time is no better than the root of the rounding, its height is exact.
        let (top_s, depth) = minimum(depth, ends_s, (start.time_s, -start.sine), TOP_S);
        failed.map_or(Ok((top_s, -depth)), Err)
    }

    /// The time at which the limit is passed between a time below it and one above it.
    fn border(&self, below_s: f64, above_s: f64, limit: f64) -> Result<f64, OrbitError> {
        // Where SGP4 fails between two times at which it did not, the sample at the root reports it.
        let height = |time_s: f64| self.sine_of_altitude(time_s).map_or(f64::NAN, |sine| sine - limit);
        let ends = [below_s, above_s].map(|time_s| (time_s, height(time_s)));
        let border_s = root(height, ends[0], ends[1]);
        self.sample(border_s).map(|_| border_s)
    }
}

/// Largest rise of a parabola through three samples above the middle one, with a margin for what a parabola leaves out.
fn reach(before: f64, sine: f64, after: f64) -> f64 {
    if !(before.is_finite() && after.is_finite()) {
        // At the edge of the interval: anything is possible within a step.
        return 2.0;
    }
    let bend = 2.0 * sine - before - after;
    let slope = 0.5 * (after - before);
    if bend > 0.0 { slope * slope / (2.0 * bend) + 0.25 * bend } else { 0.0 }
}
