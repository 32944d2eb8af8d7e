//! A cone inside the Earth's shadow, in which no satellite is lit.

use nalgebra::Vector3;

use crate::frames::{Direction, Gcrs, Rotation, Teme};

/// A cone about the anti-solar direction, starting at the Earth's centre, in which no satellite is lit.
#[derive(Copy, Clone, Debug)]
pub struct ShadowCone {
    /// Axis, from the Earth's centre.
    pub away_from_sun: Direction<Gcrs>,
    /// Radius at the Earth's centre, km.
    pub radius_km: f64,
    /// Decrease of the radius, km per km of depth.
    pub narrowing: f64,
}

/// The same cone in the frame of a window.
pub(super) struct ShadowConeInTeme {
    away_from_sun: Vector3<f64>,
    radius_km: f64,
    narrowing: f64,
}

impl ShadowCone {
    pub(super) fn in_teme(&self, teme_to_gcrs: &Rotation<Teme, Gcrs>) -> ShadowConeInTeme {
        let away_from_sun = *(teme_to_gcrs.inverse() * self.away_from_sun).vector();
        ShadowConeInTeme { away_from_sun, radius_km: self.radius_km, narrowing: self.narrowing }
    }
}

impl ShadowConeInTeme {
    /// Returns whether all positions within `slop_km` of one lie inside.
    pub fn holds(&self, position: &Vector3<f64>, slop_km: f64) -> bool {
        let depth_km = position.dot(&self.away_from_sun);
        let across_km = (position - self.away_from_sun * depth_km).norm();
        // The cone's side is steeper than 45 degrees: a step along it matters less than one across.
        depth_km > slop_km && across_km + slop_km < self.radius_km - self.narrowing * (depth_km + slop_km)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_is_inside_only_with_its_whole_error() {
        let shadow = ShadowConeInTeme { away_from_sun: Vector3::x(), radius_km: 6300.0, narrowing: 0.01 };
        let at = |depth_km: f64, across_km: f64| Vector3::new(depth_km, 0.6 * across_km, -0.8 * across_km);
        assert!(shadow.holds(&at(3000.0, 6100.0), 50.0));
        assert!(!shadow.holds(&at(3000.0, 6100.0), 200.0));
        assert!(!shadow.holds(&at(20_000.0, 6150.0), 0.0));
        // On the sunlit side of the Earth's centre, or nearly.
        assert!(!shadow.holds(&at(-3000.0, 100.0), 0.0));
        assert!(!shadow.holds(&at(40.0, 100.0), 50.0));
    }
}
