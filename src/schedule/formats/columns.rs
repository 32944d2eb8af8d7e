//! Column names of schedules, which are the same in all formats, and tables of cells.

use std::fmt;
use std::path::Path;

use hifitime::TimeScale;

use super::super::error::ALLOWED_COLUMNS;
use crate::error::Error;
use crate::message::{Quoted, listed};
use crate::units::{DEGREES, SECONDS, Unit};

/// Column names of the exposure identifier, in order of preference.
pub(in crate::schedule) const ID: &[&str] = &["exposure_id", "observationId", "visit_id", "obs_id", "id"];
/// Quantity with its names in schedules and target lists.
pub(in crate::schedule) struct Quantity {
    /// Names in order of preference.
    pub names: &'static [&'static str],
    pub unit: &'static Unit,
}

/// Exposure time of a visit of Rubin's simulations: the sum over its snaps.
const VISIT_EXPOSURE: &str = "visitExposureTime";
/// Names of durations. The last one is that of target lists only: in schedules it may be the number of an exposure.
const DURATION_NAMES: &[&str] =
    &["duration_s", "exposure_s", VISIT_EXPOSURE, "exptime", "exp_time", "t_exptime", "exposure"];

pub(in crate::schedule) static DURATIONS: Quantity =
    Quantity { names: DURATION_NAMES.split_at(DURATION_NAMES.len() - 1).0, unit: &SECONDS };
pub(in crate::schedule) static TARGET_DURATIONS: Quantity = Quantity { names: DURATION_NAMES, unit: &SECONDS };
pub(in crate::schedule) static RIGHT_ASCENSIONS: Quantity =
    Quantity { names: &["ra_deg", "ra", "fieldRA", "s_ra"], unit: &DEGREES };
pub(in crate::schedule) static DECLINATIONS: Quantity =
    Quantity { names: &["dec_deg", "dec", "fieldDec", "s_dec"], unit: &DEGREES };
pub(in crate::schedule) static ROTATIONS: Quantity =
    Quantity { names: &["rotation_deg", "rotation", "rotSkyPos", "sky_rotation"], unit: &DEGREES };

/// Number of snaps of a visit, and time from its start to its end with shutter and readout.
const SNAPS: &[&str] = &["numExposures", "nexp"];
const VISIT: &[&str] = &["visitTime"];
const RIGHT_ASCENSION: &[&str] = &["ra_deg", "fieldRA", "s_ra"];
const DECLINATION: &[&str] = &["dec_deg", "fieldDec", "s_dec"];
const ALTITUDE: &[&str] = &["altitude", "altitude_deg"];
const BAND: &[&str] = &["band", "filter"];

/// Form of the start times.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(in crate::schedule) enum StartForm {
    /// ISO 8601 text.
    Iso,
    /// Modified Julian dates.
    Mjd,
    /// Julian dates.
    Jd,
}

/// Column of the start or end times (shutter openings or closings).
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct StartColumn {
    /// Index of the column.
    pub index: usize,
    /// Name of the column.
    pub name: String,
    /// Form of its cells.
    pub form: StartForm,
    /// Time scale stated in its name.
    pub scale: Option<TimeScale>,
}

/// Start column of ObsLocTAP (used by Rubin's ObsPlan service). Only schedules with this column may lack identifiers.
const PLANNED_START: &str = "t_planning";

