//! Schedules: exposures in the order of their rows. An invalid row has a reason instead of an exposure.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::Path;

use hifitime::{Epoch, TimeScale};
use serde_json::{Value, json};

use super::error;
use super::formats::{
    Cell, Checks, ColumnMap, DECLINATIONS, DURATIONS, RIGHT_ASCENSIONS, ROTATIONS, RawTable, ScheduleFormat,
    ScheduleRow, StartColumn, StartForm, end_columns, read_raw, start_columns,
};
use super::policy::Policy;
use crate::constants::{DAY_S, LONGEST_EXPOSURE_S, ROTATIONS_DEG};
use crate::error::{Error, ErrorKind};
use crate::frames::{
    Direction, FIRST_YEAR, LAST_YEAR, check_time_of_day, epoch_from_jd, epoch_from_mjd, has_zone, is_covered,
    parse_instant, seconds_after, seconds_between,
};
use crate::input::comments_warning;
use crate::message::Quoted;
use crate::output::{counted, format_utc};
use crate::passes::Exposure;
use crate::units::{DAYS, DEGREES, SECONDS, Unit};

/// One row of a schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledExposure {
    /// Identifier of the exposure; the row number, from 1, if the schedule has no identifiers, and `row` with this
    /// number if only this row has none.
    pub id: String,
    /// Index of the row in the file, from 0.
    pub row: usize,
    /// Band as written in the file; `None` if the schedule has no band. Any name is accepted.
    pub band: Option<String>,
    /// Time with open shutter, seconds, if it is shorter than the exposure: a visit of several snaps lasts until the
    /// last one ends, with shutter and readout between them.
    pub open_s: Option<f64>,
    /// The exposure, or the reason why the row is invalid.
    pub exposure: Result<Exposure, String>,
}

impl ScheduledExposure {
    /// Returns the time with open shutter of the exposure of this row, seconds.
    pub(super) fn open_time_s(&self, exposure: &Exposure) -> f64 {
        self.open_s.unwrap_or(exposure.duration_s)
    }
}

/// Options for reading a schedule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScheduleOptions {
    /// Time scale of MJD, JD and times without `Z`. Such times are an error if neither this option, the file nor
    /// `default_time_scale` states a scale. It is an error if this option contradicts the file.
    pub time_scale: Option<TimeScale>,
    /// Time scale used if neither the file nor `time_scale` states one.
    pub default_time_scale: Option<TimeScale>,
    /// Rotation of the field for rows without a rotation, radians.
    pub default_rotation_rad: f64,
}

/// Exposures of a schedule file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Schedule {
    /// Format of the file.
    #[doc(hidden)]
    pub format: ScheduleFormat,
    /// The rows in the order of the file.
    pub exposures: Vec<ScheduledExposure>,
    /// Name of the column of start times (shutter opening).
    pub start_column: String,
    /// Time scale of the start times.
    pub time_scale: TimeScale,
    /// Number of comments in CSV and ECSV that have as many cells as a row. An identifier that begins with `#` must be
    /// in quotation marks.
    pub comments_like_rows: usize,
    /// Number of exposures for which a column has another end than start and duration, and the values of the first of
    /// them.
    pub(super) other_ends: Option<(usize, String)>,
    /// First exposures with the altitudes in a column of the file, degrees.
    pub(super) stated_altitudes: Vec<(Exposure, f64)>,
    /// Warnings about the content of the file.
    pub(super) warnings_of_file: Vec<String>,
}

impl Schedule {
    /// Reads a schedule. The format is determined from the contents.
    ///
    /// Rows with missing, non-finite or out-of-range cells are kept, with the reason.
    ///
    /// # Errors
    /// - The file is missing, a directory, empty or in another format.
    /// - A required column is missing, or its unit is unknown or contradicts its name. Other units are converted.
    /// - Times have no time scale, and `options` has none.
    pub fn read(path: &Path, options: &ScheduleOptions) -> Result<Self, Error> {
        schedule_from_raw(path, read_raw(path)?, options)
    }

    /// Returns the valid rows, each with its index in `exposures`.
    pub fn valid_exposures(&self) -> impl Iterator<Item = (usize, &Exposure)> {
        self.exposures
            .iter()
            .enumerate()
            .filter_map(|(index, scheduled)| scheduled.exposure.as_ref().ok().map(|exposure| (index, exposure)))
    }

