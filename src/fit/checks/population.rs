//! Geometries over which a model is averaged: satellites of one orbital shell above a mid-latitude site during
//! twilight.
//!
//! ```text
//! weight of a direction = cos(altitude) · ρ² / cos θ · 1 / √(sin² i - sin² φ)
//!                         sky element     on the shell   satellites there
//! ```
//!
//! ρ is the range, θ the angle between the line of sight and the satellite's zenith, φ the latitude under the
//! satellite, and i the inclination. A solid angle of the sky covers an area proportional to ρ²/cos θ on the shell. The
//! last factor is the density of satellites on circular orbits with evenly distributed nodes. The observer is on a
//! sphere of 6378.137 km; the shadow is that of the ellipsoid without atmosphere.

use nalgebra::Vector3;

use crate::constants::{AU_KM, EARTH_EQUATORIAL_RADIUS_KM};
use crate::frames::{Gcrs, Position};
use crate::geometry::{ShadowModel, ViewingGeometry};

/// Description of the geometries, for the provenance of tables.
pub const POPULATION: &str = "satellites of the shell in full sunlight above 30 deg altitude, site at latitude 40 deg, equinox, \
                              Sun's altitude from -12 to -30 deg in even steps of time; magnitudes at 1000 km by sunlight";
/// Latitude of the site, degrees. At the equinox, north and south are equivalent.
const SITE_LATITUDE_DEG: f64 = 40.0;
/// Lowest altitude of a satellite, degrees.
const LEAST_ALTITUDE_DEG: f64 = 30.0;
/// First and last altitude of the Sun, degrees. Morning twilight is the mirror image of evening twilight and is
/// omitted.
const SUN_ALTITUDES_DEG: [f64; 2] = [-12.0, -30.0];

/// Numbers of equal steps in time, altitude and azimuth. Geometries are computed for the middle of each step.
const STEPS: [usize; 3] = [12, 30, 72];

