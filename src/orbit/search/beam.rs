//! Straight tracks past a cone: the interval in which an object in uniform motion may be inside.

use nalgebra::Vector3;

/// Cone radius beyond which the path is bounded by a ball, radians.
const WIDE_RAD: f64 = 0.5;

/// A cone of directions about an axis, in any frame.
#[derive(Clone, Debug)]
pub struct Beam {
    axis: Vector3<f64>,
    radius_rad: f64,
    tangent: f64,
    secant: f64,
}

impl Beam {
    /// Creates a cone about a unit vector.
    pub fn new(axis: Vector3<f64>, radius_rad: f64) -> Self {
        Self { axis, radius_rad, tangent: radius_rad.tan(), secant: 1.0 / radius_rad.cos() }
    }

    /// Returns the unit vector.
    pub fn axis(&self) -> &Vector3<f64> {
        &self.axis
    }

    /// Returns the half opening angle, radians.
    pub fn radius_rad(&self) -> f64 {
        self.radius_rad
    }

    /// Returns the interval, seconds, in which an object may be inside the cone; `None` where it cannot be. The object
    /// is at `sight_km` from the observer at time 0 and moves uniformly for `half_s` before and after, with a position
    /// error of `slop_km`.
    ///
    /// The times are not clamped to `half_s`.
    #[inline]
    pub fn near_s(
        &self,
        sight_km: &Vector3<f64>,
        velocity_km_s: &Vector3<f64>,
        half_s: f64,
        slop_km: f64,
    ) -> Option<[f64; 2]> {
        if self.radius_rad > WIDE_RAD {
            // The whole path as a ball around its middle.
            let (distance_km, reach_km) = (sight_km.norm(), slop_km + velocity_km_s.norm() * half_s);
            let angle_rad = sight_km.cross(&self.axis).norm().atan2(sight_km.dot(&self.axis));
            let is_near = distance_km <= reach_km || angle_rad <= self.radius_rad + (reach_km / distance_km).asin();
            return is_near.then_some([-half_s, half_s]);
        }
        // A straight line past the axis: the least distance across against the width at the greatest depth. A ball of
        // radius s at the cone's edge touches it s / cos ψ across.
        let (depth, depth_rate) = (sight_km.dot(&self.axis), velocity_km_s.dot(&self.axis));
        let deepest_km = depth + depth_rate.abs() * half_s + slop_km;
        if deepest_km < 0.0 {
            return None;
        }
        let (across, across_rate) = (sight_km - self.axis * depth, velocity_km_s - self.axis * depth_rate);
        let rate2 = across_rate.norm_squared().max(1e-12);
        let nearest_s = -across.dot(&across_rate) / rate2;
        let width_km = deepest_km * self.tangent + slop_km * self.secant;
        let missed_km2 = |time_s: f64| (across + across_rate * time_s).norm_squared();
        if missed_km2(nearest_s.clamp(-half_s, half_s)) > width_km * width_km {
            return None;
        }
        // |across + rate t| ≤ width
        let about_s = ((width_km * width_km - missed_km2(nearest_s)).max(0.0) / rate2).sqrt();
        Some([nearest_s - about_s, nearest_s + about_s])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_near_while_they_are_within_the_width() {
        // 1000 km away, past the axis at 20 km, 7 km/s: the cone is 17.5 km wide there, with 10 km of margin.
        let beam = Beam::new(Vector3::z(), 1f64.to_radians());
        let (sight, velocity) = (Vector3::new(-70.0, 20.0, 1000.0), Vector3::new(7.0, 0.0, 0.0));
        let [from_s, to_s] = beam.near_s(&sight, &velocity, 30.0, 10.0).expect("near");
        let width_km = 1010.0 * 1f64.to_radians().tan() + 10.0 / 1f64.to_radians().cos();
        let half_s = (width_km * width_km - 400.0).sqrt() / 7.0;
        assert!((from_s - (10.0 - half_s)).abs() < 1e-9 && (to_s - (10.0 + half_s)).abs() < 1e-9, "{from_s} {to_s}");
        assert_eq!(beam.near_s(&sight, &velocity, 30.0, 1.0), None);
        // The object is there only 10 s later, and not behind the observer.
        assert_eq!(beam.near_s(&sight, &velocity, 4.0, 10.0), None);
        assert_eq!(beam.near_s(&-sight, &velocity, 30.0, 10.0), None);
        let wide = Beam::new(Vector3::z(), 1.0);
        assert_eq!(wide.near_s(&sight, &velocity, 30.0, 10.0), Some([-30.0, 30.0]));
        assert_eq!(wide.near_s(&-sight, &velocity, 30.0, 10.0), None);
    }
}
