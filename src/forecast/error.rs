//! Errors of forecasts and statistics.

use thiserror::Error;

use crate::passes::SkyError;

/// Errors of forecasts and statistics.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ForecastError {
    /// A number out of range.
    #[error("{what} is {given}{unit}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the quantity.
        what: &'static str,
        /// Invalid value.
        given: f64,
        /// Unit with a preceding blank, or empty.
        unit: &'static str,
        /// Accepted range.
        allowed: &'static str,
    },
    /// No satellite matches the selection.
    #[error(
        "none of the {satellites} satellites has {selection}; allowed: a selection of at least one satellite (modules and \
         docked spacecraft belong to their station: 25544 ISS, 48274 CSS)"
    )]
    EmptySelection {
        /// Number of satellites.
        satellites: usize,
        /// Description of the selection.
        selection: String,
    },
    /// Trails in random exposures are computed only for a telescope in orbit.
    #[error("{observer} is not in orbit; allowed: a telescope in orbit")]
    NotInOrbit {
        /// Name of the observer.
        observer: String,
    },
    /// The element set of an object whose orbit a telescope has is missing.
    #[error(
        "the elements have no element set of {object} ({norad_id}), whose orbit is used; allowed: a catalogue with it, or a \
         file with its element set in addition"
    )]
    NoOrbit {
        /// Name of the object.
        object: &'static str,
        /// NORAD catalogue number.
        norad_id: u32,
    },
    /// The limits of a telescope in orbit allow too small a part of the sky.
    #[error(
        "the limits of the telescope allow {found} of {drawn} random pointings; allowed: wider limits, a shorter exposure, \
         or a lower limb"
    )]
    NoPointing {
        /// Number of random pointings.
        drawn: usize,
        /// Number of allowed ones.
        found: usize,
    },
    /// Positions cannot be computed.
    #[error(transparent)]
    Sky(#[from] SkyError),
}
