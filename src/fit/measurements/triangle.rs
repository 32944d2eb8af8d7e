//! Viewing geometry from the distance, the phase angle and the radius of the orbit.
//!
//! ```text
//! sin δ_obs = -(R² + d² - q²) / (2 R d)                       R  radius of the orbit, q  position of the telescope
//! sin δ_sun = (q · s - d cos φ) / R                           d  distance, φ  phase angle
//! cos α     = (cos φ - sin δ_sun sin δ_obs) / (cos δ_sun cos δ_obs)     s  unit vector to the Sun
//! ```
//!
//! The solution is unique up to its mirror image, α → -α. The satellite is equally bright in both geometries if it is
//! symmetric about the plane that contains the Sun.

use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::geometry::ViewingGeometry;

/// Largest |cos α| that is still attributed to an error of the radius.
const GREATEST_COSINE: f64 = 1.05;
/// Lowest latitude of the observer, degrees. Near the nadir α is undetermined.
const LEAST_LATITUDE_DEG: f64 = -85.0;

/// Returns the geometry by the formulas of this module, with `along_km` = q · s and α in [0, π].
///
/// `None` if the triangle does not close, |cos α| exceeds 1.05, or the observer is within 5° of the satellite's nadir.
pub(super) fn geometry(
    radius_km: f64,
    distance_km: f64,
    phase_rad: f64,
    telescope_km: f64,
    along_km: f64,
) -> Option<ViewingGeometry> {
    let squares = radius_km * radius_km + distance_km * distance_km - telescope_km * telescope_km;
    let sin_observer = -squares / (2.0 * radius_km * distance_km);
    let sin_sun = ((along_km - distance_km * phase_rad.cos()) / radius_km).clamp(-1.0, 1.0);
    if sin_observer.abs() >= 1.0 || sin_observer <= LEAST_LATITUDE_DEG.to_radians().sin() {
        return None;
    }
    let (observer, sun) = (sin_observer.asin(), sin_sun.asin());
    let cos_longitude = (phase_rad.cos() - sin_sun * sin_observer) / (sun.cos() * observer.cos());
    if cos_longitude.is_nan() || cos_longitude.abs() >= GREATEST_COSINE {
        return None;
    }
    let longitude = cos_longitude.clamp(-1.0, 1.0).acos();
    ViewingGeometry::from_angles(sun, longitude, observer, distance_km, radius_km - EARTH_EQUATORIAL_RADIUS_KM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::AU_KM;
    use crate::frames::{Gcrs, Position};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn verif_geometry_comes_back_from_distance_and_phase(
            longitude in -0.3..0.3_f64, latitude in -0.3..0.3_f64, sun_angle in 0.0..std::f64::consts::TAU, sun_rise in -1.0..1.0_f64,
        ) {
            let telescope = Position::<Gcrs>::new(6370.0, 0.0, 0.0);
            let satellite = crate::frames::Direction::<Gcrs>::from_lon_lat_rad(longitude, latitude).at_range(6928.137);
            let sun = crate::frames::Direction::<Gcrs>::from_lon_lat_rad(sun_angle, sun_rise).at_range(AU_KM);
            let truth = ViewingGeometry::new(&satellite, &telescope, &sun).expect("a geometry");
            prop_assume!(truth.observer_latitude_rad > -1.4 && truth.sun_latitude_rad.abs() < 1.4);
            let along_km = telescope.vector().dot(&sun.vector().normalize());
            let found = geometry(6928.137, truth.range_km, truth.phase_angle_rad(), 6370.0, along_km).expect("a geometry");
            // Tolerance: the formulas neglect the Sun's parallax, 4.6e-5 rad over 6928 km; its effect on the longitude
            // is larger by 1/(cos δ_sun cos δ_obs sin α).
            const PARALLAX_RAD: f64 = 1e-4;
            prop_assert!((found.observer_latitude_rad - truth.observer_latitude_rad).abs() < 1e-9);
            prop_assert!((found.sun_latitude_rad - truth.sun_latitude_rad).abs() < PARALLAX_RAD / truth.sun_latitude_rad.cos());
            let apart = (found.observer_longitude_rad - truth.folded().observer_longitude_rad).abs();
            let sin = truth.folded().observer_longitude_rad.sin();
            prop_assert!(apart * sin.abs().max(1e-2) < 20.0 * PARALLAX_RAD, "{apart}");
        }
    }

    #[test]
    fn verif_impossible_triangles_are_rejected() {
        // Nearer than the height, farther than the opposite horizon, and straight below.
        assert_eq!(geometry(6928.0, 300.0, 1.5, 6378.0, 0.0), None);
        assert_eq!(geometry(6928.0, 20_000.0, 1.5, 6378.0, 0.0), None);
        assert_eq!(geometry(6928.0, 551.0, 1.5, 6378.0, -1000.0), None);
    }
}
