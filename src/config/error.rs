//! Errors of a configuration, and of the requests beside it.

use std::io;

use thiserror::Error;

use crate::elements::{CatalogueError, ShellError};
use crate::forecast::ForecastError;
use crate::frames::{FramesError, InstantError};
use crate::geometry::GeometryError;
use crate::identify::IdentifyError;
#[cfg(feature = "fits")]
use crate::images::FrameError;
use crate::images::TelescopeError;
use crate::orbit::OrbitError;
use crate::passes::{FieldError, SkyError, UnknownModel};
use crate::photometry::{BandError, ModelFileError, StandardMagnitudesError};
use crate::schedule::{PolicyError, ScheduleError};
#[cfg(feature = "fits")]
use crate::streaks::InjectionError;

/// Errors of a configuration: what was given, and what is accepted.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// A file of the configuration cannot be read.
    #[error("{what} {path}: {source}")]
    Io {
        /// What the file is for.
        what: &'static str,
        /// The file.
        path: String,
        /// The system's error.
        source: io::Error,
    },
    /// The configuration file is invalid.
    #[error("configuration {path}: {message}")]
    Toml {
        /// The file.
        path: String,
        /// What and where.
        message: String,
    },
    /// The policy file is invalid.
    #[error("policy {path}: {message}")]
    PolicyFile {
        /// The file.
        path: String,
        /// What and where.
        message: String,
    },
    /// A required value is missing.
    #[error("no {what}; say {allowed}")]
    Missing {
        /// What is missing.
        what: &'static str,
        /// How to specify it.
        allowed: &'static str,
    },
    /// Two values exclude each other.
    #[error("{first} and {second} exclude each other; say one of them")]
    Both {
        /// The one.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A value of unknown form.
    #[error("{what} '{given}' is not known; allowed: {allowed}")]
    Value {
        /// What it is for.
        what: &'static str,
        /// As given.
        given: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// An unknown site, with no similar name known.
    #[error(
        "unknown site {0:?}; no known name is near it: streakcast sites lists them, --lat, --lon and --height say any other place"
    )]
    UnknownSite(String),
    /// The telescope in orbit is not in the file.
    #[error(
        "no element set of the observer {id} among {count}; allowed: --observer-norad with the number of one of them"
    )]
    NoObserver {
        /// As given.
        id: u32,
        /// Number of objects.
        count: usize,
    },
    /// The file of the telescope in orbit holds several objects.
    #[error("the observer's elements hold {count} objects; say which with --observer-norad (the first is {first})")]
    SeveralObservers {
        /// How many.
        count: usize,
        /// Number of the first.
        first: u32,
    },
    /// The telescope in orbit is below the Earth's limb.
    #[error(
        "{name} is at {at_km:.0} km, below the limb height of {height_km} km; allowed: --limb-height-km below its orbit"
    )]
    BelowLimb {
        /// Its name.
        name: String,
        /// Its own height, km.
        at_km: f64,
        /// Height of the limb, km.
        height_km: f64,
    },
    /// The policy refers to limits that the file of the telescope lacks.
    #[error(
        "the policy says {key} = \"telescope\", but the file of {telescope} has no such limit in any band; \
         allowed: numbers in the policy, or a telescope whose file has them ([limits.g] and so on)"
    )]
    NoCameraLimit {
        /// The key of the policy.
        key: &'static str,
        /// Name of the telescope.
        telescope: String,
    },
    /// The telescope in orbit has no orbit.
    #[error("observer: {0}")]
    Observer(OrbitError),
    /// A number out of its range.
    #[error("{what} {given}: allowed {allowed}")]
    OutOfRange {
        /// What it is for, spelled as the flag.
        what: &'static str,
        /// As given, with its unit.
        given: String,
        /// What is allowed, with its unit.
        allowed: &'static str,
    },
    /// A number without its unit.
    #[error("{what} {given} has no unit; allowed: {allowed}")]
    NoUnit {
        /// What it is for.
        what: &'static str,
        /// As given.
        given: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// No element set gives a position at the time of the question.
    #[error(
        "none of the {satellites} element sets gives a position at {moment}: {first}; allowed: elements of about that time"
    )]
    NothingPropagates {
        /// Number of element sets.
        satellites: usize,
        /// When.
        moment: String,
        /// Why the first of them does not.
        first: String,
    },
    /// An unknown generation of satellites.
    #[error("unknown generation {given:?}; known are {known}")]
    UnknownGeneration {
        /// As given.
        given: String,
        /// All names.
        known: String,
    },
    /// A model that is not in the library.
    #[error(transparent)]
    UnknownModel(#[from] UnknownModel),
    /// Elements.
    #[error(transparent)]
    Satellites(#[from] CatalogueError),
    /// Synthetic shells.
    #[error(transparent)]
    Shell(#[from] ShellError),
    /// Site.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Dates, angles, Earth orientation.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// A time that is invalid or names no scale.
    #[error(transparent)]
    Instant(#[from] InstantError),
    /// Field of view.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Telescope.
    #[error(transparent)]
    Telescope(#[from] TelescopeError),
    /// Policy.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// Band or magnitude system.
    #[error(transparent)]
    Band(#[from] BandError),
    /// A model file.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// Standard magnitudes.
    #[error(transparent)]
    StandardMagnitudes(#[from] StandardMagnitudesError),
    /// The sky.
    #[error(transparent)]
    Sky(#[from] SkyError),
}

/// Errors of a forecast, an identification or an injection that is requested.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RequestError {
    /// The request is incomplete, contradicts itself, or is out of range: what, and what is accepted.
    #[error("{0}")]
    Invalid(String),
    /// Site, times, units.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// An angle.
    #[error(transparent)]
    Angle(#[from] FramesError),
    /// A number of a forecast.
    #[error(transparent)]
    Forecast(#[from] ForecastError),
    /// A measured streak.
    #[error(transparent)]
    Streak(#[from] IdentifyError),
    /// A schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// A frame that cannot be read.
    #[cfg(feature = "fits")]
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// An injection.
    #[cfg(feature = "fits")]
    #[error(transparent)]
    Injection(#[from] InjectionError),
}

impl RequestError {
    pub(super) fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid(message.into())
    }
}

impl From<InstantError> for RequestError {
    fn from(error: InstantError) -> Self {
        Self::Config(error.into())
    }
}
