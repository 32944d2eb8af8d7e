//! Search of a catalogue for the satellites that may have caused a streak.
//!
//! Let P be the point on the line of sight at the satellite's distance r from the Earth's centre. The orbital plane
//! must pass near P, and the satellite must reach P with a delay that is compatible with its errors:
//!
//! ```text
//! across = ĥ · P          Δu = atan2(P · (ĥ × r̂), P · r̂)          δ = -Δu r² / |r × v|
//! ```
//!
//! Here r and v are the position and the velocity of the satellite, ĥ is the normal of its orbital plane, Δu is the
//! angle along the orbit from the satellite to P, and δ is the delay. Hats denote unit vectors. This requires one SGP4
//! propagation for each satellite. A few in a thousand satellites remain, which `compare` compares with the streak.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::compare::{Reach, compare};
use super::likelihood::{Candidate, log_weight_of_unknown, set_probabilities};
use super::streak::MeasuredStreak;
use crate::error::Error;
use crate::frames::{Direction, Gcrs, Position};
use crate::orbit::{LeftOut, Propagator, State};
use crate::passes::{Exposure, ExposureInterval, Sky};
use crate::photometry::PhotometryOptions;

/// Largest delay and cross-track distance that are searched, in sigmas.
const REACH_SIGMAS: f64 = 6.0;
/// Smallest limit of the searched delay, seconds.
const LEAST_REACH_S: f64 = 30.0;
/// Smallest limit of the searched cross-track distance, radians.
const LEAST_REACH_RAD: f64 = 0.0175;
/// Range from which the first cross-track limit is computed, before the range of the satellite is known, km.
const NEAR_KM: f64 = 500.0;
/// Smallest difference between the delays of two passages of one satellite that are taken as different, seconds.
const SAME_PASSAGE_S: f64 = 1.0;

/// Options of the identification.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IdentifyOptions {
    /// If true, satellites in the Earth's shadow are included.
    pub include_dark: bool,
    /// Band, magnitude system and extinction of the magnitudes.
    pub photometry: PhotometryOptions,
}

/// Result of the identification.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Identified {
    /// Candidates, in order of decreasing probability.
    pub candidates: Vec<Candidate>,
    /// Probability that a satellite without an element set caused the streak.
    pub unknown_probability: f64,
    /// Satellites that SGP4 cannot propagate to that time, in catalogue order.
    pub left_out: Vec<LeftOut>,
    /// Warning if the position of a telescope in orbit is unknown.
    pub unknown_observer: Option<String>,
}

/// Smallest total probability of the candidates at which the streak counts as identified.
const LEAST_PROBABILITY: f64 = 0.01;

impl Identified {
    /// Returns true if no candidate fits: a satellite without an element set is more than about a hundred times as
    /// probable as all candidates together.
    pub fn is_without_fit(&self) -> bool {
        1.0 - self.unknown_probability < LEAST_PROBABILITY
    }
}

/// Finds all satellites that may have caused a streak. It uses all threads of the current thread pool.
///
/// The delay and the cross-track distance of a candidate are at most six sigmas, or 30 s and 1° if these are larger.
/// The sigmas combine the errors of the elements at their age with those of the measurement.
///
/// # Errors
/// Positions cannot be computed at that time.
pub fn identify_streak(sky: &Sky, streak: &MeasuredStreak, options: &IdentifyOptions) -> Result<Identified, Error> {
    let exposure = Exposure {
        id: String::new(),
        start: streak.start(),
        duration_s: streak.duration_s(),
        pointing: streak.middle(),
        rotation_rad: 0.0,
    };
    let interval = sky.exposure_interval(&exposure)?;
    let found = (0..sky.elements().len())
        .into_par_iter()
        .with_min_len(64)
        .map(|element_index| {
            sky.watch().check()?;
            Ok(one_satellite(&interval, element_index, streak, options))
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let mut left_out = sky.left_out().to_vec();
    let mut candidates = Vec::new();
    for (candidate, failed) in found {
        candidates.extend(candidate);
        left_out.extend(failed);
    }
    left_out.sort_by_key(|left_out| left_out.element_index);
    let log_unknown =
        log_weight_of_unknown(sky.elements().len(), streak.timing(), streak.duration_s(), streak.length_rad());
    let unknown_probability = set_probabilities(&mut candidates, log_unknown);
    candidates.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight).then(a.element_index.cmp(&b.element_index)));
    // A streak of unknown length may be as long as any field.
    let radius_rad = streak.length_rad().map_or(FRAC_PI_2, |length_rad| 0.5 * length_rad);
    let unknown_observer = sky.unknown_observer_warning("the streak", streak.start(), radius_rad);
    Ok(Identified { candidates, unknown_probability, left_out, unknown_observer })
}