/// Start columns in order of preference; those with a time scale in their names are first.
const STARTS: &[(&str, StartForm, Option<TimeScale>)] = &[
    ("start_utc", StartForm::Iso, Some(TimeScale::UTC)),
    ("start_tai", StartForm::Iso, Some(TimeScale::TAI)),
    ("start_tt", StartForm::Iso, Some(TimeScale::TT)),
    ("start_mjd_utc", StartForm::Mjd, Some(TimeScale::UTC)),
    ("start_mjd_tai", StartForm::Mjd, Some(TimeScale::TAI)),
    ("start_mjd_tt", StartForm::Mjd, Some(TimeScale::TT)),
    ("start_jd_utc", StartForm::Jd, Some(TimeScale::UTC)),
    ("start_jd_tai", StartForm::Jd, Some(TimeScale::TAI)),
    ("start_jd_tt", StartForm::Jd, Some(TimeScale::TT)),
    ("start", StartForm::Iso, None),
    ("start_mjd", StartForm::Mjd, None),
    ("start_jd", StartForm::Jd, None),
    ("observationStartMJD", StartForm::Mjd, None),
    // "MJD ... TAI" in the schema of Rubin's consolidated database (sdm_schemas, cdb_lsstcam.yaml).
    ("obs_start_mjd", StartForm::Mjd, Some(TimeScale::TAI)),
    // ObsLocTAP specifies MJD without a scale.
    (PLANNED_START, StartForm::Mjd, None),
];

/// Returns the columns of start times, the preferred one first.
pub(in crate::schedule) fn start_columns(names: &[String]) -> impl Iterator<Item = StartColumn> + '_ {
    STARTS.iter().filter_map(|&(name, form, scale)| {
        let index = names.iter().position(|found| found == name)?;
        Some(StartColumn { index, name: name.to_owned(), form, scale })
    })
}

/// Returns the columns of end times (shutter closings), whose names are those of start times with `end` or `stop`.
pub(in crate::schedule) fn end_columns(names: &[String]) -> impl Iterator<Item = StartColumn> + '_ {
    let ends = STARTS.iter().filter(|(name, ..)| *name != PLANNED_START).flat_map(|&(name, form, scale)| {
        [["end", "End"], ["stop", "Stop"]].map(|[lower, upper]| {
            let name = name.replace("start", lower).replace("Start", upper);
            (name, form, scale)
        })
    });
    ends.filter_map(|(name, form, scale)| {
        let index = names.iter().position(|found| *found == name)?;
        Some(StartColumn { index, name, form, scale })
    })
}

/// Index of the column of each quantity.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct ColumnMap {
    /// Identifier; `None` only for ObsLocTAP, where the row number is the identifier.
    pub id: Option<usize>,
    pub start: StartColumn,
    pub duration: usize,
    pub right_ascension: usize,
    pub declination: usize,
    pub rotation: Option<usize>,
    pub band: Option<usize>,
    /// Number of snaps.
    pub snaps: Option<usize>,
    /// Time of the whole visit.
    pub visit: Option<usize>,
    /// Altitude of the pointing.
    pub altitude: Option<usize>,
    /// True if the duration is the sum over the snaps.
    pub is_sum: bool,
}

