//! From viewing geometry to magnitude: reflection laws, panels, phase functions, and brightness models by name.
//!
//! ```
//! use streakcast::geometry::ViewingGeometry;
//! use streakcast::photometry::ModelLibrary;
//!
//! let model = ModelLibrary::embedded().find("starlink-v1.5")?;
//! // Sun 20 deg below the satellite's horizon; observer at longitude 60 and latitude -50 deg of its body frame; range
//! // 900 km, height 550 km.
//! let [sun, longitude, latitude] = [-20.0_f64, 60.0, -50.0].map(f64::to_radians);
//! let geometry = ViewingGeometry::from_angles(sun, longitude, latitude, 900.0, 550.0).expect("a valid geometry");
//! let magnitude = model.standard_magnitude(&geometry).expect("the satellite is lit");
//! println!("{:.2} mag at 1000 km", magnitude.0);
//! # Ok::<(), streakcast::Error>(())
//! ```

mod atmosphere;
mod band;
#[doc(hidden)]
pub mod brdf;
mod bright_objects;
mod brightness;
mod diffuse;
#[doc(hidden)]
pub mod earthshine;
mod error;
mod error_distribution;
mod library;
mod magnitude;
mod model;
mod model_file;
#[doc(hidden)]
pub mod panels;
mod pass_update;
mod phase;
#[doc(hidden)]
pub mod radiation;
mod response;
mod standard_magnitudes;
mod thermal;
pub(crate) mod two_panel;

pub(crate) use atmosphere::clear_sky_extinction_mag;
pub use band::{Band, MagSystem};
pub use brightness::{Brightness, Earthshine, MagnitudeSource, PhotometryOptions};
pub use library::ModelLibrary;
pub(crate) use magnitude::airmass;
pub use magnitude::{Magnitude, StandardMagnitude};
pub use model::BrightnessModel;
pub(crate) use pass_update::{PassResidual, PassUpdate};
pub use response::ResponseBand;
pub use standard_magnitudes::StandardMagnitudes;
#[cfg(all(feature = "fits", unix))]
pub(crate) use thermal::SIZE_SIGMA;
pub(crate) use two_panel::SatellitePositions;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    atmosphere::twilight_limit_mag,
    bright_objects::BrightObjects,
    error_distribution::{ErrorDistribution, NormalPart},
    model_file::{Coefficients, GeometryRange, ModelFile, PANEL_OFFSET, Provenance, SatelliteShape},
    pass_update::pass_correlation,
    phase::{DiffuseSphere, StandardObject},
    two_panel::{BodyAngles, ChassisAndSail, SatelliteModel},
};
