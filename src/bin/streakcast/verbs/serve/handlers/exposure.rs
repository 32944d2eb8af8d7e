//! `/api/v1/exposure`: returns the results of `flag` and `passes` for an exposure with any start, and the crossings
//! before and after it.

use serde_json::Value;
use streakcast::frames::{seconds_after, seconds_between};
use streakcast::output::{Table, Value as Cell};
use streakcast::passes::{Exposure, Pass};
use streakcast::schedule::{
    FlagRequest, FlagTotals, ScheduledExposure, StreakColumns, VerdictKind, exposure_table, flag_exposures, flag_table,
    streak_table,
};

use super::super::super::passes::left_out_table;
use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, number, optional, required};
use super::super::state::{LIMIT_MAG, RequestState};
use super::document::{AROUND, Document, POINTING, degrees, document_schema, rows_schema};
use super::target::{TARGET, pointing_of};
use streakcast::Error;

pub const PARAMETERS: &[Parameter] = &[
    required("start_utc", Kind::Moment, "Shutter opening."),
    required("duration_s", number(0.001, 3600.0, " s"), "Length of the exposure, seconds."),
    optional(
        "ra_deg",
        number(0.0, 360.0, " deg"),
        "Right ascension of the field's centre, ICRS, degrees; required without target.",
    ),
    optional(
        "dec_deg",
        number(-90.0, 90.0, " deg"),
        "Declination of the field's centre, degrees; required without target.",
    ),
    TARGET,
    optional(
        "rotation_deg",
        number(-360.0, 360.0, " deg"),
        "Position angle of the field's y axis from north through east, degrees; default: that of the server.",
    ),
    optional(
        "band",
        Kind::Text { longest: 20 },
        "Band of the exposure, for limits by band: one with magnitudes, with a limit, or in the schedule.",
    ),
    LIMIT_MAG,
    optional("samples", Kind::Count { least: 0, greatest: 500 }, "Points along each track; default 0."),
    optional(
        "around_s",
        number(0.0, 1800.0, " s"),
        "Time before and after the exposure in which crossings are also returned, seconds; default 0.",
    ),
];

/// Identifier of the exposure in the response, as in `passes`.
const ID: &str = "1";

pub fn handle(state: &RequestState, query: &Query) -> Result<String, Problem> {
    let start = query.moment("start_utc").ok_or_else(|| Problem::missing("start_utc", "UTC"))?;
    let state = &state.at(start)?;
    let rotation_deg = query.number("rotation_deg").or(state.config.rotation).unwrap_or_default();
    let exposure = Exposure {
        id: ID.to_owned(),
        start,
        duration_s: query.number("duration_s").unwrap_or_default(),
        pointing: pointing_of(query)?,
        rotation_rad: rotation_deg.to_radians(),
    };
    if let Some(band) = query.text("band") {
        state.check_band("band", band)?;
    }
    let policy = state.policy(query);
    let row = ScheduledExposure {
        id: ID.to_owned(),
        row: 0,
        band: query.text("band").map(str::to_owned),
        open_s: None,
        exposure: Ok(exposure.clone()),
    };
    let limit_mag = policy.limit_mag.as_ref().and_then(|limit| limit.limit_in(row.band.as_deref()));
    let samples = query.count("samples").unwrap_or_default();
    let passes_of = |exposure: &Exposure, samples: usize| -> Result<_, Error> {
        let crossings = state.sky().field_passes(
            std::slice::from_ref(exposure),
            &state.plan.field,
            &state.pass_options(samples),
        )?;
        Ok(crossings.by_exposure.into_iter().next().unwrap_or_default())
    };
    let long = query.number("around_s").map(|around_s| Exposure {
        start: seconds_after(start, -around_s),
        duration_s: exposure.duration_s + 2.0 * around_s,
        ..exposure.clone()
    });
    let request = state.request(&policy);
    // Passes and verdict are computed in parallel, because the page sends this request repeatedly during a drag.
    let ((passes, before_and_after), report) = rayon::join(
        || rayon::join(|| passes_of(&exposure, samples), || long.map_or(Ok(Vec::new()), |long| passes_of(&long, 0))),
        || flag_exposures(&[&row], &request),
    );
    let report = report?;
    let (mut passes, mut before_and_after) = (passes?, before_and_after?);
    let mut caveats = state.caveats_of_verdict(start, seconds_after(start, exposure.duration_s), &report.left_out)?;
    let mut totals = FlagTotals::default();
    totals.add(&report);
    caveats.warnings.extend(totals.lower_limit_warning());
    if report.flags.iter().any(|flag| matches!(flag.kind, VerdictKind::Unknown | VerdictKind::Invalid)) {
        // The pointing is below the horizon, so that crossings are not visible, or most crossings are unknown.
        passes.clear();
        before_and_after.clear();
    }
    let streaks = streak_table(
        passes.iter().map(|pass| request.streak_row((&exposure, None), pass, row.band.as_deref(), limit_mag)),
        StreakColumns { p_brighter: policy.has_limit_in(row.band.as_deref()), chords: true, samples: samples > 0 },
    );
    let around = Table {
        columns: AROUND.to_vec(),
        rows: before_and_after.iter().map(|pass| around_row(&request, pass, &row, &exposure, limit_mag)).collect(),
    };
    let mut document = Document::with_provenance(&state.provenance());
    document.caveats(&caveats);
    document.table("exposures", &exposure_table([&exposure]));
    document.table("flags", &flag_table(&report.flags));
    document.table("passes", &streaks);
    document.table("around", &around);
    document.table("pointing", &pointing(state, &exposure)?);
    document.table("left_out", &left_out_table(&report.left_out));
    Ok(document.into_json())
}

