//! Start of a verb: number of threads, and writer of messages.

use streakcast::config::Config;

use crate::notices::Notices;

/// Sets the number of threads, and returns the writer of messages.
pub fn begin(config: &Config) -> anyhow::Result<Notices> {
    if let Some(threads) = config.threads()? {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    Ok(Notices::from_config(config))
}
