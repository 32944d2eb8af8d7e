//! The Earth's shadow: `illumination` (the limb and the Sun before it), `disk` (how bright the Sun's disk is), `atmosphere` (what air does to light
//! that grazes the Earth), `grazing` (how high a ray passes).

mod atmosphere;
mod disk;
mod grazing;
mod illumination;

pub use grazing::{KARMAN_LINE_KM, grazing_height_km, sunlit_by_100_km_rule};
pub use illumination::{Illumination, ShadowModel, illumination};
