//! `setup`: asks five questions and writes the home file.

mod dialog;
mod run;
mod towns;

pub use run::{SetupArguments, run};