    /// Returns the number of rows whose identifier also occurs in an earlier row.
    pub fn repeated_ids(&self) -> usize {
        // Takes less memory than a hash table of millions of texts.
        let mut ids: Vec<&str> = self.exposures.iter().map(|row| row.id.as_str()).collect();
        ids.sort_unstable();
        ids.windows(2).filter(|pair| pair[0] == pair[1]).count()
    }

    /// Returns warnings about the schedule and its limits.
    #[doc(hidden)]
    pub fn warnings(&self, policy: &Policy) -> Vec<String> {
        let mut warnings = self.warnings_of_file.clone();
        if self.format == ScheduleFormat::Opsim && self.time_scale != TimeScale::UTC {
            warnings.push(format!(
                "opsim databases have {} in UTC, but it is read as {}: crossings are those of other times unless the file was converted",
                self.start_column, self.time_scale
            ));
        }
        warnings.extend(comments_warning(self.comments_like_rows));
        warnings.extend(self.other_ends.as_ref().map(|(count, first)| {
            let exposures = counted(*count, "exposure ends", "exposures end");
            format!(
                "{exposures} at another time than the file states, which may include readout or several snaps: {first}"
            )
        }));
        let mut without = self.exposures.iter().filter(|exposure| exposure.id == unnamed(exposure.row)).peekable();
        if let Some(first) = without.peek().map(|exposure| exposure.id.as_str()) {
            let exposures = counted(without.count(), "exposure has", "exposures have");
            warnings.push(format!(
                "{exposures} no exposure_id, or a wrong number of cells; the results name them by their rows, the first as {first}"
            ));
        }
        let repeated = self.repeated_ids();
        if repeated > 0 {
            let exposures = counted(repeated, "exposure has", "exposures have");
            warnings.push(format!(
                "{exposures} the exposure_id of an earlier one, so that it does not identify the exposure of a streak"
            ));
        }
        warnings.extend(policy.band_warnings(&self.bands()));
        warnings
    }

    /// Returns the properties of the file for the provenance.
    #[doc(hidden)]
    pub fn statement(&self, path: &Path) -> Value {
        let first = self.valid_exposures().map(|(_, exposure)| exposure.start).min();
        json!({
            "file": path.display().to_string(),
            "format": self.format.to_string(),
            "exposures": self.exposures.len(),
            "start_column": self.start_column,
            "first_start_utc": first.map(|first| format_utc(first, 3)),
        })
    }

    /// Returns the bands of all rows; `None` for rows without a band.
    pub fn bands(&self) -> BTreeSet<Option<&str>> {
        self.exposures.iter().map(|row| row.band.as_deref()).collect()
    }
}

