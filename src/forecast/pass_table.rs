//! Passes of a night as a table: one row a pass.

use crate::elements::ElementSet;
use crate::frames::seconds_between;
use crate::output::{Column, Kind, Table, Value};
use crate::passes::{TrackPoint, Visibility, VisiblePass};

/// Two moments this close are one, seconds.
const SAME_S: f64 = 0.01;

/// A pass and whose it is.
#[derive(Copy, Clone)]
pub struct PassRow<'a> {
    /// The pass.
    pub pass: &'a VisiblePass,
    /// Its element set: name and designator.
    pub elements: &'a ElementSet,
}

impl<'a> PassRow<'a> {
    /// Name, or number where there is none.
    pub fn name(&self) -> String {
        if self.elements.name.is_empty() { self.pass.norad_id.to_string() } else { self.elements.name.to_string() }
    }

    /// The brightest point, where the model sees anything.
    pub fn peak(&self) -> Option<&'a TrackPoint> {
        self.pass.visible.as_ref()?.peak.as_ref()
    }

    /// What begins the visible part: `rise`, `shadow` or `dusk`.
    pub fn begins_by(&self) -> Option<&'static str> {
        let begin = &self.pass.visible.as_ref()?.begin;
        Some(if is_at(begin, self.pass.rise.as_ref()) {
            "rise"
        } else if is_at(begin, self.pass.shadow_exit.as_ref()) {
            "shadow"
        } else {
            "dusk"
        })
    }

    /// What ends it: `set`, `shadow` or `dawn`.
    pub fn ends_by(&self) -> Option<&'static str> {
        let end = &self.pass.visible.as_ref()?.end;
        Some(if is_at(end, self.pass.set.as_ref()) {
            "set"
        } else if is_at(end, self.pass.shadow_entry.as_ref()) {
            "shadow"
        } else {
            "dawn"
        })
    }
}

fn is_at(point: &TrackPoint, other: Option<&TrackPoint>) -> bool {
    other.is_some_and(|other| seconds_between(point.epoch, other.epoch).abs() < SAME_S)
}

