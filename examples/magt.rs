//! Temporary: verdicts of exposures with limits, and the time of a magnitude.
use std::time::Instant;
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::{Earthshine, ModelLibrary, PhotometryOptions};
use streakcast::{Exposure, Field, Policy, Satellites, Site, Sky};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    if args[1] == "time" {
        let geometries: Vec<ViewingGeometry> = (0..1000)
            .map(|i| {
                let up = -(i as f64 + 0.5) / 1000.0;
                let range = 550.0 / f64::max(0.2, -up);
                ViewingGeometry::from_angles(
                    (-12.0 + 1e-4 * i as f64).to_radians(),
                    2.399_963 * i as f64,
                    up.asin(),
                    range,
                    550.0,
                )
                .unwrap()
            })
            .collect();
        let library = ModelLibrary::embedded();
        for name in [
            "starlink-v1.5-facets",
            "v2mini-panels",
            "visorsat-panels",
            "oneweb-panels",
            "iridium-next",
            "starlink-v1.5",
        ] {
            let model = library.get(name).unwrap();
            let mut best = [f64::INFINITY; 2];
            for (k, earthshine) in [Earthshine::Off, Earthshine::Computed].into_iter().enumerate() {
                let options = PhotometryOptions { earthshine, ..PhotometryOptions::default() };
                for _ in 0..400 {
                    let start = Instant::now();
                    let sum: f64 = geometries
                        .iter()
                        .filter_map(|g| Some(model.brightness(std::hint::black_box(g), 1.0, &options)?.magnitude.0))
                        .sum();
                    std::hint::black_box(sum);
                    best[k] = best[k].min(start.elapsed().as_secs_f64());
                }
            }
            println!("{name}: {:.1} ns sunlight, {:.1} ns with earthshine", best[0] * 1e6, best[1] * 1e6);
        }
        return Ok(());
    }
    let satellites = Satellites::from_files([&args[2]])?;
    let sky = Sky::new(satellites, Site::from_mpc("X05")?);
    let field = Field::circle_deg(3.5)?;
    for line in std::fs::read_to_string(&args[1])?.lines() {
        let cells: Vec<&str> = line.split(',').collect();
        let exposure = Exposure::new(cells[1], cells[2].parse()?, cells[3], cells[4])?;
        for limit in [6.0, 7.0, 8.0] {
            let verdict = sky.judge(&exposure, &field, &Policy::limit_mag(limit))?;
            let passes: Vec<String> = verdict
                .passes
                .iter()
                .map(|p| {
                    let b = p.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
                    b.map_or("-".into(), |b| {
                        format!(
                            "{}:{:.2}+-{:.2}:{}:{:.3}:{:.3}",
                            p.norad_id,
                            b.magnitude.0,
                            b.sigma_mag,
                            b.source,
                            b.probability_brighter_than(limit),
                            p.probability
                        )
                    })
                })
                .collect();
            println!("{}|{limit}|{:?}|{:.3}|{}", cells[0], verdict.kind, verdict.p_any, passes.join(" "));
        }
    }
    Ok(())
}
