//! Status file of the gate, with the result of the run and counters over all runs; kinds of faults.

use std::fmt;
use std::fs::File;
use std::io;
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use streakcast::input;
use streakcast::output::{lock_folder, write_atomically};

/// Counters over all runs that use the same status file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Counters {
    pub runs: u64,
    /// Begin of the first run that is counted; `None` if an earlier version wrote the file.
    pub since_utc: Option<String>,
    pub clear: u64,
    /// Started at once because this start has the least cost of streaks.
    pub started: u64,
    pub waited: u64,
    pub not_clear: u64,
    pub skipped: u64,
    /// Number of faults by kind.
    pub faults: std::collections::BTreeMap<String, u64>,
    pub waited_s: f64,
}

/// Status of the last run.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Before {
    pub counters: Counters,
    pub satellites: Option<usize>,
    /// True if there is a file with other content than a status: its counters are lost.
    #[serde(skip)]
    pub is_damaged: bool,
}

/// Reads the status of the last run; default values if there is no valid file.
pub fn read(path: Option<&Path>) -> Before {
    let regular = path.filter(|path| input::check_regular(path).is_ok());
    let text = regular.and_then(|path| input::read_to_string(path).ok());
    match text.filter(|text| !text.trim().is_empty()).map(|text| serde_json::from_str(&text)) {
        Some(Ok(before)) => before,
        found => Before { is_damaged: found.is_some(), ..Before::default() },
    }
}

/// Longest wait for another run that counts in the same folder.
const LONGEST_LOCK: Duration = Duration::from_secs(1);

/// Locks the folder of the status file until the result is dropped, so that runs at the same time do not lose counts.
/// The file itself is replaced at each run. `None` if the folder cannot be locked, or another program keeps it locked.
pub fn lock(path: &Path) -> Option<File> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    lock_folder(folder, LONGEST_LOCK)
}

/// Writes the status file atomically.
///
/// # Errors
/// The path is that of a pipe or device, or of a file that is not a status file: it is not replaced.
pub fn write(path: &Path, statements: &Map<String, Value>) -> io::Result<()> {
    if path.exists() {
        input::check_regular(path)?;
        let before = input::read(path)?;
        if !is_status(&String::from_utf8_lossy(before.trim_ascii())) {
            let what = "the file exists and is not a status file; allowed: a new file, or one that gate wrote";
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, what));
        }
    }
    let text = serde_json::to_string_pretty(statements)? + "\n";
    write_atomically(path, |out| out.write_all(text.as_bytes()))
}

/// Returns true for the content of a status file, which counts runs, also if it is damaged; and for an empty file.
fn is_status(text: &str) -> bool {
    match serde_json::from_str::<Value>(text) {
        Ok(value) => value.pointer("/counters/runs").is_some_and(Value::is_number),
        Err(_) => {
            text.is_empty() || text.starts_with('{') && text.contains("\"counters\"") && text.contains("\"runs\"")
        }
    }
}

/// Longest message of a fault, characters.
const LONGEST_MESSAGE: usize = 600;

/// Returns a text of at most `most` characters, without control characters; a shortened text ends with `...`.
pub fn clipped(text: &str, most: usize) -> String {
    let printable = |mark: char| if mark.is_control() { ' ' } else { mark };
    let mut marks = text.chars().map(printable);
    let mut short: String = marks.by_ref().take(most).collect();
    if marks.next().is_some() {
        short += "...";
    }
    short
}

/// Kind of a fault. The status file has a counter for each kind.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// Elements are missing, invalid, incomplete or cannot be propagated.
    Elements,
    /// Elements are too old to predict positions, or too old for the length and margin of the exposure.
    StaleElements,
    /// The job of the host is missing or invalid.
    Host,
    /// The target has no coordinates, or is below the horizon.
    Target,
    /// The INDI server does not respond, or its response is invalid.
    Indi,
    /// The site of the mount differs from the given one.
    Site,
    /// The clocks of this machine and of the INDI server differ, or the clock was changed during a wait.
    Clock,
    /// The run did not end within --timeout.
    Timeout,
    /// Any other input is invalid.
    Setup,
}

impl FaultKind {
    /// Returns the name in the status file.
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::Elements => "elements",
            FaultKind::StaleElements => "stale_elements",
            FaultKind::Host => "host",
            FaultKind::Target => "target",
            FaultKind::Indi => "indi",
            FaultKind::Site => "site",
            FaultKind::Clock => "clock",
            FaultKind::Timeout => "timeout",
            FaultKind::Setup => "setup",
        }
    }
}

/// Fault with its message.
#[derive(Debug)]
pub struct Fault {
    pub kind: FaultKind,
    pub message: String,
}

impl Fault {
    pub fn new(kind: FaultKind, message: impl fmt::Display) -> Self {
        // The message is on one line, as required by the log, and of limited length, because parts of it may come from
        // a server.
        let line = message.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        Self { kind, message: clipped(&line, LONGEST_MESSAGE) }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}