/// Returns viewing geometries of satellites on circular orbits `height_km` above 6378.137 km with this inclination,
/// degrees, [0, 180]. Each has a weight proportional to the number of satellites.
///
/// Empty if no satellite is in this part of the sky, or if all of them are in the Earth's shadow.
pub(super) fn shell_geometries(height_km: f64, inclination_deg: f64) -> Vec<(ViewingGeometry, f64)> {
    let (sin_site, cos_site) = SITE_LATITUDE_DEG.to_radians().sin_cos();
    let up = Vector3::new(cos_site, 0.0, sin_site);
    let (north, east) = (Vector3::new(-sin_site, 0.0, cos_site), Vector3::y());
    let observer = up * EARTH_EQUATORIAL_RADIUS_KM;
    let radius_km = EARTH_EQUATORIAL_RADIUS_KM + height_km;
    let sin_inclination = inclination_deg.to_radians().sin();
    // With the Sun on the equator: sin(altitude) = cos(latitude of the site) cos(hour angle)
    let [first, last] = SUN_ALTITUDES_DEG.map(|altitude| (altitude.to_radians().sin() / cos_site).acos());
    let least = LEAST_ALTITUDE_DEG.to_radians();
    let [moments, altitudes, azimuths] = STEPS;
    let middle = |step: usize, of: usize| (step as f64 + 0.5) / of as f64;
    let mut geometries = Vec::new();
    for moment in 0..moments {
        let hour_angle = first + (last - first) * middle(moment, moments);
        // Hour angles increase to the west.
        let sun = Position::<Gcrs>::new(AU_KM * hour_angle.cos(), -AU_KM * hour_angle.sin(), 0.0);
        for (i, j) in (0..altitudes).flat_map(|i| (0..azimuths).map(move |j| (i, j))) {
            let altitude = least + (std::f64::consts::FRAC_PI_2 - least) * middle(i, altitudes);
            let azimuth = std::f64::consts::TAU * middle(j, azimuths);
            let (sin_alt, cos_alt) = altitude.sin_cos();
            let sight = up * sin_alt + (north * azimuth.cos() + east * azimuth.sin()) * cos_alt;
            // ρ = -q sin(altitude) + √(q² sin² + r² - q²)
            let rise = EARTH_EQUATORIAL_RADIUS_KM * sin_alt;
            let range_km = (rise * rise + radius_km * radius_km - observer.norm_squared()).sqrt() - rise;
            let satellite = observer + sight * range_km;
            let zenith = satellite / radius_km;
            let density = sin_inclination * sin_inclination - zenith.z * zenith.z;
            let satellite = Position::from_vector(satellite);
            if density <= 0.0 || ShadowModel::Geometric.illumination(&satellite, &sun).lit_fraction() < 1.0 {
                continue;
            }
            let weight = cos_alt * range_km * range_km / sight.dot(&zenith) / density.sqrt();
            let geometry = ViewingGeometry::new(&satellite, &Position::from_vector(observer), &sun);
            geometries.extend(geometry.map(|geometry| (geometry, weight)));
        }
    }
    geometries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_geometries_are_in_the_expected_range() {
        let geometries = shell_geometries(550.0, 53.0);
        assert!(geometries.len() > 10_000, "{}", geometries.len());
        for (geometry, weight) in &geometries {
            assert!(*weight > 0.0 && (geometry.height_km - 550.0).abs() < 1e-6);
            let altitude = geometry.geocentric_altitude_rad().expect("a triangle").to_degrees();
            assert!((30.0..90.0).contains(&altitude), "{altitude}");
            // At night the Sun is below the chassis plane, by at most 23 deg for a lit satellite at 550 km.
            assert!((-23.1..0.0).contains(&geometry.sun_latitude_rad.to_degrees()));
        }
        assert!(shell_geometries(550.0, 10.0).is_empty(), "no orbit of 10 deg is seen 30 deg high from 40 deg");
    }

    #[test]
    fn verif_weights_sum_to_the_number_of_satellites() {
        // A polar shell has the density 1/cos φ. The expected number is a sum over cells of latitude and longitude on
        // the shell, instead of altitude and azimuth in the sky. At a large height, a large part of the shell is above
        // the lowest altitude.
        let height_km = 20_000.0;
        let seen: f64 = shell_geometries(height_km, 90.0).iter().map(|(_, weight)| weight).sum();
        let radius_km = EARTH_EQUATORIAL_RADIUS_KM + height_km;
        let site = SITE_LATITUDE_DEG.to_radians();
        let steps = 400_usize;
        let mut expected = 0.0;
        for moment in 0..STEPS[0] {
            let [first, last] = SUN_ALTITUDES_DEG.map(|a| (a.to_radians().sin() / site.cos()).acos());
            let hour_angle = first + (last - first) * (moment as f64 + 0.5) / STEPS[0] as f64;
            let sun = Position::<Gcrs>::new(AU_KM * hour_angle.cos(), -AU_KM * hour_angle.sin(), 0.0);
            for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
                let latitude = std::f64::consts::PI * ((i as f64 + 0.5) / steps as f64 - 0.5);
                let longitude = std::f64::consts::TAU * (j as f64 + 0.5) / steps as f64;
                let position =
                    Vector3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin())
                        * radius_km;
                let up = Vector3::new(site.cos(), 0.0, site.sin());
                let sight = (position - up * EARTH_EQUATORIAL_RADIUS_KM).normalize();
                let lit =
                    ShadowModel::Geometric.illumination(&Position::from_vector(position), &sun).lit_fraction() >= 1.0;
                if sight.dot(&up) > LEAST_ALTITUDE_DEG.to_radians().sin() && lit {
                    // Area r² cos φ dφ dλ times density 1/cos φ.
                    expected +=
                        radius_km * radius_km * std::f64::consts::PI * std::f64::consts::TAU / (steps * steps) as f64;
                }
            }
        }
        let least = LEAST_ALTITUDE_DEG.to_radians();
        let element = (std::f64::consts::FRAC_PI_2 - least) / STEPS[1] as f64 * std::f64::consts::TAU / STEPS[2] as f64;
        // Relative tolerance: the steps of both grids are coarse at the borders of the cone and of the shadow, and the
        // density is steep near the pole.
        const GRID_TOLERANCE: f64 = 0.01;
        assert!((seen * element / expected - 1.0).abs() < GRID_TOLERANCE, "{} {expected}", seen * element);
    }
}
