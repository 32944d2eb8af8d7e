//! Offsets learned from measured magnitudes, and alarms: `cargo run --example learn_offsets`.
//!
//! The measurements are invented: eight nights of three OneWeb satellites, 0.3 mag fainter than their model, and a
//! ninth night in which one of them is 4 mag brighter. For real ones, fill `residual_mag` with measured less predicted
//! magnitudes, or read photometry files with `streakcast::learn::passes_of`.

use std::collections::BTreeMap;
use std::error::Error;

use streakcast::Watch;
use streakcast::elements::{Generation, NoradId};
use streakcast::frames::{parse_instant, seconds_after};
use streakcast::learn::{PassPoint, find_alarms, group_passes, learn};
use streakcast::passes::ModelChoice;

fn main() -> Result<(), Box<dyn Error>> {
    // 1. Measurements: satellite, kind, time, and difference from the model.
    let start = parse_instant("2026-08-01T23:30:00Z", None)?;
    let point = |satellite: u32, night: u32, difference_mag: f64| {
        let own_mag = 0.1 * f64::from(satellite) - 0.2;
        let pass_mag = if (satellite + night).is_multiple_of(2) { 0.1 } else { -0.1 };
        let epoch = seconds_after(start, 86_400.0 * f64::from(night));
        let residual_mag = difference_mag + own_mag + pass_mag;
        let point = PassPoint { epoch, residual_mag, sigma_mag: Some(0.05) };
        (NoradId(90_000 + satellite), Generation::OneWeb, point)
    };
    let nights = (0..8).flat_map(|night| (1..=3).map(move |satellite| point(satellite, night, 0.3)));
    let passes = group_passes(nights);

    // 2. Offsets: that of a satellite is shrunk towards that of its kind, and that of the kind towards 0 (the model).
    let models = ModelChoice::default();
    let learned = learn(&passes, &BTreeMap::new(), &models, serde_json::Map::new(), &Watch::default())?.file;
    for one in &learned.satellites {
        println!("{}: {:+.2} +- {:.2} mag, {} passes", one.norad_id, one.offset_mag, one.offset_sigma_mag, one.passes);
    }

    // 3. Alarms of the ninth night.
    let tonight = group_passes([point(1, 8, 0.3), point(2, 8, -3.7), point(3, 8, 0.3)]);
    for alarm in find_alarms(&tonight, &learned, 1e-4).alarms {
        println!("{}: {:+.1} mag, p = {:.0e}", alarm.norad_id, alarm.value, alarm.p_after_looks);
    }

    // 4. Models with the learned offsets, for `Sky::with_models`; `learned.to_json()` is the file for --learned.
    let models = models.with_learned(learned, "learned.json")?;
    println!("{}", models.of_kind(Generation::OneWeb).ok_or("no model")?.source());
    Ok(())
}
