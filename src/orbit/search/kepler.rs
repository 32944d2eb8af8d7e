//! Slowly varying elements of a satellite, interpolated over a window, and its position by Kepler's equation.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use nalgebra::Vector3;

use super::super::state::State;
use crate::constants::WGS72_MU_KM3_S2;
use crate::frames::Teme;

/// Osculating elements. The x axis of the orbit plane is the projection of a reference vector into the plane.
#[derive(Copy, Clone, Debug)]
pub(super) struct SlowElements {
    /// Unit normal of the orbit plane.
    pub normal: Vector3<f64>,
    /// Mean longitude from the x axis, radians.
    pub mean_longitude_rad: f64,
    /// Components of the eccentricity vector in the orbit plane.
    pub eccentricity: [f64; 2],
    /// Semi-major axis, km.
    pub semi_major_axis_km: f64,
}

/// Returns the x axis of the orbit plane: `reference` minus its component along the normal. It is a unit vector if the
/// reference lies in the plane.
pub(super) fn plane_axis(reference: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
    reference - normal * reference.dot(normal)
}

impl SlowElements {
    /// Computes the elements from a position and velocity; `None` if the orbit is not closed.
    pub fn from_state(state: &State<Teme>, reference: &Vector3<f64>) -> Option<Self> {
        let (r, v) = (state.position.vector(), state.velocity.vector());
        let radius = r.norm();
        let momentum = r.cross(v);
        let normal = momentum / momentum.norm();
        // vis viva: 1/a = 2/r - v²/μ
        let semi_major_axis_km = 1.0 / (2.0 / radius - v.norm_squared() / WGS72_MU_KM3_S2);
        let eccentricity_vector = v.cross(&momentum) / WGS72_MU_KM3_S2 - r / radius;
        let x_axis = plane_axis(reference, &normal).normalize();
        let y_axis = normal.cross(&x_axis);
        let (k, h) = (eccentricity_vector.dot(&x_axis), eccentricity_vector.dot(&y_axis));
        let e2 = k * k + h * h;
        if !(semi_major_axis_km > 0.0 && e2 < 1.0) {
            return None;
        }
        // Equinoctial eccentric longitude F from the position (Broucke & Cefola 1972), then Kepler's equation: λ = F +
        // h cos F - k sin F
        let root = (1.0 - e2).sqrt();
        let beta = 1.0 / (1.0 + root);
        let (x, y) = (r.dot(&x_axis) / semi_major_axis_km, r.dot(&y_axis) / semi_major_axis_km);
        let cos_f = k + ((1.0 - k * k * beta) * x - h * k * beta * y) / root;
        let sin_f = h + ((1.0 - h * h * beta) * y - h * k * beta * x) / root;
        let mean_longitude_rad = sin_f.atan2(cos_f) + h * cos_f - k * sin_f;
        Some(Self { normal, mean_longitude_rad, eccentricity: [k, h], semi_major_axis_km })
    }

    /// Returns the mean motion, rad/s.
    pub fn mean_motion_rad_s(&self) -> f64 {
        (WGS72_MU_KM3_S2 / self.semi_major_axis_km.powi(3)).sqrt()
    }
}

/// Returns position and velocity in the orbit plane, km and km/s, from mean longitude, eccentricity vector and
/// semi-major axis. The position is accurate to 10⁻⁵ of the semi-major axis, and better for small eccentricities.
pub(super) fn plane_state(mean_longitude_rad: f64, [k, h]: [f64; 2], semi_major_axis_km: f64) -> ([f64; 2], [f64; 2]) {
    // Kepler's equation λ = F + h cos F - k sin F is solved by Newton's method. For small steps, sine and cosine of F
    // are updated by rotation, which is faster than evaluating them.
    let mut f = mean_longitude_rad;
    let (mut sin_f, mut cos_f) = sin_cos(f);
    for _ in 0..12 {
        let step = (mean_longitude_rad - f - h * cos_f + k * sin_f) / (1.0 - h * sin_f - k * cos_f);
        // Near e = 1 a full Newton step can overshoot.
        let step = step.clamp(-0.95, 0.95);
        f += step;
        if step.abs() < 0.05 {
            let square = step * step;
            let sin = step * (1.0 - square / 6.0 * (1.0 - square / 20.0));
            let cos = 1.0 - 0.5 * square * (1.0 - square / 12.0 * (1.0 - square / 30.0));
            (sin_f, cos_f) = (sin_f * cos + cos_f * sin, cos_f * cos - sin_f * sin);
        } else {
            (sin_f, cos_f) = sin_cos(f);
        }
        // Newton's method converges quadratically, so the remaining error is below e/2 · 10⁻⁵.
        if step.abs() < 3e-3 {
            break;
        }
    }
    let root = (1.0 - k * k - h * h).max(0.0).sqrt();
    let beta = 1.0 / (1.0 + root);
    let a = semi_major_axis_km;
    let x = a * ((1.0 - h * h * beta) * cos_f + h * k * beta * sin_f - k);
    let y = a * ((1.0 - k * k * beta) * sin_f + h * k * beta * cos_f - h);
    // a dF/dt = n a² / r = √(μ/a) / (1 - k cos F - h sin F)
    let rate = (WGS72_MU_KM3_S2 / a).sqrt() / (1.0 - k * cos_f - h * sin_f);
    let u = rate * (h * k * beta * cos_f - (1.0 - h * h * beta) * sin_f);
    let v = rate * ((1.0 - k * k * beta) * cos_f - h * k * beta * sin_f);
    ([x, y], [u, v])
}

