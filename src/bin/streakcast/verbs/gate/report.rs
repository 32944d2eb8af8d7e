//! Verdict of a run of the gate, and what is stated about it: the line in the log and the status file with its
//! counters.

use std::path::Path;

use hifitime::Epoch;
use serde_json::{Map, Value, json};
use streakcast::frames::seconds_between;
use streakcast::output::format_utc;
use streakcast::schedule::BestStart;

use super::arguments::Flags;
use super::status_file;
use super::status_file::{Before, Fault, FaultKind};

/// Result of a run.
pub enum GateVerdict {
    /// The field is clear from `first` to `until`, at once or after a wait. If `is_limited`, satellites that exceed no
    /// limit may cross. If the policy has a largest cost `most_s`, the streaks of these starts cost at most this.
    Clear { waited_s: f64, first: Epoch, until: Epoch, most_s: Option<f64>, is_limited: bool },
    /// The cost of streaks plus the wait is smallest if the exposure starts from `first` to `until`.
    Best { waited_s: f64, first: Epoch, until: Epoch, best: BestStart },
    /// There is no clear start within the longest wait, with streaks that cost at most `most_s`.
    NotClear { most_s: Option<f64> },
    /// The frame is not a light frame.
    Skipped(String),
}

impl GateVerdict {
    /// Returns the wait, seconds, with the first and the last start; `None` if the exposure starts without being
    /// checked.
    pub fn start(&self) -> Option<(f64, Epoch, Epoch)> {
        match self {
            GateVerdict::Clear { waited_s, first, until, .. } | GateVerdict::Best { waited_s, first, until, .. } => {
                Some((*waited_s, *first, *until))
            }
            GateVerdict::NotClear { .. } | GateVerdict::Skipped(_) => None,
        }
    }
}

/// Changes of the counters by one run.
pub struct Counted {
    verdict: &'static str,
    waited_s: f64,
    fault: Option<FaultKind>,
}

impl Counted {
    pub fn from_result(result: &Result<GateVerdict, Fault>) -> Self {
        let (verdict, waited_s) = match result {
            Ok(GateVerdict::Clear { waited_s, .. } | GateVerdict::Best { waited_s, .. }) if *waited_s > 0.0 => {
                ("waited", *waited_s)
            }
            Ok(GateVerdict::Clear { .. }) => ("clear", 0.0),
            Ok(GateVerdict::Best { .. }) => ("started", 0.0),
            Ok(GateVerdict::NotClear { .. }) => ("not_clear", 0.0),
            Ok(GateVerdict::Skipped(_)) => ("skipped", 0.0),
            Err(_) => ("fault", 0.0),
        };
        Self { verdict, waited_s, fault: result.as_ref().err().map(|fault| fault.kind) }
    }
}

/// Writes the status of a run, with the counters over all runs. Returns a warning if the counters before it are lost.
pub fn write_final(path: &Path, mut status: Map<String, Value>, counted: &Counted) -> std::io::Result<Option<String>> {
    let _lock = status_file::lock(path);
    let Before { mut counters, satellites, is_damaged } = status_file::read(Some(path));
    if counters.runs == 0 {
        counters.since_utc = status.get("began_utc").and_then(Value::as_str).map(str::to_owned);
    }
    counters.waited_s += counted.waited_s;
    counters.runs = counters.runs.saturating_add(1);
    match counted.verdict {
        "waited" => counters.waited = counters.waited.saturating_add(1),
        "started" => counters.started = counters.started.saturating_add(1),
        "clear" => counters.clear = counters.clear.saturating_add(1),
        "not_clear" => counters.not_clear = counters.not_clear.saturating_add(1),
        "skipped" => counters.skipped = counters.skipped.saturating_add(1),
        _ => {}
    }
    if let Some(kind) = counted.fault {
        let count = counters.faults.entry(kind.name().to_owned()).or_default();
        *count = count.saturating_add(1);
    }
    if let (None, Some(satellites)) = (status.get("satellites"), satellites) {
        state(&mut status, "satellites", satellites);
    }
    state(&mut status, "counters", json!(counters));
    status_file::write(path, &status)?;
    Ok(is_damaged.then(|| damaged(path)))
}

fn damaged(path: &Path) -> String {
    format!("{} was damaged: its counters start again", path.display())
}

/// Adds a statement to the status.
pub fn state(status: &mut Map<String, Value>, name: &str, value: impl Into<Value>) {
    status.insert(name.to_owned(), value.into());
}

