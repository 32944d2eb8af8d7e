//! Why a setup cannot be used.

use std::io;

use thiserror::Error;

use crate::elements::{CatalogueError, ShellError};
use crate::frames::FramesError;
use crate::geometry::GeometryError;
use crate::images::TelescopeError;
use crate::orbit::OrbitError;
use crate::passes::{FieldError, SkyError, UnknownModel};
use crate::photometry::{BandError, ModelFileError, StandardMagnitudesError};
use crate::schedule::{InstantError, PolicyError};

/// Why a setup cannot be used: what was given, and what is allowed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SetupError {
    /// A file named in the setup cannot be read.
    #[error("{what} {path}: {source}")]
    Io {
        /// What the file is for.
        what: &'static str,
        /// The file.
        path: String,
        /// What the system said.
        source: io::Error,
    },
    /// The configuration file is not what it should be.
    #[error("configuration {path}: {message}")]
    Toml {
        /// The file.
        path: String,
        /// What and where.
        message: String,
    },
    /// The policy file is not what it should be.
    #[error("policy {path}: {message}")]
    PolicyFile {
        /// The file.
        path: String,
        /// What and where.
        message: String,
    },
    /// Something that must be said was not.
    #[error("no {what}; say {allowed}")]
    Missing {
        /// What is missing.
        what: &'static str,
        /// How to say it.
        allowed: &'static str,
    },
    /// Two things were said that exclude each other.
    #[error("{first} and {second} exclude each other; say one of them")]
    Both {
        /// The one.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A value of no known form.
    #[error("{what} '{given}' is not known; allowed: {allowed}")]
    Value {
        /// What it is for.
        what: &'static str,
        /// As given.
        given: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A site that is not known, and looks like none that is.
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
        /// How many objects there are.
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
    /// The telescope in orbit sees nothing: it is below what counts as the Earth's limb.
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
    /// The policy asks the telescope for limits that its file lacks.
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
    /// Not one element set gives a position at the time asked for.
    #[error(
        "none of the {satellites} element sets gives a position at {moment}: {first}; allowed: elements of about that time"
    )]
    NothingPropagates {
        /// How many there are.
        satellites: usize,
        /// When.
        moment: String,
        /// Why the first of them does not.
        first: String,
    },
    /// A generation of satellites that is not known.
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
    Catalogue(#[from] CatalogueError),
    /// Synthetic shells.
    #[error(transparent)]
    Shell(#[from] ShellError),
    /// Site.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Dates, angles, Earth orientation.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// A time that does not name its scale, or is none.
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
