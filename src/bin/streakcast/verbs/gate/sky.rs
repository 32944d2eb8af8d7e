//! Sky of a run of the gate: element files that may be incomplete are read again, or are a fault.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use serde_json::{Map, Value};
use streakcast::config::{Config, NameOrTable, PreparedSky, SiteConfig, SiteTable};
use streakcast::frames::seconds_after;
use streakcast::geometry::Site;

use super::arguments::{Flags, Request};
use super::deadline::{Step, left};
use super::report::state;
use super::status_file;
use super::status_file::{Fault, FaultKind};
use crate::notices::Notices;
use streakcast::{Error, ErrorKind};

/// Age below which an element file may still be incomplete.
const FRESH: Duration = Duration::from_secs(10);
/// Age above which an element file is taken as complete.
const SETTLED: Duration = Duration::from_secs(600);
/// Largest number of attempts to read element files.
const TRIES: usize = 4;
/// Pause between two attempts.
const RETRY: Duration = Duration::from_millis(300);
/// Longest attempt after which another one is made: larger files are read once.
const LONGEST_TRY: Duration = Duration::from_secs(1);

/// Prepares the sky over the site. If an element file may be incomplete, it is read again.
pub fn prepare(
    flags: &Flags,
    request: &Request,
    site: &Site,
    step: &Step,
    status: &mut Map<String, Value>,
    notices: &Notices,
) -> Result<PreparedSky, Fault> {
    let named = NameOrTable::Table(SiteTable {
        name: Some(site.name.clone()),
        mpc: None,
        latitude_deg: Some(site.latitude_rad.to_degrees()),
        longitude_deg: Some(site.longitude_rad.to_degrees()),
        height_m: Some(site.height_m),
    });
    let site = SiteConfig { named: Some(named), ..SiteConfig::default() };
    let config = Config { site, ..request.config.clone() };
    let now = flags.clock.now();
    let setup_fault = |error| Fault::new(FaultKind::Setup, error);
    let files = config.element_files_at(now).map_err(setup_fault)?;
    let of_all_nights = config.element_files().map_err(setup_fault)?;
    let is_of_elements = |error: &Error| is_of_elements(error, &of_all_nights, &config);
    if let Some(path) = &flags.host.status_file {
        step.begin(format!("reading {}", path.display()));
    }
    let satellites_before = status_file::read(flags.host.status_file.as_deref()).satellites;
    let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    step.begin(if names.is_empty() {
        "reading the inputs".to_owned()
    } else {
        format!("reading {}", names.join(", "))
    });
    let mut tries = 1;
    let prepared = loop {
        let attempt = Instant::now();
        let prepared = config.prepare(now, seconds_after(now, flags.max_wait_s));
        let is_done = match &prepared {
            Err(error) => !is_of_elements(error),
            Ok(prepared) => {
                rejected(prepared) == 0 || files.iter().all(|path| age(path).is_none_or(|age| age >= FRESH))
            }
        };
        let took = attempt.elapsed();
        let has_time = took < LONGEST_TRY && left(flags.deadline, flags.timeout) > RETRY + 2 * took;
        if is_done || tries == TRIES || !has_time {
            break prepared;
        }
        tries += 1;
        // The file may be being written, so the pause is real also in a rehearsal.
        std::thread::sleep(RETRY);
    };
    let prepared = prepared.map_err(|error| {
        Fault::new(if is_of_elements(&error) { FaultKind::Elements } else { FaultKind::Setup }, error)
    })?;
    notices.warn(&prepared.warnings);
    let (satellites, rejected) = (prepared.sky.elements().len(), rejected(&prepared));
    state(status, "elements_rejected", rejected);
    // Far fewer satellites than in the last run mean that the file is incomplete, unless it is old enough.
    let cut_short = is_cut_short(&prepared);
    let least = |before: usize| if cut_short { before - before / 10 } else { before.div_ceil(2) };
    let is_settled =
        files.is_empty() || !cut_short && files.iter().all(|path| age(path).is_some_and(|age| age >= SETTLED));
    let shrank = satellites_before.filter(|before| satellites < least(*before) && !is_settled);
    if rejected > satellites || shrank.is_some() {
        let before = shrank.map_or_else(String::new, |before| format!(", {before} in the last run"));
        let message =
            format!("elements may be incomplete: {satellites} satellites, {rejected} records rejected{before}");
        return Err(Fault::new(FaultKind::Elements, message));
    }
    state(status, "satellites", satellites);
    Ok(prepared)
}

/// Returns true if an error is in the element files, or in their satellites at the time of the exposure.
fn is_of_elements(error: &Error, elements: &BTreeSet<PathBuf>, config: &Config) -> bool {
    // Another input may lie in a folder of elements.
    let is_other =
        |file: &Path| config.qs_mag.iter().chain(&config.learned).chain(&config.measured).any(|other| other == file);
    let is_in = |file: &Path| elements.iter().any(|given| file.starts_with(given)) && !is_other(file);
    error.kind() == ErrorKind::NoPosition || error.file().is_some_and(is_in)
}

fn rejected(prepared: &PreparedSky) -> usize {
    let attached = prepared.provenance.attached().find(|(name, _)| *name == "rejected_count");
    attached.and_then(|(_, count)| count.as_u64()).map_or(0, |count| count as usize)
}

fn is_cut_short(prepared: &PreparedSky) -> bool {
    let attached = prepared.provenance.attached().find(|(name, _)| *name == "cut_short");
    attached.and_then(|(_, names)| names.as_array()).is_some_and(|names| !names.is_empty())
}

/// Returns the time since the last change of a file; `None` if it is in the future.
fn age(path: &Path) -> Option<Duration> {
    let changed = std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok()?;
    SystemTime::now().duration_since(changed).ok()
}