fn around_row(
    request: &FlagRequest<'_>,
    pass: &Pass,
    row: &ScheduledExposure,
    exposure: &Exposure,
    limit_mag: Option<f64>,
) -> Vec<Cell> {
    let after_s = |epoch| seconds_between(exposure.start, epoch);
    let peak = pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
    let band = row.band.as_deref();
    let limit_mag = request.limit_mag_of(pass, band, exposure.duration_s, limit_mag);
    vec![
        i64::from(pass.norad_id.0).into(),
        request.sky.elements()[pass.element_index].name.as_ref().into(),
        after_s(pass.enter.epoch).into(),
        after_s(pass.exit.epoch).into(),
        peak.map(|brightness| brightness.magnitude.0).into(),
        pass.probability.into(),
        limit_mag.map(|limit_mag| pass.probability_brighter_than(limit_mag)).into(),
        request.exceeds_limit(pass, band, exposure.duration_s).into(),
    ]
}

/// Returns altitudes and azimuths of field and Sun at the start and at the end of the exposure.
fn pointing(state: &RequestState, exposure: &Exposure) -> Result<Table, Problem> {
    let ends = [exposure.start, seconds_after(exposure.start, exposure.duration_s)];
    let row = |epoch| -> Result<Vec<Cell>, Error> {
        let (altitude_deg, azimuth_deg) = degrees(&state.sky().pointing_altaz(&exposure.pointing, epoch)?);
        let (sun_altitude_deg, sun_azimuth_deg) = degrees(&state.sky().sun_altaz(epoch)?);
        Ok(vec![epoch.into(), altitude_deg.into(), azimuth_deg.into(), sun_altitude_deg.into(), sun_azimuth_deg.into()])
    };
    let rows = ends.into_iter().map(row).collect::<Result<_, _>>()?;
    Ok(Table { columns: POINTING.to_vec(), rows })
}

pub fn schema() -> Value {
    let columns = StreakColumns { p_brighter: true, chords: true, samples: true };
    let mut passes = rows_schema(&streak_table(std::iter::empty(), columns).columns);
    // These columns are only present if the corresponding parameter, or a magnitude limit, is given.
    if let Some(required) = passes["items"]["required"].as_array_mut() {
        required.retain(|name| name != "samples" && name != "p_brighter");
    }
    document_schema(&[
        ("exposures", rows_schema(&exposure_table([]).columns)),
        ("flags", rows_schema(&flag_table(&[]).columns)),
        ("passes", passes),
        ("around", rows_schema(&AROUND)),
        ("pointing", rows_schema(&POINTING)),
        ("left_out", rows_schema(&left_out_table(&[]).columns)),
    ])
}
