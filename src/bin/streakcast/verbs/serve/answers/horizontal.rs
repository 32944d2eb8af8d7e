//! Angles of the horizon as columns want them.

use streakcast::passes::AltAz;

/// Altitude and azimuth, degrees.
pub fn degrees(place: &AltAz) -> (f64, f64) {
    (place.altitude_rad.to_degrees(), place.azimuth_rad.to_degrees())
}

/// To so many decimals, for values outside of tables.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    let factor = 10_f64.powi(decimals);
    (value * factor).round() / factor
}
