//! The Earth's shadow: `illumination` (fraction of the Sun's light that reaches a satellite), `penumbra` (part of the
//! limb-darkened Sun above the limb of the solid Earth), `atmosphere` (refraction and extinction of grazing sunlight),
//! `grazing` (height of a straight ray above the ground).

mod atmosphere;
mod grazing;
mod illumination;
mod penumbra;

pub use grazing::{KARMAN_LINE_KM, grazing_height_km, sunlit_by_100_km_rule};
pub use illumination::{Illumination, ShadowModel, illumination};
