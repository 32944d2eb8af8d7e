//! Time of the main task, from element text to crossings; time of an exposure with filled caches; and scaling.
//!
//! ```text
//! cargo bench --bench night -- ELEMENTS SCHEDULE [FOV_DEG]          medians of cold and warm runs
//! cargo bench --bench night                                         scaling with satellites and exposures
//! cargo bench --bench night -- old ELEMENTS DATE [FOV_DEG]          crossing probabilities with old elements
//! cargo bench --bench night -- windows ELEMENTS DATE [FOV_DEG]      clear windows of 40 targets over five hours
//! ```
//!
//! The schedule of the published figures is made by `tests/reference/make_bench_exposures.py`; `tests/benches/peers`
//! runs other packages on the same input.

use std::path::PathBuf;
use std::time::Instant;

use hifitime::{Epoch, Unit};
use streakcast::elements::{Constellation, ElementSet, ReadOptions, Satellites};
use streakcast::frames::{Direction, EopTable, Horizontal, OrientationTable, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{Exposure, Field, ModelChoice, PassOptions, Passes, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::schedule::{
    FlagRequest, Policy, Schedule, ScheduleOptions, WindowRequest, WindowTarget, clear_windows_without_passes,
};

fn main() {
    // `cargo bench` and `cargo test --benches` add flags.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    match words.as_slice() {
        [] => growth(),
        [old, elements, date] if old == "old" => old_elements(elements, date, 3.5),
        [old, elements, date, fov_deg] if old == "old" => old_elements(elements, date, number(fov_deg)),
        [windows, elements, date] if windows == "windows" => clear(elements, date, 8.0),
        [windows, elements, date, fov_deg] if windows == "windows" => clear(elements, date, number(fov_deg)),
        [elements, schedule] => medians(elements, schedule, 3.5),
        [elements, schedule, fov_deg] => medians(elements, schedule, number(fov_deg)),
        _ => eprintln!("usage: night [ELEMENTS SCHEDULE [FOV_DEG] | (old | windows) ELEMENTS DATE [FOV_DEG]]"),
    }
}

fn number(word: &str) -> f64 {
    word.parse().unwrap_or_else(|_| panic!("{word:?} is not a number"))
}

fn cerro_pachon() -> Observer {
    Observer::new(Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site"))
}

fn sky(elements: Vec<ElementSet>) -> Sky {
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    Sky::with_models(elements, cerro_pachon(), EopTable::embedded(), &choice)
}

fn exposures(schedule: &str) -> Vec<Exposure> {
    let options = ScheduleOptions::default();
    let schedule = Schedule::read(&PathBuf::from(schedule), &options).expect("the schedule reads");
    schedule.valid_exposures().map(|(_, exposure)| exposure.clone()).collect()
}

fn crossings_of(sky: &Sky, exposures: &[Exposure], fov_deg: f64) -> Passes {
    let field = Field::circle(fov_deg.to_radians()).expect("a field");
    // Satellites in the shadow are included, because the peers list them too.
    let options = PassOptions { include_dark: true, ..PassOptions::default() };
    sky.field_passes(exposures, &field, &options).expect("passes")
}

/// Returns the times for reading, preparation, and crossings, seconds.
fn cold(elements: &str, exposures: &[Exposure], fov_deg: f64) -> [f64; 3] {
    let start = Instant::now();
    let catalogue = Satellites::read(&[PathBuf::from(elements)], &ReadOptions::default()).expect("the elements read");
    let read_s = start.elapsed().as_secs_f64();
    let sky = sky(catalogue.element_sets);
    let ready_s = start.elapsed().as_secs_f64() - read_s;
    crossings_of(&sky, exposures, fov_deg);
    let crossings_s = start.elapsed().as_secs_f64() - read_s - ready_s;
    [read_s, ready_s, crossings_s]
}

fn medians(elements: &str, schedule: &str, fov_deg: f64) {
    let exposures = exposures(schedule);
    let runs: Vec<[f64; 3]> = (0..9).map(|_| cold(elements, &exposures, fov_deg)).collect();
    let catalogue = Satellites::read(&[PathBuf::from(elements)], &ReadOptions::default()).expect("the elements read");
    let satellites = catalogue.element_sets.len();
    let sky = sky(catalogue.element_sets);
    let mut found = 0;
    let warm: Vec<f64> = (0..9)
        .map(|_| {
            let start = Instant::now();
            found = crossings_of(&sky, &exposures, fov_deg).by_exposure.iter().map(Vec::len).sum();
            start.elapsed().as_secs_f64()
        })
        .collect();
    println!(
        "{satellites} satellites, {} exposures, {found} crossings, {} threads",
        exposures.len(),
        rayon::current_num_threads()
    );
    for (part, name) in ["reading", "making ready", "crossings"].into_iter().enumerate() {
        println!("{name:14} {:8.1} ms", 1e3 * median(runs.iter().map(|run| run[part]).collect()));
    }
    println!("{:14} {:8.1} ms", "text to list", 1e3 * median(runs.iter().map(|run| run.iter().sum()).collect()));
    let each_us = 1e6 * median(warm) / exposures.len() as f64;
    println!("{:14} {each_us:8.1} µs an exposure", "warm");
    let one_by_one: Vec<f64> = exposures
        .iter()
        .map(|exposure| {
            let start = Instant::now();
            crossings_of(&sky, std::slice::from_ref(exposure), fov_deg);
            start.elapsed().as_secs_f64()
        })
        .collect();
    println!("{:14} {:8.1} µs per exposure, as called by a scheduler", "one by one", 1e6 * median(one_by_one));
}

/// Measures the probabilities of all satellites in twelve visits of an evening, with filled caches.
fn old_elements(elements: &str, date: &str, fov_deg: f64) {
    let catalogue = Satellites::read(&[PathBuf::from(elements)], &ReadOptions::default()).expect("the elements read");
    let sky = sky(catalogue.element_sets);
    let start: Epoch = format!("{date}T23:40:00 UTC").parse().expect("a date");
    let visits = random_exposures(start, 12);
    let field = Field::circle(fov_deg.to_radians()).expect("a field");
    let mut found = sky.crossing_probabilities(&visits, &field).expect("probabilities");
    let times = (0..9)
        .map(|_| {
            let begin = Instant::now();
            found = sky.crossing_probabilities(&visits, &field).expect("probabilities");
            begin.elapsed().as_secs_f64()
        })
        .collect();
    let count: usize = found.iter().map(Vec::len).sum();
    let expected: f64 = found.iter().flatten().map(|one| one.probability).sum();
    println!(
        "{} satellites, {} visits on {date}: {count} satellites, {expected:.4} streaks expected",
        sky.elements().len(),
        visits.len()
    );
    println!("{:14} {:8.2} ms a visit", "all together", 1e3 * median(times) / visits.len() as f64);
    let one_by_one: Vec<f64> = visits
        .iter()
        .map(|visit| {
            let begin = Instant::now();
            sky.crossing_probabilities(std::slice::from_ref(visit), &field).expect("probabilities");
            begin.elapsed().as_secs_f64()
        })
        .collect();
    println!("{:14} {:8.2} ms a visit", "one by one", 1e3 * median(one_by_one));
}

/// Measures the clear windows of forty targets above the horizon in an evening, computed in one request.
fn clear(elements: &str, date: &str, fov_deg: f64) {
    let catalogue = Satellites::read(&[PathBuf::from(elements)], &ReadOptions::default()).expect("the elements read");
    let sky = sky(catalogue.element_sets);
    let from: Epoch = format!("{date}T22:50:00 UTC").parse().expect("a date");
    let exposures = random_exposures(from, 40);
    let target = |exposure| WindowTarget { exposure, band: None };
    let targets: Vec<WindowTarget> = exposures.into_iter().map(target).collect();
    let field = Field::circle(fov_deg.to_radians()).expect("a field");
    let (policy, photometry) = (Policy::default(), PhotometryOptions::default());
    let conditions =
        FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
    let request = WindowRequest { conditions, min_altitude_rad: 0.0, max_sun_altitude_rad: None };
    let find_windows =
        || clear_windows_without_passes(&targets, from, seconds_after(from, 5.0 * 3600.0), &request).expect("windows");
    let mut report = find_windows();
    let times = (0..9)
        .map(|_| {
            let begin = Instant::now();
            report = find_windows();
            begin.elapsed().as_secs_f64()
        })
        .collect();
    let windows: usize = report.by_target.iter().map(|one| one.windows.len()).sum();
    let blocking_passes: usize = report.by_target.iter().map(|one| one.blocking_passes.len()).sum();
    println!(
        "{} satellites, {} targets: {windows} windows, {blocking_passes} passes",
        sky.elements().len(),
        targets.len()
    );
    println!("{:14} {:8.2} ms a target", "five hours", 1e3 * median(times) / targets.len() as f64);
}

/// Returns random pointings above an altitude of 30°, one every 34 s over successive nights.
fn random_exposures(start: Epoch, count: usize) -> Vec<Exposure> {
    let mut state = 1_u64;
    // Linear congruential generator of Knuth (MMIX): the pointings must only be spread out and reproducible.
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let observer = cerro_pachon();
    (0..count)
        .map(|number| {
            let (night, visit) = (number / 1000, number % 1000);
            let at = start + night as f64 * Unit::Day + 34.0 * visit as f64 * Unit::Second;
            let here = observer.state(&OrientationTable::new(at, at, &EopTable::embedded()).at_s(0.0));
            let altitude_rad = (0.5 + 0.5 * random()).asin();
            let direction = Direction::<Horizontal>::from_lon_lat_rad(random() * std::f64::consts::TAU, altitude_rad);
            Exposure {
                id: number.to_string(),
                start: at,
                duration_s: 30.0,
                pointing: here.horizon.inverse() * direction,
                rotation_rad: 0.0,
            }
        })
        .collect()
}

fn growth() {
    let start = Epoch::from_gregorian_utc(2026, 4, 25, 23, 40, 0, 0);
    let mut shells: Vec<ElementSet> = Vec::new();
    for name in ["starlink-gen2", "kuiper", "oneweb", "starlink-gen1"] {
        shells.extend(Constellation::by_name(name).expect("a shell").element_sets(start));
    }
    let measure = |satellites: usize, count: usize| {
        let exposures = random_exposures(start, count);
        // Every n-th satellite is used, so that catalogues of all sizes contain the same fractions of shells.
        let step = shells.len() as f64 / satellites as f64;
        let chosen = (0..satellites).map(|number| shells[(number as f64 * step) as usize].clone()).collect();
        let sky = sky(chosen);
        let mut found = 0;
        let times: Vec<f64> = (0..5)
            .map(|_| {
                let begin = Instant::now();
                found = crossings_of(&sky, &exposures, 3.5).by_exposure.iter().map(Vec::len).sum::<usize>();
                begin.elapsed().as_secs_f64()
            })
            .collect();
        let each_us = |time_s: f64| 1e6 * time_s / count as f64;
        let (cold_us, warm_us) = (each_us(times[0]), each_us(median(times)));
        println!(
            "{satellites:6} satellites {count:6} exposures {found:6} crossings {warm_us:9.1} µs an exposure, {cold_us:9.1} µs cold"
        );
    };
    for satellites in [5_000, 10_000, 20_000, 40_000] {
        measure(satellites, 1_000);
    }
    for count in [100, 1_000, 10_000] {
        measure(10_000, count);
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
