//! Rise, culmination and set: every pass above a site's horizon in a night.
//!
//! Altitudes are geometric (no refraction) against the WGS84 horizon of the site. The satellite is followed in steps short
//! enough that its altitude has one extreme in three of them; every maximum that could reach the wanted altitude is closed in
//! on, and rise and set are rooted on both sides of it. Satellites that never come near (their shell and inclination keep them
//! below the horizon) cost nothing.

use hifitime::Epoch;
use rayon::prelude::*;

use super::look::Look;
use super::scene::Scene;
use super::sightline::{ObserverMotion, SightLine};
use super::sky::{PassOptions, Sky, SkyError};
use super::track::TrackPoint;
use crate::catalogue::NoradId;
use crate::constants::DAY_S;
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::Observer;
use crate::orbit::{Arc, LeftOut, OrbitError, OrbitUncertainty, Propagator};

/// Steps of the search are this share of the orbital period, at most [`LONGEST_STEP_S`].
const STEPS_PER_REVOLUTION: f64 = 72.0;
/// Longest step of the search, seconds.
const LONGEST_STEP_S: f64 = 300.0;
/// Rise, set and culmination are closed to this, seconds.
const CLOSE_S: f64 = 1e-4;

/// One pass of one satellite above the horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct HorizonPass {
    /// Who.
    pub norad_id: NoradId,
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Where the altitude reaches the wanted one; `None` where the satellite is up when the night begins.
    pub rise: Option<TrackPoint>,
    /// The highest point within the time asked for.
    pub culmination: TrackPoint,
    /// Where the altitude falls below the wanted one; `None` where the satellite is still up when the night ends.
    pub set: Option<TrackPoint>,
}

/// The satellite's altitude from SGP4 itself.
struct Follow<'a> {
    sky: &'a Sky,
    scene: &'a Scene,
    propagator: &'a Propagator,
    minutes: f64,
    observer: &'a Observer,
    motion: ObserverMotion,
}

impl Sky {
    /// Every stretch above `min_altitude_rad` between two moments, on all threads, by time of culmination; and the satellites
    /// that have no position at some moment in between.
    ///
    /// # Errors
    /// [`SkyError::NoEphemeris`] outside the years of the Sun's ephemeris; [`SkyError::NoHorizon`] for an observer in orbit.
    pub fn horizon_passes(
        &self,
        start: Epoch,
        end: Epoch,
        min_altitude_rad: f64,
        options: &PassOptions,
    ) -> Result<(Vec<HorizonPass>, Vec<LeftOut>), SkyError> {
        super::sky::check_epoch(start)?;
        super::sky::check_epoch(end)?;
        let observer =
            self.viewpoint().site().ok_or_else(|| SkyError::NoHorizon { observer: self.viewpoint().name() })?;
        let span_s = seconds_between(start, end).max(0.0);
        let scene = self.scene_without_windows(start, span_s);
        let middle_s = 0.5 * span_s;
        let motion = ObserverMotion::of_site(
            observer,
            &scene.orientation.at_s(middle_s),
            scene.sun.at_s(middle_s).earth_velocity,
            middle_s,
        );
        let answers: Vec<(Vec<HorizonPass>, Option<LeftOut>)> = (0..self.index().len())
            .into_par_iter()
            .with_min_len(16)
            .map(|element_index| {
                let Some(propagator) = self.index().propagator(element_index) else { return Default::default() };
                let minutes = propagator.minutes_since_epoch(start);
                let motion = motion.clone();
                let follow = Follow { sky: self, scene: &scene, propagator, minutes, observer, motion };
                let mut passes = Vec::new();
                let failed = follow.passes(element_index, span_s, min_altitude_rad, options, &mut passes).err();
                let left_out = failed.map(|reason| LeftOut { norad_id: propagator.norad_id(), element_index, reason });
                (passes, left_out)
            })
            .collect();
        let mut passes = Vec::new();
        let mut left_out = self.index().left_out().to_vec();
        for (found, failed) in answers {
            passes.extend(found);
            left_out.extend(failed);
        }
        passes
            .sort_by(|a, b| a.culmination.epoch.cmp(&b.culmination.epoch).then(a.element_index.cmp(&b.element_index)));
        left_out.sort_by_key(|left_out| left_out.element_index);
        Ok((passes, left_out))
    }
}

