//! Verdict on one exposure: `cargo run --example flag_exposures [-- ELEMENTS.csv]`.
//!
//! Without an element file a synthetic constellation is used; its positions do not correspond to real satellites.

use streakcast::frames::parse_instant;
use streakcast::{Exposure, Field, Policy, Satellites, Site, Sky};

fn main() -> Result<(), streakcast::Error> {
    let satellites = match std::env::args().nth(1) {
        Some(file) => Satellites::from_files([file])?,
        None => Satellites::synthetic("starlink-gen1", parse_instant("2026-08-14T00:00:00Z", None)?)?,
    };
    let sky = Sky::new(satellites, Site::from_mpc("X05")?);
    let exposure = Exposure::new("2026-08-14T23:36:25Z", 30.0, "14h53m36s", "-08d54m")?;
    let verdict = sky.judge(&exposure, &Field::circle_deg(3.5)?, &Policy::limit_mag(7.0))?;
    println!("{verdict}");
    for pass in &verdict.passes {
        println!("{} {} {:.1}", pass.norad_id, pass.enter.epoch, pass.peak_magnitude());
    }
    Ok(())
}