/// Converts a table of cells to a schedule.
///
/// # Errors
/// Columns or the time scale are missing, units contradict column names, or there are no rows.
fn schedule_from_raw(path: &Path, table: RawTable, options: &ScheduleOptions) -> Result<Schedule, Error> {
    if table.rows.is_empty() {
        // An empty JSON array has no columns.
        let no_columns = table.names.is_empty();
        return Err(if no_columns { error::empty(path) } else { error::no_rows(path) });
    }
    let map = ColumnMap::find(path, &table.names)?;
    if map.start.form != StartForm::Iso && table.single_precision.contains(&map.start.name) {
        return Err(Error::format(format!(
            "column {} has single precision, in which MJD have steps of 5 min and JD of 6 h",
            map.start.name
        ))
        .allowing("double precision (float64 in ECSV, double in VOTable), or times as text")
        .in_file("schedule", path));
    }
    let scales = Scales::read(path, &table, &map)?;
    if let Some(what) = table.rejected.get(&map.start.name) {
        return Err(error::format(path, format!("column {} {what}", map.start.name)));
    }
    let scale = start_scale(path, &table, &map.start, options)?;
    let read = [
        (Some(map.duration), &DURATIONS),
        (Some(map.right_ascension), &RIGHT_ASCENSIONS),
        (Some(map.declination), &DECLINATIONS),
        (map.rotation, &ROTATIONS),
    ];
    let checks = Checks::find(path, &table, &read, map.snaps.filter(|_| map.is_sum))?;
    let other_starts = with_scales(&table, start_columns(&table.names).filter(|column| *column != map.start), None);
    let ends = with_scales(&table, end_columns(&table.names), Some(scale).filter(|_| map.start.scale.is_none()));
    let (mut other_ends, mut most_decimals) = (None, None);
    let altitude = map.altitude.and_then(|index| Some((index, table.scale(path, index, &DEGREES).ok()?)));
    let mut stated_altitudes = Vec::new();
    let exposures: Vec<ScheduledExposure> = table
        .rows
        .iter()
        .enumerate()
        .map(|(row, cells)| {
            let mut scheduled = scheduled_exposure(row, &cells, &map, &scales, scale, options);
            if let (Ok(cells), Ok(exposure)) = (cells.as_ref(), &scheduled.exposure) {
                let cell = |index: usize| cells.get(index).unwrap_or(&Cell::Missing);
                if map.start.form != StartForm::Iso {
                    most_decimals = most_decimals.max(cell(map.start.index).text().map(|text| decimals(&text)));
                }
                if let Some((index, scale)) = altitude.filter(|_| stated_altitudes.len() < COMPARED_ALTITUDES)
                    && let Some(altitude_deg) = cell(index).number().ok().map(|number| scale * number)
                    && (0.0..=90.0).contains(&altitude_deg)
                {
                    stated_altitudes.push((exposure.clone(), altitude_deg));
                }
                if let Some((end, stated)) = contradiction(cell, exposure, &map.start, &ends, Moment::End) {
                    let (count, _) = other_ends.get_or_insert_with(|| (0, format!("{end} (used) and {stated}")));
                    *count += 1;
                }
                let starts = contradiction(cell, exposure, &map.start, &other_starts, Moment::Start);
                let checked =
                    checks.reject(cell).and_then(|()| starts.map_or(Ok(()), |starts| Err(contradicting(starts))));
                if let Err(reason) = checked {
                    scheduled.exposure = Err(reason);
                }
            }
            scheduled
        })
        .collect();
    let comments_like_rows = table.comments_like_rows;
    let start_column = map.start.name;
    let mut warnings_of_file = table.warnings;
    let step_s = most_decimals.map(|decimals| scales.start * DAY_S * 10f64.powi(-decimals));
    if let (Some(decimals), Some(step_s)) =
        (most_decimals, step_s.filter(|step_s| *step_s > LARGEST_STEP_S && exposures.len() > 1))
    {
        warnings_of_file.push(format!(
            "{start_column} has at most {}, so that starts are in steps of {step_s:.0} s, in which satellites in low orbits \
             move by up to 1 deg/s; allowed: 6 decimals of a day or more",
            counted(decimals as usize, "decimal", "decimals")
        ));
    }
    Ok(Schedule {
        format: table.format,
        exposures,
        start_column,
        time_scale: scale,
        comments_like_rows,
        other_ends,
        stated_altitudes,
        warnings_of_file,
    })
}

/// Number of exposures whose altitudes are compared with those of the site.
const COMPARED_ALTITUDES: usize = 50;

/// Largest step of start times that is not a rounding, s. Five decimals of a day have a step of 0.9 s.
const LARGEST_STEP_S: f64 = 1.0;

/// Returns the number of decimals of a number as text.
fn decimals(text: &str) -> i32 {
    text.split_once('.').map_or(0, |(_, digits)| digits.len().min(12) as i32)
}

/// Adds the time scales to columns of times; those without a stated scale have the scale `default`, or are left out.
fn with_scales(
    table: &RawTable,
    columns: impl Iterator<Item = StartColumn>,
    default: Option<TimeScale>,
) -> Vec<(StartColumn, TimeScale)> {
    columns
        .filter(|column| !table.single_precision.contains(&column.name))
        .filter_map(|column| {
            let scale = column.scale.or_else(|| table.time_scales.get(&column.name).copied()).or(default)?;
            Some((column, scale))
        })
        .collect()
}

/// Returns the reason for the rejection of a row with contradicting times.
fn contradicting((first, other): (String, String)) -> String {
    format!("{first} and {other}: they contradict each other; allowed: one of these columns, or equal times")
}

/// Moment of an exposure.
#[derive(Copy, Clone, PartialEq)]
enum Moment {
    Start,
    End,
}

