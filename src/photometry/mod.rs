//! From geometry to magnitude: laws of reflection, panels, phase functions, and the models made of them by name.

mod band;
mod batch;
mod blocking;
pub mod brdf;
mod brightness;
pub mod earthshine;
mod library;
mod magnitude;
mod model;
mod model_check;
mod model_file;
mod panel;
pub mod panels;
mod parameter_sigma;
mod phase;
mod polygon;
mod satellite;
mod sphere;
mod standard_magnitudes;

pub use band::{Band, BandError, MagSystem};
pub use batch::{BodyAngles, Places};
pub use blocking::{Blocked, ChassisBlocking};
pub use brightness::{Brightness, Earthshine, MagnitudeSource, PhotometryOptions};
pub use library::ModelLibrary;
pub use magnitude::{Magnitude, StandardMagnitude, airmass};
pub use model::{BrightnessModel, FittedRange};
pub use model_file::{
    Coefficients, GeometryRange, ModelFile, ModelFileError, ModelKind, PANEL_OFFSET, PhasePolynomial, Provenance,
    SatelliteShape,
};
pub use panel::{Incidence, Panel};
pub use phase::PhaseFunction;
pub use polygon::PanelPolygon;
pub use satellite::{Faces, SatelliteModel, Terms};
pub use sphere::DiffuseSphere;
pub use standard_magnitudes::{StandardMagnitudes, StandardMagnitudesError};
