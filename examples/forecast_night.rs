//! Visible passes of a night for a synthetic constellation: `cargo run --example forecast_night`.
//!
//! For real element sets, replace the line that creates `elements` by `Satellites::read(&paths,
//! &ReadOptions::default())?.element_sets`.

use std::error::Error;

use streakcast::elements::Constellation;
use streakcast::forecast::{ForecastRequest, Selection, forecast};
use streakcast::frames::EopTable;
use streakcast::frames::parse_instant;
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{ModelChoice, Sky, TrackPoint};
use streakcast::photometry::ModelLibrary;
use streakcast::schedule::night_of;

fn main() -> Result<(), Box<dyn Error>> {
    // 1. Satellites, site, and night (from noon to noon at the site).
    let noon = parse_instant("2026-08-14T12:00:00Z", None)?;
    let elements = Constellation::by_name("starlink-gen1")?.element_sets(noon);
    let site = Site::from_mpc("X05")?;
    let (from, to) = night_of(noon, site.longitude_rad);
    let sky = Sky::with_models(
        elements,
        Observer::new(site),
        EopTable::embedded(),
        &ModelChoice::new(&ModelLibrary::embedded())?,
    );

    // 2. Request: passes brighter than magnitude 5.5 that reach 40 degrees, with five points along each.
    let request = ForecastRequest {
        max_magnitude: Some(5.5),
        min_culmination_rad: 40.0_f64.to_radians(),
        samples: 5,
        ..ForecastRequest::new(from, to)
    };
    let result = forecast(&sky, &request, &Selection::default())?;
    println!("dark for {:.1} h; {} passes", result.night.dark_s() / 3600.0, result.found.passes.len());

    // 3. Each pass: first, highest and last visible point, and its brightness.
    for pass in result.found.passes.iter().take(5) {
        let Some(seen) = &pass.visible else { continue };
        println!("{}", sky.elements()[pass.element_index].name);
        for (what, point) in [("from", &seen.begin), ("over", &seen.highest), ("to", &seen.end)] {
            println!("    {what:4} {}", point_text(point));
        }
        for point in &pass.samples {
            let magnitude = point.brightness.as_ref().map(|light| format!("{:.2}", light.magnitude.0));
            println!("    {} {}", point.epoch, magnitude.as_deref().unwrap_or("dark"));
        }
    }
    if let Some(why) = result.why_empty(&sky, &request) {
        println!("no passes: {why}");
    }
    Ok(())
}

fn point_text(point: &TrackPoint) -> String {
    let (altitude_rad, azimuth_rad) = (point.altitude_rad.unwrap_or(f64::NAN), point.azimuth_rad.unwrap_or(f64::NAN));
    let (altitude_deg, azimuth_deg) = (altitude_rad.to_degrees(), azimuth_rad.to_degrees());
    format!("{} altitude {altitude_deg:2.0} deg, azimuth {azimuth_deg:3.0} deg", point.epoch)
}
