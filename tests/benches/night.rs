//! The main job's speed: TLE text to crossing list, and a warm exposure.
fn main() {
    use std::time::Instant;
    use streakcast::{catalogue::*, frames::*, geometry::*, passes::*};
    let file = std::env::args().nth(1).unwrap();
    for _ in 0..5 {
        let t0 = Instant::now();
        let cat = Catalogue::read(&[std::path::PathBuf::from(&file)], &ReadOptions::default()).unwrap();
        let t1 = Instant::now();
        let n = cat.element_sets.len();
        let site = Observer::new(Site::new_deg("cp", -30.244639, -70.749417, 2663.0).unwrap());
        let sky = Sky::new(
            cat.element_sets,
            site.clone(),
            EopTable::embedded(),
            &ModelChoice::new(&streakcast::photometry::ModelLibrary::embedded()).expect("shipped models"),
        );
        let t2 = Instant::now();
        let start = hifitime::Epoch::from_gregorian_utc(2026, 4, 25, 23, 40, 0, 0);
        let mut seed = 1u64;
        let mut rnd = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let eop = EopTable::embedded();
        let table = OrientationTable::new(start, start + 34000.0 * hifitime::Unit::Second, &eop);
        let exposures: Vec<Exposure> = (0..1000)
            .map(|i| {
                let st = start + (34.0 * i as f64) * hifitime::Unit::Second;
                let h = site.state(&table.at_s(34.0 * i as f64)).horizon.inverse();
                let alt = (0.5 + 0.5 * rnd()).asin();
                let az = rnd() * std::f64::consts::TAU;
                Exposure {
                    id: i.to_string(),
                    start: st,
                    duration_s: 30.0,
                    pointing: h * Direction::from_lon_lat_rad(az, alt),
                    rotation_rad: 0.0,
                }
            })
            .collect();
        let field = Field::circle(3.5f64.to_radians()).unwrap();
        let t3 = Instant::now();
        let dark = PassOptions { include_dark: true, ..Default::default() };
        let p = sky.field_passes(&exposures, &field, &dark).unwrap();
        let t4 = Instant::now();
        let p2 = sky.field_passes(&exposures, &field, &PassOptions::default()).unwrap();
        let t5 = Instant::now();
        println!(
            "read {:?} ({n}) sky {:?} dark passes {:?} ({}) lit passes {:?} ({}) left out {}",
            t1 - t0,
            t2 - t1,
            t4 - t3,
            p.by_exposure.iter().map(Vec::len).sum::<usize>(),
            t5 - t4,
            p2.by_exposure.iter().map(Vec::len).sum::<usize>(),
            p.left_out.len()
        );
    }
}
