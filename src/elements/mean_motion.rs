//! Between the mean motion of an element set and the size of its orbit, as SGP4 understands them.
//!
//! An element set prints Kozai's mean motion n. SGP4 recovers Brouwer's from it before anything else (Hoots & Roehrich,
//! Spacetrack Report 3, section 6; Vallado et al. 2006, AIAA 2006-6753, `initl`), which is what the semi-major axis belongs
//! to. Kepler's law with the printed mean motion is wrong by up to 5 km in low orbits. Constants are WGS72, as in SGP4.

use std::f64::consts::TAU;

use super::element_set::ElementSet;
use crate::constants::WGS72_MU_KM3_S2;

/// WGS72 equatorial radius, km: the earth radius of SGP4.
const EARTH_RADIUS_KM: f64 = 6378.135;
/// WGS72 second zonal harmonic.
const J2: f64 = 0.001_082_616;
/// WGS72 fourth zonal harmonic.
const J4: f64 = -0.000_001_655_97;
/// Minutes in a day.
const DAY_MIN: f64 = 1440.0;

/// √μ in earth radii^1.5 a minute: mean motion at one earth radius, rad/min.
fn k_e() -> f64 {
    60.0 / (EARTH_RADIUS_KM.powi(3) / WGS72_MU_KM3_S2).sqrt()
}

/// δ = 3/2 k₂ (3 cos²i − 1) / (a² (1 − e²)^1.5) with k₂ = J₂/2, a in earth radii.
fn delta(semi_major_axis: f64, eccentricity: f64, inclination_rad: f64) -> f64 {
    let cos_i = inclination_rad.cos();
    0.75 * J2 * (3.0 * cos_i * cos_i - 1.0)
        / (semi_major_axis * semi_major_axis * (1.0 - eccentricity * eccentricity).powf(1.5))
}

/// Brouwer's mean motion over Kozai's printed one: 1 / (1 + δ₀), and the semi-major axis in earth radii.
fn recover(mean_motion_rad_min: f64, eccentricity: f64, inclination_rad: f64) -> f64 {
    // a₁ = (k_e / n)^(2/3);  a₀ = a₁ (1 − δ₁/3 − δ₁² − 134/81 δ₁³);  n″ = n / (1 + δ₀)       STR 3, section 6
    let a1 = (k_e() / mean_motion_rad_min).powf(2.0 / 3.0);
    let d1 = delta(a1, eccentricity, inclination_rad);
    let a0 = a1 * (1.0 - d1 * (1.0 / 3.0 + d1 * (1.0 + 134.0 / 81.0 * d1)));
    let brouwer = mean_motion_rad_min / (1.0 + delta(a0, eccentricity, inclination_rad));
    (k_e() / brouwer).powf(2.0 / 3.0)
}

/// Semi-major axis (Brouwer's mean, the one SGP4 works with) of an element set, km.
pub fn semi_major_axis_km(set: &ElementSet) -> f64 {
    let mean_motion = set.mean_motion_rev_day * TAU / DAY_MIN;
    EARTH_RADIUS_KM * recover(mean_motion, set.eccentricity, set.inclination_deg.to_radians())
}

/// The mean motion to print, revolutions a day, so that SGP4 flies a circular orbit with this mean radius (km).
///
/// SGP4's radius of a circular mean orbit is a (1 − 3/4 J₂ (R/a)² (3 cos²i − 1)) and terms that average to nothing over a
/// revolution: the semi-major axis that belongs to a radius differs from it by up to 5 km. Good to a metre.
pub(super) fn mean_motion_for_radius(radius_km: f64, inclination_rad: f64) -> f64 {
    let radius = radius_km / EARTH_RADIUS_KM;
    // δ of a circular orbit is just that short-period offset: r = a (1 − δ(a)); the iteration gains three digits a step.
    let mut a = radius;
    for _ in 0..6 {
        a = radius / (1.0 - delta(a, 0.0, inclination_rad));
    }
    // The inverse of `recover`, by fixed point on the printed mean motion.
    let mut mean_motion = k_e() / a.powf(1.5);
    for _ in 0..6 {
        mean_motion *= (recover(mean_motion, 0.0, inclination_rad) / a).powf(1.5);
    }
    mean_motion * DAY_MIN / TAU
}

/// How fast SGP4 turns a circular orbit, without drag: the node and the argument of latitude (ω + M), rad/day.
///
/// `mean_motion_rev_day` is the printed one. Near-Earth orbits only (periods below 225 minutes).
pub(super) fn secular_rates_rad_day(mean_motion_rev_day: f64, inclination_rad: f64) -> (f64, f64) {
    let a = recover(mean_motion_rev_day * TAU / DAY_MIN, 0.0, inclination_rad);
    let n = k_e() / a.powf(1.5);
    let cos = inclination_rad.cos();
    let (cos2, cos4) = (cos * cos, cos.powi(4));
    // Ṁ, ω̇, Ω̇ as `sgp4init` of Vallado et al. (2006) has them, for e = 0.
    let t1 = 1.5 * J2 * n / (a * a);
    let t2 = 0.5 * t1 * J2 / (a * a);
    let t3 = -0.46875 * J4 * n / a.powi(4);
    let anomaly = n + 0.5 * t1 * (3.0 * cos2 - 1.0) + 0.0625 * t2 * (13.0 - 78.0 * cos2 + 137.0 * cos4);
    let perigee = -0.5 * t1 * (1.0 - 5.0 * cos2)
        + 0.0625 * t2 * (7.0 - 114.0 * cos2 + 395.0 * cos4)
        + t3 * (3.0 - 36.0 * cos2 + 49.0 * cos4);
    let node = cos * (-t1 + 0.5 * t2 * (4.0 - 19.0 * cos2) + 2.0 * t3 * (3.0 - 7.0 * cos2));
    (node * DAY_MIN, (anomaly + perigee) * DAY_MIN)
}
