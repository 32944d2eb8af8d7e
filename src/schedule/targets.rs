//! Target lists: name, position and exposure time of each target, in the file formats of schedules.

use std::path::Path;

use hifitime::Epoch;

use super::error;
use super::formats::{Cell, Checks, DECLINATIONS, RIGHT_ASCENSIONS, ROTATIONS, TARGET_DURATIONS, read_raw};
use super::windows::WindowTarget;
use crate::constants::{LONGEST_EXPOSURE_S, ROTATIONS_DEG};
use crate::error::Error;
use crate::frames::{Direction, parse_declination_deg, parse_right_ascension_deg};
use crate::passes::Exposure;
use crate::units::{DEGREES, SECONDS, Unit};

const NAME: &[&str] = &["name", "target_name", "starname", "target"];
const UNIQUE_ID: &[&str] = &["unique_id", "id"];
const RIGHT_ASCENSION: &[&str] = &["ra_deg", "ra", "s_ra"];
const DECLINATION: &[&str] = &["dec_deg", "dec", "s_dec"];
const BAND: &[&str] = &["band", "filter"];

/// One row of a target list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedTarget {
    /// Name of the target; the row number, from 1, if the cell is empty.
    pub name: String,
    /// Identifier of the target in a scheduler; the name if the list has no such column.
    pub unique_id: String,
    /// The target, or the reason why the row is invalid.
    pub target: Result<WindowTarget, String>,
}

/// Target list.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetList {
    /// The rows in the order of the file.
    pub targets: Vec<ListedTarget>,
    /// Number of comments in CSV and ECSV that have as many cells as a row.
    pub comments_like_rows: usize,
    /// Warnings about the content of the file.
    pub warnings: Vec<String>,
}

/// Reads a target list (CSV, ECSV, JSON and the other formats of schedules).
///
/// Columns: `name, ra_deg (or ra), dec_deg (or dec), exposure_s (or exposure)`; optional: `unique_id, rotation_deg,
/// band`. Positions are ICRS, in degrees or as text such as `12h34m56s` and `-30d30m`; numbers in another unit that the
/// file or the name of the column states are converted. A row without a position is kept, with the reason.
/// `duration_s` and `rotation_rad` are used for rows without an exposure time or a rotation.
///
/// # Errors
/// Same as [`Schedule::read`](super::Schedule::read), and missing columns.
pub fn read_targets(path: &Path, duration_s: Option<f64>, rotation_rad: f64) -> Result<TargetList, Error> {
    // The readers are those of schedules.
    read(path, duration_s, rotation_rad).map_err(|error| error.with_purpose("schedule", "target list"))
}

