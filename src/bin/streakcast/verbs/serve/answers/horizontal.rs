//! Angles in degrees, and rounding outside of tables.

use streakcast::passes::AltAz;

/// Altitude and azimuth, degrees.
pub fn degrees(place: &AltAz) -> (f64, f64) {
    (place.altitude_rad.to_degrees(), place.azimuth_rad.to_degrees())
}

/// Rounds to a number of decimals.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    let factor = 10_f64.powi(decimals);
    (value * factor).round() / factor
}
