//! Tables of passes: one row for each pass, one row for each point of a light curve, and a readable table in local time
//! for observers.

use hifitime::{Epoch, TimeScale, Unit};

use crate::elements::ElementSet;
use crate::frames::{compass, seconds_after, seconds_between};
use crate::message::known_step_s;
use crate::output::{Column, Kind, Table, TableField, Value, format_utc};
use crate::passes::{TrackPoint, Visibility, VisiblePass};
use crate::photometry::Brightness;

/// Largest difference between two times that are taken as the same event, seconds.
const SAME_S: f64 = 0.01;

/// Pass with the element set of its satellite.
#[derive(Copy, Clone)]
pub struct PassRow<'a> {
    /// Visible pass.
    pub pass: &'a VisiblePass,
    /// Element set of the satellite.
    pub elements: &'a ElementSet,
    /// Start and end of the forecast.
    pub range: (Epoch, Epoch),
    /// Dark intervals of the forecast.
    pub dark: &'a [(Epoch, Epoch)],
}

const P_BRIGHTER: Column = Column::real(
    "p_brighter",
    "",
    4,
    "Probability of being brighter than the magnitude limit at some visible point; in twilight the limit is brighter.",
);

impl<'a> PassRow<'a> {
    /// Returns the name of the satellite, or its catalogue number if it has no name.
    pub fn name(&self) -> String {
        self.pass.norad_id.or_name(&self.elements.name)
    }

    /// Returns the brightest point; `None` if the pass has no magnitude.
    pub fn peak(&self) -> Option<&'a TrackPoint> {
        self.pass.visible.as_ref()?.peak.as_ref()
    }

    /// Returns the event that begins the visible part: `rise`, `shadow`, `dusk`, or `start` (of the forecast).
    pub fn begins_by(&self) -> Option<&'static str> {
        let begin = self.pass.visible.as_ref()?.begin.epoch;
        Some(if is_at(begin, epoch_of(&self.pass.rise)) {
            "rise"
        } else if is_at(begin, Some(self.range.0)) {
            "start"
        } else if self.dark.iter().any(|(dusk, _)| is_at(begin, Some(*dusk))) {
            "dusk"
        } else {
            "shadow"
        })
    }

    /// Returns the event that ends the visible part: `set`, `shadow`, `dawn`, or `end` (of the forecast).
    pub fn ends_by(&self) -> Option<&'static str> {
        let end = self.pass.visible.as_ref()?.end.epoch;
        Some(if is_at(end, epoch_of(&self.pass.set)) {
            "set"
        } else if is_at(end, Some(self.range.1)) {
            "end"
        } else if self.dark.iter().any(|(_, dawn)| is_at(end, Some(*dawn))) {
            "dawn"
        } else {
            "shadow"
        })
    }
}

fn epoch_of(point: &Option<TrackPoint>) -> Option<Epoch> {
    point.as_ref().map(|point| point.epoch)
}

fn is_at(moment: Epoch, other: Option<Epoch>) -> bool {
    other.is_some_and(|other| seconds_between(moment, other).abs() < SAME_S)
}

