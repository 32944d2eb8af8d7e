//! Which satellites cross: against an independent brute force (python-sgp4, ERFA), and the cull against our own.

mod common;

use std::collections::BTreeMap;

use hifitime::{Epoch, TimeScale};
use std::str::FromStr;
use streakcast::catalogue::{Catalogue, ElementSet, ReadOptions};
use streakcast::frames::{Direction, EopTable};
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{Exposure, Field, ModelChoice, PassOptions, Sky};

/// Cerro Pachón as the golden numbers have it.
fn cerro_pachon() -> Observer {
    Observer::new(Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site"))
}

fn sky(elements: Vec<ElementSet>) -> Sky {
    Sky::new(
        elements,
        cerro_pachon(),
        EopTable::embedded(),
        &ModelChoice::new(&streakcast::photometry::ModelLibrary::embedded()).expect("shipped models"),
    )
}

fn utc(text: &str) -> Epoch {
    Epoch::from_str(text.trim_end_matches('Z')).map(|epoch| epoch.to_time_scale(TimeScale::UTC)).expect("a time")
}

struct Golden {
    exposure: Exposure,
    /// norad id to (enter, exit) pairs and the least separation
    crossings: BTreeMap<u32, (Vec<(f64, f64)>, f64)>,
}

fn golden() -> Vec<Golden> {
    let text = include_str!("data/crossings_golden.csv");
    let mut all: Vec<Golden> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |cell: usize| cells[cell].parse::<f64>().expect("a number");
        if all.last().is_none_or(|last| last.exposure.id != cells[0]) {
            let exposure = Exposure {
                id: cells[0].to_owned(),
                start: utc(cells[1]),
                duration_s: number(2),
                pointing: Direction::from_lon_lat_rad(number(3).to_radians(), number(4).to_radians()),
                rotation_rad: 0.0,
            };
            all.push(Golden { exposure, crossings: BTreeMap::new() });
        }
        if !cells[5].is_empty() {
            let id = cells[5].parse().expect("an id");
            let entry = all.last_mut().expect("pushed").crossings.entry(id).or_insert((Vec::new(), number(8)));
            entry.0.push((number(6), number(7)));
        }
    }
    all
}

/// Entry and exit of fast satellites agree to this, seconds: golden times are root-found to 1e-6 s on the same model.
const TIME_TOLERANCE_S: f64 = 2e-3;
/// And every border is met to this angle, degrees: 0.2 arcsec. Slow satellites cross in seconds what others cross in milliseconds.
const ANGLE_TOLERANCE_DEG: f64 = 0.2 / 3600.0;

#[test]
fn valid_crossings_against_python_sgp4_and_erfa() {
    let Some(data) = common::data_dir() else { return };
    let catalogue = Catalogue::read(&[data.join("tle/active/active_2026-04-25.txt")], &ReadOptions::default())
        .expect("the catalogue reads");
    let sky = sky(catalogue.element_sets);
    let golden = golden();
    let exposures: Vec<Exposure> = golden.iter().map(|golden| golden.exposure.clone()).collect();
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let options = PassOptions { include_dark: true, ..PassOptions::default() };
    let passes = sky.field_passes(&exposures, &field, &options).expect("an answer");
    let mut compared = 0;
    for (golden, passes) in golden.iter().zip(&passes.by_exposure) {
        let ids: Vec<u32> = {
            let mut ids: Vec<u32> = passes.iter().map(|pass| pass.norad_id.0).collect();
            ids.sort_unstable();
            ids
        };
        let expected: Vec<u32> = golden.crossings.keys().copied().collect();
        assert_eq!(ids, expected, "{}", golden.exposure.id);
        for pass in passes {
            let (chords, separation_deg) = &golden.crossings[&pass.norad_id.0];
            assert_eq!(pass.chords.len(), chords.len(), "{} {}", golden.exposure.id, pass.norad_id);
            assert!((pass.min_separation_rad.to_degrees() - separation_deg).abs() < ANGLE_TOLERANCE_DEG);
            for (chord, (enter_s, exit_s)) in pass.chords.iter().zip(chords) {
                let tolerance_s = TIME_TOLERANCE_S + ANGLE_TOLERANCE_DEG / pass.angular_rate_rad_s.to_degrees();
                assert!(
                    (chord.enter_s - enter_s).abs() < tolerance_s && (chord.exit_s - exit_s).abs() < tolerance_s,
                    "{} {}: {chord:?} against {enter_s} {exit_s}",
                    golden.exposure.id,
                    pass.norad_id
                );
            }
            compared += 1;
        }
    }
    assert_eq!(compared, 129);
}
