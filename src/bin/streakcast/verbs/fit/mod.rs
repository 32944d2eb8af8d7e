//! `fit`: from photometry to a model.

mod chains;
mod compare;
mod form;
mod identify;
mod photometry;
mod points;
mod reduce;
mod report;
mod run;
mod run_checks;

pub use run::run;