fn pass_fields<'a>() -> Vec<TableField<PassRow<'a>>> {
    let field = TableField::<PassRow<'a>>::new;
    vec![
        field(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |row| {
            i64::from(row.pass.norad_id.0).into()
        }),
        field(Column::new("name", Kind::Text, "Name in the element set."), |row| Value::nonempty(&row.elements.name)),
        field(
            Column::time(
                "rise_utc",
                "Time at which the satellite rises above the minimum altitude; empty if it is above at the start of the search.",
            ),
            |row| epoch(row.pass.rise.as_ref()),
        ),
        field(Column::time("culmination_utc", "Time of the highest point of the pass, visible or not."), |row| {
            row.pass.culmination.epoch.into()
        }),
        field(
            Column::time(
                "set_utc",
                "Time at which the satellite sets below the minimum altitude; empty if it is above at the end of the search.",
            ),
            |row| epoch(row.pass.set.as_ref()),
        ),
        field(Column::real("rise_azimuth_deg", "deg", 3, "Azimuth of the rise, from north through east."), |row| {
            azimuth_deg(row.pass.rise.as_ref())
        }),
        field(Column::real("max_altitude_deg", "deg", 3, "Altitude at culmination, without refraction."), |row| {
            altitude_deg(Some(&row.pass.culmination))
        }),
        field(Column::real("set_azimuth_deg", "deg", 3, "Azimuth of the set, from north through east."), |row| {
            azimuth_deg(row.pass.set.as_ref())
        }),
        field(
            Column::time(
                "shadow_entry_utc",
                "Start of fading at the first entry into the Earth's shadow; empty if there is none.",
            ),
            |row| epoch(row.pass.shadow_entry.as_ref()),
        ),
        field(
            Column::time(
                "shadow_exit_utc",
                "Full sunlight after the first exit from the Earth's shadow; empty if there is none.",
            ),
            |row| epoch(row.pass.shadow_exit.as_ref()),
        ),
        field(Column::time("peak_utc", "Time of the brightest visible point."), |row| epoch(row.peak())),
        field(
            Column::real(
                "peak_magnitude",
                "mag",
                3,
                "Apparent magnitude at the brightest visible point; empty without a visible part.",
            ),
            |row| magnitude(row.peak()),
        ),
        field(Column::real("peak_magnitude_sigma", "mag", 3, "One sigma of that magnitude."), |row| sigma(row.peak())),
        field(
            Column::real("peak_altitude_deg", "deg", 3, "Altitude at the brightest visible point, without refraction."),
            |row| altitude_deg(row.peak()),
        ),
        field(Column::real("peak_azimuth_deg", "deg", 3, "Azimuth at the brightest visible point."), |row| {
            azimuth_deg(row.peak())
        }),
        field(
            Column::real(
                "range_km",
                "km",
                3,
                "Distance at the brightest visible point; at culmination if there is no such point.",
            ),
            |row| row.peak().unwrap_or(&row.pass.culmination).range_km.into(),
        ),
        field(Column::new("mag_source", Kind::Text, "Source of the magnitude."), |row| {
            row.peak().and_then(|peak| peak.brightness.as_ref()).map(|light| light.source.to_string()).into()
        }),
        field(
            Column::real(
                "element_age_days",
                "d",
                4,
                "Time of culmination minus epoch of the elements; negative for elements from after the pass.",
            ),
            |row| row.pass.element_age_days.into(),
        ),
        field(
            Column::new(
                "position_source",
                Kind::Text,
                "Source of the positions: `element set`, or `ephemeris` with the name of the file.",
            ),
            |row| row.pass.position_source.to_string().into(),
        ),
        field(TIME_ERROR, |row| row.pass.along_track_sigma_s.into()),
        field(
            Column::new(
                "in_fitted_range",
                Kind::Boolean,
                "False if the geometry at the brightest visible point is more than 10 deg from the geometries to which the model was fitted.",
            ),
            |row| row.peak().and_then(|peak| peak.brightness.as_ref()).map(|light| light.in_fitted_range).into(),
        ),
    ]
}