fn read(path: &Path, duration_s: Option<f64>, rotation_rad: f64) -> Result<TargetList, Error> {
    let table = read_raw(path)?;
    let find = |accepted: &[&str]| accepted.iter().find_map(|name| table.names.iter().position(|found| found == name));
    let with_unit = |unit: &Unit, accepted: &[&str]| {
        unit.find(accepted, &table.names).map_err(|error| error.in_file("schedule", path))
    };
    let columns = [
        find(NAME),
        with_unit(&DEGREES, RIGHT_ASCENSION)?,
        with_unit(&DEGREES, DECLINATION)?,
        with_unit(&SECONDS, TARGET_DURATIONS.names)?,
    ];
    let needed = [("name", true), ("ra_deg", true), ("dec_deg", true), ("exposure_s", duration_s.is_none())];
    let missing: Vec<&str> = columns
        .iter()
        .zip(needed)
        .filter_map(|(column, (name, is_needed))| (column.is_none() && is_needed).then_some(name))
        .collect();
    if !missing.is_empty() {
        return Err(Error::format(format!("missing {}; found {}", missing.join(", "), table.names.join(", ")))
            .allowing("name, ra_deg, dec_deg, exposure_s (or --exposure) and, if known, unique_id, rotation_deg, band")
            .in_file("schedule", path));
    }
    if table.rows.is_empty() {
        return Err(error::no_rows(path));
    }
    let (unique_id, rotation, band) = (find(UNIQUE_ID), with_unit(ROTATIONS.unit, ROTATIONS.names)?, find(BAND));
    let [name, right_ascension, declination, exposure] = columns;
    let scale = |column: Option<usize>, unit: &Unit| column.map_or(Ok(1.0), |index| table.scale(path, index, unit));
    let scales = [
        scale(right_ascension, &DEGREES)?,
        scale(declination, &DEGREES)?,
        scale(exposure, &SECONDS)?,
        scale(rotation, &DEGREES)?,
    ];
    let read = [
        (exposure, &TARGET_DURATIONS),
        (right_ascension, &RIGHT_ASCENSIONS),
        (declination, &DECLINATIONS),
        (rotation, &ROTATIONS),
    ];
    let checks = Checks::find(path, &table, &read, None)?;
    let listed = table.rows.iter().enumerate().map(|(row, cells)| {
        let numbered = (row + 1).to_string();
        let cells = match cells.as_ref() {
            Ok(cells) => cells,
            Err(reason) => {
                return ListedTarget { name: numbered.clone(), unique_id: numbered, target: Err(reason.clone()) };
            }
        };
        let cell = |column: Option<usize>| column.and_then(|column| cells.get(column)).unwrap_or(&Cell::Missing);
        let name = cell(name).text().unwrap_or(numbered);
        let cells_of_target = TargetCells {
            right_ascension: cell(right_ascension).scaled(scales[0]),
            declination: cell(declination).scaled(scales[1]),
            exposure: cell(exposure).scaled(scales[2]),
            rotation: cell(rotation).scaled(scales[3]),
        };
        let target = cells_of_target.exposure(&name, duration_s, rotation_rad);
        let target = target.and_then(|exposure| checks.reject(|index| cell(Some(index))).map(|()| exposure));
        let target = target.map(|exposure| WindowTarget { exposure, band: cell(band).text() });
        ListedTarget { unique_id: cell(unique_id).text().unwrap_or_else(|| name.clone()), name, target }
    });
    Ok(TargetList {
        targets: listed.collect(),
        comments_like_rows: table.comments_like_rows,
        warnings: table.warnings.clone(),
    })
}

/// Cells of a target in degrees and seconds.
struct TargetCells {
    right_ascension: Cell,
    declination: Cell,
    exposure: Cell,
    rotation: Cell,
}

