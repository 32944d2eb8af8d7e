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
pub mod shell_files;
pub mod statistics;
pub mod windows;

use anyhow::anyhow;
use streakcast::config::Config;

use crate::notices::Notices;

/// Largest number of threads. More threads take minutes to start.
const MAX_THREADS: usize = 1024;

/// Sets the number of threads, and returns the writer of messages.
pub fn begin(config: &Config) -> anyhow::Result<Notices> {
    if let Some(threads) = config.run.threads {
        if !(1..=MAX_THREADS).contains(&threads) {
            return Err(anyhow!("threads is {threads}; allowed: 1 to {MAX_THREADS}"));
        }
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    Ok(Notices::of(config))
}
