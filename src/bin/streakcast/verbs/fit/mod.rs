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

pub use arguments::FitArguments;
pub use run::run;
