//! Measured magnitudes of a pass, which correct the predicted magnitudes of the same pass.

use std::collections::BTreeMap;
use std::path::Path;

use hifitime::{Epoch, TimeScale};

use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{parse_instant, seconds_between};
use crate::geometry::ViewingGeometry;
use crate::input::TableRows;
use crate::photometry::{Brightness, Magnitude, PassUpdate};
use crate::units::MAGNITUDES;

/// Longest interval between two measurements of one pass, seconds. A pass of a low satellite takes some ten minutes,
/// and the next one is an orbit later.
pub const LONGEST_PASS_GAP_S: f64 = 1200.0;
/// Range of measured magnitudes.
const MAGNITUDE_RANGE: [f64; 2] = [-30.0, 40.0];

/// Flags of measurements that are not used: limits, fluxes of less than half of a streak, and streaks that may be of
/// another satellite.
const UNUSED_FLAGS: [&str; 4] = ["saturated", "clipped", "masked", "position"];

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

/// Reads a CSV or ECSV table with the columns `norad_id`, `mid_utc`, `magnitude` and `magnitude_sigma`, for example one
/// that `streakcast measure` wrote. Lines that begin with `#`, rows without a magnitude, and rows whose `flags` contain
/// `saturated`, `clipped`, `masked` or `position` or whose `calibrated` is `false` are omitted, and so are streaks of
/// unknown satellites in a table with the column `streak` (`measure --streaks`).
///
/// # Errors
/// The file cannot be read, a column is missing or a value is invalid.
pub fn read_measured(path: &Path) -> Result<Vec<MeasuredMagnitude>, Error> {
    let error = |problem: String| Error::format(problem).in_file("", path);
    let failed = |problem: std::io::Error| error(problem.to_string());
    let rows = TableRows::open(path).map_err(failed)?;
    let form = "a table with the columns norad_id, mid_utc, magnitude and magnitude_sigma";
    let column = |name| rows.column(name, form).map_err(failed);
    let magnitudes = |name| rows.numbers(&[name], &MAGNITUDES, form).map_err(failed);
    let [id, time, magnitude, sigma] =
        [column("norad_id")?, column("mid_utc")?, magnitudes("magnitude")?, magnitudes("magnitude_sigma")?];
    let [flags, calibrated] = [rows.find("flags"), rows.find("calibrated")];
    let has_given_tracks = rows.find("streak").is_some();
    let mut measured = Vec::new();
    for row in rows {
        let row = row.map_err(failed)?;
        if row.is_missing(magnitude) || has_given_tracks && row.is_missing(id) {
            continue;
        }
        let is_doubtful = flags.is_some_and(|flags| UNUSED_FLAGS.iter().any(|flag| row.text(flags).contains(flag)));
        let is_calibrated = calibrated.map(|column| row.truth(column)).transpose().map_err(failed)?;
        if is_doubtful || is_calibrated == Some(false) {
            continue;
        }
        let wrong_time = || failed(row.wrong(time, "a time in UTC, such as 2026-08-14T23:36:25Z"));
        measured.push(MeasuredMagnitude {
            norad_id: NoradId(row.parsed(id, "a catalogue number").map_err(failed)?),
            epoch: parse_instant(row.text(time), Some(TimeScale::UTC)).map_err(|_| wrong_time())?,
            magnitude: Magnitude(row.number_in(magnitude, MAGNITUDE_RANGE).map_err(failed)?),
            // An empty cell is an unknown error, not an error of 0.
            sigma_mag: row.number_in(sigma, [0.0, 10.0]).map_err(failed)?,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<MeasuredMagnitude>, Error> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read_measured(file.path())
    }

    #[test]
    fn unknown_errors_and_states_are_not_zero_or_true() {
        let names = "norad_id,mid_utc,magnitude,magnitude_sigma,calibrated,flags";
        let row = |magnitude, sigma, calibrated, flags| {
            read(&format!("{names}\n44714,2026-08-14T23:36:25Z,{magnitude},{sigma},{calibrated},{flags}\n"))
        };
        assert_eq!(row("5.5", "0.1", "True", "width").unwrap()[0].sigma_mag, 0.1);
        for (magnitude, calibrated, flags) in
            [("nan", "True", ""), ("", "true", ""), ("5.5", "False", ""), ("5.5", "true", "masked width")]
        {
            assert!(row(magnitude, "0.1", calibrated, flags).unwrap().is_empty(), "{magnitude} {calibrated} {flags}");
        }
        for (sigma, calibrated, part) in [
            ("", "true", "line 2: magnitude_sigma is ''; allowed: a number from 0 to 10"),
            ("0.1", "0", "line 2: calibrated is '0'; allowed: true or false"),
        ] {
            let error = row("5.5", sigma, calibrated, "").unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        let in_unit = |unit: &str| {
            let header = format!(
                "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n# - {{name: magnitude, unit: {unit}, datatype: float64}}\n"
            );
            let names = "norad_id,mid_utc,magnitude,magnitude_sigma";
            read(&format!("{header}{names}\n44714,2026-08-14T23:36:25Z,5500,0.1\n"))
        };
        assert!((in_unit("mmag").unwrap()[0].magnitude.0 - 5.5).abs() < 1e-9);
        assert!(in_unit("s").unwrap_err().to_string().contains("column magnitude is in 's'; allowed: mag"));
        let twice = format!("{names},magnitude\n44714,2026-08-14T23:36:25Z,5,0.1,true,,6\n");
        let error = read(&twice).unwrap_err().to_string();
        assert!(error.contains("two columns have the name magnitude"), "{error}");
    }
}
