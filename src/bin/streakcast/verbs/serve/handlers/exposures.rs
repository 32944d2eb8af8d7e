//! `/api/v1/exposures`: returns the verdicts of many exposures in one response, as `flag`.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;
use streakcast::frames::{Direction, seconds_after};
use streakcast::passes::Exposure;
use streakcast::schedule::{FlagTotals, ScheduledExposure, Verdict, exposure_table, flag_exposures, flag_table};

use super::super::super::passes::left_out_table;
use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, moment, number, optional, required};
use super::super::state::{Caveats, LIMIT_MAG, RequestState};
use super::document::{Document, document_schema, rows_schema};

/// Largest number of exposures in a request.
const MOST: usize = 250;
const ACCEPTED: &str = "START,DURATION_S,RA_DEG,DEC_DEG[,ROTATION_DEG[,BAND]], as 2024-08-14T00:30:00Z,30,188.5,-30.5";

pub const PARAMETERS: &[Parameter] = &[
    required(
        "exposures",
        Kind::Text { longest: 15_000 },
        "At most 250 exposures, separated by semicolons: START,DURATION_S,RA_DEG,DEC_DEG[,ROTATION_DEG[,BAND]], in UTC, seconds, \
         and degrees (ICRS). They are numbered from 1.",
    ),
    LIMIT_MAG,
    optional(
        "rotation_deg",
        number(-360.0, 360.0, " deg"),
        "Position angle of exposures without one, degrees; default: that of the server.",
    ),
];

pub fn handle(state: &RequestState, query: &Query) -> Result<String, Problem> {
    let text = query.text("exposures").unwrap_or_default();
    let given: Vec<&str> = text.split(';').filter(|part| !part.trim().is_empty()).collect();
    if given.is_empty() || given.len() > MOST {
        let allowed = format!("1 to {MOST} exposures, {ACCEPTED}");
        return Err(Problem::of_parameter(
            "exposures",
            format!("{} exposures are given; allowed: {allowed}", given.len()),
        ));
    }
    let default_rotation_deg = query.number("rotation_deg").or(state.config.rotation).unwrap_or_default();
    let rows = given.iter().enumerate().map(|(row, text)| scheduled(state, row, text, default_rotation_deg));
    let rows = rows.collect::<Result<Vec<ScheduledExposure>, _>>()?;
    let policy = state.policy(query);
    // Nights of different periods of constellations that grow have different satellites.
    let mut periods: BTreeMap<usize, Vec<(&ScheduledExposure, &Exposure)>> = BTreeMap::new();
    for row in &rows {
        if let Ok(exposure) = &row.exposure {
            periods.entry(state.period(exposure.start)).or_default().push((row, exposure));
        }
    }
    let mut totals = FlagTotals::default();
    let mut flags: BTreeMap<usize, Verdict> = BTreeMap::new();
    let (mut left_out, mut warnings, mut provenance) = (Vec::new(), Vec::new(), None);
    for part in periods.values() {
        let starts = part.iter().map(|(_, exposure)| exposure.start);
        let first = starts.min().unwrap_or(state.started);
        let ends = part.iter().map(|(_, exposure)| seconds_after(exposure.start, exposure.duration_s));
        let last = ends.max().unwrap_or(first);
        let state = state.at(first)?;
        let given: Vec<&ScheduledExposure> = part.iter().map(|(row, _)| *row).collect();
        let report = flag_exposures(&given, &state.request(&policy))?;
        warnings.extend(state.caveats_of_verdict(first, last, &report.left_out)?.warnings);
        totals.add(&report);
        left_out.extend(report.left_out);
        flags.extend(given.iter().map(|row| row.row).zip(report.flags));
        provenance.get_or_insert_with(|| state.provenance());
    }
    let mut told = BTreeSet::new();
    warnings.retain(|warning| told.insert(warning.clone()));
    warnings.extend(totals.lower_limit_warning());
    let mut document = Document::with_provenance(&provenance.unwrap_or_else(|| state.provenance()));
    document.caveats(&Caveats { warnings, left_out_count: left_out.len() });
    document.table("exposures", &exposure_table(rows.iter().filter_map(|row| row.exposure.as_ref().ok())));
    document.table("flags", &flag_table(&flags.into_values().collect::<Vec<_>>()));
    document.table("left_out", &left_out_table(&left_out));
    Ok(document.into_json())
}

fn scheduled(state: &RequestState, row: usize, text: &str, rotation_deg: f64) -> Result<ScheduledExposure, Problem> {
    let id = (row + 1).to_string();
    let of_this = |problem: Problem| problem.in_part("exposures", &format!("exposure {id}"));
    let wrong = |what: &str, given: &str, allowed: &str| of_this(Problem::parameter(what, given, allowed));
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    if !(4..=6).contains(&cells.len()) {
        return Err(wrong("values", text.trim(), ACCEPTED));
    }
    let start = moment(cells[0]).ok_or_else(|| wrong("start_utc", cells[0], "UTC like 2024-08-14T00:30:00Z"))?;
    let within = |what: &str, text: &str, [least, greatest]: [f64; 2], unit: &str| {
        let number = text.parse().ok().filter(|number| (least..=greatest).contains(number));
        number.ok_or_else(|| wrong(what, text, &format!("{least} to {greatest} {unit}, as a number without the unit")))
    };
    let pointing = Direction::from_lon_lat_rad(
        within("ra_deg", cells[2], [0.0, 360.0], "deg")?.to_radians(),
        within("dec_deg", cells[3], [-90.0, 90.0], "deg")?.to_radians(),
    );
    let rotation_deg = match cells.get(4) {
        Some(text) if !text.is_empty() => within("rotation_deg", text, [-360.0, 360.0], "deg")?,
        _ => rotation_deg,
    };
    let band = cells.get(5).filter(|band| !band.is_empty()).map(|band| (*band).to_owned());
    if let Some(band) = &band {
        state.check_band("band", band).map_err(of_this)?;
    }
    let exposure = Exposure {
        id: id.clone(),
        start,
        duration_s: within("duration_s", cells[1], [0.001, 3600.0], "s")?,
        pointing,
        rotation_rad: rotation_deg.to_radians(),
    };
    Ok(ScheduledExposure { id, row, band, open_s: None, exposure: Ok(exposure) })
}

pub fn schema() -> Value {
    document_schema(&[
        ("exposures", rows_schema(&exposure_table([]).columns)),
        ("flags", rows_schema(&flag_table(&[]).columns)),
        ("left_out", rows_schema(&left_out_table(&[]).columns)),
    ])
}
