//! From raw cells to exposures: units, time scales, ranges. What is wrong with a row becomes its reason.

use std::path::Path;

use hifitime::{Epoch, TimeScale};

use crate::frames::{
    Direction, FIRST_YEAR, InstantError, LAST_YEAR, epoch_from_jd, epoch_from_mjd, is_covered, parse_instant,
};
use crate::passes::Exposure;

use super::error::ScheduleError;
use super::formats::{Cell, ColumnMap, RawTable, StartColumn, StartForm, display};
use super::scheduled::{Schedule, ScheduleOptions, ScheduledExposure};

/// The longest exposure that is taken for one: a day.
pub(super) const LONGEST_EXPOSURE_S: f64 = 86_400.0;

/// Gives every row of a raw table its meaning.
///
/// # Errors
/// Missing columns, units that are not what the names say, a time scale that nobody named, or no rows.
pub(super) fn schedule_from_raw(
    path: &Path,
    table: RawTable,
    options: &ScheduleOptions,
) -> Result<Schedule, ScheduleError> {
    if table.rows.is_empty() {
        // An empty array of JSON has no columns to miss.
        let no_columns = table.names.is_empty();
        let path = display(path);
        return Err(if no_columns { ScheduleError::Empty { path } } else { ScheduleError::NoRows { path } });
    }
    let map = ColumnMap::find(path, &table.names)?;
    check_units(path, &table, &map)?;
    let scale = start_scale(path, &table, &map.start, options)?;
    let exposures = table
        .rows
        .iter()
        .enumerate()
        .map(|(row, cells)| scheduled_exposure(row, cells, &map, scale, options))
        .collect();
    Ok(Schedule { format: table.format, exposures, start_column: map.start.name, time_scale: scale })
}

/// The scale of the shutter openings: the column's name, then the file's header, then the caller.
fn start_scale(
    path: &Path,
    table: &RawTable,
    start: &StartColumn,
    options: &ScheduleOptions,
) -> Result<TimeScale, ScheduleError> {
    let stated = table.time_scales.get(&start.name).copied();
    if let (Some(named), Some(stated)) = (start.scale, stated)
        && named != stated
    {
        let allowed = "the time scale that the column's name says";
        return Err(ScheduleError::Unit {
            path: display(path),
            column: start.name.clone(),
            unit: stated.to_string(),
            allowed,
        });
    }
    // Texts that all end in Z or an offset need no other word, and none can overrule them.
    let zoned = || {
        start.form == StartForm::Iso
            && table
                .rows
                .iter()
                .flatten()
                .filter_map(|cells| cells.get(start.index)?.text())
                .all(|text| !matches!(parse_instant(&text, None), Err(InstantError::NoScale(_))))
    };
    if let (Some(named), Some(said)) = (start.scale.or(stated), options.time_scale)
        && named != said
        && !zoned()
    {
        let (path, column) = (display(path), start.name.clone());
        return Err(ScheduleError::OtherTimeScale { path, column, named, said });
    }
    start
        .scale
        .or(stated)
        .or(options.time_scale)
        .or(options.default_time_scale)
        .or_else(|| zoned().then_some(TimeScale::UTC))
        .ok_or_else(|| ScheduleError::NoTimeScale { path: display(path), column: start.name.clone() })
}

fn check_units(path: &Path, table: &RawTable, map: &ColumnMap) -> Result<(), ScheduleError> {
    let degrees: &[&str] = &["deg", "degree", "degrees"];
    let seconds: &[&str] = &["s", "second", "seconds"];
    let expected = [
        (Some(map.right_ascension), degrees, "deg"),
        (Some(map.declination), degrees, "deg"),
        (map.rotation, degrees, "deg"),
        (Some(map.duration), seconds, "s"),
    ];
    for (index, spellings, allowed) in expected {
        let Some(column) = index.and_then(|index| table.names.get(index)) else { continue };
        if let Some(unit) = table.units.get(column).filter(|unit| !spellings.contains(&unit.as_str())) {
            let (column, unit) = (column.clone(), unit.clone());
            return Err(ScheduleError::Unit { path: display(path), column, unit, allowed });
        }
    }
    Ok(())
}

fn scheduled_exposure(
    row: usize,
    cells: &Result<Vec<Cell>, String>,
    map: &ColumnMap,
    scale: TimeScale,
    options: &ScheduleOptions,
) -> ScheduledExposure {
    let numbered = || (row + 1).to_string();
    let cells = match cells {
        Ok(cells) => cells,
        Err(reason) => return ScheduledExposure { id: numbered(), row, band: None, exposure: Err(reason.clone()) },
    };
    let cell = |index: usize| cells.get(index).unwrap_or(&Cell::Missing);
    let id = map.id.and_then(|index| cell(index).text()).unwrap_or_else(numbered);
    let band = map.band.and_then(|index| cell(index).text());
    let exposure = exposure(&id, cell, map, scale, options);
    ScheduledExposure { id, row, band, exposure }
}

fn exposure<'a>(
    id: &str,
    cell: impl Fn(usize) -> &'a Cell,
    map: &ColumnMap,
    scale: TimeScale,
    options: &ScheduleOptions,
) -> Result<Exposure, String> {
    let number = |index: usize, name: &str, range: std::ops::RangeInclusive<f64>| {
        let value = cell(index).number().map_err(|what| format!("{name} {what}"))?;
        if range.contains(&value) {
            Ok(value)
        } else {
            Err(format!("{name} is {value}, allowed {} to {}", range.start(), range.end()))
        }
    };
    let start = start_of(cell(map.start.index), &map.start, scale)?;
    let duration_s = number(map.duration, "duration", 0.0..=LONGEST_EXPOSURE_S)?;
    // Right ascensions are written from 0 to 360 or from -180 to 180.
    let right_ascension_deg = number(map.right_ascension, "right ascension", -180.0..=360.0)?;
    let declination_deg = number(map.declination, "declination", -90.0..=90.0)?;
    let rotation_rad = match map.rotation.map(&cell) {
        None | Some(Cell::Missing) => options.default_rotation_rad,
        Some(value) => value.number().map_err(|what| format!("rotation {what}"))?.to_radians(),
    };
    Ok(Exposure {
        id: id.to_owned(),
        start,
        duration_s,
        pointing: Direction::from_lon_lat_rad(right_ascension_deg.to_radians(), declination_deg.to_radians()),
        rotation_rad,
    })
}

fn start_of(cell: &Cell, column: &StartColumn, scale: TimeScale) -> Result<Epoch, String> {
    let number = || cell.number().map_err(|what| format!("start {what}"));
    let start = match column.form {
        StartForm::Iso => {
            let text = cell.text().ok_or("start is missing")?;
            parse_instant(&text, Some(scale)).map_err(|error| format!("start {error}"))?
        }
        StartForm::Mjd => epoch_from_mjd(number()?, scale).map_err(|error| format!("start {error}"))?,
        StartForm::Jd => epoch_from_jd(number()?, scale).map_err(|error| format!("start {error}"))?,
    };
    if is_covered(start) {
        Ok(start)
    } else {
        let shown = crate::output::format_utc(start, 0);
        Err(format!("start {shown} is covered by no ephemeris, allowed {FIRST_YEAR} to {LAST_YEAR}"))
    }
}
