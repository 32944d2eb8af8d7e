//! `reproduce`: compares published numbers of satellites with computed ones.

mod lu2024;
mod run;
mod table_one;

pub use run::{ReproduceArguments, run};