impl ColumnMap {
    /// Finds the columns by name.
    ///
    /// # Errors
    /// One error with all missing columns and all columns of the file; or a column that is read occurs twice.
    pub fn find(path: &Path, names: &[String]) -> Result<Self, Error> {
        let starts = STARTS.iter().map(|(name, ..)| name);
        let read = [ID, DURATIONS.names, SNAPS, VISIT, RIGHT_ASCENSION, DECLINATION, ROTATIONS.names, BAND].concat();
        for name in read.iter().chain(starts) {
            if names.iter().filter(|found| found == name).count() > 1 {
                return Err(Error::format(format!("column {} occurs twice", *name))
                    .allowing("once")
                    .in_file("schedule", path));
            }
        }
        let find = |accepted: &[&str]| accepted.iter().find_map(|name| names.iter().position(|found| found == name));
        let with_unit = |unit: &Unit, accepted: &[&str]| {
            unit.find(accepted, names).map_err(|error| error.in_file("schedule", path))
        };
        let start = start_columns(names).next();
        let (id, duration, right_ascension, declination) = (
            find(ID),
            with_unit(DURATIONS.unit, DURATIONS.names)?,
            with_unit(&DEGREES, RIGHT_ASCENSION)?,
            with_unit(&DEGREES, DECLINATION)?,
        );
        let needs_id = start.as_ref().is_none_or(|start| start.name != PLANNED_START);
        if let (Some(start), Some(duration), Some(right_ascension), Some(declination)) =
            (start.clone(), duration, right_ascension, declination)
            && (id.is_some() || !needs_id)
        {
            let (rotation, band) = (with_unit(ROTATIONS.unit, ROTATIONS.names)?, find(BAND));
            // An altitude with another unit is not that of a pointing.
            let altitude = DEGREES.find(ALTITUDE, names).ok().flatten();
            let (snaps, visit, is_sum) = (find(SNAPS), find(VISIT), names[duration] == VISIT_EXPOSURE);
            return Ok(Self {
                id,
                start,
                duration,
                right_ascension,
                declination,
                rotation,
                band,
                snaps,
                visit,
                altitude,
                is_sum,
            });
        }
        let missing: Vec<&str> = [
            ("exposure_id", id.is_none() && needs_id),
            ("start_utc", start.is_none()),
            ("duration_s", duration.is_none()),
            ("ra_deg", right_ascension.is_none()),
            ("dec_deg", declination.is_none()),
        ]
        .into_iter()
        .filter_map(|(name, is_missing)| is_missing.then_some(name))
        .collect();
        Err(Error::format(format!(
            "missing {}; found {}",
            missing.iter().map(|name| with_hint(name, names)).collect::<Vec<_>>().join(", "),
            names_text(names)
        ))
        .allowing(ALLOWED_COLUMNS)
        .in_file("schedule", path))
    }
}

/// Returns the name of a missing column, followed by the most similar name in the file if there is one. Similar names
/// differ only in case, in separators or in a few letters, or lack the unit.
fn with_hint(missing: &str, names: &[String]) -> String {
    let key = |name: &str| name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
    let expected = key(missing);
    // Up to a third of the letters may differ, for example two of a six-letter word.
    let near = names
        .iter()
        .filter(|name| name.len() <= 40)
        .map(|name| (key(name), name))
        .map(|(key, name)| (strsim::levenshtein(&expected, &key), key, name))
        .filter(|(distance, key, _)| 3 * distance <= expected.len() || (key.len() > 1 && expected.starts_with(&**key)))
        .min_by_key(|(distance, ..)| *distance);
    near.map_or_else(|| missing.to_owned(), |(.., name)| format!("{missing} (rename {name}?)"))
}

/// Returns the names as a list, shortened if there are many.
fn names_text(names: &[String]) -> String {
    if names.is_empty() { "no columns".to_owned() } else { listed(names.iter().map(String::as_str)) }
}

/// Format of a schedule file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum ScheduleFormat {
    /// A SQLite database with a table `observations`, as written by Rubin's simulations.
    Opsim,
    /// Comma, semicolon or tab separated text with a header line.
    Csv,
    /// astropy's ECSV.
    Ecsv,
    /// A JSON array of rows, or an object with the array `exposures`.
    Json,
    /// A VOTable with its first table in TABLEDATA.
    VoTable,
}

impl ScheduleFormat {
    /// Returns the usual extensions of files in this format, in lower case. CSV files may also have other extensions,
    /// such as `txt`.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            ScheduleFormat::Opsim => &["db", "sqlite", "sqlite3"],
            ScheduleFormat::Csv => &["csv", "tsv"],
            ScheduleFormat::Ecsv => &["ecsv"],
            ScheduleFormat::Json => &["json"],
            ScheduleFormat::VoTable => &["xml", "vot", "votable"],
        }
    }

    /// Returns the format whose usual extension is that of `path`.
    pub fn by_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let all = [Self::Opsim, Self::Csv, Self::Ecsv, Self::Json, Self::VoTable];
        all.into_iter().find(|format| format.extensions().contains(&&*extension))
    }
}

