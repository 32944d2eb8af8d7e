//! What a map cannot be made of.

use thiserror::Error;

/// Why there is no map.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MapError {
    /// A number beyond what is allowed.
    #[error("{what} {given}{unit}: allowed {allowed}")]
    OutOfRange {
        /// Which number.
        what: &'static str,
        /// What was given.
        given: f64,
        /// Its unit with a blank before it; empty for none.
        unit: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A satellite that would stand below the observer.
    #[error(
        "satellite height {height_km} km: the site {site} stands {site_km:.1} km above the same sphere of 6378.137 km"
    )]
    BelowSite {
        /// The height asked for.
        height_km: f64,
        /// The site's name.
        site: String,
        /// The site's distance from the Earth's centre less 6378.137 km.
        site_km: f64,
    },
    /// A FITS file that could not be written.
    #[cfg(feature = "fits")]
    #[error("FITS: {0}")]
    Fits(String),
    /// The folder in which a FITS file is made before its bytes are handed over is of no use.
    #[cfg(feature = "fits")]
    #[error("FITS files are made in a scratch folder first; {0}")]
    Scratch(String),
}

/// The value, where it lies in the range.
pub(super) fn in_range(
    what: &'static str,
    given: f64,
    unit: &'static str,
    allowed: &'static str,
    is_allowed: bool,
) -> Result<f64, MapError> {
    if is_allowed { Ok(given) } else { Err(MapError::OutOfRange { what, given, unit, allowed }) }
}

/// A satellite's height, km: positive, at most 100,000.
pub(super) fn height(height_km: f64) -> Result<f64, MapError> {
    let is_allowed = height_km > 0.0 && height_km <= 100_000.0;
    in_range("height", height_km, " km", "above 0, at most 100000 km", is_allowed)
}

/// A latitude or altitude, radians, told in degrees where it is out of range.
pub(super) fn latitude(what: &'static str, angle_rad: f64) -> Result<f64, MapError> {
    // What was typed as 120 is told as 120, and not as the 119.99999999999999 that it is after a way through radians.
    let degrees = (angle_rad.to_degrees() * 1e9).round() / 1e9;
    // A right angle in degrees may come out a rounding beyond.
    in_range(what, degrees, " deg", "-90 to 90 deg", degrees.abs() <= 90.0 + 1e-9)?;
    Ok(angle_rad.clamp(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2))
}