/// Columns that are written by default only in formats with nested tables, so that the default columns of the other
/// formats do not change.
fn more_fields<'a>() -> Vec<TableField<PassRow<'a>>> {
    let field = TableField::<PassRow<'a>>::new;
    vec![
        field(Column::new("international_designator", Kind::Text, "COSPAR designator."), |row| {
            Value::nonempty(&row.elements.international_designator)
        }),
        field(Column::time("begin_utc", "Start of the visible part."), |row| epoch(seen(row).map(|seen| &seen.begin))),
        field(Column::real("begin_altitude_deg", "deg", 3, "Altitude at the start of the visible part."), |row| {
            altitude_deg(seen(row).map(|seen| &seen.begin))
        }),
        field(Column::real("begin_azimuth_deg", "deg", 3, "Azimuth at the start of the visible part."), |row| {
            azimuth_deg(seen(row).map(|seen| &seen.begin))
        }),
        field(
            Column::new(
                "begins_by",
                Kind::Text,
                "Event at the start of the visible part: rise, shadow (of the solid Earth), dusk, or start (of the time range).",
            ),
            |row| row.begins_by().into(),
        ),
        field(Column::time("highest_utc", "Time of the highest point of the visible part."), |row| {
            epoch(seen(row).map(|seen| &seen.highest))
        }),
        field(
            Column::real("highest_altitude_deg", "deg", 3, "Altitude at the highest point of the visible part."),
            |row| altitude_deg(seen(row).map(|seen| &seen.highest)),
        ),
        field(
            Column::real("highest_azimuth_deg", "deg", 3, "Azimuth at the highest point of the visible part."),
            |row| azimuth_deg(seen(row).map(|seen| &seen.highest)),
        ),
        field(Column::time("end_utc", "End of the visible part."), |row| epoch(seen(row).map(|seen| &seen.end))),
        field(Column::real("end_altitude_deg", "deg", 3, "Altitude at the end of the visible part."), |row| {
            altitude_deg(seen(row).map(|seen| &seen.end))
        }),
        field(Column::real("end_azimuth_deg", "deg", 3, "Azimuth at the end of the visible part."), |row| {
            azimuth_deg(seen(row).map(|seen| &seen.end))
        }),
        field(
            Column::new(
                "ends_by",
                Kind::Text,
                "Event at the end of the visible part: set, shadow (of the solid Earth), dawn, or end (of the time range).",
            ),
            |row| row.ends_by().into(),
        ),
        field(
            Column::real(
                "peak_phase_angle_deg",
                "deg",
                3,
                "Sun-satellite-observer angle at the brightest visible point.",
            ),
            |row| row.peak().map(|peak| peak.geometry.phase_angle_rad().to_degrees()).into(),
        ),
    ]
}

/// Optional columns of a table of visible passes.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct PassColumns {
    /// Probability that the satellite is brighter than the magnitude limit.
    pub p_brighter: bool,
    /// Columns that are written by default only in formats with nested tables.
    pub more: bool,
    /// Points along each pass.
    pub samples: bool,
}

/// Returns passes as a table, in their order.
pub fn pass_table<'a>(rows: impl IntoIterator<Item = PassRow<'a>>, columns: PassColumns) -> Table {
    let PassColumns { p_brighter, more, samples } = columns;
    let mut fields = pass_fields();
    if p_brighter {
        fields.push(TableField::new(P_BRIGHTER, |row| row.pass.p_brighter.into()));
    }
    if more {
        fields.extend(more_fields());
    }
    if samples {
        let column = Column::new("samples", Kind::Rows(POINTS), "Points along the pass, from rise to set.");
        fields.push(TableField::new(column, |row| Value::Rows(row.pass.samples.iter().map(point_cells).collect())));
    }
    Table::from_records(&fields, rows)
}

fn seen<'a>(row: &PassRow<'a>) -> Option<&'a Visibility> {
    row.pass.visible.as_ref()
}

fn epoch(point: Option<&TrackPoint>) -> Value {
    point.map(|point| point.epoch).into()
}

fn altitude_deg(point: Option<&TrackPoint>) -> Value {
    point.and_then(|point| point.altitude_rad).map(f64::to_degrees).into()
}

fn azimuth_deg(point: Option<&TrackPoint>) -> Value {
    point.and_then(|point| point.azimuth_rad).map(f64::to_degrees).into()
}

fn magnitude(point: Option<&TrackPoint>) -> Value {
    point.and_then(|point| point.brightness.as_ref()).map(|light| light.magnitude.0).into()
}

fn sigma(point: Option<&TrackPoint>) -> Value {
    point.and_then(|point| point.brightness.as_ref()).map(|light| light.sigma_mag).into()
}

/// Columns of one point along a pass.
const POINTS: &[Column] = &[
    Column::time("utc", "Time at which the light reaches the observer."),
    Column::real("altitude_deg", "deg", 4, "Altitude without refraction."),
    Column::real("azimuth_deg", "deg", 4, "Azimuth from north through east."),
    Column::real("ra_deg", "deg", 6, "Right ascension, ICRS astrometric topocentric."),
    Column::real("dec_deg", "deg", 6, "Declination."),
    Column::real("range_km", "km", 3, "Distance from the observer."),
    Column::real("phase_angle_deg", "deg", 3, "Sun-satellite-observer angle."),
    Column::new("illumination", Kind::Text, "sunlit, penumbra or umbra."),
    Column::real("lit_fraction", "", 4, "Fraction of the Sun's light that reaches the satellite."),
    Column::real(
        "magnitude",
        "mag",
        3,
        "Apparent magnitude; empty in the umbra and if no sunlit surface faces the observer.",
    ),
    Column::real("magnitude_sigma", "mag", 3, "One sigma of the magnitude."),
    Column::new(
        "in_fitted_range",
        Kind::Boolean,
        "False if the geometry is more than 10 deg from the geometries to which the model was fitted.",
    ),
];

