//! The status file: what this run found, and counters over all runs.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use streakcast::output::write_atomically;

/// Counters over all runs that wrote the same file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Counters {
    pub runs: u64,
    pub clear: u64,
    pub waited: u64,
    pub not_clear: u64,
    pub skipped: u64,
    /// By kind.
    pub faults: std::collections::BTreeMap<String, u64>,
    pub waited_s: f64,
}

/// What the last run left.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Before {
    pub counters: Counters,
    pub satellites: Option<usize>,
}

/// Reads what the last run left; nothing where there is no file, or none that is understood.
pub fn read(path: Option<&Path>) -> Before {
    let text = path.and_then(|path| std::fs::read_to_string(path).ok());
    text.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}

/// Writes it, whole or not at all.
pub fn write(path: &Path, statements: &Map<String, Value>) -> std::io::Result<()> {
    let text = serde_json::to_string_pretty(statements)? + "\n";
    write_atomically(path, |out| out.write_all(text.as_bytes()))
}
