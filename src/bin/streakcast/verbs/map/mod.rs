//! `map`: magnitudes over a satellite's own sky and over that of a site, as tables, FITS and pictures.

mod arguments;
#[cfg(feature = "plot")]
mod pictures;
mod run;
mod target;

pub use arguments::{
    BodyViewArguments, MapArguments, MapBodyArguments, MapOutputArguments, MapSkyArguments, SkyViewArguments,
};
pub use run::{body, model_of, run, site_of, sky};
