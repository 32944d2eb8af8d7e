//! The error of the crate's front door.

use thiserror::Error as ThisError;

use crate::elements::{CatalogueError, ShellError};
use crate::frames::{FramesError, InstantError};
use crate::geometry::GeometryError;
use crate::passes::{ExposureTextError, FieldError, SkyError};
use crate::schedule::{PolicyError, ScheduleError};

/// Errors of the names at the crate's root: wraps the errors of their modules, with their messages.
#[derive(Debug, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// Files of element sets.
    #[error(transparent)]
    Satellites(#[from] CatalogueError),
    /// A synthetic constellation.
    #[error(transparent)]
    Constellation(#[from] ShellError),
    /// A site.
    #[error(transparent)]
    Site(#[from] GeometryError),
    /// An angle or a time scale.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// A time from text.
    #[error(transparent)]
    Time(#[from] InstantError),
    /// An exposure from text.
    #[error(transparent)]
    Exposure(#[from] ExposureTextError),
    /// A field of view.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A policy.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// A schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// Crossings that cannot be computed.
    #[error(transparent)]
    Sky(#[from] SkyError),
}
