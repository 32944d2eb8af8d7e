//! Errors of maps.

use thiserror::Error;

/// Errors of maps.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MapError {
    /// A number out of range.
    #[error("{what} is {given}{unit}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the number.
        what: &'static str,
        /// Given value.
        given: f64,
        /// Unit with a blank before it, or empty.
        unit: &'static str,
        /// Accepted values.
        allowed: &'static str,
    },
    /// A satellite below the observer.
    #[error(
        "satellite height is {height_km} km, below site {site}; allowed: above {site_km:.1} km (over the sphere of 6378.137 km)"
    )]
    BelowSite {
        /// Given height.
        height_km: f64,
        /// The site's name.
        site: String,
        /// The site's distance from the Earth's centre less 6378.137 km.
        site_km: f64,
    },
    /// Failure to write a FITS file.
    #[cfg(all(feature = "fits", unix))]
    #[error("FITS: {0}")]
    Fits(String),
    /// Failure of the temporary folder in which FITS files are written.
    #[cfg(all(feature = "fits", unix))]
    #[error("cannot write a FITS file in the scratch folder: {0}")]
    Scratch(String),
}

/// Returns the value if it is allowed.
pub(super) fn in_range(
    what: &'static str,
    given: f64,
    unit: &'static str,
    allowed: &'static str,
    is_allowed: bool,
) -> Result<f64, MapError> {
    if is_allowed { Ok(given) } else { Err(MapError::OutOfRange { what, given, unit, allowed }) }
}

/// Checks the height of a satellite, km: positive, at most 100,000.
pub(super) fn height(height_km: f64) -> Result<f64, MapError> {
    let is_allowed = height_km > 0.0 && height_km <= 100_000.0;
    in_range("height", height_km, " km", "above 0, at most 100000 km", is_allowed)
}

/// Checks a latitude or altitude, radians; errors state it in degrees.
pub(super) fn latitude(what: &'static str, angle_rad: f64) -> Result<f64, MapError> {
    // Removes the rounding of a conversion to radians and back: 120 instead of 119.99999999999999.
    let degrees = (angle_rad.to_degrees() * 1e9).round() / 1e9;
    // Rounding may raise a right angle slightly above 90 degrees.
    in_range(what, degrees, " deg", "-90 to 90 deg", degrees.abs() <= 90.0 + 1e-9)?;
    Ok(angle_rad.clamp(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2))
}
