//! Errors of maps.

use thiserror::Error;

use crate::watch::Interrupted;

/// Errors of magnitude maps.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MapError {
    /// A number is out of range.
    #[error("{what} is {given}{unit}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the number.
        what: &'static str,
        /// Given value, in `unit`.
        given: f64,
        /// Unit with a blank before it; empty for a number without unit.
        unit: &'static str,
        /// Accepted values.
        allowed: &'static str,
    },
    /// The satellite is below the observer.
    #[error(
        "satellite height is {height_km} km, below site {site}; allowed: above {site_km:.1} km (over the sphere of 6378.137 km)"
    )]
    BelowSite {
        /// Given height of the satellite above 6378.137 km, in km.
        height_km: f64,
        /// The site's name.
        site: String,
        /// Distance of the site from the Earth's centre minus 6378.137 km, in km.
        site_km: f64,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A FITS file cannot be written.
    #[cfg(all(feature = "fits", unix))]
    #[error("FITS: {0}")]
    Fits(String),
    /// The temporary folder for FITS files cannot be used.
    #[cfg(all(feature = "fits", unix))]
    #[error("cannot write a FITS file in the scratch folder: {0}")]
    Scratch(String),
}

/// Returns the value if it is allowed, otherwise an error.
pub(super) fn in_range(
    what: &'static str,
    given: f64,
    unit: &'static str,
    allowed: &'static str,
    is_allowed: bool,
) -> Result<f64, MapError> {
    if is_allowed { Ok(given) } else { Err(MapError::OutOfRange { what, given, unit, allowed }) }
}

/// Checks that the height of a satellite, km, is positive and at most 100,000.
pub(super) fn height(height_km: f64) -> Result<f64, MapError> {
    let is_allowed = height_km > 0.0 && height_km <= 100_000.0;
    in_range("height", height_km, " km", "above 0, at most 100000 km", is_allowed)
}

/// Checks that a latitude or altitude, radians, is within ±90°; the error states it in degrees.
pub(super) fn latitude(what: &'static str, angle_rad: f64) -> Result<f64, MapError> {
    // The conversion of degrees to radians and back may change 120 into 119.99999999999999; this is rounded away.
    let degrees = (angle_rad.to_degrees() * 1e9).round() / 1e9;
    // After rounding, a right angle may be slightly above 90 degrees.
    in_range(what, degrees, " deg", "-90 to 90 deg", degrees.abs() <= 90.0 + 1e-9)?;
    Ok(angle_rad.clamp(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2))
}
