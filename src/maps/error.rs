//! Checks of the numbers of maps.

use crate::error::Error;

/// Returns the value if it is allowed, otherwise an error.
pub(super) fn in_range(
    what: &'static str,
    given: f64,
    unit: &'static str,
    allowed: &'static str,
    is_allowed: bool,
) -> Result<f64, Error> {
    if is_allowed { Ok(given) } else { Err(Error::invalid(what, format_args!("{given}{unit}"), allowed)) }
}

/// Checks that the height of a satellite, km, is positive and at most 100,000.
pub(super) fn height(height_km: f64) -> Result<f64, Error> {
    let is_allowed = height_km > 0.0 && height_km <= 100_000.0;
    in_range("height", height_km, " km", "above 0, at most 100000 km", is_allowed)
}

/// Checks that a latitude or altitude, radians, is within ±90°; the error states it in degrees.
pub(super) fn latitude(what: &'static str, angle_rad: f64) -> Result<f64, Error> {
    // The conversion of degrees to radians and back may change 120 into 119.99999999999999; this is rounded away.
    let degrees = (angle_rad.to_degrees() * 1e9).round() / 1e9;
    // After rounding, a right angle may be slightly above 90 degrees.
    in_range(what, degrees, " deg", "-90 to 90 deg", degrees.abs() <= 90.0 + 1e-9)?;
    Ok(angle_rad.clamp(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2))
}
