//! Identification of a streak: `cargo run --example identify_streak`.
//!
//! The streak is that of a satellite of a synthetic constellation, which needs no files. For real satellites, replace
//! the line that creates `elements` by `Satellites::read(&paths, &ReadOptions::default())?.element_sets`, and take
//! `ends` from a plate-solved image.

use std::error::Error;

use streakcast::elements::Constellation;
use streakcast::frames::parse_instant;
use streakcast::frames::{Direction, EopTable, seconds_between};
use streakcast::geometry::{Observer, Site};
use streakcast::identify::{IdentifyOptions, MeasuredStreak, Timing, identify_streak};
use streakcast::passes::{Exposure, Field, ModelChoice, PassOptions, Sky};
use streakcast::photometry::ModelLibrary;

fn main() -> Result<(), Box<dyn Error>> {
    // 1. Satellites and site.
    let start = parse_instant("2026-08-14T23:29:05Z", None)?;
    let elements = Constellation::by_name("starlink-gen1")?.element_sets(parse_instant("2026-08-14T00:00:00Z", None)?);
    let observer = Observer::new(Site::from_mpc("X05")?);
    let sky = Sky::with_models(elements, observer, EopTable::embedded(), &ModelChoice::new(&ModelLibrary::embedded())?);

    // 2. Measurement: two ends in an exposure of 30 s, with errors of 5 arcsec and 0.5 s (clock). Here the ends are
    //    those of a predicted crossing.
    let exposure = Exposure {
        id: "1".to_owned(),
        start,
        duration_s: 30.0,
        pointing: Direction::from_lon_lat_rad(198.9_f64.to_radians(), 7.7_f64.to_radians()),
        rotation_rad: 0.0,
    };
    let field = Field::circle(3.5_f64.to_radians())?;
    let passes = sky.field_passes(std::slice::from_ref(&exposure), &field, &PassOptions::default())?;
    let pass = passes.by_exposure[0].first().ok_or("nothing crosses this field")?;
    let ends = [pass.enter.direction, pass.exit.direction];
    let place_sigma_rad = (5.0_f64 / 3600.0).to_radians();
    let streak = MeasuredStreak::from_ends(ends, (start, 30.0), Timing::Within, place_sigma_rad, 0.5)?;

    // 3. Candidates, most probable first, with along-track and cross-track offsets from the prediction.
    let found = identify_streak(&sky, &streak, &IdentifyOptions::default())?;
    for candidate in found.candidates.iter().take(3) {
        let across_arcsec = candidate.cross_track_rad.value.to_degrees() * 3600.0;
        println!(
            "{} with probability {:.3}: {:+.2} s late, {across_arcsec:+.1} arcsec across the track, {:.0} km away",
            sky.elements()[candidate.element_index].name,
            candidate.probability,
            candidate.along_track_s.value,
            candidate.passage.range_km,
        );
    }
    println!("probability of a satellite missing from the element sets: {:.3}", found.unknown_probability);

    // The satellite that made the streak comes first.
    let first = found.candidates.first().ok_or("no candidate")?;
    if first.norad_id != pass.norad_id || seconds_between(pass.enter.epoch, first.passage.epoch).abs() > 30.0 {
        return Err(format!("{} made the streak, and {} was found", pass.norad_id, first.norad_id).into());
    }
    Ok(())
}
