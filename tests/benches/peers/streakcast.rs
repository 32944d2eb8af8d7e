//! Run of streakcast for `compare.py`: reads elements and a schedule, writes timings and crossings as JSON.
//!
//! Usage: `streakcast ELEMENTS SCHEDULE FOV_DEG LIMIT`. LIMIT is the number of exposures; 0 uses the whole schedule.
//! The time is measured from the text of the elements to the last crossing. As for the peers, reading the schedule and
//! the bundled models is excluded, and all satellites have their published drag.

use std::path::PathBuf;
use std::time::Instant;

use streakcast::elements::{ReadOptions, Satellites};
use streakcast::frames::EopTable;
use streakcast::geometry::{Observer, Site};
use streakcast::orbit::DragModel;
use streakcast::passes::{Exposure, Field, ModelChoice, PassOptions, Sky};
use streakcast::photometry::ModelLibrary;
use streakcast::schedule::{Schedule, ScheduleOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo bench` adds a flag.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let [elements, schedule, fov_deg, limit] = words.as_slice() else {
        eprintln!("usage: streakcast ELEMENTS SCHEDULE FOV_DEG LIMIT (0: all); see tests/benches/peers/compare.py");
        return Ok(());
    };
    let limit = match limit.parse()? {
        0 => usize::MAX,
        some => some,
    };
    let schedule = Schedule::read(&PathBuf::from(schedule), &ScheduleOptions::default())?;
    let exposures: Vec<Exposure> =
        schedule.valid_exposures().map(|(_, exposure)| exposure.clone()).take(limit).collect();
    let field = Field::circle(fov_deg.parse::<f64>()?.to_radians())?;
    let models = ModelChoice::new(&ModelLibrary::embedded())?;
    let options = PassOptions { include_dark: true, ..PassOptions::default() };
    let observer = Observer::new(Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0)?);
    let eop = EopTable::embedded();

    let start = Instant::now();
    let catalogue = Satellites::read(&[PathBuf::from(elements)], &ReadOptions::default())?;
    let read = Instant::now();
    let sky = Sky::with_models(catalogue.element_sets, observer, eop, &models).with_drag(DragModel::Published);
    let ready = Instant::now();
    let passes = sky.field_passes(&exposures, &field, &options)?;
    let end = Instant::now();

    let crossings: Vec<(&str, u32)> = exposures
        .iter()
        .zip(&passes.by_exposure)
        .flat_map(|(exposure, passes)| passes.iter().map(|pass| (exposure.id.as_str(), pass.norad_id.0)))
        .collect();
    let answer = serde_json::json!({
        "name": "streakcast",
        "exposures": exposures.len(),
        "timings": {
            "read_s": (ready - start).as_secs_f64(),
            "of_it_text_s": (read - start).as_secs_f64(),
            "crossings_s": (end - ready).as_secs_f64(),
            "total_s": (end - start).as_secs_f64(),
        },
        "crossings": crossings,
        "left_out": passes.left_out.iter().map(|left_out| left_out.norad_id.0).collect::<Vec<_>>(),
    });
    println!("{answer}");
    Ok(())
}
