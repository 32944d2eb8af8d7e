//! `/api/v1/forecast`: returns the visible passes of a night, as `forecast` of the command line, with their calendar.

use hifitime::Epoch;
use serde_json::{Value, json};
use streakcast::config::ForecastConfig;
use streakcast::forecast::{
    Forecast, ForecastRequest, Night, PassColumns, Selection, calendar, forecast, night_table, pass_table,
};
use streakcast::frames::{seconds_after, seconds_between};
use streakcast::passes::VisiblePasses;

use super::super::super::passes::left_out_table;
use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, number, optional, required};
use super::super::state::RequestState;
use super::document::{Document, OFFSETS, document_schema, offset_table, row_schema, rows_schema};
use crate::clock::{civil_date, date_of, mean_evening_mjd, night_at};

/// Largest number of points of all passes in a response.
const MOST_POINTS: usize = 200_000;

pub const PARAMETERS: &[Parameter] = &[
    optional("night", Kind::Date, "The evening's local date; required without time_utc."),
    optional(
        "time_utc",
        Kind::Moment,
        "A time instead of the date: the night at this time, or by day the next one, as `tonight` of the command line.",
    ),
    required(
        "max_mag",
        number(-30.0, 40.0, " mag"),
        "Only passes that are probably brighter than this, through clear air and in twilight.",
    ),
    optional("samples", Kind::Count { least: 0, greatest: 500 }, "Points along each pass; default 0."),
];

pub fn handle(state: &RequestState, query: &Query) -> Result<String, Problem> {
    let night = match (query.date("night"), query.moment("time_utc")) {
        (Some(_), Some(_)) => return Err(Problem::both("night", "time_utc")),
        (Some(noon), None) => date_of(mean_evening_mjd(noon, &state.site, state.local_time.as_ref())),
        (None, Some(epoch)) => night_at(&state.site, epoch),
        (None, None) => return Err(Problem::missing("night", "night or time_utc")),
    };
    let (max_mag, samples) = (query.number("max_mag"), query.count("samples").unwrap_or(0));
    // All times of a night have one response.
    let key = format!("passes of {night}, {max_mag:?}, {samples}");
    if let Some(response) = state.cache.get(&key) {
        return Ok(response);
    }
    let response = compute(state, night, max_mag, samples)?;
    state.cache.insert(key, &response);
    Ok(response)
}

/// Returns the response for the night whose evening has a date in local mean time.
fn compute(state: &RequestState, mean_night: String, max_mag: Option<f64>, samples: usize) -> Result<String, Problem> {
    let mut wanted = ForecastConfig { max_mag, samples: Some(0), ..ForecastConfig::default() };
    wanted.range.night = Some(mean_night.clone());
    let invalid = |error: String| Problem::new(400, error);
    let (request, selection) = wanted.resolve(&state.config, 0).map_err(|error| invalid(error.to_string()))?;
    let state = &state.at(request.start)?;
    let of = |request: &ForecastRequest, selection: &Selection| {
        forecast(state.sky(), request, selection).map_err(|error| invalid(error.to_string()))
    };
    let mut found = of(&request, &selection)?;
    let passes = found.found.passes.len();
    let points = passes * samples.max(1);
    if points > MOST_POINTS {
        let text = format!(
            "{passes} passes with {points} points; allowed: up to {MOST_POINTS} points, with fewer samples or a brighter max_mag"
        );
        return Err(invalid(text));
    }
    if samples > 0 && passes > 0 {
        // Points are only computed for these passes, after their number is known.
        let norad_ids = found.found.passes.iter().map(|pass| pass.norad_id.0).collect();
        let request = ForecastRequest { samples, ..request.clone() };
        found.found.passes = of(&request, &Selection { norad_ids, ..selection.clone() })?.found.passes;
    }
    let mut caveats = state.caveats_of_passes(request.start, request.end, &found.found)?;
    caveats.warnings.extend(found.prior_warning(state.sky(), request.max_magnitude));
    caveats.warnings.extend(found.fitted_range_warning());
    caveats.warnings.extend(state.prepared().unknown_part_warning(request.start, request.end));

    let columns = PassColumns { p_brighter: true, more: true, samples: samples > 0 };
    let rows = || found.rows(state.sky());
    let why_empty = found.why_empty(state.sky(), &request);
    let utc_offset_s = |epoch| state.utc_offset_h(epoch) * 3600.0;
    let mut document = Document::with_provenance(&state.provenance());
    document.caveats(&caveats);
    document.value("date", civil_date(&mean_night, &state.site, state.local_time.as_ref()));
    let middle = seconds_after(request.start, 0.5 * seconds_between(request.start, request.end));
    document.value("utc_offset_h", state.utc_offset_h(middle));
    document.table("utc_offsets", &offset_table(state.utc_offsets(request.start, request.end)));
    document.value("may_have_passes", found.may_have_passes());
    document.record("night", &night_table(&found, why_empty.as_deref()));
    document.table("passes", &pass_table(rows(), columns));
    // The time of creation is that of the server's start, so that the same request has the same response.
    let events = || calendar(rows(), &state.site, state.started, None, None, utc_offset_s);
    document.value("calendar", why_empty.is_none().then(events));
    document.table("left_out", &left_out_table(&found.found.left_out));
    Ok(document.into_json())
}

pub fn schema() -> Value {
    let columns = PassColumns { p_brighter: true, more: true, samples: true };
    let mut passes = rows_schema(&pass_table([], columns).columns);
    // This column is only present if the parameter is given.
    if let Some(required) = passes["items"]["required"].as_array_mut() {
        required.retain(|name| name != "samples");
    }
    let at = Epoch::from_mjd_utc(0.0);
    let night =
        Night { start: at, end: at, max_sun_altitude_rad: None, dark: vec![], lowest_sun_rad: 0.0, lowest_sun_at: at };
    let nothing = Forecast { night, found: VisiblePasses::default(), late: (0, 0.0) };
    document_schema(&[
        ("date", json!({"type": "string", "description": "The evening's local date."})),
        (
            "utc_offset_h",
            json!({"type": "number", "description": "Local time minus UTC in the middle of the night, hours."}),
        ),
        ("utc_offsets", rows_schema(&OFFSETS)),
        (
            "may_have_passes",
            json!({"type": "boolean", "description": "True if a night without visible passes may have some: elements are too old, or times uncertain by more than a minute."}),
        ),
        ("night", row_schema(&night_table(&nothing, None).columns)),
        ("passes", passes),
        (
            "calendar",
            json!({"type": ["string", "null"], "description": "iCalendar (RFC 5545) with one event for each visible pass; null without one."}),
        ),
        ("left_out", rows_schema(&left_out_table(&[]).columns)),
    ])
}
