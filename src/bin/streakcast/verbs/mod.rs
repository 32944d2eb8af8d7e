//! Verbs of the command line. Each has a file or folder that also defines its flags.

#[cfg(feature = "fit")]
pub mod alarms;
pub mod annotate;
pub mod doctor;
pub mod ephemeris;
#[cfg(feature = "fetch")]
pub mod fetch;
#[cfg(feature = "fit")]
pub mod fit;
pub mod flag;
pub mod forecast;
pub mod gate;
pub mod identify;
#[cfg(all(feature = "fits", unix))]
pub mod inject;
#[cfg(feature = "fit")]
pub mod learn;
pub mod lists;
pub mod map;
#[cfg(all(feature = "fits", unix))]
pub mod mask;
#[cfg(all(feature = "fits", unix))]
pub mod measure;
pub mod model;
#[cfg(feature = "fit")]
mod model_check;
mod model_pressure;
pub mod passes;
#[cfg(feature = "plot")]
pub mod plot;
pub mod reproduce;
mod schedule_verdicts;
#[cfg(feature = "serve")]
pub mod serve;
pub mod setup;
pub mod shell_files;
pub mod statistics;
pub mod windows;
