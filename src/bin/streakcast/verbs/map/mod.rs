//! `map`: maps of magnitudes over the sky of a site and over the directions around a satellite, as tables, FITS and
//! pictures.

mod arguments;
#[cfg(feature = "plot")]
mod pictures;
mod run;
mod target;

pub use arguments::MapArguments;
#[cfg(feature = "plot")]
pub use arguments::{BodyViewArguments, MapBodyArguments, MapOutputArguments, MapSkyArguments, SkyViewArguments};
pub use run::run;
#[cfg(any(feature = "fit", feature = "plot"))]
pub use run::site_of;
#[cfg(feature = "plot")]
pub use run::{body, sky};
pub use run::{model_of, provisional};
