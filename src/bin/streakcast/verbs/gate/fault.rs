//! What went wrong that is not the user's doing: the night goes on.

use std::fmt;

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
