//! `fit`: from photometry to a model.

mod arguments;
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

pub use arguments::FitArguments;
pub use run::run;
