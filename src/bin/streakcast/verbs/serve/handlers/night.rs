//! `/api/v1/night`: returns the exposures of the schedule in one night, their verdicts, the Sun, the field and the
//! site.

use serde_json::{Value, json};
use streakcast::frames::{seconds_after, seconds_between};
use streakcast::output::{Table, Value as Cell, format_utc};
use streakcast::schedule::{ScheduledExposure, Verdict, evening_mjd, flag_exposures, flag_table, night_of};

use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, optional};
use super::super::state::{LIMIT_MAG, RequestState};
use super::document::{
    Document, NIGHTS, OFFSETS, SCHEDULED, SITE, SUN, degrees, document_schema, number_schema, object_schema,
    offset_table, optional_number_schema, row_schema, rows_schema, text_schema,
};
use crate::clock::{civil_date, date_of, mean_evening_mjd};
use streakcast::Error;

pub const PARAMETERS: &[Parameter] = &[
    optional(
        "night",
        Kind::Date,
        "The evening's local date; default: the first night of the schedule, or without a schedule that in which the server was started.",
    ),
    optional("time_utc", Kind::Moment, "A time in the night, instead of its date."),
    LIMIT_MAG,
];

/// Interval between two positions of the Sun, seconds.
const SUN_EVERY_S: f64 = 300.0;
/// Number of points of the outline of a circle.
const OUTLINE_POINTS: usize = 120;

pub fn handle(state: &RequestState, query: &Query) -> Result<String, Problem> {
    let night_at = |epoch| evening_mjd(epoch, state.site.longitude_rad);
    let night = match (query.date("night"), query.moment("time_utc")) {
        (Some(_), Some(_)) => return Err(Problem::both("night", "time_utc")),
        (Some(noon), None) => mean_evening_mjd(noon, &state.site, state.local_time.as_ref()),
        (None, Some(epoch)) => night_at(epoch),
        (None, None) => state.nights.keys().next().copied().unwrap_or_else(|| night_at(state.started)),
    };
    let rows = state.nights.get(&night).map(Vec::as_slice).unwrap_or_default();
    let site = &state.site;

    let (from, to) =
        night_of(streakcast::frames::epoch_from_mjd(night as f64, hifitime::TimeScale::UTC)?, site.longitude_rad);
    let state = &state.at(from)?;
    let count = (seconds_between(from, to) / SUN_EVERY_S) as usize + 1;
    let sun_row = |step: usize| -> Result<Vec<Cell>, Error> {
        let epoch = seconds_after(from, SUN_EVERY_S * step as f64);
        let (altitude_deg, azimuth_deg) = degrees(&state.sky().sun_altaz(epoch)?);
        Ok(vec![epoch.into(), altitude_deg.into(), azimuth_deg.into()])
    };
    let sun_rows = (0..count).map(sun_row).collect::<Result<_, _>>()?;
    let sun = Table { columns: SUN.to_vec(), rows: sun_rows };

    let exposures = Table {
        columns: SCHEDULED.to_vec(),
        rows: rows.iter().map(|&row| scheduled_row(&state.exposures[row])).collect(),
    };
    let policy = state.policy(query);
    let flags: Vec<Verdict> = if policy == state.plan.policy {
        rows.iter().map(|&row| state.flags[row].clone()).collect()
    } else {
        let rows: Vec<_> = rows.iter().map(|&row| &state.exposures[row]).collect();
        flag_exposures(&rows, &state.request(&policy))?.flags
    };
    let of_night;
    let caveats = if rows.is_empty() {
        of_night = state.caveats_of_verdict(from, to, &[])?;
        &of_night
    } else {
        &state.caveats
    };
    let date = |evening_mjd| civil_date(&date_of(evening_mjd), &state.site, state.local_time.as_ref());
    let nights = Table {
        columns: NIGHTS.to_vec(),
        rows: state.nights.iter().map(|(night, rows)| vec![date(*night).into(), rows.len().into()]).collect(),
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
    let photometry = &state.plan.photometry;
    let mut document = Document::with_provenance(&state.provenance());
    document.caveats(caveats);
    document.value("night", date(night));
    document.table("nights", &nights);
    document.value("from_utc", format_utc(from, 0));
    document.value("to_utc", format_utc(to, 0));
    // That of the middle of the night; `utc_offsets` has all.
    let middle = seconds_after(from, 0.5 * seconds_between(from, to));
    document.value("utc_offset_h", state.utc_offset_h(middle));
    document.table("utc_offsets", &offset_table(state.utc_offsets(from, to)));
    document.record("site", &site);
    document.value(
        "field",
        json!({
            "outlines_deg": state.plan.field.outlines_deg(OUTLINE_POINTS),
            "radius_deg": state.plan.field.bounding_radius_rad().to_degrees(),
        }),
    );
    document.value("limit_mag", policy.limit_mag.as_ref().and_then(|limit| limit.limit_in(None)));
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
    let outline =
        json!({"type": "array", "items": {"type": "array", "items": number_schema(), "minItems": 2, "maxItems": 2}});
    let field =
        object_schema(&[("outlines_deg", json!({"type": "array", "items": outline})), ("radius_deg", number_schema())]);
    document_schema(&[
        ("night", text_schema()),
        ("nights", rows_schema(&NIGHTS)),
        ("from_utc", text_schema()),
        ("to_utc", text_schema()),
        ("utc_offset_h", number_schema()),
        ("utc_offsets", rows_schema(&OFFSETS)),
        ("site", row_schema(&SITE)),
        ("field", field),
        ("limit_mag", optional_number_schema()),
        ("max_delay_s", number_schema()),
        ("band", text_schema()),
        ("mag_system", text_schema()),
        ("models", json!({"type": "array", "items": text_schema()})),
        ("exposures", rows_schema(&SCHEDULED)),
        ("flags", rows_schema(&flag_table(&[]).columns)),
        ("sun", rows_schema(&SUN)),
    ])
}