/// Returns sine and cosine to 4·10⁻⁷. The first omitted terms are x⁹/9! and x¹⁰/10!, where x is at most π/4.
#[inline(always)]
pub(super) fn sin_cos(angle_rad: f64) -> (f64, f64) {
    /// 1.5 · 2⁵²: the sum of this and a smaller number is rounded to an integer, which is found in the lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let shifted = angle_rad * FRAC_2_PI + ROUND;
    let quarters = shifted - ROUND;
    let x = angle_rad - quarters * FRAC_PI_2;
    let square = x * x;
    let sin = x * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0))));
    let cos = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40_320.0))));
    match shifted.to_bits() & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Slowly varying elements of one satellite over a window, and the margins of its search.
#[derive(Copy, Clone, Debug)]
pub(super) struct Phase {
    pub element_index: u32,
    pub reference: [f32; 3],
    pub mean_longitude_rad: f64,
    pub mean_longitude_rate_rad_s: f64,
    pub eccentricity: [f32; 2],
    pub eccentricity_change: [f32; 2],
    pub semi_major_axis_km: f32,
    pub semi_major_axis_change_km: f32,
    /// Largest error of the interpolated position plus the search distance across the track, km.
    pub slop_km: f32,
    /// Largest delay along the track that is searched, seconds.
    pub along_track_s: f32,
    /// Largest difference between true and mean longitude, radians.
    pub swing_rad: f32,
    /// True if strong drag or an extreme eccentricity makes the interpolated position too inaccurate. SGP4 is then
    /// evaluated whenever the satellite passes the plane test.
    pub only_plane: bool,
}

impl Phase {
    /// Returns the components of the eccentricity vector, and the semi-major axis, km.
    fn shape(&self, fraction: f64) -> ([f64; 2], f64) {
        let eccentricity = [0, 1]
            .map(|axis| f64::from(self.eccentricity[axis]) + fraction * f64::from(self.eccentricity_change[axis]));
        let semi_major_axis_km =
            f64::from(self.semi_major_axis_km) + fraction * f64::from(self.semi_major_axis_change_km);
        (eccentricity, semi_major_axis_km)
    }

    /// Returns the distance of the perigee from the Earth's centre, km.
    pub fn perigee_km(&self, fraction: f64) -> f64 {
        let ([k, h], semi_major_axis_km) = self.shape(fraction);
        semi_major_axis_km * (1.0 - k.hypot(h))
    }

    /// Returns the interpolated position and velocity in TEME, km and km/s. The reference vector turns with the plane
    /// by a degree or two and is not normalised again.
    pub fn state(&self, normal: &Vector3<f64>, time_s: f64, fraction: f64) -> (Vector3<f64>, Vector3<f64>) {
        let [rx, ry, rz] = self.reference;
        let x_axis = plane_axis(&Vector3::new(f64::from(rx), f64::from(ry), f64::from(rz)), normal);
        let y_axis = normal.cross(&x_axis);
        let (eccentricity, semi_major_axis_km) = self.shape(fraction);
        let longitude_rad = self.mean_longitude_rad + self.mean_longitude_rate_rad_s * time_s;
        let ([x, y], [u, v]) = plane_state(longitude_rad, eccentricity, semi_major_axis_km);
        (x_axis * x + y_axis * y, x_axis * u + y_axis * v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Position, Velocity};

    #[test]
    fn verif_sine_and_cosine_are_within_their_error() {
        for step in -40_000..40_000 {
            let angle_rad = f64::from(step) * 1e-3;
            let (sin, cos) = sin_cos(angle_rad);
            assert!((sin - angle_rad.sin()).abs() < 4e-7 && (cos - angle_rad.cos()).abs() < 4e-7, "{angle_rad}");
        }
    }

    /// A state turned into slow elements and back is the same state, for circular, equatorial, retrograde and eccentric
    /// orbits.
    #[test]
    fn verif_state_round_trip() {
        let cases = [
            (Vector3::new(6900.0, 100.0, -300.0), Vector3::new(0.3, 5.0, 5.6)),
            (Vector3::new(42_164.0, 0.0, 0.0), Vector3::new(0.0, 3.0747, 0.0)),
            (Vector3::new(-7000.0, 500.0, 0.0), Vector3::new(1.0, 9.0, 0.5)),
            (Vector3::new(7000.0, 0.0, 0.0), Vector3::new(0.0, -1.0, 7.4)),
        ];
        for (r, v) in cases {
            let state = State { position: Position::from_vector(r), velocity: Velocity::from_vector(v) };
            let reference = Vector3::new(0.3, -0.8, 0.2);
            let slow = SlowElements::from_state(&state, &reference).expect("a closed orbit");
            let ([x, y], [u, w]) = plane_state(slow.mean_longitude_rad, slow.eccentricity, slow.semi_major_axis_km);
            let x_axis = plane_axis(&reference, &slow.normal).normalize();
            let y_axis = slow.normal.cross(&x_axis);
            assert!((x_axis * x + y_axis * y - r).norm() < 1e-5 * r.norm(), "{r}");
            assert!((x_axis * u + y_axis * w - v).norm() < 1e-5 * v.norm(), "{v}");
        }
    }
}
