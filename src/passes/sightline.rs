//! One satellite seen from one observer over a stretch of time: the smooth track that crossings are cut from.

use std::sync::Arc as Shared;

use nalgebra::Vector3;

use super::crossing::Sight;
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::frames::{Gcrs, Orientation, Position, Velocity};
use crate::geometry::{Aspect, Observer, aspect};
use crate::orbit::{Arc, State};

/// How an observer moves among the stars: a site near one moment, a telescope in orbit over the stretch of its arc.
#[derive(Clone, Debug)]
pub(super) struct ObserverMotion {
    path: Path,
    /// Earth's barycentric velocity, for the aspect.
    earth_velocity: Velocity<Gcrs>,
    /// Times before and after which it stands still, seconds.
    moving_s: (f64, f64),
}

#[derive(Clone, Debug)]
enum Path {
    /// A site turns about the pole of date at the Earth's rate.
    ///
    /// Exact to a millimetre over ten minutes: only the rates of precession, polar motion and UT1 are left out.
    Turning { at_s: f64, fixed: Vector3<f64>, turning: Vector3<f64>, ahead: Vector3<f64> },
    /// A telescope flies.
    Flying(Shared<Arc>),
}

impl ObserverMotion {
    /// A site near `at_s`.
    pub fn of_site(observer: &Observer, orientation: &Orientation, earth_velocity: Velocity<Gcrs>, at_s: f64) -> Self {
        let place = *observer.position(orientation).vector();
        let pole: Vector3<f64> = orientation.teme_to_gcrs.matrix().column(2).into_owned();
        let fixed = pole * pole.dot(&place);
        let path = Path::Turning { at_s, fixed, turning: place - fixed, ahead: pole.cross(&place) };
        Self { path, earth_velocity, moving_s: (f64::NEG_INFINITY, f64::INFINITY) }
    }

    /// A telescope on its arc.
    pub fn of_flight(arc: Shared<Arc>, earth_velocity: Velocity<Gcrs>) -> Self {
        Self { path: Path::Flying(arc), earth_velocity, moving_s: (f64::NEG_INFINITY, f64::INFINITY) }
    }

    /// The same observer, standing still before the first and after the second of two times.
    pub fn still_outside(&self, from_s: f64, to_s: f64) -> Self {
        Self { moving_s: (from_s, to_s), ..self.clone() }
    }

    fn own_time_s(&self, time_s: f64) -> f64 {
        time_s.max(self.moving_s.0).min(self.moving_s.1)
    }

    pub fn position(&self, time_s: f64) -> Position<Gcrs> {
        let time_s = self.own_time_s(time_s);
        match &self.path {
            Path::Turning { at_s, fixed, turning, ahead } => {
                let (sin, cos) = (EARTH_ROTATION_RAD_S * (time_s - at_s)).sin_cos();
                Position::from_vector(fixed + turning * cos + ahead * sin)
            }
            Path::Flying(arc) => arc.state_at(time_s).position,
        }
    }

    /// Its velocity, km/s; while it stands still, that with which it came or will go on.
    pub fn velocity(&self, time_s: f64) -> Vector3<f64> {
        let time_s = self.own_time_s(time_s);
        match &self.path {
            Path::Turning { at_s, turning, ahead, .. } => {
                let (sin, cos) = (EARTH_ROTATION_RAD_S * (time_s - at_s)).sin_cos();
                (ahead * cos - turning * sin) * EARTH_ROTATION_RAD_S
            }
            Path::Flying(arc) => *arc.state_at(time_s).velocity.vector(),
        }
    }

    /// Line of sight to a satellite and its rate, as it runs: without the observer's own motion while it stands still.
    pub fn sight_of(&self, state: &State<Gcrs>, time_s: f64) -> Sight {
        let seen = aspect(&state.position, &state.velocity, &self.position(time_s), &self.earth_velocity);
        let moves = self.own_time_s(time_s) == time_s;
        let own = if moves { self.velocity(time_s) } else { Vector3::zeros() };
        Sight { vector: *seen.direction.vector(), rate_s: (state.velocity.vector() - own) / seen.range_km }
    }

    /// No mean speed away from where it is at `mid_s` is greater within `half_s` of it, km/s.
    pub fn fastest_km_s(&self, mid_s: f64, half_s: f64) -> f64 {
        match &self.path {
            Path::Turning { ahead, .. } => ahead.norm() * EARTH_ROTATION_RAD_S,
            // |Δr| ≤ v t + ½ g t²
            Path::Flying(_) => self.velocity(mid_s).norm() + 0.5 * GRAVITY_KM_S2 * half_s,
        }
    }
}

/// No orbit falls faster, km/s²: gravity at the ground.
const GRAVITY_KM_S2: f64 = 0.009_83;

/// A satellite's arc and the observer it is seen from.
pub(super) struct SightLine<'a> {
    pub arc: &'a Arc,
    pub observer: ObserverMotion,
}

impl SightLine<'_> {
    /// Satellite state, observer and aspect at one moment.
    pub fn aspect_at(&self, time_s: f64) -> (State<Gcrs>, Position<Gcrs>, Aspect) {
        self.aspect_of_late(time_s, 0.0)
    }

    /// As [`SightLine::aspect_at`], the satellite being where it was predicted `late_s` earlier.
    fn aspect_of_late(&self, time_s: f64, late_s: f64) -> (State<Gcrs>, Position<Gcrs>, Aspect) {
        let state = self.arc.state_at(time_s - late_s);
        let place = self.observer.position(time_s);
        let aspect = aspect(&state.position, &state.velocity, &place, &self.observer.earth_velocity);
        (state, place, aspect)
    }

    /// The astrometric line of sight and its rate. The rate leaves out how light time itself changes (10⁻⁴ of the rate), which
    /// moves no border and no extreme by more than the rounding of a root.
    pub fn sight(&self, time_s: f64) -> Sight {
        self.sight_of_late(time_s, 0.0)
    }

    /// As [`SightLine::sight`], the satellite being late.
    pub fn sight_of_late(&self, time_s: f64, late_s: f64) -> Sight {
        let (state, _, aspect) = self.aspect_of_late(time_s, late_s);
        let relative = state.velocity.vector() - self.observer.velocity(time_s);
        Sight { vector: *aspect.direction.vector(), rate_s: relative / aspect.range_km }
    }
}