/// Returns the start or end of an exposure and a different one in another column, as texts. Cells that are no times are
/// ignored.
fn contradiction<'a>(
    cell: impl Fn(usize) -> &'a Cell,
    exposure: &Exposure,
    read: &StartColumn,
    others: &[(StartColumn, TimeScale)],
    moment: Moment,
) -> Option<(String, String)> {
    // Largest difference beside the rounding of Julian dates. The end may contain the motion of the shutter.
    let (expected, difference_s, what) = match moment {
        Moment::Start => (exposure.start, 1.0, read.name.clone()),
        Moment::End => {
            let end = seconds_after(exposure.start, exposure.duration_s);
            (end, 2.0, format!("{} plus {} s", read.name, exposure.duration_s))
        }
    };
    // Unit of the last digit.
    let rounding_s = |column: &StartColumn| match cell(column.index) {
        // The time of day follows the date, before the offset from UTC.
        Cell::Text(text) if column.form == StartForm::Iso => match text.trim().split_once(['T', 't', ' ']) {
            None => DAY_S,
            Some((_, time)) if time.split(['+', '-']).next().is_some_and(|time| time.matches(':').count() < 2) => 60.0,
            Some(_) => 0.0,
        },
        Cell::Text(text) => DAY_S * 10f64.powi(-decimals(text)),
        _ => 0.0,
    };
    for (column, scale) in others {
        let most_s = difference_s + rounding_s(column) + rounding_s(read);
        if let Ok(other) = start_of(cell(column.index), column, *scale)
            && seconds_between(expected, other).abs() > most_s
        {
            let [first, other] = [expected, other].map(|epoch| format_utc(epoch, 0));
            return Some((format!("{what} is {first}"), format!("{} is {other}", column.name)));
        }
    }
    None
}

/// Returns the time scale of the start times: from the name of the column, the header of the file, or the options.
fn start_scale(
    path: &Path,
    table: &RawTable,
    start: &StartColumn,
    options: &ScheduleOptions,
) -> Result<TimeScale, Error> {
    let of_header = table.time_scales.get(&start.name).copied();
    if let (Some(named), Some(of_header)) = (start.scale, of_header)
        && named != of_header
    {
        let column = &start.name;
        return Err(Error::format(format!("column {column} is in '{of_header}'"))
            .allowing("the time scale in the name of the column")
            .in_file("schedule", path));
    }
    let texts = || table.rows.iter().filter_map(|cells| cells.as_ref().as_ref().ok()?.get(start.index)?.text());
    let stated = start.scale.or(of_header);
    if let Some(stated) = stated.filter(|stated| start.form == StartForm::Iso && *stated != TimeScale::UTC)
        && let Some(text) = texts().find(|text| has_zone(text))
    {
        let (column, text) = (&start.name, Quoted::new(&text));
        return Err(Error::format(format!(
            "column {column} is in {stated}, but its time '{text}' has a zone, as in UTC"
        ))
        .allowing(format!("times without Z or offset, or the column start_utc; {stated} and UTC differ by over 30 s"))
        .in_file("schedule", path));
    }
    // Times with a zone (Z or an offset) in every cell need no time scale.
    let zoned = || {
        start.form == StartForm::Iso
            && texts()
                .all(|text| !parse_instant(&text, None).is_err_and(|error| error.kind() == ErrorKind::NoTimeScale))
    };
    if let (Some(named), Some(given)) = (stated, options.time_scale)
        && named != given
        && !zoned()
    {
        let column = &start.name;
        return Err(Error::format(format!("column {column} is in {named}, but --time-scale is {given}"))
            .allowing(format!(
                "no --time-scale, --time-scale {}, a column of another name, or times that end in Z",
                named.to_string().to_ascii_lowercase()
            ))
            .in_file("schedule", path));
    }
    stated
        .or(options.time_scale)
        .or(options.default_time_scale)
        .or_else(|| zoned().then_some(TimeScale::UTC))
        .ok_or_else(|| Error::new(ErrorKind::NoTimeScale, format!("the time scale of column {} is missing", start.name)).allowing("--time-scale utc, tai or tt (opsim files use UTC, ConsDB and many others TAI; TAI read as UTC is wrong by 37 s, which invalidates every result)").in_file("schedule", path))
}

/// Values of the units of the columns, in the units of an exposure.
#[derive(Copy, Clone)]
struct Scales {
    start: f64,
    duration: f64,
    /// Value for the time of a visit.
    visit: f64,
    right_ascension: f64,
    declination: f64,
    rotation: f64,
}

