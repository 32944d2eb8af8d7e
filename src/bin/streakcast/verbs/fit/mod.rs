//! `fit`: from photometry to a model.

mod compare;
mod points;
mod reduce;
mod report;
mod run;

pub use run::run;
