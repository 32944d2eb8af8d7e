//! Light that the Earth throws on a satellite (Lu 2024, section 2.4).

mod albedo;
mod arithmetic;
mod cap;
mod healpix;
mod nodes;
mod rule;
mod table;

pub use albedo::{Albedo, AlbedoMap, EarthBelow, PAPER_ALBEDO, SurfaceAlbedos};
pub use healpix::healpix_earthshine;
pub use nodes::{EarthTerms, EarthshineNodes, Shine};
pub use table::EarthshineTable;
