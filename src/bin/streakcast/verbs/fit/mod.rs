//! `fit`: fits of brightness models to photometry.

mod arguments;
mod chains;
mod compare;
mod form;
mod photometry;
mod points;
mod reduce;
mod report;
mod run;

pub use arguments::FitArguments;
pub use run::run;
