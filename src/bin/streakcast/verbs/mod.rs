//! Verbs of the command line. Each has a file or folder that also defines its flags.

pub mod alarms;
pub mod annotate;
pub mod doctor;
pub mod ephemeris;
pub mod fetch;
pub mod fit;
pub mod flag;
pub mod forecast;
pub mod gate;
pub mod identify;
#[cfg(unix)]
pub mod inject;
pub mod learn;
pub mod lists;
pub mod map;
#[cfg(unix)]
pub mod mask;
#[cfg(unix)]
pub mod measure;
pub mod model;
mod model_check;
mod model_pressure;
mod orbit_statistics;
pub mod passes;
pub mod plot;
pub mod reproduce;
mod schedule_verdicts;
pub mod serve;
pub mod setup;
pub mod shell_files;
pub mod statistics;
pub mod windows;
