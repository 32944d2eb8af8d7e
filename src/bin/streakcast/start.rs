//! Start of a verb: number of threads, and writer of messages.

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
