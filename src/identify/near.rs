//! Whose orbits lead past a streak: every satellite's plane and phase against one line of sight.
//!
//! A satellite on the line of sight at its own distance r from the Earth's centre stands at P. Its orbit plane must pass there, and it must be there
//! after a delay that its errors allow:
//!
//! ```text
//! beside = ĥ · P          Δu = atan2(P · (ĥ × r̂), P · r̂)          δ = -Δu r² / |r × v|
//! ```
//!
//! One SGP4 a satellite; a few in a thousand are left, and `compare` asks those exactly.

use nalgebra::Vector3;

use super::compare::Reach;
use super::streak::MeasuredStreak;
use crate::frames::{Direction, Gcrs, Position};
use crate::orbit::{Propagator, State};
use crate::passes::ExposureInterval;

/// Orbits with a greater eccentricity change distance and speed so much on the way that their place is stepped to.
const ROUND: f64 = 0.03;
/// How far J₂ and the radius of a nearly circular orbit may move the place that is asked for, km and share of the delay's way.
const SLOP_KM: f64 = 60.0;
const SLOP_SHARE: f64 = 0.05;
/// A place on an eccentric orbit is stepped to until it is this near, seconds, in at most so many steps.
const CLOSE_S: f64 = 1.0;
const MOST_STEPS: usize = 30;

/// First guesses of the delays with which a satellite comes by, seconds: none where it does not. An observer in orbit may see two places of one orbit in line.
pub(super) fn delays_s(
    interval: &ExposureInterval<'_>,
    element_index: usize,
    streak: &MeasuredStreak,
    reach: &Reach,
) -> Vec<f64> {
    let mid_s = 0.5 * interval.duration_s();
    let Some(propagator) = interval.propagator(element_index) else { return Vec::new() };
    let Ok(state) = interval.state(propagator, mid_s, 0.0) else { return Vec::new() };
    let observer = interval.observer(mid_s);
    let towards = streak.place();
    let (r, v) = (state.position.vector(), state.velocity.vector());
    let Some(normal) = r.cross(v).try_normalize(0.0) else { return Vec::new() };
    if interval.sky().elements()[element_index].eccentricity > ROUND {
        // The distance at which the line of sight meets the plane; its place on the orbit is stepped to.
        let range_km = -normal.dot(observer.vector()) / normal.dot(towards.vector());
        if !(range_km > 0.0 && range_km.is_finite()) {
            return Vec::new();
        }
        let place = observer.vector() + towards.vector() * range_km;
        return delay_on_eccentric(interval, propagator, &place, mid_s)
            .filter(|late_s| late_s.abs() <= reach.along_track_s + SLOP_KM)
            .into_iter()
            .collect();
    }
    let delay = |range_km: f64| {
        let place = observer.vector() + towards.vector() * range_km;
        let angle_rad = angle_to(&state, &place);
        let slop_km = SLOP_KM + SLOP_SHARE * angle_rad.abs() * r.norm();
        let late_s = -angle_rad * r.norm_squared() / r.cross(v).norm();
        let is_near = normal.dot(&place).abs() <= reach.cross_track_rad * range_km + slop_km
            && late_s.abs() <= reach.along_track_s + slop_km / v.norm();
        is_near.then_some(late_s)
    };
    ranges_km(&observer, &towards, r.norm()).into_iter().filter_map(delay).collect()
}

/// Angle along the orbit from the satellite to a place, (-π, π], radians.
fn angle_to(state: &State<Gcrs>, place: &Vector3<f64>) -> f64 {
    let radial = state.position.vector().normalize();
    let ahead = state.position.vector().cross(state.velocity.vector()).normalize().cross(&radial);
    place.dot(&ahead).atan2(place.dot(&radial))
}

/// The same for an orbit whose distance and speed change: stepped to with SGP4, each step by the angular speed of where it stands.
fn delay_on_eccentric(
    interval: &ExposureInterval<'_>,
    propagator: &Propagator,
    place: &Vector3<f64>,
    mid_s: f64,
) -> Option<f64> {
    let longest_s = 0.1 * propagator.period_s();
    let mut late_s = 0.0;
    for _ in 0..MOST_STEPS {
        let state = interval.state(propagator, mid_s, late_s).ok()?;
        let momentum = state.position.vector().cross(state.velocity.vector()).norm();
        let step_s = angle_to(&state, place) * state.position.vector().norm_squared() / momentum;
        late_s -= step_s.clamp(-longest_s, longest_s);
        if step_s.abs() < CLOSE_S {
            return Some(late_s);
        }
    }
    None
}

/// Where a line of sight meets a sphere about the Earth's centre, in front of the observer, km.
fn ranges_km(observer: &Position<Gcrs>, towards: &Direction<Gcrs>, radius_km: f64) -> Vec<f64> {
    // ρ = -O·d ± √((O·d)² + r² - O²)
    let along = observer.vector().dot(towards.vector());
    let square = along * along + radius_km * radius_km - observer.vector().norm_squared();
    if square < 0.0 {
        return Vec::new();
    }
    [-along - square.sqrt(), -along + square.sqrt()].into_iter().filter(|range_km| *range_km > 0.0).collect()
}
