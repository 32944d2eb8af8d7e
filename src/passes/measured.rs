//! Measured magnitudes of a pass, which correct the predicted magnitudes of the same pass.

use std::collections::BTreeMap;
use std::path::Path;

use hifitime::Epoch;
use thiserror::Error;

use crate::elements::{NoradId, parse_iso};
use crate::frames::seconds_between;
use crate::geometry::ViewingGeometry;
use crate::input;
use crate::photometry::{Brightness, Magnitude, PassUpdate};

/// Longest interval between two measurements of one pass, seconds. A pass of a low satellite takes some ten minutes,
/// and the next one is an orbit later.
pub const LONGEST_PASS_GAP_S: f64 = 1200.0;
/// Range of measured magnitudes.
const MAGNITUDES: [f64; 2] = [-30.0, 40.0];

/// Error of a table of measured magnitudes.
#[derive(Debug, Error)]
#[error("{file}: {problem}")]
pub struct MeasuredError {
    /// Name of the file.
    pub file: String,
    /// Problem, with row and allowed values.
    pub problem: String,
}

/// Measured apparent magnitude of a satellite, in the band of the predictions that it corrects.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MeasuredMagnitude {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Time.
    pub epoch: Epoch,
    /// Apparent magnitude.
    pub magnitude: Magnitude,
    /// Error (one sigma), mag.
    pub sigma_mag: f64,
}

/// Reads a CSV table with the columns `norad_id`, `mid_utc`, `magnitude` and `magnitude_sigma`, for example one that
/// `streakcast measure` wrote. Lines that begin with `#`, rows without a magnitude, and rows whose `flags` contain
/// `saturated` or whose `calibrated` is `false` are omitted.
///
/// # Errors
/// [`MeasuredError`] if the file cannot be read, a column is missing or a value is invalid.
pub fn read_measured(path: &Path) -> Result<Vec<MeasuredMagnitude>, MeasuredError> {
    let error = |problem: String| MeasuredError { file: path.display().to_string(), problem };
    let text = input::read_to_string(path).map_err(|problem| error(problem.to_string()))?;
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let names = reader.headers().map_err(|problem| error(problem.to_string()))?.clone();
    let find = |name: &str| names.iter().position(|column| column == name);
    let column = |name: &str| {
        let columns = "norad_id, mid_utc, magnitude and magnitude_sigma";
        find(name).ok_or_else(|| error(format!("no column {name}; allowed: a CSV table with the columns {columns}")))
    };
    let columns = [column("norad_id")?, column("mid_utc")?, column("magnitude")?, column("magnitude_sigma")?];
    let [flags, calibrated] = [find("flags"), find("calibrated")];
    let mut measured = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|problem| error(problem.to_string()))?;
        let cell = |at: usize| record.get(at).unwrap_or_default().trim();
        let [id, time, magnitude, sigma] = columns.map(cell);
        let is_limit = flags.is_some_and(|at| cell(at).contains("saturated"));
        let is_instrumental = calibrated.is_some_and(|at| cell(at).eq_ignore_ascii_case("false"));
        if magnitude.is_empty() || is_limit || is_instrumental {
            continue;
        }
        let wrong = |name: &str, given: &str, allowed: &str| {
            error(format!("row {}: {name} is '{given}'; allowed: {allowed}", row + 1))
        };
        let number = |name: &str, given: &str, [least, most]: [f64; 2]| {
            let value = given.parse::<f64>().ok().filter(|value| (least..=most).contains(value));
            value.ok_or_else(|| wrong(name, given, &format!("a number from {least} to {most}")))
        };
        measured.push(MeasuredMagnitude {
            norad_id: NoradId(id.parse().map_err(|_| wrong("norad_id", id, "a catalogue number"))?),
            epoch: parse_iso(time)
                .ok_or_else(|| wrong("mid_utc", time, "a time in UTC, such as 2026-08-14T23:36:25Z"))?,
            magnitude: Magnitude(number("magnitude", magnitude, MAGNITUDES)?),
            sigma_mag: if sigma.is_empty() { 0.0 } else { number("magnitude_sigma", sigma, [0.0, 10.0])? },
        });
    }
    Ok(measured)
}

/// Corrections of the passes of all satellites, by the index of their element sets.
#[derive(Clone, Debug, Default)]
pub(super) struct MeasuredPasses {
    passes: BTreeMap<usize, Vec<MeasuredPass>>,
}

/// Pass with measurements, and the times of the first and the last of them.
#[derive(Clone, Debug)]
pub(super) struct MeasuredPass {
    pub first: Epoch,
    pub last: Epoch,
    pub update: PassUpdate,
}

impl MeasuredPasses {
    pub fn new(passes: BTreeMap<usize, Vec<MeasuredPass>>) -> Self {
        Self { passes }
    }

    /// Returns the brightness of a satellite, corrected if it is measured in the same pass.
    pub fn apply(
        &self,
        element_index: usize,
        epoch: Epoch,
        geometry: &ViewingGeometry,
        light: Brightness,
    ) -> Brightness {
        let is_of = |pass: &&MeasuredPass| {
            seconds_between(epoch, pass.first) <= LONGEST_PASS_GAP_S
                && seconds_between(pass.last, epoch) <= LONGEST_PASS_GAP_S
        };
        match self.passes.get(&element_index).and_then(|passes| passes.iter().find(is_of)) {
            Some(pass) => pass.update.apply(geometry, light),
            None => light,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.passes.is_empty()
    }
}
