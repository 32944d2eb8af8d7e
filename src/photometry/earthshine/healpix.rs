//! The paper's Earth of equal-area pixels: slow, plain, and what the product rule is held against.

use nalgebra::Vector3;

use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;

use super::cap::dip_rad;

/// Every pixel of the Earth that the Sun lights and the satellite sees, as (direction, irradiance): a unit vector from
/// the satellite in the body frame, and the light on a plate square to it, relative to the Sun's own.
///
/// ```text
/// dE = (albedo/π) cos(Sun) cos(view) A_pix / d²                   Lu (2024), section 2.4
/// ```
///
/// The paper's form, for validation: pixels are flat, taken at their centres (so that one cut by the terminator or the
/// limb counts whole or not at all), and the grid's pole stands at the nadir. `nside` is a power of two, 1 to 8192;
/// empty where it is not, where the satellite does not stand above the ground, or where nothing in view is lit.
pub fn healpix_earthshine(sun_latitude_rad: f64, height_km: f64, albedo: f64, nside: u32) -> Vec<(Vector3<f64>, f64)> {
    if !(nside.is_power_of_two() && nside <= 8192 && height_km > 0.0 && sun_latitude_rad.is_finite()) {
        return Vec::new();
    }
    let radius_km = EARTH_EQUATORIAL_RADIUS_KM;
    let satellite_km = Vector3::new(0.0, 0.0, radius_km + height_km);
    let sun = Vector3::new(sun_latitude_rad.cos(), 0.0, sun_latitude_rad.sin());
    let n_pixels = 12 * u64::from(nside) * u64::from(nside);
    let area_km2 = 4.0 * std::f64::consts::PI * radius_km * radius_km / n_pixels as f64;
    let limb_latitude_rad = std::f64::consts::FRAC_PI_2 - dip_rad(height_km);
    // Rings run from the pole down.
    (0..n_pixels)
        .map(|pixel| cdshealpix::ring::center(nside, pixel))
        .take_while(|&(_, latitude)| latitude > limb_latitude_rad)
        .filter_map(|(longitude, latitude)| {
            let (up, along) = latitude.sin_cos();
            let ground = Vector3::new(along * longitude.cos(), along * longitude.sin(), up);
            let to_ground_km = ground * radius_km - satellite_km;
            let distance_km = to_ground_km.norm();
            let direction = to_ground_km / distance_km;
            let (cos_sun, cos_view) = (ground.dot(&sun), -ground.dot(&direction));
            let irradiance =
                albedo / std::f64::consts::PI * cos_sun * cos_view * area_km2 / (distance_km * distance_km);
            (cos_sun > 0.0 && cos_view > 0.0).then_some((direction, irradiance))
        })
        .collect()
}