/// Column of the error of all times of a pass.
const TIME_ERROR: Column =
    Column::real("along_track_sigma_s", "s", 4, "One sigma of all times of the pass: the lateness of the satellite.");

/// Columns that identify the pass of a point.
const PASS: [Column; 3] = [
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::new("name", Kind::Text, "Name in the element set."),
    Column::time("culmination_utc", "Time of the highest point of the pass."),
];

/// Returns the cells of one point along a pass.
fn point_cells(point: &TrackPoint) -> Vec<Value> {
    let light = point.brightness.as_ref();
    vec![
        point.epoch.into(),
        point.altitude_rad.map(f64::to_degrees).into(),
        point.azimuth_rad.map(f64::to_degrees).into(),
        point.direction.longitude_rad().to_degrees().into(),
        point.direction.latitude_rad().to_degrees().into(),
        point.range_km.into(),
        point.geometry.phase_angle_rad().to_degrees().into(),
        point.illumination.name().into(),
        point.illumination.lit_fraction().into(),
        light.map(|light| light.magnitude.0).into(),
        light.map(|light| light.sigma_mag).into(),
        light.map(|light| light.in_fitted_range).into(),
    ]
}

/// Returns the sampled points of all passes, grouped by pass in time order.
pub fn light_curve_table<'a>(rows: impl IntoIterator<Item = PassRow<'a>>) -> Table {
    let columns = PASS.iter().chain(POINTS).chain([&TIME_ERROR]).copied().collect();
    let mut table = Table { columns, rows: Vec::new() };
    for row in rows {
        let of_pass: Vec<Value> =
            vec![i64::from(row.pass.norad_id.0).into(), row.name().into(), row.pass.culmination.epoch.into()];
        let late: Value = row.pass.along_track_sigma_s.into();
        let cells = |point| of_pass.iter().cloned().chain(point_cells(point)).chain([late.clone()]).collect();
        table.rows.extend(row.pass.samples.iter().map(cells));
    }
    table
}

const READABLE_COLUMNS: [Column; 21] = [
    Column::new(
        "date",
        Kind::Text,
        "Local date of the brightest visible point, or of the start if no magnitude is known.",
    ),
    Column::new("satellite", Kind::Text, "Name of the satellite."),
    Column::real("magnitude", "mag", 1, "Magnitude at the brightest point."),
    Column::real("sigma", "mag", 1, "One sigma of the magnitude."),
    Column::new("brightest", Kind::Text, "Local time of the brightest visible point."),
    Column::new("brightest_altitude", Kind::Text, "Altitude of the brightest visible point."),
    Column::new("brightest_azimuth", Kind::Text, "Compass direction of the brightest visible point."),
    Column::new("start", Kind::Text, "Local time at which the visible part begins."),
    Column::new("start_altitude", Kind::Text, "Altitude at the start of the visible part."),
    Column::new("start_azimuth", Kind::Text, "Compass direction at the start of the visible part."),
    Column::new("highest", Kind::Text, "Local time of the highest visible point."),
    Column::new("highest_altitude", Kind::Text, "Altitude of the highest visible point."),
    Column::new("highest_azimuth", Kind::Text, "Compass direction of the highest visible point."),
    Column::new("end", Kind::Text, "Local time at which the visible part ends."),
    Column::new("end_altitude", Kind::Text, "Altitude at the end of the visible part."),
    Column::new("end_azimuth", Kind::Text, "Compass direction at the end of the visible part."),
    Column::new(
        "ends_by",
        Kind::Text,
        "Event at the end of the visible part: set, shadow (of the solid Earth), dawn, or end (of the time range).",
    ),
    Column::real("along_track_sigma_s", "s", 1, "One sigma of the times."),
    Column::real("element_age_days", "d", 1, "Time of culmination minus epoch of the elements."),
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::new(
        "mag_source",
        Kind::Text,
        "Source of the magnitude; `not fitted here` if its geometry is outside that of the fit.",
    ),
];

