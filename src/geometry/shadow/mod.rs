//! The Earth's shadow: `illumination` (limb and Sun), `disk` (limb darkening), `atmosphere` (refraction and extinction
//! of grazing light), `grazing` (height of a ray).

mod atmosphere;
mod disk;
mod grazing;
mod illumination;

pub use grazing::{KARMAN_LINE_KM, grazing_height_km, sunlit_by_100_km_rule};
pub use illumination::{Illumination, ShadowModel, illumination};
