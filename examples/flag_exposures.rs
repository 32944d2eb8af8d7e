//! Three exposures under a synthetic constellation, judged by the library alone: `cargo run --example flag_exposures`.
//!
//! Satellites, observer and models make a [`Sky`]; a sky, a field and a policy make verdicts. With real element sets, the
//! line that makes `elements` becomes `Catalogue::read(&paths, &ReadOptions::default())?.element_sets`.

use std::error::Error;

use streakcast::elements::Constellation;
use streakcast::frames::parse_instant;
use streakcast::frames::{Direction, EopTable, parse_declination_deg, parse_right_ascension_deg};
use streakcast::geometry::{Observer, Site};
use streakcast::output::format_utc;
use streakcast::passes::{Exposure, Field, ModelChoice, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::schedule::{FlagRequest, MagnitudeLimit, Policy, ScheduledExposure, flag_exposures};

fn main() -> Result<(), Box<dyn Error>> {
    // 1. Who is up there: the 4,408 satellites of Starlink Gen1 as filed. None of them is claimed to be there.
    let evening = parse_instant("2026-08-14T23:36:00Z", None)?;
    let elements = Constellation::by_name("starlink-gen1")?.element_sets(evening);

    // 2. Who looks: Rubin Observatory by its MPC code, and how the Earth stands.
    let observer = Observer::new(Site::by_mpc_code("X05")?);
    let sky = Sky::new(elements, observer, EopTable::embedded(), &ModelChoice::new(&ModelLibrary::embedded())?);

    // 3. What is asked: three exposures of 30 s with a field 3.5 degrees across.
    let field = Field::circle(3.5_f64.to_radians())?;
    let exposures = [
        exposure("west", "2026-08-14T23:36:25Z", "14h53m36s", "-08d54m")?,
        exposure("zenith", "2026-08-14T23:48:00Z", "230.5", "-26.2")?,
        exposure("midnight", "2026-08-15T04:00:00Z", "312.5", "-5.3")?,
    ];

    // 4. What is called bad: anything brighter than magnitude 7, the limit that Rubin asks operators to keep.
    let policy = Policy { limit_mag: Some(MagnitudeLimit::All(7.0)), ..Policy::default() };
    let request = FlagRequest {
        sky: &sky,
        field: &field,
        policy: &policy,
        telescope: None,
        photometry: &PhotometryOptions::default(),
    };
    let report = flag_exposures(&exposures.iter().collect::<Vec<_>>(), &request)?;

    for (flag, passes) in report.flags.iter().zip(&report.passes) {
        println!("{}: {}", flag.exposure_id, flag.verdict);
        for pass in passes {
            let Some(brightness) = pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref()) else { continue };
            println!(
                "    {} from {} to {}, magnitude {:.2} +- {:.2} ({})",
                pass.norad_id,
                format_utc(pass.enter.epoch, 3),
                format_utc(pass.exit.epoch, 3),
                brightness.magnitude.0,
                brightness.sigma_mag,
                brightness.source
            );
        }
        match (flag.delay_s, flag.next_clear_start) {
            (Some(delay_s), Some(start)) if delay_s > 0.0 => {
                println!("    clear when started {delay_s:.1} s later, at {}", format_utc(start, 3));
            }
            (None, _) => println!("    not clear within ten minutes"),
            _ => {}
        }
    }
    Ok(())
}

/// Thirty seconds from `start` towards an ICRS place, written as one writes it.
fn exposure(id: &str, start: &str, ra: &str, dec: &str) -> Result<ScheduledExposure, Box<dyn Error>> {
    let pointing = Direction::from_lon_lat_rad(
        parse_right_ascension_deg(ra)?.to_radians(),
        parse_declination_deg(dec)?.to_radians(),
    );
    let exposure = Exposure {
        id: id.to_owned(),
        start: parse_instant(start, None)?,
        duration_s: 30.0,
        pointing,
        rotation_rad: 0.0,
    };
    Ok(ScheduledExposure { id: id.to_owned(), row: 0, band: None, exposure: Ok(exposure) })
}