/// Returns the passes as a readable table for observers: date, magnitude, and time, altitude and direction of the
/// brightest point, start, highest point and end. Times are rounded to 1 s, 10 s, 1 min or 10 min, whichever is next
/// above their error. `utc_offset_s` returns local time minus UTC at a time, seconds. A pass without a visible part is
/// listed from rise to set. With a magnitude limit, the last column is the probability of being brighter.
pub fn readable_table<'a>(rows: impl IntoIterator<Item = PassRow<'a>>, utc_offset_s: impl Fn(Epoch) -> f64) -> Table {
    let (mut columns, mut has_limit) = (READABLE_COLUMNS.to_vec(), false);
    let cells = |row: PassRow<'_>| {
        has_limit |= row.pass.p_brighter.is_some();
        let mut cells = readable_cells(&row, &utc_offset_s);
        cells.extend(row.pass.p_brighter.map(Value::from));
        cells
    };
    let rows = rows.into_iter().map(cells).collect();
    if has_limit {
        columns.push(P_BRIGHTER);
    }
    Table { columns, rows }
}

fn readable_cells(row: &PassRow<'_>, utc_offset_s: &impl Fn(Epoch) -> f64) -> Vec<Value> {
    let pass = row.pass;
    let (begin, highest, end) = match &pass.visible {
        Some(seen) => (Some(&seen.begin), &seen.highest, Some(&seen.end)),
        None => (pass.rise.as_ref(), &pass.culmination, pass.set.as_ref()),
    };
    let step_s = known_step_s(pass.along_track_sigma_s);
    let clock = |epoch: Epoch| {
        let offset_s = utc_offset_s(epoch);
        let clock = clock(epoch, offset_s, step_s);
        if is_repeated(epoch, utc_offset_s) { format!("{clock} {}", utc_offset(offset_s)) } else { clock }
    };
    let three = |point: Option<&TrackPoint>| -> [Value; 3] {
        let altitude = |point: &TrackPoint| Some(format!("{:.0}\u{b0}", point.altitude_rad?.to_degrees()));
        [
            point.map(|point| clock(point.epoch)).into(),
            point.and_then(altitude).into(),
            point.and_then(|point| point.azimuth_rad).map(compass).into(),
        ]
    };
    let light = row.peak().and_then(|peak| peak.brightness.as_ref());
    // The date is beside the time of the brightest point, which may be after midnight.
    let dated = row.peak().or(begin).unwrap_or(highest).epoch;
    let date = format_utc(seconds_after(dated, utc_offset_s(dated)), 0).chars().take(10).collect::<String>();
    let mut cells: Vec<Value> = vec![
        date.into(),
        row.name().into(),
        light.map(|light| light.magnitude.0).into(),
        light.map(|light| light.sigma_mag).into(),
    ];
    cells.extend([row.peak(), begin, Some(highest), end].into_iter().flat_map(three));
    cells.push(row.ends_by().unwrap_or("not visible").into());
    cells.push(pass.along_track_sigma_s.into());
    cells.push(pass.element_age_days.into());
    cells.push(i64::from(pass.norad_id.0).into());
    let source = |light: &Brightness| {
        let not_fitted = if light.in_fitted_range { "" } else { ", not fitted here" };
        format!("{}{not_fitted}", light.source)
    };
    cells.push(light.map(source).into());
    cells
}

/// Returns true if the clock shows this time twice, because it is set back between the two.
fn is_repeated(epoch: Epoch, utc_offset_s: &impl Fn(Epoch) -> f64) -> bool {
    // No clock is set back by more than this.
    const LARGEST_STEP_S: f64 = 3.0 * 3600.0;
    let offset_s = |shift_s: f64| utc_offset_s(seconds_after(epoch, shift_s));
    let here_s = offset_s(0.0);
    let (back_s, ahead_s) = (here_s - offset_s(LARGEST_STEP_S), offset_s(-LARGEST_STEP_S) - here_s);
    // The offset before the change minus that after it is the time by which the clock is set back.
    (back_s > 0.0 && offset_s(back_s) == here_s - back_s) || (ahead_s > 0.0 && offset_s(-ahead_s) == here_s + ahead_s)
}