impl TargetCells {
    fn exposure(&self, name: &str, duration_s: Option<f64>, rotation_rad: f64) -> Result<Exposure, String> {
        let position = |cell: &Cell, what: &str, example: &str| {
            cell.text().ok_or_else(|| format!("{what} is missing; allowed: degrees, or text such as {example}"))
        };
        let right_ascension_deg =
            parse_right_ascension_deg(&position(&self.right_ascension, "right ascension", "12h34m")?)
                .map_err(|e| e.to_string())?;
        let declination_deg = parse_declination_deg(&position(&self.declination, "declination", "-30d30m")?)
            .map_err(|e| e.to_string())?;
        let duration_s = match (&self.exposure, duration_s) {
            (Cell::Missing, Some(duration_s)) => duration_s,
            (Cell::Missing, None) => return Err("exposure is missing; allowed: seconds, or --exposure TIME".to_owned()),
            (cell, _) => cell.number().map_err(|what| format!("exposure {what}; allowed: seconds"))?,
        };
        if !(duration_s > 0.0 && duration_s <= LONGEST_EXPOSURE_S) {
            return Err(format!("exposure is {duration_s} s; allowed: above 0 to {LONGEST_EXPOSURE_S}"));
        }
        let rotation_rad = match &self.rotation {
            Cell::Missing => rotation_rad,
            cell => {
                let rotation_deg = cell.number().map_err(|what| format!("rotation {what}; allowed: -360 to 360"))?;
                if !ROTATIONS_DEG.contains(&rotation_deg) {
                    return Err(format!("rotation is {rotation_deg}; allowed: -360 to 360"));
                }
                rotation_deg.to_radians()
            }
        };
        Ok(Exposure {
            id: name.to_owned(),
            // The start is not used: windows are computed for all start times of a range.
            start: Epoch::from_gregorian_utc_at_midnight(2000, 1, 1),
            duration_s,
            pointing: Direction::from_lon_lat_rad(right_ascension_deg.to_radians(), declination_deg.to_radians()),
            rotation_rad,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, text: &str, duration_s: Option<f64>) -> Result<Vec<ListedTarget>, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        read_targets(&path, duration_s, 0.0).map(|list| list.targets)
    }

    #[test]
    fn contradictory_columns_and_comments_like_rows_are_found() {
        let csv = "name,ra,dec,exposure_s,exposure,equinox\na,10,20,30,30,2000\n#b,10,20,30,30,2000\n\
            c,10,20,30,300,2000\nd,10,20,30,30,1950\n";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, csv).unwrap();
        let list = read_targets(&path, None, 0.0).unwrap();
        let reasons = list.targets.iter().map(|listed| listed.target.as_ref().err().cloned().unwrap_or_default());
        let reasons: Vec<String> = reasons.collect();
        assert_eq!((list.comments_like_rows, reasons[0].as_str()), (1, ""));
        assert!(reasons[1].starts_with("exposure_s is 30 and exposure is 300"), "{reasons:?}");
        assert!(reasons[2].starts_with("equinox is 1950"), "{reasons:?}");
        let csv = "name,ra,dec,exposure,dec_deg,rotation,exposure_min\na,10,20,60,20,90,1\nb,10,-50d00m,60,-30,0,1\n\
            c,10,20,60,20,90,2\nd,10,-50,60,-30,0,1\n";
        let targets = read("t.csv", csv, None).unwrap();
        let exposure = &targets[0].target.as_ref().unwrap().exposure;
        assert_eq!(exposure.rotation_rad, 90_f64.to_radians());
        for (target, expected) in targets[1..].iter().zip([
            "dec_deg is -30 and dec is -50d00m",
            "exposure is 60 and exposure_min is 2",
            "dec_deg is -30 and dec is -50",
        ]) {
            let reason = target.target.as_ref().unwrap_err();
            assert!(reason.starts_with(expected), "{reason}");
        }
    }

    #[test]
    fn one_list_in_its_spellings() {
        let csv = "name,ra,dec,exposure\nM 31,00h42m44s,+41d16m09s,300\nwhere,,,60\nlong,1,2,-3\n";
        let targets = read("t.csv", csv, None).unwrap();
        let exposure = &targets[0].target.as_ref().unwrap().exposure;
        assert!((exposure.pointing.longitude_rad().to_degrees() - 10.683_333).abs() < 1e-5);
        assert_eq!((exposure.duration_s, targets[0].unique_id.as_str()), (300.0, "M 31"));
        assert_eq!(
            targets[1].target,
            Err("right ascension is missing; allowed: degrees, or text such as 12h34m".into())
        );
        assert!(targets[2].target.as_ref().unwrap_err().contains("-3 s; allowed: above 0 to 86400"));
        let json = r#"{"targets": [{"unique_id": 7, "starname": "HD 1", "ra_deg": 10.5, "dec_deg": -3, "band": "r"}]}"#;
        let target = read("t.json", json, Some(30.0)).unwrap().remove(0);
        assert_eq!((target.unique_id.as_str(), target.name.as_str()), ("7", "HD 1"));
        let target = target.target.unwrap();
        assert_eq!((target.exposure.duration_s, target.band.as_deref()), (30.0, Some("r")));
        let message = read("t.csv", "name,ra\nx,1\n", None).unwrap_err().to_string();
        assert!(message.contains("missing dec_deg, exposure_s; found name, ra"), "{message}");
    }
}
