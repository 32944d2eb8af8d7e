//! Two-body arithmetic: when a satellite comes to a direction in its plane, and where it falls within a minute.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use crate::constants::WGS72_MU_KM3_S2;
use crate::frames::{Gcrs, Position, Velocity};
use crate::orbit::State;

/// An osculating ellipse, and where on it the satellite is.
pub(super) struct TwoBody {
    position: Vector3<f64>,
    normal: Vector3<f64>,
    /// Towards the perigee, as long as the eccentricity.
    eccentricity: Vector3<f64>,
    mean_motion_rad_s: f64,
}

impl TwoBody {
    /// `None` for an orbit that is not closed.
    pub fn of(position: &Vector3<f64>, velocity: &Vector3<f64>) -> Option<Self> {
        let momentum = position.cross(velocity);
        let radius_km = position.norm();
        // vis viva: 1/a = 2/r - v²/μ
        let axis_km = 1.0 / (2.0 / radius_km - velocity.norm_squared() / WGS72_MU_KM3_S2);
        let eccentricity = velocity.cross(&momentum) / WGS72_MU_KM3_S2 - position / radius_km;
        (axis_km > 0.0 && eccentricity.norm() < 1.0).then(|| Self {
            position: *position,
            normal: momentum.normalize(),
            eccentricity,
            mean_motion_rad_s: (WGS72_MU_KM3_S2 / axis_km.powi(3)).sqrt(),
        })
    }

    pub fn period_s(&self) -> f64 {
        TAU / self.mean_motion_rad_s
    }

    /// Mean anomaly of a direction in the plane, radians.
    fn mean_anomaly_rad(&self, direction: &Vector3<f64>) -> f64 {
        let e = self.eccentricity.norm();
        // A circle has no perigee; any direction will do.
        let x_axis = if e > 1e-9 { self.eccentricity / e } else { self.position.normalize() };
        let y_axis = self.normal.cross(&x_axis);
        let (x, y) = (direction.dot(&x_axis), direction.dot(&y_axis));
        let radius = x.hypot(y);
        // tan E = √(1 - e²) sin ν / (e + cos ν), M = E - e sin E
        let eccentric_rad = ((1.0 - e * e).sqrt() * y).atan2(e * radius + x);
        eccentric_rad - e * eccentric_rad.sin()
    }

    /// Time to the direction of a target, the shorter way round, seconds.
    pub fn time_to_s(&self, target: &Vector3<f64>) -> f64 {
        let turn_rad = self.mean_anomaly_rad(target) - self.mean_anomaly_rad(&self.position);
        ((turn_rad + PI).rem_euclid(TAU) - PI) / self.mean_motion_rad_s
    }
}

/// The fall from one state, as a series in time.
pub(super) struct FreeFall {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    jerk: Vector3<f64>,
}

impl FreeFall {
    pub fn of(state: &State<Gcrs>) -> Self {
        let (position, velocity) = (*state.position.vector(), *state.velocity.vector());
        let square = position.norm_squared();
        // r̈ = -μ r / r³, and its derivative -μ (v / r³ - 3 r (r·v) / r⁵)
        let strength = -WGS72_MU_KM3_S2 / (square * square.sqrt());
        let acceleration = position * strength;
        let jerk = (velocity - position * (3.0 * position.dot(&velocity) / square)) * strength;
        Self { position, velocity, acceleration, jerk }
    }

    /// After (or before) some seconds. The next term of the series is r (ω t)⁴/24, 5 m in half a minute of a low orbit; the Earth's flattening
    /// does ½ · 10⁻⁵ km/s² · t², as much.
    pub fn state_at(&self, time_s: f64) -> State<Gcrs> {
        let velocity = self.velocity + (self.acceleration + self.jerk * (0.5 * time_s)) * time_s;
        let position =
            self.position + (self.velocity + (self.acceleration * 0.5 + self.jerk * (time_s / 6.0)) * time_s) * time_s;
        State { position: Position::from_vector(position), velocity: Velocity::from_vector(velocity) }
    }
}