impl Scales {
    fn read(path: &Path, table: &RawTable, map: &ColumnMap) -> Result<Self, Error> {
        let of = |index: Option<usize>, unit: &Unit| match index {
            Some(index) => table.scale(path, index, unit),
            None => Ok(1.0),
        };
        let start = Some(map.start.index).filter(|_| map.start.form != StartForm::Iso);
        Ok(Self {
            start: of(start, &DAYS)?,
            duration: of(Some(map.duration), &SECONDS)?,
            visit: of(map.visit, &SECONDS)?,
            right_ascension: of(Some(map.right_ascension), &DEGREES)?,
            declination: of(Some(map.declination), &DEGREES)?,
            rotation: of(map.rotation, &DEGREES)?,
        })
    }
}

/// Returns the identifier of a row without one in a schedule with identifiers, where a number could be that of another
/// row.
fn unnamed(row: usize) -> String {
    format!("row {}", row + 1)
}

fn scheduled_exposure(
    row: usize,
    cells: &ScheduleRow,
    map: &ColumnMap,
    scales: &Scales,
    scale: TimeScale,
    options: &ScheduleOptions,
) -> ScheduledExposure {
    let numbered = || if map.id.is_some() { unnamed(row) } else { (row + 1).to_string() };
    let cells = match cells {
        Ok(cells) => cells,
        Err(reason) => {
            return ScheduledExposure { id: numbered(), row, band: None, open_s: None, exposure: Err(reason.clone()) };
        }
    };
    let cell = |index: usize| cells.get(index).unwrap_or(&Cell::Missing);
    let id = map.id.and_then(|index| cell(index).text()).unwrap_or_else(numbered);
    let band = map.band.and_then(|index| cell(index).text());
    let (exposure, open_s) = exposure(&id, cell, map, scales, scale, options)
        .map_or_else(|reason| (Err(reason), None), |(exposure, open_s)| (Ok(exposure), open_s));
    ScheduledExposure { id, row, band, open_s, exposure }
}

/// Returns the exposure of a row, and the time with open shutter, seconds, if that is shorter.
fn exposure<'a>(
    id: &str,
    cell: impl Fn(usize) -> &'a Cell,
    map: &ColumnMap,
    scales: &Scales,
    scale: TimeScale,
    options: &ScheduleOptions,
) -> Result<(Exposure, Option<f64>), String> {
    let number = |index: usize, scale: f64, name: &str, range: RangeInclusive<f64>| {
        let least = if *range.start() == f64::MIN_POSITIVE { "above 0".to_owned() } else { range.start().to_string() };
        let allowed = format!("{least} to {}", range.end());
        let in_words = |what| format!("{name} {what}; allowed: a decimal number such as 30.5, {allowed}");
        let value = scale * cell(index).number().map_err(in_words)?;
        if range.contains(&value) { Ok(value) } else { Err(format!("{name} is {value}; allowed: {allowed}")) }
    };
    let start = start_of(&cell(map.start.index).scaled(scales.start), &map.start, scale)?;
    if let Cell::Text(text) = cell(map.start.index)
        && map.start.form == StartForm::Iso
    {
        check_time_of_day(text).map_err(|error| format!("start {error}"))?;
    }
    let mut duration_s = number(map.duration, scales.duration, "duration", f64::MIN_POSITIVE..=LONGEST_EXPOSURE_S)?;
    let open_s = duration_s;
    // Between snaps the camera is read out, so that the last snap ends later than the sum of the exposures.
    let is_stated = |index: &usize| *cell(*index) != Cell::Missing;
    let snaps = map.snaps.filter(|index| map.is_sum && is_stated(index));
    let snaps = snaps.map(|index| number(index, 1.0, "numExposures", 0.0..=1e6)).transpose()?;
    if snaps.is_some_and(|snaps| snaps > 1.0) {
        let visit = map.visit.ok_or("visit has several snaps (numExposures or nexp), and visitTime is missing")?;
        duration_s = number(visit, scales.visit, "visitTime", duration_s..=LONGEST_EXPOSURE_S)?;
    } else if let Some(visit) = map.visit.filter(|index| map.is_sum && is_stated(index))
        && snaps.is_none_or(|snaps| snaps < 1.0)
    {
        // There may be several snaps.
        duration_s = duration_s.max(number(visit, scales.visit, "visitTime", 0.0..=LONGEST_EXPOSURE_S)?);
    }
    // Right ascensions may be given in [0, 360] or [-180, 180].
    let right_ascension_deg = number(map.right_ascension, scales.right_ascension, "right ascension", -180.0..=360.0)?;
    let declination_deg = number(map.declination, scales.declination, "declination", -90.0..=90.0)?;
    let rotation_rad = match map.rotation {
        Some(column) if *cell(column) != Cell::Missing => {
            number(column, scales.rotation, "rotation", ROTATIONS_DEG)?.to_radians()
        }
        _ => options.default_rotation_rad,
    };
    let exposure = Exposure {
        id: id.to_owned(),
        start,
        duration_s,
        pointing: Direction::from_lon_lat_rad(right_ascension_deg.to_radians(), declination_deg.to_radians()),
        rotation_rad,
    };
    Ok((exposure, (open_s < duration_s).then_some(open_s)))
}

