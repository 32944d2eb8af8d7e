//! `ephemeris`: positions of chosen satellites at given times.

use crate::arguments::OutputArguments;
use clap::Args;
use serde_json::json;
use streakcast::config::{Config, EphemerisConfig, PreparedSky, SATELLITES, SELECTION, SITE, TIMES};
use streakcast::forecast::{EphemerisRequest, EphemerisRow, ephemeris, ephemeris_table};
use streakcast::output::format_utc;

use super::passes::left_out_table;
use crate::failure::Outcome;
use crate::help::{CAMERA_FLAGS, VerbFlags, help};
use crate::output::VerbResult;
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct EphemerisArguments {
    #[command(flatten)]
    pub ephemeris: EphemerisConfig,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    EphemerisArguments, "ephemeris", asks [SELECTION, TIMES, SATELLITES, SITE],
    ignores [(CAMERA_FLAGS, "has no effect on an ephemeris")],
    "--name S1 --start 2024-08-14T03:30:00Z --end 2024-08-14T03:31:00Z --step 30s --shells oneweb --mpc X05 --min-altitude 20",
    "--norad 25544 --times 2024-08-14T03:30:00Z --elements active.tle --site Paranal --format ecsv"
}

const ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("norad_id", "norad"),
    rounded("utc", "time (UTC)", 1),
    rounded("ra_deg", "RA deg", 4),
    rounded("dec_deg", "dec deg", 4),
    rounded("ra_cos_dec_rate_deg_s", "dRA cos(dec) deg/s", 4),
    rounded("dec_rate_deg_s", "ddec deg/s", 4),
    rounded("altitude_deg", "alt deg", 2),
    rounded("azimuth_deg", "az deg", 2),
    rounded("range_km", "range km", 1),
    rounded("range_rate_km_s", "km/s", 3),
    shown("illumination", "light"),
    rounded("magnitude", "mag", 1),
    rounded("magnitude_sigma", "sigma", 1),
    rounded("element_age_days", "age d", 1),
    rounded("along_track_sigma_s", "late s", 1),
];

pub fn run(typed: EphemerisArguments) -> anyhow::Result<Outcome> {
    let config = typed.config.with_file()?;
    let EphemerisConfig { times, times_file, start, selection, .. } = &typed.ephemeris;
    let has_times = !times.is_empty() || times_file.is_some() || start.is_some();
    EphemerisArguments::HELP.check(&config, &[(&SELECTION, selection.is_given()), (&TIMES, has_times)])?;
    let request = typed.ephemeris.resolve(&config)?;
    let output = typed.output.open(&config)?;
    let notices = begin(&config)?;
    let (first, last) = request.span()?;
    let mut prepared = config.prepare(first, last)?;
    let selected = request.selection.among(prepared.sky.elements());
    notices.warn(&prepared.warnings_of(first, last, &|elements| selected.contains(elements)));
    notices.warn(&request.selection.unknown_warning(prepared.sky.elements()));
    let found = ephemeris(&prepared.sky, &request)?;
    let warning = prepared.left_out_warning_of_times(&found.left_out, first, !found.points.is_empty())?;
    notices.list_left_out(warning, &found.left_out);
    state(&mut prepared, &config, &typed.ephemeris, &request);
    let elements = prepared.sky.elements();
    let rows = found.points.iter().map(|point| EphemerisRow { point, elements: &elements[point.element_index] });
    let table = ephemeris_table(rows);
    output.write(
        &VerbResult::new("ephemeris", &table, ON_SCREEN, &prepared.provenance)
            .with("left_out", &left_out_table(&found.left_out)),
        &notices,
    )?;
    Ok(if found.points.is_empty() { Outcome::No } else { Outcome::Done })
}

fn state(prepared: &mut PreparedSky, config: &Config, given: &EphemerisConfig, request: &EphemerisRequest) {
    config.state_scales(&mut prepared.provenance, &request.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "times": request.times.len(),
            "times_file": given.times_file.as_ref().map(|path| path.display().to_string()),
            "start_utc": given.start.as_ref().and(request.times.first()).map(|epoch| format_utc(*epoch, 3)),
            "step": given.step,
            "norad": given.selection.norad,
            "name": given.selection.name,
            "generation": given.selection.generation,
            "min_altitude_deg": given.min_altitude,
        }),
    );
}
