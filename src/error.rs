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
use crate::learn::LearnError;
use crate::maps::MapError;
use crate::measure::MeasureError;
use crate::orbit::OrbitError;
use crate::passes::{LearnedError, SkyError};
use crate::photometry::PhotometryError;
#[cfg(feature = "plot")]
use crate::plot::PlotError;
use crate::schedule::ScheduleError;
use crate::streaks::StreaksError;

/// Errors of all modules, with their messages.
#[derive(Debug, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// Error in element sets or synthetic constellations.
    #[error(transparent)]
    Elements(#[from] ElementsError),
    /// Error in times, angles or Earth orientation.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// Error in a site.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Error of the propagation of a satellite.
    #[error(transparent)]
    Orbit(#[from] OrbitError),
    /// Error in brightness models or bands.
    #[error(transparent)]
    Photometry(#[from] PhotometryError),
    /// Error in an exposure, a field of view, crossings or passes.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// Error in a learned file.
    #[error(transparent)]
    Learned(#[from] LearnedError),
    /// Error in a schedule or a policy.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// Error of a forecast.
    #[error(transparent)]
    Forecast(#[from] ForecastError),
    /// Error of the identification of a streak.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// Error in frames, detectors or telescopes.
    #[error(transparent)]
    Images(#[from] ImagesError),
    /// Error in drawing streaks or injecting them into frames.
    #[error(transparent)]
    Streaks(#[from] StreaksError),
    /// Error of measuring streaks.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// Error of a map.
    #[error(transparent)]
    Maps(#[from] MapError),
    /// Error of a chart.
    #[cfg(feature = "plot")]
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// Error in photometry or a fit.
    #[cfg(feature = "fit")]
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Error of learning from measurements.
    #[error(transparent)]
    Learn(#[from] LearnError),
    /// Error in a configuration.
    #[error(transparent)]
    #[doc(hidden)]
    Config(#[from] ConfigError),
}