/// Formats a time zone as `UTC` or `UTC+05:45`.
pub(super) fn utc_offset(utc_offset_s: f64) -> String {
    let minutes = (utc_offset_s / 60.0).round() as i64;
    let sign = if minutes < 0 { '-' } else { '+' };
    match minutes.abs() {
        0 => "UTC".to_owned(),
        minutes => format!("UTC{sign}{:02}:{:02}", minutes / 60, minutes % 60),
    }
}

/// Returns the local time of day as text, rounded to `step_s`; without seconds if this is a minute.
pub(super) fn clock(epoch: Epoch, utc_offset_s: f64, step_s: f64) -> String {
    // Steps are counted from the start of the time scale, so that only those of UTC are whole minutes of its clock.
    let local = seconds_after(epoch.to_time_scale(TimeScale::UTC), utc_offset_s).round(step_s * Unit::Second);
    let length = if step_s < 60.0 { 8 } else { 5 };
    format_utc(local, 0).chars().skip(11).take(length).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The clock of New York is set back from 02:00 to 01:00 on 2026-11-01, at 06:00 UTC; that of Lord Howe Island by
    /// half an hour on 2026-04-05, at 15:00 UTC of the day before.
    #[test]
    fn times_that_occur_twice() {
        let utc = |month, day, hour, minute| Epoch::from_gregorian_utc(2026, month, day, hour, minute, 0, 0);
        let zone = |change: Epoch, before_h: f64, after_h: f64| {
            move |epoch: Epoch| 3600.0 * if epoch < change { before_h } else { after_h }
        };
        let new_york = zone(utc(11, 1, 6, 0), -4.0, -5.0);
        for (hour, minute, expected) in
            [(4, 59, false), (5, 0, true), (5, 59, true), (6, 0, true), (6, 59, true), (7, 0, false)]
        {
            assert_eq!(is_repeated(utc(11, 1, hour, minute), &new_york), expected, "{hour}:{minute}");
        }
        let lord_howe = zone(utc(4, 4, 15, 0), 11.0, 10.5);
        for (hour, minute, expected) in [(14, 29, false), (14, 30, true), (15, 29, true), (15, 30, false)] {
            assert_eq!(is_repeated(utc(4, 4, hour, minute), &lord_howe), expected, "{hour}:{minute}");
        }
        let spring = zone(utc(3, 8, 7, 0), -5.0, -4.0);
        assert!((5..10).all(|hour| !is_repeated(utc(3, 8, hour, 30), &spring)));
    }

    #[test]
    fn clocks_ahead_of_utc_turn_the_date() {
        let epoch = Epoch::from_gregorian_utc(2022, 1, 21, 23, 30, 0, 600_000_000);
        assert_eq!(clock(epoch, 3600.0, 1.0), "00:30:01");
        assert_eq!(clock(epoch, -4.5 * 3600.0, 1.0), "19:00:01");
    }

    #[test]
    fn times_are_rounded_to_the_step_above_their_error() {
        let epoch = Epoch::from_gregorian_utc(2026, 4, 25, 19, 7, 46, 600_000_000);
        let rounded = |sigma_s: f64| clock(epoch, 7200.0, known_step_s(sigma_s));
        assert_eq!(
            [0.3, 1.0, 1.1, 10.0, 12.0, 900.0].map(rounded),
            ["21:07:47", "21:07:47", "21:07:50", "21:07:50", "21:08", "21:10"]
        );
        let in_tai = |sigma_s: f64| clock(epoch.to_time_scale(TimeScale::TAI), 7200.0, known_step_s(sigma_s));
        assert_eq!([0.3, 5.0, 12.0].map(in_tai), ["21:07:47", "21:07:50", "21:08"]);
        let midnight = Epoch::from_gregorian_utc(2026, 4, 25, 23, 59, 56, 0);
        assert_eq!(clock(midnight, 0.0, 10.0), "00:00:00");
    }
}
