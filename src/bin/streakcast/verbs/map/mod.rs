//! `map`: maps of magnitudes over the sky of a site and over the directions around a satellite, as tables, FITS and
//! pictures.

mod arguments;
mod pictures;
mod run;
mod target;

pub use arguments::MapArguments;
pub use arguments::{BodyViewArguments, MapBodyArguments, MapOutputArguments, MapSkyArguments, SkyViewArguments};
pub use run::run;
pub use run::site_of;
pub use run::{body, sky};
pub use run::{model_of, provisional};
