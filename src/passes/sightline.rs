//! One satellite seen from one observer over a stretch of time: the smooth track that crossings are cut from.

use nalgebra::Vector3;

use super::crossing::Sight;
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::frames::{Gcrs, Orientation, Position, Velocity};
use crate::geometry::{Aspect, Observer, aspect};
use crate::orbit::{Arc, State};

/// A site among the stars near one moment: it turns about the pole of date at the Earth's rate.
///
/// Exact to a millimetre over ten minutes: only the rates of precession, polar motion and UT1 are left out.
#[derive(Copy, Clone, Debug)]
pub(super) struct SiteMotion {
    at_s: f64,
    fixed: Vector3<f64>,
    turning: Vector3<f64>,
    ahead: Vector3<f64>,
    /// Earth's barycentric velocity, for the aspect.
    earth_velocity: Velocity<Gcrs>,
    /// Times before and after which it stands still, seconds.
    moving_s: (f64, f64),
}

impl SiteMotion {
    pub fn new(observer: &Observer, orientation: &Orientation, earth_velocity: Velocity<Gcrs>, at_s: f64) -> Self {
        let place = *observer.position(orientation).vector();
        let pole: Vector3<f64> = orientation.teme_to_gcrs.matrix().column(2).into_owned();
        let fixed = pole * pole.dot(&place);
        Self {
            at_s,
            fixed,
            turning: place - fixed,
            ahead: pole.cross(&place),
            earth_velocity,
            moving_s: (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    /// The same site, standing still before the first and after the second of two times.
    pub fn still_outside(self, from_s: f64, to_s: f64) -> Self {
        Self { moving_s: (from_s, to_s), ..self }
    }

    /// How far the Earth has turned since the moment of reference, radians.
    fn turn_rad(&self, time_s: f64) -> f64 {
        EARTH_ROTATION_RAD_S * (time_s.max(self.moving_s.0).min(self.moving_s.1) - self.at_s)
    }

    pub fn position(&self, time_s: f64) -> Position<Gcrs> {
        let (sin, cos) = self.turn_rad(time_s).sin_cos();
        Position::from_vector(self.fixed + self.turning * cos + self.ahead * sin)
    }

    fn velocity(&self, time_s: f64) -> Vector3<f64> {
        let (sin, cos) = self.turn_rad(time_s).sin_cos();
        (self.ahead * cos - self.turning * sin) * EARTH_ROTATION_RAD_S
    }

    /// Speed, km/s.
    pub fn speed_km_s(&self) -> f64 {
        self.ahead.norm() * EARTH_ROTATION_RAD_S
    }
}

/// A satellite's arc and the site it is seen from.
pub(super) struct SightLine<'a> {
    pub arc: &'a Arc,
    pub site: SiteMotion,
}

impl SightLine<'_> {
    /// Satellite state, site and aspect at one moment.
    pub fn aspect_at(&self, time_s: f64) -> (State<Gcrs>, Position<Gcrs>, Aspect) {
        let state = self.arc.state_at(time_s);
        let site = self.site.position(time_s);
        let aspect = aspect(&state.position, &state.velocity, &site, &self.site.earth_velocity);
        (state, site, aspect)
    }

    /// The astrometric line of sight and its rate. The rate leaves out how light time itself changes (10⁻⁴ of the rate), which
    /// moves no border and no extreme by more than the rounding of a root.
    pub fn sight(&self, time_s: f64) -> Sight {
        let (state, _, aspect) = self.aspect_at(time_s);
        let relative = state.velocity.vector() - self.site.velocity(time_s);
        Sight { vector: *aspect.direction.vector(), rate_s: relative / aspect.range_km }
    }
}