impl fmt::Display for ScheduleFormat {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            ScheduleFormat::Opsim => "opsim SQLite",
            ScheduleFormat::Csv => "CSV",
            ScheduleFormat::Ecsv => "ECSV",
            ScheduleFormat::Json => "JSON",
            ScheduleFormat::VoTable => "VOTable",
        })
    }
}

/// Returns a path as shown in messages.
pub(in crate::schedule) fn display(path: &Path) -> String {
    path.display().to_string()
}

/// One cell of a table file.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) enum Cell {
    /// Empty, NULL or absent.
    Missing,
    /// A number.
    Number(f64),
    /// Text, or an integer with all its digits.
    Text(String),
}

impl Cell {
    /// Creates a cell from trimmed text; an empty text is missing.
    pub fn from_text(text: &str) -> Self {
        match text.trim() {
            "" => Cell::Missing,
            text => Cell::Text(text.to_owned()),
        }
    }

    /// Returns the number. The error text follows the column name in the reason of an invalid row.
    pub fn number(&self) -> Result<f64, String> {
        let number = match self {
            Cell::Missing => return Err("is missing".to_owned()),
            Cell::Number(number) => *number,
            Cell::Text(text) => text.parse().map_err(|_| format!("'{}' is not a number", Quoted::new(text)))?,
        };
        if number.is_finite() { Ok(number) } else { Err(format!("is {number}")) }
    }

    /// Returns the cell with its number in another unit. Texts that are not numbers are unchanged.
    pub fn scaled(&self, scale: f64) -> Cell {
        match self {
            Cell::Text(text) if scale != 1.0 => {
                text.parse().map_or_else(|_| self.clone(), |number: f64| Cell::Number(number * scale))
            }
            Cell::Number(number) => Cell::Number(number * scale),
            cell => cell.clone(),
        }
    }

    /// Returns the text; `None` for a missing cell.
    pub fn text(&self) -> Option<String> {
        match self {
            Cell::Missing => None,
            Cell::Number(number) => Some(number.to_string()),
            Cell::Text(text) => Some(text.clone()),
        }
    }
}

/// Cells of a row, or the reason why the row is invalid.
pub(in crate::schedule) type ScheduleRow = Result<Vec<Cell>, String>;

#[cfg(test)]
mod tests {
    use super::*;

    fn find(names: &[&str]) -> Result<ColumnMap, Error> {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        ColumnMap::find(Path::new("night.csv"), &names)
    }

    #[test]
    fn a_column_with_a_time_scale_is_preferred() {
        let map = find(&["start_mjd", "start_utc", "dec_deg", "ra_deg", "duration_s", "exposure_id"]).unwrap();
        assert_eq!((map.start.name.as_str(), map.start.scale), ("start_utc", Some(TimeScale::UTC)));
        let map = find(&["start_mjd", "start_mjd_tai", "dec_deg", "ra_deg", "duration_s", "exposure_id"]).unwrap();
        assert_eq!((map.start.name.as_str(), map.start.scale), ("start_mjd_tai", Some(TimeScale::TAI)));
        assert_eq!((map.rotation, map.band), (None, None));
    }

    /// The names of tables of targets and of verdicts are both accepted; the first of the list is preferred.
    #[test]
    fn exposure_times_have_two_names() {
        let names = ["start_utc", "dec_deg", "ra_deg", "exposure_s", "exposure_id", "duration_s"];
        assert_eq!(find(&names[..5]).unwrap().duration, 3);
        assert_eq!(find(&names).unwrap().duration, 5);
    }

    #[test]
    fn one_message_lists_all_missing_columns() {
        let message = find(&["exposure_id", "ra", "dec_deg", "start_mjd"]).unwrap_err().to_string();
        assert!(
            message.starts_with(
                "schedule night.csv: missing duration_s, ra_deg (rename ra?); found exposure_id, ra, dec_deg"
            ),
            "{message}"
        );
        assert!(message.contains("allowed: exposure_id, start_utc"), "{message}");
        assert!(!message.contains('\n'));
    }
}
