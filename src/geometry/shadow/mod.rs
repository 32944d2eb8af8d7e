//! The Earth's shadow: `illumination` (limb of the Earth and disk of the Sun), `disk` (limb darkening of the Sun),
//! `atmosphere` (refraction and extinction of grazing sunlight), `grazing` (height of a straight ray above the ground).

mod atmosphere;
mod disk;
mod grazing;
mod illumination;

pub use grazing::{KARMAN_LINE_KM, grazing_height_km, sunlit_by_100_km_rule};
pub use illumination::{Illumination, ShadowModel, illumination};
