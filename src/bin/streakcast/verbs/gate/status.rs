//! Faults that do not end the night, and the status file: results of this run, and counters over all runs.

use std::fmt;
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

/// Which counter a fault is counted in.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// Elements are missing, broken, half-written or give no positions.
    Elements,
    /// Elements are too old to say anything.
    StaleElements,
    /// The host said nothing, or nothing that is understood.
    Host,
    /// Nobody knows where the target is, or it is below the horizon.
    Target,
    /// The INDI server is down, silent, or talks nonsense.
    Indi,
    /// The mount's site is not the one given.
    Site,
    /// Two clocks disagree.
    Clock,
    /// Any other file or number.
    Setup,
}

impl FaultKind {
    /// Its name in the status file.
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::Elements => "elements",
            FaultKind::StaleElements => "stale_elements",
            FaultKind::Host => "host",
            FaultKind::Target => "target",
            FaultKind::Indi => "indi",
            FaultKind::Site => "site",
            FaultKind::Clock => "clock",
            FaultKind::Setup => "setup",
        }
    }
}

/// A fault with its words.
#[derive(Debug)]
pub struct Fault {
    pub kind: FaultKind,
    pub message: String,
}

impl Fault {
    pub fn new(kind: FaultKind, message: impl fmt::Display) -> Self {
        // One line of log, whatever was wrong.
        Self { kind, message: message.to_string().split_whitespace().collect::<Vec<_>>().join(" ") }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}
