//! `reproduce`: compares published numbers of satellites with computed ones.

#[cfg(all(feature = "fit", feature = "plot"))]
mod lu2024;
mod run;
#[cfg(all(feature = "fit", feature = "plot"))]
mod table_one;

pub use run::{ReproduceArguments, run};