/// Returns the best passage of one satellite, which is missing if it does not pass near the streak, and the reason if
/// SGP4 cannot propagate it.
fn one_satellite(
    interval: &ExposureInterval<'_>,
    element_index: usize,
    streak: &MeasuredStreak,
    options: &IdentifyOptions,
) -> (Vec<Candidate>, Option<LeftOut>) {
    let Some(propagator) = interval.propagator(element_index) else { return (Vec::new(), None) };
    let mid_s = 0.5 * interval.duration_s();
    if let Err(reason) = interval.state(propagator, mid_s, 0.0) {
        return (Vec::new(), Some(LeftOut { norad_id: propagator.norad_id(), element_index, reason }));
    }
    let errors = interval.uncertainty(element_index, propagator, mid_s);
    let along_s = REACH_SIGMAS * errors.along_track_s.hypot(streak.time_sigma_s());
    let across_rad = REACH_SIGMAS * (errors.cross_track_km / NEAR_KM).hypot(streak.position_sigma_rad());
    let reach = Reach {
        // At most half a revolution is searched.
        along_track_s: (along_s.max(LEAST_REACH_S) + mid_s).min(0.5 * propagator.period_s()),
        cross_track_rad: across_rad.clamp(LEAST_REACH_RAD, 0.5),
    };
    let mut delays = delays_s(interval, element_index, streak, &reach);
    delays.sort_by(f64::total_cmp);
    delays.dedup_by(|a, b| (*a - *b).abs() < SAME_PASSAGE_S);
    let best = delays
        .into_iter()
        .filter_map(|guess_s| {
            compare(interval, element_index, streak, guess_s, &reach, &options.photometry, options.include_dark)
        })
        .max_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
    (best.into_iter().collect(), None)
}

/// Largest eccentricity of orbits for which the delay is computed in closed form. For others it is found iteratively.
const CIRCULAR: f64 = 0.03;
/// Allowance for J₂ and for the varying radius of nearly circular orbits, km.
const ALLOWANCE_KM: f64 = 60.0;
/// Allowance for the same effects, as a fraction of the distance along the orbit.
const ALLOWANCE_SHARE: f64 = 0.05;
/// Tolerance of the iteration for eccentric orbits, seconds.
const CLOSE_S: f64 = 1.0;
/// Largest number of steps of the iteration.
const MOST_STEPS: usize = 30;

/// Returns first estimates of the delays with which a satellite passes the streak, seconds; empty if it does not pass.
/// The line of sight of an observer in orbit may intersect the orbit at two points.
fn delays_s(interval: &ExposureInterval<'_>, element_index: usize, streak: &MeasuredStreak, reach: &Reach) -> Vec<f64> {
    let mid_s = 0.5 * interval.duration_s();
    let Some(propagator) = interval.propagator(element_index) else { return Vec::new() };
    let Ok(state) = interval.state(propagator, mid_s, 0.0) else { return Vec::new() };
    let observer = interval.observer(mid_s);
    let towards = streak.middle();
    let (r, v) = (state.position.vector(), state.velocity.vector());
    let Some(normal) = r.cross(v).try_normalize(0.0) else { return Vec::new() };
    if interval.sky().elements()[element_index].eccentricity > CIRCULAR {
        // Point at which the line of sight intersects the orbital plane.
        let range_km = -normal.dot(observer.vector()) / normal.dot(towards.vector());
        if !(range_km > 0.0 && range_km.is_finite()) {
            return Vec::new();
        }
        let position = observer.vector() + towards.vector() * range_km;
        return delay_on_eccentric(interval, propagator, &position, mid_s)
            .filter(|delay_s| delay_s.abs() <= reach.along_track_s + ALLOWANCE_KM / v.norm())
            .into_iter()
            .collect();
    }
    let delay = |range_km: f64| {
        let position = observer.vector() + towards.vector() * range_km;
        let angle_rad = angle_to(&state, &position);
        let allowance_km = ALLOWANCE_KM + ALLOWANCE_SHARE * angle_rad.abs() * r.norm();
        let delay_s = -angle_rad * r.norm_squared() / r.cross(v).norm();
        let is_near = normal.dot(&position).abs() <= reach.cross_track_rad * range_km + allowance_km
            && delay_s.abs() <= reach.along_track_s + allowance_km / v.norm();
        is_near.then_some(delay_s)
    };
    ranges_km(&observer, &towards, r.norm()).into_iter().filter_map(delay).collect()
}

/// Returns the angle along the orbit from the satellite to a position, (-π, π], radians.
fn angle_to(state: &State<Gcrs>, position: &Vector3<f64>) -> f64 {
    let radial = state.position.vector().normalize();
    let ahead = state.position.vector().cross(state.velocity.vector()).normalize().cross(&radial);
    position.dot(&ahead).atan2(position.dot(&radial))
}

/// Returns the delay for an eccentric orbit, found by steps along the orbit at the current angular rate, seconds.
fn delay_on_eccentric(
    interval: &ExposureInterval<'_>,
    propagator: &Propagator,
    position: &Vector3<f64>,
    mid_s: f64,
) -> Option<f64> {
    let longest_s = 0.1 * propagator.period_s();
    let mut delay_s = 0.0;
    for _ in 0..MOST_STEPS {
        let state = interval.state(propagator, mid_s, delay_s).ok()?;
        let momentum = state.position.vector().cross(state.velocity.vector()).norm();
        let step_s = angle_to(&state, position) * state.position.vector().norm_squared() / momentum;
        delay_s -= step_s.clamp(-longest_s, longest_s);
        if step_s.abs() < CLOSE_S {
            return Some(delay_s);
        }
    }
    None
}

/// Returns the ranges in front of the observer at which a line of sight intersects a sphere about the Earth's centre,
/// km.
fn ranges_km(observer: &Position<Gcrs>, towards: &Direction<Gcrs>, radius_km: f64) -> Vec<f64> {
    // ρ = -O·d ± √((O·d)² + r² - O²)
    let along = observer.vector().dot(towards.vector());
    let square = along * along + radius_km * radius_km - observer.vector().norm_squared();
    if square < 0.0 {
        return Vec::new();
    }
    [-along - square.sqrt(), -along + square.sqrt()].into_iter().filter(|range_km| *range_km > 0.0).collect()
}