impl Follow<'_> {
    /// Errors of the prediction at a moment, seconds of the scene.
    fn uncertainty(&self, element_index: usize, time_s: f64) -> OrbitUncertainty {
        let moment = seconds_after(self.scene.start, time_s);
        self.sky.uncertainty(element_index, seconds_between(self.propagator.epoch(), moment) / DAY_S)
    }

    /// Sine of the altitude at a moment, seconds of the scene.
    fn sine_of_altitude(&self, time_s: f64) -> Result<f64, OrbitError> {
        let orientation = self.scene.orientation.at_s(time_s);
        let state = self.propagator.state_at_minutes(self.minutes + time_s / 60.0, &orientation.teme_to_gcrs)?;
        let here = self.observer.state(&orientation);
        Ok(here.sine_of_altitude(&(state.position - here.position)))
    }

    fn passes(
        &self,
        element_index: usize,
        span_s: f64,
        min_altitude_rad: f64,
        options: &PassOptions,
        passes: &mut Vec<HorizonPass>,
    ) -> Result<(), OrbitError> {
        let steps = (span_s / (self.propagator.period_s() / STEPS_PER_REVOLUTION).min(LONGEST_STEP_S)).ceil().max(2.0);
        let step_s = span_s / steps;
        let limit = min_altitude_rad.sin();
        let sines = (0..=steps as usize)
            .map(|step| Ok((step_s * step as f64, self.sine_of_altitude(step_s * step as f64)?)))
            .collect::<Result<Vec<_>, OrbitError>>()?;
        let last = sines.len() - 1;
        // Where each stretch above the limit was last seen to begin and end.
        let mut done_s = f64::NEG_INFINITY;
        for step in 0..=last {
            let (time_s, sine) = sines[step];
            let before = if step > 0 { sines[step - 1].1 } else { f64::NEG_INFINITY };
            let after = if step < last { sines[step + 1].1 } else { f64::NEG_INFINITY };
            if time_s < done_s || sine < before || sine < after || sine + reach(before, sine, after) < limit {
                continue;
            }
            let (low_s, high_s) = ((time_s - step_s).max(0.0), (time_s + step_s).min(span_s));
            let (top_s, top) = self.highest(low_s, high_s)?;
            if top < limit {
                continue;
            }
            // Outwards from the top, step by step, to the first time below the limit.
            let rise_from = (0..=step).rev().map(|at| sines[at]).find(|(at_s, sine)| *at_s < top_s && *sine < limit);
            let set_until = sines[step..].iter().copied().find(|(at_s, sine)| *at_s > top_s && *sine < limit);
            let rise_s = rise_from.map(|(at_s, _)| self.border(at_s, top_s, limit)).transpose()?;
            let set_s = set_until.map(|(at_s, _)| self.border(at_s, top_s, limit)).transpose()?;
            // A stretch with several maxima (a slow or eccentric orbit) culminates at the highest of them.
            let until_s = set_until.map_or(f64::INFINITY, |(at_s, _)| at_s);
            let (mut top_s, mut top) = (top_s, top);
            for &(at_s, sine) in sines[step + 1..].iter().take_while(|(at_s, _)| *at_s < until_s) {
                if sine > top {
                    (top_s, top) = self.highest((at_s - step_s).max(0.0), (at_s + step_s).min(span_s))?;
                }
            }
            done_s = until_s;
            passes.extend(self.describe(element_index, rise_s, top_s, set_s, options)?);
        }
        Ok(())
    }

    /// The highest moment between two, by golden section.
    fn highest(&self, mut low_s: f64, mut high_s: f64) -> Result<(f64, f64), OrbitError> {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let (mut left_s, mut right_s) = (high_s - golden * (high_s - low_s), low_s + golden * (high_s - low_s));
        let (mut left, mut right) = (self.sine_of_altitude(left_s)?, self.sine_of_altitude(right_s)?);
        // The top is flat: its time is no better than the root of the rounding, its height is exact.
        while high_s - low_s > 1e-3 {
            if left > right {
                high_s = right_s;
                (right_s, right) = (left_s, left);
                left_s = high_s - golden * (high_s - low_s);
                left = self.sine_of_altitude(left_s)?;
            } else {
                low_s = left_s;
                (left_s, left) = (right_s, right);
                right_s = low_s + golden * (high_s - low_s);
                right = self.sine_of_altitude(right_s)?;
            }
        }
        let top_s = 0.5 * (low_s + high_s);
        Ok((top_s, self.sine_of_altitude(top_s)?))
    }

    /// Where the limit is passed between a moment below it and one above it.
    fn border(&self, mut below_s: f64, mut above_s: f64, limit: f64) -> Result<f64, OrbitError> {
        while (above_s - below_s).abs() > CLOSE_S {
            let middle_s = 0.5 * (below_s + above_s);
            if self.sine_of_altitude(middle_s)? < limit {
                below_s = middle_s;
            } else {
                above_s = middle_s;
            }
        }
        Ok(above_s)
    }

    fn describe(
        &self,
        element_index: usize,
        rise_s: Option<f64>,
        top_s: f64,
        set_s: Option<f64>,
        options: &PassOptions,
    ) -> Result<Option<HorizonPass>, OrbitError> {
        let point = |time_s: f64| {
            // A stretch around the moment, long enough for its own derivative.
            let orientation = self.scene.orientation.at_s(time_s);
            let arc = Arc::new(self.propagator, self.minutes, time_s - 1.0, 2.0, &orientation.teme_to_gcrs)?;
            let line = SightLine { arc: &arc, observer: self.motion.clone() };
            let look = Look {
                scene: self.scene,
                viewpoint: self.sky.viewpoint(),
                shadow: self.sky.shadow(),
                line: &line,
                model: self.sky.model(element_index),
                options,
                uncertainty: self.uncertainty(element_index, time_s),
            };
            Ok::<_, OrbitError>(look.point(time_s))
        };
        let rise = rise_s.map(point).transpose()?.flatten();
        let set = set_s.map(point).transpose()?.flatten();
        Ok(point(top_s)?.map(|culmination| HorizonPass {
            norad_id: self.propagator.norad_id(),
            element_index,
            rise,
            culmination,
            set,
        }))
    }
}

/// How far above its highest sample a parabola through three of them may rise, with room for what a parabola leaves out.
fn reach(before: f64, sine: f64, after: f64) -> f64 {
    if !(before.is_finite() && after.is_finite()) {
        // At the edge of the time asked for: anything is possible within a step.
        return 2.0;
    }
    let bend = 2.0 * sine - before - after;
    let slope = 0.5 * (after - before);
    if bend > 0.0 { slope * slope / (2.0 * bend) + 0.25 * bend } else { 0.0 }
}
