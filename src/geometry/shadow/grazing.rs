//! Height above the ground of the straight line from the Sun to a satellite, by which Lu (2024) selects photometry.

use nalgebra::Vector3;

use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING};
use crate::frames::{Gcrs, Position};

/// Kármán line, km: in Lu (2024), section 3.1, a satellite is in shadow where the line to the Sun passes lower than
/// this.
pub const KARMAN_LINE_KM: f64 = 100.0;

/// Returns the lowest height above the WGS84 ellipsoid, km, of the straight line from the Sun's centre to a satellite;
/// negative where the line crosses the Earth. `None` where the satellite itself is the lowest point, with the Earth
/// behind it.
///
/// Heights are those of similar ellipsoidal shells, within 0.4 % of the geodetic height at 100 km.
pub fn grazing_height_km(satellite: &Position<Gcrs>, sun: &Position<Gcrs>) -> Option<f64> {
    let stretch = |v: &Vector3<f64>| Vector3::new(v.x, v.y, v.z / (1.0 - EARTH_FLATTENING));
    let position = stretch(satellite.vector());
    let to_sun = stretch(sun.vector()) - position;
    // Lowest at t = -r·s/s² along the line, if t is positive.
    let ahead = -position.dot(&to_sun) / to_sun.norm_squared();
    (0.0..=1.0).contains(&ahead).then(|| {
        let lowest = position + to_sun * ahead;
        let equatorial_km = lowest.norm() - EARTH_EQUATORIAL_RADIUS_KM;
        // Scale back: radii shrink towards the poles by the flattening.
        let sine = lowest.z / lowest.norm();
        equatorial_km * (1.0 - EARTH_FLATTENING * sine * sine)
    })
}

/// Returns true where the line from the Sun's centre to the satellite passes above 100 km or has no lowest point. Lu
/// (2024) selects photometry by this rule. The rule ignores the size of the Sun's disk; use it only to select data.
pub fn sunlit_by_100_km_rule(satellite: &Position<Gcrs>, sun: &Position<Gcrs>) -> bool {
    grazing_height_km(satellite, sun).is_none_or(|height_km| height_km >= KARMAN_LINE_KM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::AU_KM;

    #[test]
    fn lines_over_equator_and_pole_have_their_clearance() {
        let sun = Position::new(AU_KM, 0.0, 0.0);
        let polar = EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING);
        for (axis, radius) in
            [(Vector3::y(), EARTH_EQUATORIAL_RADIUS_KM), (Vector3::z(), polar), (-Vector3::z(), polar)]
        {
            for height_km in [-20.0, 0.0, 99.0, 101.0, 400.0] {
                // Behind the Earth, on the line from the Sun's centre tangent to this height.
                let touch = axis * (radius + height_km);
                let from_sun = touch - sun.vector();
                let satellite = Position::from_vector(touch + from_sun.normalize() * 2600.0);
                let found = grazing_height_km(&satellite, &sun).expect("a lowest point");
                // The lowest point is 0.3 km from the one above the pole, and heights are accurate to 0.4 %.
                assert!((found - height_km).abs() < 0.01 + 0.004 * height_km.abs(), "{axis} {height_km}: {found}");
                assert_eq!(sunlit_by_100_km_rule(&satellite, &sun), height_km > 100.0);
            }
        }
    }

    #[test]
    fn towards_the_sun_nothing_is_in_the_way() {
        let sun = Position::new(AU_KM, 0.0, 0.0);
        let before = Position::new(6900.0, 0.0, 0.0);
        assert_eq!(grazing_height_km(&before, &sun), None);
        assert!(sunlit_by_100_km_rule(&before, &sun));
        assert!(!sunlit_by_100_km_rule(&Position::new(-6900.0, 0.0, 0.0), &sun));
    }
}
