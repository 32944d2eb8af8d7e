//! `fit`: fits of brightness models to photometry.

pub(super) mod arguments;
mod chains;
mod compare;
mod form;
pub(super) mod photometry;
mod points;
mod reduce;
pub(super) mod report;
pub(super) mod run;

pub use arguments::{FitArguments, PhotometryArguments};
pub use photometry::{config as config_of, history as history_of_flags, names, state as state_photometry};
pub use points::measured;
pub use run::run;