/// One column and how its cell comes from a row.
struct Field {
    column: Column,
    value: fn(&PassRow<'_>) -> Value,
}

const fn field(column: Column, value: fn(&PassRow<'_>) -> Value) -> Field {
    Field { column, value }
}

static FIELDS: &[Field] = &[
    field(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |row| {
        i64::from(row.pass.norad_id.0).into()
    }),
    field(Column::new("name", Kind::Text, "Name in the element set."), |row| text(&row.elements.name)),
    field(
        Column::time("rise_utc", "Reaches the least altitude; empty where it is up before the search begins."),
        |row| moment(row.pass.rise.as_ref()),
    ),
    field(Column::time("culmination_utc", "Highest point of the pass, seen or not."), |row| {
        row.pass.culmination.epoch.into()
    }),
    field(
        Column::time("set_utc", "Falls below the least altitude; empty where it is up after the search ends."),
        |row| moment(row.pass.set.as_ref()),
    ),
    field(Column::real("rise_azimuth_deg", "deg", 3, "Azimuth at the rise, from north through east."), |row| {
        azimuth_deg(row.pass.rise.as_ref())
    }),
    field(Column::real("max_altitude_deg", "deg", 3, "Altitude at culmination, without refraction."), |row| {
        altitude_deg(Some(&row.pass.culmination))
    }),
    field(Column::real("set_azimuth_deg", "deg", 3, "Azimuth at the set."), |row| azimuth_deg(row.pass.set.as_ref())),
    field(
        Column::time(
            "shadow_entry_utc",
            "Light first begins to fade into the Earth's shadow; empty where it does not.",
        ),
        |row| moment(row.pass.shadow_entry.as_ref()),
    ),
    field(Column::time("shadow_exit_utc", "Light is first back in full; empty where it was never gone."), |row| {
        moment(row.pass.shadow_exit.as_ref())
    }),
    field(Column::time("peak_utc", "Brightest moment that can be seen."), |row| moment(row.peak())),
    field(Column::real("peak_magnitude", "mag", 3, "Apparent magnitude there; empty where nothing is seen."), |row| {
        magnitude(row.peak())
    }),
    field(Column::real("peak_magnitude_sigma", "mag", 3, "One sigma of it."), |row| sigma(row.peak())),
    field(Column::real("peak_altitude_deg", "deg", 3, "Altitude there, without refraction."), |row| {
        altitude_deg(row.peak())
    }),
    field(Column::real("peak_azimuth_deg", "deg", 3, "Azimuth there."), |row| azimuth_deg(row.peak())),
    field(Column::real("range_km", "km", 3, "Distance there; at culmination where there is no peak."), |row| {
        row.peak().unwrap_or(&row.pass.culmination).range_km.into()
    }),
    field(Column::new("mag_source", Kind::Text, "What the magnitude rests on."), |row| {
        row.peak().and_then(|peak| peak.brightness.as_ref()).map(|light| light.source.to_string()).into()
    }),
    field(
        Column::real(
            "element_age_days",
            "d",
            4,
            "Culmination less epoch of the elements; negative where these are newer.",
        ),
        |row| row.pass.element_age_days.into(),
    ),
];

/// Columns that only formats with tables inside tables carry: scripts count on the others' columns.
static MORE: &[Field] = &[
    field(Column::new("international_designator", Kind::Text, "COSPAR designator."), |row| {
        text(&row.elements.international_designator)
    }),
    field(Column::time("begin_utc", "The visible part begins."), |row| moment(seen(row).map(|seen| &seen.begin))),
    field(Column::real("begin_altitude_deg", "deg", 3, "Altitude there."), |row| {
        altitude_deg(seen(row).map(|seen| &seen.begin))
    }),
    field(Column::real("begin_azimuth_deg", "deg", 3, "Azimuth there."), |row| {
        azimuth_deg(seen(row).map(|seen| &seen.begin))
    }),
    field(Column::new("begins_by", Kind::Text, "rise, shadow or dusk."), |row| row.begins_by().into()),
    field(Column::time("highest_utc", "Highest point of the visible part."), |row| {
        moment(seen(row).map(|seen| &seen.highest))
    }),
    field(Column::real("highest_altitude_deg", "deg", 3, "Altitude there."), |row| {
        altitude_deg(seen(row).map(|seen| &seen.highest))
    }),
    field(Column::real("highest_azimuth_deg", "deg", 3, "Azimuth there."), |row| {
        azimuth_deg(seen(row).map(|seen| &seen.highest))
    }),
    field(Column::time("end_utc", "The visible part ends."), |row| moment(seen(row).map(|seen| &seen.end))),
    field(Column::real("end_altitude_deg", "deg", 3, "Altitude there."), |row| {
        altitude_deg(seen(row).map(|seen| &seen.end))
    }),
    field(Column::real("end_azimuth_deg", "deg", 3, "Azimuth there."), |row| {
        azimuth_deg(seen(row).map(|seen| &seen.end))
    }),
    field(Column::new("ends_by", Kind::Text, "set, shadow or dawn."), |row| row.ends_by().into()),
    field(Column::real("peak_phase_angle_deg", "deg", 3, "Sun-satellite-observer angle at the peak."), |row| {
        row.peak().map(|peak| peak.geometry.phase_angle_rad().to_degrees()).into()
    }),
    field(
        Column::new(
            "in_fitted_range",
            Kind::Boolean,
            "False where the model is asked beyond the geometry it rests on, and the sigma is wide.",
        ),
        |row| row.peak().and_then(|peak| peak.brightness.as_ref()).map(|light| light.in_fitted_range).into(),
    ),
];

static SAMPLED: &[Field] =
    &[field(Column::new("samples", Kind::Rows(super::light_curve::POINTS), "Points from rise to set."), |row| {
        Value::Rows(row.pass.samples.iter().map(super::light_curve::cells).collect())
    })];

/// The passes as a table, in their order: the columns of the forecast, `more` of them for formats that hold any number, and the points along each
/// pass where samples were asked for.
pub fn pass_table<'a>(rows: impl IntoIterator<Item = PassRow<'a>>, more: bool, samples: bool) -> Table {
    let more: &[Field] = if more { MORE } else { &[] };
    let samples: &[Field] = if samples { SAMPLED } else { &[] };
    let fields: Vec<&Field> = FIELDS.iter().chain(more).chain(samples).collect();
    Table {
        columns: fields.iter().map(|field| field.column).collect(),
        rows: rows.into_iter().map(|row| fields.iter().map(|field| (field.value)(&row)).collect()).collect(),
    }
}

fn seen<'a>(row: &PassRow<'a>) -> Option<&'a Visibility> {
    row.pass.visible.as_ref()
}

fn text(text: &str) -> Value {
    if text.is_empty() { Value::Null } else { text.into() }
}

fn moment(point: Option<&TrackPoint>) -> Value {
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
