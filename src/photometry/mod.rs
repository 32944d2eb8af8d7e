//! From viewing geometry to magnitude: reflection laws, panels, phase functions, and brightness models by name.

mod atmosphere;
mod band;
pub mod brdf;
mod bright_objects;
mod brightness;
mod diffuse;
pub mod earthshine;
mod error;
mod error_distribution;
mod library;
mod magnitude;
mod model;
mod model_file;
pub mod panels;
mod pass_update;
mod phase;
pub mod radiation;
mod standard_magnitudes;
pub(crate) mod two_panel;

pub use atmosphere::{clear_sky_extinction_mag, twilight_limit_mag};
pub use band::{Band, MagSystem};
pub use bright_objects::{BrightObject, BrightObjects};
pub use brightness::{Brightness, Earthshine, MagnitudeSource, PhotometryOptions};
pub use error::PhotometryError;
pub use error_distribution::{ErrorDistribution, NormalPart};
pub use library::ModelLibrary;
pub use magnitude::{Magnitude, StandardMagnitude, airmass};
pub use model::BrightnessModel;
pub use model_file::{
    Coefficients, GeometryRange, ModelFile, ModelKind, PANEL_OFFSET, PhasePolynomial, Provenance, SatelliteShape,
};
pub use pass_update::{PassResidual, PassUpdate, pass_correlation};
pub use phase::{DiffuseSphere, PhaseFunction, StandardObject};
pub use standard_magnitudes::StandardMagnitudes;
pub use two_panel::{Blocked, BodyAngles, ChassisAndSail, SatelliteModel, SatellitePositions, Terms};
