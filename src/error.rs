//! Error type of the crate root.

use thiserror::Error as ThisError;

use crate::config::ConfigError;
use crate::elements::ElementsError;
#[cfg(feature = "fit")]
use crate::fit::FitError;
use crate::forecast::ForecastError;
use crate::frames::FramesError;
use crate::geometry::GeometryError;
use crate::identify::IdentifyError;
use crate::images::ImagesError;
use crate::maps::MapError;
use crate::orbit::OrbitError;
use crate::passes::SkyError;
use crate::photometry::PhotometryError;
#[cfg(feature = "plot")]
use crate::plot::PlotError;
use crate::schedule::ScheduleError;
use crate::streaks::StreaksError;

/// Errors of all modules, with their messages.
#[derive(Debug, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// Element sets and synthetic constellations.
    #[error(transparent)]
    Elements(#[from] ElementsError),
    /// Times, angles, Earth orientation.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// Sites.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Propagation.
    #[error(transparent)]
    Orbit(#[from] OrbitError),
    /// Brightness models and bands.
    #[error(transparent)]
    Photometry(#[from] PhotometryError),
    /// Exposures, fields of view, crossings and passes.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// Schedules and policies.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// Forecasts.
    #[error(transparent)]
    Forecast(#[from] ForecastError),
    /// Measured streaks.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// Frames, detectors and telescopes.
    #[error(transparent)]
    Images(#[from] ImagesError),
    /// Streaks and their injection into frames.
    #[error(transparent)]
    Streaks(#[from] StreaksError),
    /// Maps.
    #[error(transparent)]
    Maps(#[from] MapError),
    /// Charts.
    #[cfg(feature = "plot")]
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// Photometry and fits.
    #[cfg(feature = "fit")]
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Configurations.
    #[error(transparent)]
    Config(#[from] ConfigError),
}