fn start_of(cell: &Cell, column: &StartColumn, scale: TimeScale) -> Result<Epoch, String> {
    let number = |example| cell.number().map_err(|what| format!("start {what}; allowed: a date such as {example}"));
    let start = match column.form {
        StartForm::Iso => {
            let text = cell.text().ok_or("start is missing")?;
            parse_instant(&text, Some(scale)).map_err(|error| format!("start {error}"))?
        }
        StartForm::Mjd => epoch_from_mjd(number("61156.25 (MJD)")?, scale).map_err(|error| format!("start {error}"))?,
        StartForm::Jd => epoch_from_jd(number("2461156.75 (JD)")?, scale).map_err(|error| format!("start {error}"))?,
    };
    if is_covered(start) {
        Ok(start)
    } else {
        let shown = format_utc(start, 0);
        Err(format!("start {shown} is outside the years of the ephemeris; allowed: {FIRST_YEAR} to {LAST_YEAR}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(start_column: &str, starts: [&str; 2]) -> Result<Schedule, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("night.csv");
        let [first, second] = starts;
        let text = format!(
            "exposure_id,{start_column},duration_s,ra_deg,dec_deg\na,{first},30,150,-30\nb,{second},30,150,-30\n"
        );
        std::fs::write(&path, text).unwrap();
        Schedule::read(&path, &ScheduleOptions::default())
    }

    #[test]
    fn a_zone_in_a_column_of_another_scale_is_an_error() {
        for (column, start, scale) in
            [("start_tai", "2026-04-26T00:00:00Z", "TAI"), ("start_tt", "2026-04-26 02:00+02:00", "TT")]
        {
            let message = read(column, ["2026-04-26T00:01:00", start]).unwrap_err().to_string();
            let expected = format!("column {column} is in {scale}, but its time '{start}' has a zone, as in UTC");
            assert!(message.contains(&expected), "{message}");
        }
        // An offset in a column in UTC, and times without a zone in one in TAI, are no contradictions.
        let [utc, tai] = [("start_utc", "2026-04-26T02:00+02:00"), ("start_tai", "2026-04-26T00:00:37")]
            .map(|(column, start)| read(column, [start, start]).unwrap().exposures[0].exposure.clone().unwrap().start);
        assert_eq!(utc.to_time_scale(TimeScale::TAI), tai);
    }

    #[test]
    fn a_date_without_a_time_is_no_start() {
        let schedule = read("start_utc", ["2026-04-26", "2026-04-26T00:00"]).unwrap();
        let reason = schedule.exposures[0].exposure.clone().unwrap_err();
        assert!(reason.contains("'2026-04-26'") && reason.contains("a date with the time of day"), "{reason}");
        assert!(schedule.exposures[1].exposure.is_ok());
    }

    #[test]
    fn few_decimals_of_dates_give_one_warning_with_the_step() {
        for (column, starts, expected) in [
            (
                "start_mjd_utc",
                ["61155.999", "61155.97"],
                Some("has at most 3 decimals, so that starts are in steps of 86 s"),
            ),
            (
                "start_jd_tai",
                ["2461155.5", "2461156"],
                Some("has at most 1 decimal, so that starts are in steps of 8640 s"),
            ),
            ("start_mjd_utc", ["61155.99", "61155.96943"], None),
            ("start_utc", ["2026-04-26T00:00:00.5", "2026-04-26T00:01"], None),
        ] {
            let warnings = read(column, starts).unwrap().warnings_of_file;
            assert_eq!(warnings.len(), usize::from(expected.is_some()), "{warnings:?}");
            assert!(expected.is_none_or(|expected| warnings[0].contains(expected)), "{warnings:?}");
        }
    }
}
