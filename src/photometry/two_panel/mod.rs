//! Chassis and sail (solar array) of Lu (2024): one set of equations for single geometries, for columns of geometries,
//! and for fits.

mod columns;
mod equations;
mod satellite;

pub use columns::{BodyAngles, SatellitePositions};
pub(super) use columns::{Columns, standard_magnitudes};
pub use equations::ChassisAndSail;
#[cfg(feature = "fit")]
pub(crate) use equations::{Directions, LitPanels, magnitudes, slope_of_lobe, weighted_sum};
pub use satellite::SatelliteModel;
#[cfg(feature = "fit")]
pub(crate) use satellite::chassis_earthshine;
