//! The Earth's limb for an observer in space.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING};
use crate::frames::{Direction, Gcrs, Position};

/// Boundary of the region hidden by the Earth: the WGS84 ellipsoid, or a shell above it.
///
/// Stretching z by 1/(1 - f) makes the ellipsoid a sphere and keeps lines straight, so visibility is exact for height
/// 0. The z axis of GCRS is used as the Earth's axis (an error of 60 m in 2026).
#[derive(Copy, Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct EarthLimb {
    /// Height of the shell above the ellipsoid, km, at least 0: lines of sight that pass lower count as hidden.
    pub height_km: f64,
}

impl EarthLimb {
    fn radius_km(&self) -> f64 {
        EARTH_EQUATORIAL_RADIUS_KM + self.height_km
    }

    /// Returns the smallest height above the shell of the straight line between two positions, km. It is negative where
    /// the line passes below the shell or through the Earth.
    pub fn clearance_km(&self, observer: &Position<Gcrs>, target: &Position<Gcrs>) -> f64 {
        let (from, to) = (stretch(observer.vector()), stretch(target.vector()));
        let line = to - from;
        let nearest = (-from.dot(&line) / line.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        (from + line * nearest).norm() - self.radius_km()
    }

    /// Returns the height of a position above the ellipsoid, km, in the stretched space; above the poles it is too
    /// large by one part in 298.
    pub fn height_of_km(&self, observer: &Position<Gcrs>) -> f64 {
        stretch(observer.vector()).norm() - EARTH_EQUATORIAL_RADIUS_KM
    }

    /// Returns the angle between a direction and the limb in the plane of direction and Earth's centre, radians, in
    /// [-π/2, π]; negative where the line of sight meets the Earth. For an observer below the shell every direction is
    /// hidden, and the angle is -π/2.
    pub fn altitude_rad(&self, observer: &Position<Gcrs>, direction: &Direction<Gcrs>) -> f64 {
        let (down, ahead) = (-stretch(observer.vector()), stretch(direction.vector()));
        if down.norm() < self.radius_km() {
            return -FRAC_PI_2;
        }
        // The point of the limb in this plane, in the stretched space. At nadir and zenith the plane is any.
        let nadir = down.normalize();
        let any = if nadir.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let across = |vector: Vector3<f64>| (vector - nadir * vector.dot(&nadir)).try_normalize(1e-12);
        let side = across(ahead).or(across(any)).unwrap_or(any);
        let (sin, cos) = (self.radius_km() / down.norm()).asin().sin_cos();
        let edge = unstretch(&(nadir * cos + side * sin));
        let from_nadir_rad =
            |vector: &Vector3<f64>| vector.cross(observer.vector()).norm().atan2(-vector.dot(observer.vector()));
        from_nadir_rad(direction.vector()) - from_nadir_rad(&edge)
    }
}

fn stretch(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z / (1.0 - EARTH_FLATTENING))
}

fn unstretch(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z * (1.0 - EARTH_FLATTENING))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn up_down_and_over_the_limb() {
        let (limb, shell) = (EarthLimb::default(), EarthLimb { height_km: 100.0 });
        let observer = Position::new(6918.137, 0.0, 0.0);
        let dip_rad = (6378.137_f64 / 6918.137).asin();
        for (angle_rad, seen) in [(0.0, false), (dip_rad - 1e-9, false), (dip_rad + 1e-9, true), (3.0, true)] {
            let direction = Direction::from_lon_lat_rad(std::f64::consts::PI - angle_rad, 0.0);
            let altitude_rad = limb.altitude_rad(&observer, &direction);
            assert!((altitude_rad - (angle_rad - dip_rad)).abs() < 1e-12);
            let far = observer + direction.at_range(20_000.0);
            assert_eq!(limb.clearance_km(&observer, &far) > 0.0, seen);
            assert!(shell.altitude_rad(&observer, &direction) < altitude_rad);
        }
        // A target between observer and Earth is seen against it.
        assert!(limb.clearance_km(&observer, &Position::new(6600.0, 0.0, 0.0)) > 0.0);
        // From below the shell every direction is hidden, and all angles are in range.
        assert!((limb.height_of_km(&observer) - 540.0).abs() < 1e-9);
        for longitude_rad in [0.0, 1.0, std::f64::consts::PI] {
            let up = Direction::from_lon_lat_rad(longitude_rad, 0.0);
            assert_eq!(EarthLimb { height_km: 700.0 }.altitude_rad(&observer, &up), -FRAC_PI_2);
        }
    }

    /// A telescope over the pole sees the limb at the meridian's ellipse: x²/a² + z²/b² = 1 has the tangent through
    /// (0, h) with the slope √(h² - b²) / a.
    #[test]
    fn angles_from_the_limb_are_those_on_the_sky() {
        let polar_km = EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING);
        let observer = Position::new(0.0, 0.0, polar_km + 700.0);
        let slope = ((polar_km + 700.0).powi(2) - polar_km.powi(2)).sqrt() / EARTH_EQUATORIAL_RADIUS_KM;
        for latitude_deg in [-80.0_f64, -30.0, 0.0, 30.0, 80.0] {
            let direction = Direction::from_lon_lat_rad(0.7, latitude_deg.to_radians());
            let altitude_rad = EarthLimb::default().altitude_rad(&observer, &direction);
            assert!((altitude_rad - (latitude_deg.to_radians() + slope.atan())).abs() < 1e-12, "{latitude_deg}");
        }
        // The zenith is 90° + atan(slope) from the limb in every plane.
        let up = Direction::from_vector(Vector3::z());
        let altitude_rad = EarthLimb::default().altitude_rad(&observer, &up);
        assert!((altitude_rad - (FRAC_PI_2 + slope.atan())).abs() < 1e-12);
    }

    proptest! {
        /// Compares with points along the line, tested by the ellipsoid's equation.
        #[test]
        fn verif_hidden_lines_meet_the_ellipsoid(
            a in prop::array::uniform3(-1.0..1.0f64), b in prop::array::uniform3(-1.0..1.0f64), high in 6800.0..9000.0f64, far in 6800.0..40_000.0f64,
        ) {
            let (a, b) = (Vector3::from(a), Vector3::from(b));
            prop_assume!(a.norm() > 0.1 && b.norm() > 0.1);
            let (a, b) = (a.normalize() * high, b.normalize() * far);
            let polar_km = EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING);
            let level = |p: Vector3<f64>| (p.x.hypot(p.y) / EARTH_EQUATORIAL_RADIUS_KM).hypot(p.z / polar_km);
            let lowest = (0..=4000).map(|step| level(a + (b - a) * (f64::from(step) / 4000.0))).fold(f64::INFINITY, f64::min);
            let clearance_km = EarthLimb::default().clearance_km(&Position::from_vector(a), &Position::from_vector(b));
            // Steps of s = 12 km miss the lowest point by up to s²/8r.
            let step_km = (b - a).norm() / 4000.0;
            let missed_km = step_km * step_km / (8.0 * EARTH_EQUATORIAL_RADIUS_KM * lowest.max(1e-6));
            let sampled_km = (lowest - 1.0) * EARTH_EQUATORIAL_RADIUS_KM;
            prop_assert!((clearance_km - sampled_km).abs() < 0.001 + 1.1 * missed_km, "{clearance_km} {sampled_km}");
        }
    }
}
