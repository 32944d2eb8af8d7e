//! Home file: a configuration file in the user's configuration folder, which the command line reads by itself.

use std::path::PathBuf;

/// Name of the folder and of the file in the user's configuration folder.
const FOLDER: &str = "streakcast";
const FILE: &str = "streakcast.toml";
/// Environment variable by which tests and services switch the home file off.
const OFF: &str = "STREAKCAST_NO_HOME";

/// Returns the path of the home file, which may be missing; `None` if the system has no such folder.
pub fn path() -> Option<PathBuf> {
    let system = etcetera::base_strategy::choose_native_strategy().ok()?;
    Some(etcetera::BaseStrategy::config_dir(&system).join(FOLDER).join(FILE))
}

/// Returns the path of the home file; `None` also if it is switched off.
pub fn file() -> Option<PathBuf> {
    path().filter(|_| std::env::var_os(OFF).is_none_or(|off| off.is_empty()))
}
