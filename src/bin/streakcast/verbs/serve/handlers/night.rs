//! `/api/v1/night`: returns one night of the schedule with verdicts, Sun, field and site.

use serde_json::{Value, json};
use streakcast::frames::{mjd_utc, seconds_after, seconds_between};
use streakcast::output::{Table, Value as Cell, format_utc};
use streakcast::passes::SkyError;
use streakcast::schedule::{ScheduledExposure, Verdict, flag_table, night_of};

use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, optional};
use super::super::state::ServerState;
use super::document::degrees;
use super::document::{
    Document, left_out_count_schema, object_schema, provenance_schema, row_schema, rows_schema, warnings_schema,
};
use super::document::{NIGHTS, SCHEDULED, SITE, SUN};
use super::exposure::of_sky;
use crate::clock::date_of;

pub const PARAMETERS: &[Parameter] =
    &[optional("night", Kind::Date, "The evening's local date; default: the first night of the schedule.")];

/// Interval between two positions of the Sun, seconds.
const SUN_EVERY_S: f64 = 300.0;
/// Number of points of the outline of a circle.
const OUTLINE_POINTS: usize = 120;

pub fn handle(state: &ServerState, query: &Query) -> Result<String, Problem> {
    let known = || state.nights.keys().map(|night| date_of(*night)).take(40).collect::<Vec<_>>().join(", ");
    let night = match query.date("night") {
        Some(noon) => mjd_utc(noon).floor() as i64,
        None => *state.nights.keys().next().ok_or_else(|| Problem::new(404, "no exposure of the schedule is valid"))?,
    };
    let rows = state.nights.get(&night).ok_or_else(|| Problem::parameter("night", &date_of(night), &known()))?;
    let site = &state.site;

    let (from, to) = night_of(
        streakcast::frames::epoch_from_mjd(night as f64, hifitime::TimeScale::UTC)
            .map_err(|error| Problem::new(400, error.to_string()))?,
        site.longitude_rad,
    );
    let count = (seconds_between(from, to) / SUN_EVERY_S) as usize + 1;
    let sun_row = |step: usize| -> Result<Vec<Cell>, SkyError> {
        let epoch = seconds_after(from, SUN_EVERY_S * step as f64);
        let (altitude_deg, azimuth_deg) = degrees(&state.sky().sun_altaz(epoch)?);
        Ok(vec![epoch.into(), altitude_deg.into(), azimuth_deg.into()])
    };
    let sun_rows = (0..count).map(sun_row).collect::<Result<_, _>>().map_err(|error| of_sky(&error))?;
    let sun = Table { columns: SUN.to_vec(), rows: sun_rows };

    let exposures = Table {
        columns: SCHEDULED.to_vec(),
        rows: rows.iter().map(|&row| scheduled_row(&state.schedule.exposures[row])).collect(),
    };
    let flags: Vec<Verdict> = rows.iter().map(|&row| state.flags[row].clone()).collect();
    let nights = Table {
        columns: NIGHTS.to_vec(),
        rows: state.nights.iter().map(|(night, rows)| vec![date_of(*night).into(), rows.len().into()]).collect(),
    };
    let site = Table {
        columns: SITE.to_vec(),
        rows: vec![vec![
            site.name.as_str().into(),
            site.mpc_code.clone().into(),
            site.latitude_rad.to_degrees().into(),
            site.longitude_rad.to_degrees().into(),
            site.height_m.into(),
        ]],
    };
    let policy = &state.plan.policy;
    let photometry = &state.plan.photometry;
    let mut document = Document::with_provenance(&state.provenance);
    document.caveats(&state.caveats);
    document.value("night", date_of(night));
    document.table("nights", &nights);
    document.value("from_utc", format_utc(from, 0));
    document.value("to_utc", format_utc(to, 0));
    // A night with a change of the clocks has the offset of its middle.
    let middle = seconds_after(from, 0.5 * seconds_between(from, to));
    document.value("utc_offset_h", state.utc_offset_h(middle));
    document.record("site", &site);
    document.value(
        "field",
        json!({
            "outlines_deg": state.plan.field.outlines_deg(OUTLINE_POINTS),
            "radius_deg": state.plan.field.bounding_radius_rad().to_degrees(),
        }),
    );
    document.value("limit_mag", policy.limit_mag.as_ref().and_then(|limit| limit.of(None)));
    document.value("max_delay_s", policy.max_delay_or_default_s());
    document.value("band", photometry.band.name());
    document.value("mag_system", photometry.system.to_string());
    document.value("models", state.library.names().collect::<Vec<_>>());
    document.table("exposures", &exposures);
    document.table("flags", &flag_table(&flags));
    document.table("sun", &sun);
    Ok(document.into_json())
}

fn scheduled_row(scheduled: &ScheduledExposure) -> Vec<Cell> {
    let exposure = scheduled.exposure.as_ref().ok();
    vec![
        scheduled.id.as_str().into(),
        scheduled.row.into(),
        exposure.map(|exposure| exposure.start).into(),
        exposure.map(|exposure| exposure.duration_s).into(),
        exposure.map(|exposure| exposure.pointing.longitude_rad().to_degrees()).into(),
        exposure.map(|exposure| exposure.pointing.latitude_rad().to_degrees()).into(),
        exposure.map(|exposure| exposure.rotation_rad.to_degrees()).into(),
        scheduled.band.clone().into(),
    ]
}

pub fn schema() -> Value {
    let number = json!({"type": "number"});
    let text = json!({"type": "string"});
    let outline = json!({"type": "array", "items": {"type": "array", "items": number, "minItems": 2, "maxItems": 2}});
    let field =
        object_schema(&[("outlines_deg", json!({"type": "array", "items": outline})), ("radius_deg", number.clone())]);
    object_schema(&[
        ("provenance", provenance_schema()),
        ("warnings", warnings_schema()),
        ("left_out_count", left_out_count_schema()),
        ("night", text.clone()),
        ("nights", rows_schema(&NIGHTS)),
        ("from_utc", text.clone()),
        ("to_utc", text.clone()),
        ("utc_offset_h", number.clone()),
        ("site", row_schema(&SITE)),
        ("field", field),
        ("limit_mag", json!({"type": ["number", "null"]})),
        ("max_delay_s", number),
        ("band", text.clone()),
        ("mag_system", text.clone()),
        ("models", json!({"type": "array", "items": text})),
        ("exposures", rows_schema(&SCHEDULED)),
        ("flags", rows_schema(&flag_table(&[]).columns)),
        ("sun", rows_schema(&SUN)),
    ])
}
