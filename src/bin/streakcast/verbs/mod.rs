//! One verb, one file.

pub mod annotate;
pub mod fit;
pub mod flag;
pub mod gate;
#[cfg(feature = "fits")]
pub mod inject;
mod judged;
pub mod map;
pub mod model;
pub mod passes;
#[cfg(feature = "plot")]
pub mod plot;
pub mod shells;
pub mod sites;
pub mod windows;