/// Returns the part of the log line that states by how much an exposure without a wait starts after the last start that
/// was judged; empty if it is in time.
fn late(waited_s: f64, until: Epoch, now: Epoch) -> String {
    let late_s = seconds_between(until, now);
    // Less is printed as 0.0 s.
    if waited_s > 0.0 || late_s < 0.05 {
        return String::new();
    }
    format!(" ({late_s:.1} s ago, because the computation took longer than --margin)")
}

/// Returns the log line of a run.
pub fn line(result: &Result<GateVerdict, Fault>, flags: &Flags) -> String {
    let now = flags.clock.now();
    // With --strict the host does not start the exposure.
    let starts = |text: &'static str| if flags.strict { "" } else { text };
    match result {
        Ok(GateVerdict::Clear { waited_s, until, most_s, is_limited, .. }) => {
            let after = if *waited_s > 0.0 { format!("after {waited_s:.1} s") } else { "now".to_owned() };
            let others = if *is_limited { "; satellites that exceed no limit may cross" } else { "" };
            let costs = most_s.map(|most_s| format!(", streaks cost at most {most_s} s")).unwrap_or_default();
            let late = if most_s.is_some() { late(*waited_s, *until, now) } else { String::new() };
            format!("gate: clear {after}{costs}, starts until at least {}{late}{others}", format_utc(*until, 0))
        }
        Ok(GateVerdict::Best { waited_s, until, best, .. }) => {
            let (after, instead) = match *waited_s > 0.0 {
                true => (format!("after {waited_s:.1} s"), format!(" instead of {:.2} s", best.scheduled_cost_s)),
                false => ("now".to_owned(), String::new()),
            };
            format!(
                "gate: start {after}, streaks cost {:.2} s{instead}, starts until at least {}{}",
                best.streak_cost_s,
                format_utc(*until, 1),
                late(*waited_s, *until, now)
            )
        }
        Ok(GateVerdict::NotClear { most_s }) => {
            let starts = starts("; the exposure starts and will be streaked");
            let costs = most_s.map(|most_s| format!(" at which streaks cost at most {most_s} s")).unwrap_or_default();
            format!("warning: gate: no clear start within {} s{costs}{starts}", flags.max_wait_s)
        }
        Ok(GateVerdict::Skipped(why)) => format!("gate: {why}: no wait"),
        Err(fault) => {
            let starts = starts(", the exposure starts");
            format!("warning: gate: {fault}; satellites were not checked{starts}")
        }
    }
}

/// Name of the Sun's altitude in the status.
pub const SUN_ALTITUDE: &str = "sun_altitude_deg";
/// Altitude of the Sun above which the line of a run states it, degrees: the end of civil twilight.
const TWILIGHT_DEG: f64 = -6.0;

/// Returns a remark for the line of a run by daylight or in bright twilight, for which the search for clear starts does
/// not wait; empty by night.
pub fn daylight(status: &Map<String, Value>) -> String {
    let altitude_deg = status.get(SUN_ALTITUDE).and_then(Value::as_f64);
    let bright = altitude_deg.filter(|altitude_deg| *altitude_deg > TWILIGHT_DEG);
    bright.map(|altitude_deg| format!("; it is not dark: the Sun is at {altitude_deg:.1} deg")).unwrap_or_default()
}

/// Rounds a number to some decimals; `None` if it is not finite.
pub fn rounded(value: f64, decimals: i32) -> Option<f64> {
    let scale = 10_f64.powi(decimals);
    value.is_finite().then(|| (value * scale).round() / scale)
}

/// Writes the status file during a wait, with the counters of the last run; the counters are updated at the end of this
/// run. Returns a warning if they are lost.
pub fn write_waiting(path: &Path, mut status: Map<String, Value>) -> std::io::Result<Option<String>> {
    let _lock = status_file::lock(path);
    let Before { counters, is_damaged, .. } = status_file::read(Some(path));
    state(&mut status, "verdict", "waiting");
    state(&mut status, "counters", json!(counters));
    status_file::write(path, &status)?;
    Ok(is_damaged.then(|| damaged(path)))
}

#[cfg(test)]
mod tests {
    use streakcast::frames::seconds_after;

    use super::*;

    #[test]
    fn a_start_after_the_judged_ones_is_stated() {
        let until = streakcast::frames::parse_instant("2026-08-14T23:29:07Z", None).unwrap();
        let after = |waited_s: f64, late_s: f64| late(waited_s, until, seconds_after(until, late_s));
        assert_eq!(after(0.0, 3.25), " (3.2 s ago, because the computation took longer than --margin)");
        // In time; too little to be printed; after a wait, which has a fault of its own.
        assert_eq!([after(0.0, -1.0), after(0.0, 0.04), after(5.0, 3.0)], ["", "", ""]);
    }
}
