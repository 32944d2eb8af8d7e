//! Errors of a configuration and of requests that use it.

use std::io;

use thiserror::Error;

use crate::elements::ElementsError;
use crate::forecast::ForecastError;
use crate::frames::FramesError;
use crate::geometry::GeometryError;
use crate::identify::IdentifyError;
use crate::images::ImagesError;
#[cfg(all(feature = "fits", unix))]
use crate::measure::MeasureError;
use crate::message::Quoted;
use crate::orbit::OrbitError;
use crate::passes::{LearnedError, MeasuredError, SkyError};
use crate::photometry::PhotometryError;
use crate::schedule::ScheduleError;
#[cfg(all(feature = "fits", unix))]
use crate::streaks::StreaksError;

/// Error of a configuration, or of a forecast, identification, injection or measurement request.
///
/// Each message contains the invalid value and the accepted values.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The request is incomplete or contradictory, or a number is out of range.
    #[error("{0}")]
    Invalid(String),
    /// A file of the configuration cannot be read.
    #[error("{what} {path}: {source}")]
    Io {
        /// Purpose of the file.
        what: &'static str,
        /// Path of the file.
        path: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The content of a file of the configuration is invalid.
    #[error("{what} {path}: {source}")]
    File {
        /// Purpose of the file.
        what: &'static str,
        /// Path of the file.
        path: String,
        /// Error of the content.
        source: Box<ConfigError>,
    },
    /// The configuration file is invalid.
    #[error("configuration {path}: {message}")]
    Toml {
        /// Path of the file.
        path: String,
        /// Error and its position.
        message: String,
    },
    /// The policy file is invalid.
    #[error("policy {path}: {message}")]
    PolicyFile {
        /// Path of the file.
        path: String,
        /// Error and its position.
        message: String,
    },
    /// A required value is missing.
    #[error("missing {what}; specify {allowed}")]
    Missing {
        /// Name of the missing value.
        what: &'static str,
        /// Flags that set it.
        allowed: &'static str,
    },
    /// A required input is missing.
    #[error("missing {name}; specify {flags}")]
    MissingInput {
        /// Name of the input.
        name: &'static str,
        /// Flags that give it.
        flags: String,
    },
    /// Two options exclude each other.
    #[error("{first} and {second} exclude each other; specify one of them")]
    Both {
        /// Name of the first option.
        first: &'static str,
        /// Name of the second option.
        second: &'static str,
    },
    /// The text of a value has an invalid form.
    #[error("invalid {what} '{given}'; allowed: {allowed}", given = Quoted::new(.given))]
    Value {
        /// Name of the value.
        what: &'static str,
        /// Invalid text.
        given: String,
        /// Accepted forms.
        allowed: &'static str,
    },
    /// The site is unknown, and no known name is similar.
    #[error(
        "unknown site {given:?}; allowed: a name listed by streakcast sites, or --lat and --lon; streakcast setup --place \
         TOWN writes those of a town into the home file", given = Quoted::new(.0)
    )]
    UnknownSite(String),
    /// The file has no element set of the telescope in orbit.
    #[error(
        "--observer-norad {id} is not among the {count} objects of the elements; allowed: the NORAD number of one of them (for \
         objects with only a COSPAR designator, one that has this designator in --elements)"
    )]
    NoObserver {
        /// NORAD catalogue number of the telescope.
        id: u32,
        /// Number of objects in the file.
        count: usize,
    },
    /// The file contains several objects, and no number selects the telescope in orbit.
    #[error(
        "the elements of the observer contain {count} objects; specify one with --observer-norad (the first is {first})"
    )]
    SeveralObservers {
        /// Number of objects in the file.
        count: usize,
        /// NORAD catalogue number or COSPAR designator of the first object.
        first: String,
    },
    /// A limit on the pointings of a telescope in orbit is given for a site.
    #[error(
        "{keys} is a limit of a telescope in orbit (--observer-elements), not of a site; allowed for a site: {uses}"
    )]
    OnlyInOrbit {
        /// The flag.
        keys: &'static str,
        /// The flag to use for a site.
        uses: &'static str,
    },
    /// The telescope in orbit is below the height of the Earth's limb.
    #[error(
        "{name} is at {at_km:.0} km, below the limb height of {height_km} km; allowed: --limb-height-km below the orbit"
    )]
    BelowLimb {
        /// Name of the telescope.
        name: String,
        /// Height of the telescope, km.
        at_km: f64,
        /// Height of the limb, km.
        height_km: f64,
    },
    /// The orbit of the telescope is invalid.
    #[error("observer: {0}")]
    Observer(OrbitError),
    /// A number is out of its range.
    #[error("{what} is {given}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the value, written as its flag.
        what: &'static str,
        /// Invalid value, with its unit.
        given: String,
        /// Accepted range, with its unit.
        allowed: &'static str,
    },
    /// A number has no unit.
    #[error("{what} is {given}, without a unit; allowed: {allowed}")]
    NoUnit {
        /// Name of the value.
        what: &'static str,
        /// Invalid text.
        given: String,
        /// Accepted forms.
        allowed: &'static str,
    },
    /// No element set can be propagated to the time of the request.
    #[error(
        "{} be propagated to {moment}; specify elements of about that date (first error: {first})",
        none_can(*satellites)
    )]
    NothingPropagates {
        /// Number of element sets.
        satellites: usize,
        /// Time of the request.
        moment: String,
        /// Reason why the first element set cannot be propagated.
        first: String,
    },
    /// The positions of the satellites are unknown at the time of the request, because their elements are too old.
    #[error("{reason}; specify elements of about the date of the request")]
    UnknownPositions {
        /// Age of the elements, and number of satellites.
        reason: String,
    },
    /// The generation of satellites is unknown.
    #[error("unknown generation {given:?}; allowed: {known}", given = Quoted::new(.given))]
    UnknownGeneration {
        /// Unknown name.
        given: String,
        /// All accepted names.
        known: String,
    },
    /// Error in element sets or synthetic shells.
    #[error(transparent)]
    Elements(#[from] ElementsError),
    /// Error in times, Earth orientation or angles of the configuration.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// Error in an angle of a request.
    #[error(transparent)]
    Angle(FramesError),
    /// Error in the site.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Error in the telescope description.
    #[error(transparent)]
    Images(#[from] ImagesError),
    /// Error in the FITS frame of a request.
    #[cfg(all(feature = "fits", unix))]
    #[error(transparent)]
    Frame(ImagesError),
    /// The learned file is invalid, or its offsets are relative to other models.
    #[error(transparent)]
    Learned(#[from] LearnedError),
    /// A table of measured magnitudes is invalid.
    #[error(transparent)]
    Measured(#[from] MeasuredError),
    /// Error in bands, model files or standard magnitudes.
    #[error(transparent)]
    Photometry(#[from] PhotometryError),
    /// Error in the choice of models, the field of view or the prepared sky.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// Error in the policy.
    #[error(transparent)]
    Policy(ScheduleError),
    /// Error in the schedule of a request.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// Error of a forecast.
    #[error(transparent)]
    Forecast(#[from] ForecastError),
    /// Error of the identification of a streak.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// Error of an injection.
    #[cfg(all(feature = "fits", unix))]
    #[error(transparent)]
    Streaks(#[from] StreaksError),
    /// Error of measuring streaks.
    #[cfg(all(feature = "fits", unix))]
    #[error(transparent)]
    Measure(#[from] MeasureError),
}

impl ConfigError {
    pub(super) fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid(message.into())
    }

    /// Returns true if the error occurred in a forecast, identification, injection or measurement, and false if the
    /// configuration is invalid.
    pub fn is_of_request(&self) -> bool {
        let is_general = matches!(
            self,
            Self::Invalid(_) | Self::Angle(_) | Self::Schedule(_) | Self::Forecast(_) | Self::Identify(_)
        );
        #[cfg(all(feature = "fits", unix))]
        return is_general || matches!(self, Self::Frame(_) | Self::Streaks(_) | Self::Measure(_));
        #[cfg(not(all(feature = "fits", unix)))]
        is_general
    }
}

/// Returns the beginning of the sentence that no element set can be used.
fn none_can(element_sets: usize) -> String {
    if element_sets == 1 {
        "the only element set cannot".to_owned()
    } else {
        format!("none of the {element_sets} element sets can")
    }
}
