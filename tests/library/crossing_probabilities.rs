//! Probabilities that satellites cross an exposure, compared with random draws of the errors, for elements a day, three
//! weeks and half a year old.

use std::borrow::Borrow;

use crate::common::is_all;
use crate::common::random::Random;
use hifitime::{Epoch, Unit};
use streakcast::elements::{Constellation, ElementSet, Origin};
use streakcast::frames::{Direction, EopTable, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::orbit::{DragModel, OrbitClass, OrbitKind, OrbitUncertainty, uncertainty};
use streakcast::passes::{
    CrossingProbability, Exposure, Field, ModelChoice, Pass, PassOptions, SatelliteSnapshot, Sky, SnapshotOptions,
    SnapshotPositions, TrackPoint,
};
use streakcast::photometry::ModelLibrary;

fn sky(elements: Vec<ElementSet>) -> Sky {
    let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    Sky::with_models(elements, Observer::new(site), EopTable::embedded(), &choice)
        .with_drag(DragModel::Published)
        .with_elements_of_any_age()
}

/// Returns satellites of a shell with elements that are `age_days` older than the exposures and treated as published.
fn published(age_days: f64, at: Epoch, count: usize) -> Vec<ElementSet> {
    let epoch = at - age_days * Unit::Day;
    let mut elements = Constellation::by_name("starlink-gen1").expect("a shell").element_sets(epoch);
    // The first 1584 element sets are the first shell, of which every n-th satellite is used.
    elements.truncate(1584);
    let step = elements.len() / count;
    let mut elements: Vec<ElementSet> = elements.into_iter().step_by(step).collect();
    for set in &mut elements {
        set.origin = Origin::Published;
        set.name = "STARLINK-1".into();
    }
    elements
}

/// Returns a satellite displaced from its prediction by multiples of sigma: delayed, and with its orbital plane tilted
/// in inclination and node.
fn moved(set: &ElementSet, sigma: OrbitUncertainty, [late, inclination, node]: [f64; 3]) -> ElementSet {
    let mut set = set.clone();
    // SGP4 depends only on the time since epoch: with a later epoch the satellite is late on the same path.
    set.epoch = seconds_after(set.epoch, sigma.along_track_s * late);
    // The offset from the plane has the sigma σ at every argument of latitude: r Δi and r sin i ΔΩ each have the sigma
    // σ.
    let tilt_deg = (sigma.cross_track_km / 6928.0).to_degrees();
    set.inclination_deg += tilt_deg * inclination;
    set.right_ascension_of_node_deg =
        (set.right_ascension_of_node_deg + tilt_deg * node / set.inclination_deg.to_radians().sin()).rem_euclid(360.0);
    set
}

/// Returns the same satellites displaced by one draw of their errors.
fn drawn(elements: &[ElementSet], age_days: f64, draws: &mut Random) -> Vec<ElementSet> {
    let of = |set: &ElementSet| {
        let sigma = uncertainty(OrbitClass::from_elements(set, DragModel::Published), age_days);
        moved(set, sigma, [draws.normal(), draws.normal(), draws.normal()])
    };
    elements.iter().map(of).collect()
}

/// Returns exposures at twilight, distributed over the sky.
fn exposures(start: Epoch, count: usize, draws: &mut Random) -> Vec<Exposure> {
    (0..count)
        .map(|number| {
            let zenith_deg = 60.0 * draws.uniform().sqrt();
            let turn = std::f64::consts::TAU * draws.uniform();
            Exposure {
                id: number.to_string(),
                start: seconds_after(start, 6.0 * number as f64),
                duration_s: 30.0,
                // Near the zenith: declination near the latitude of the site, right ascension near its sidereal time
                // (16 h at the start).
                pointing: Direction::from_lon_lat_rad(
                    (240.0 + 0.025 * number as f64 + zenith_deg * turn.cos() / 0.86).to_radians(),
                    (-30.0 + zenith_deg * turn.sin()).to_radians().clamp(-1.5, 1.5),
                ),
                rotation_rad: 0.0,
            }
        })
        .collect()
}

/// Expected numbers of streaks and of streaked exposures, and expected streak length, compared with draws of all
/// errors.
///
/// Tolerance: three sigma of the draws, and 4 % for the approximations: planes do not turn during the delay, the site
/// is fixed within a piece of the exposure, and one cross-track error represents two directions.
#[test]
fn verif_probabilities_against_draws_of_the_errors() {
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    for (age_days, rounds) in [(1.0, 40), (20.0, 60), (30.0, 60)] {
        let rounds = rounds / if is_all() { 1 } else { 3 };
        let mut draws = Random(20_261_121);
        let exposures = exposures(start, 360, &mut draws);
        let elements = published(age_days, exposures[180].start, 1584);
        let found = sky(elements.clone()).crossing_probabilities(&exposures, &field).expect("probabilities");
        assert!(found.iter().flatten().all(|one| !one.is_lower_limit));
        let skies = (0..rounds).map(|_| sky(drawn(&elements, age_days, &mut draws)));
        compare(&format!("{age_days} d"), &exposures, &field, sums(&found), skies);
    }
}

/// Same as above a week after the elements, for satellites that hold their orbits; the distribution of their delays has
/// wings. Delays of satellites that manoeuvred (3 %) are drawn, but outside the range searched.
#[test]
fn verif_probabilities_of_station_keeping_satellites() {
    const AGE_DAYS: f64 = 7.0;
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let mut draws = Random(20_261_124);
    let exposures = exposures(start, 360, &mut draws);
    let elements = published(AGE_DAYS, exposures[180].start, 1584);
    let class = OrbitClass::from_elements(&elements[0], DragModel::StationKeeping);
    assert!(matches!(class.kind, OrbitKind::Starlink(..)), "{class:?}");
    let keeping = |elements| sky(elements).with_drag(DragModel::StationKeeping);
    let found = keeping(elements.clone()).crossing_probabilities(&exposures, &field).expect("probabilities");
    let skies: Vec<Sky> = (0..if is_all() { 60 } else { 20 })
        .map(|_| {
            let drawn = elements.iter().map(|set| {
                let sigma = uncertainty(class, AGE_DAYS);
                let mut share = draws.uniform();
                let part = sigma.lateness.parts().find(|(weight, _)| {
                    share -= weight;
                    share <= 0.0
                });
                let late = part.map_or(0.0, |(_, sigma_s)| sigma_s / sigma.along_track_s) * draws.normal();
                moved(set, sigma, [late, draws.normal(), draws.normal()])
            });
            keeping(drawn.collect())
        })
        .collect();
    compare("station keeping, 7 d", &exposures, &field, sums(&found), skies.iter());
}

/// Streak lengths in a field as sums over the possible positions of the satellites, with elements of a day, a week and
/// three weeks.
///
/// Tolerances: 6 % of the sum, and a correlation of 0.95 between exposures, for steps of a second, in which a satellite
/// moves by up to 1 deg.
#[test]
fn verif_possible_positions_have_the_expected_streak_lengths() {
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let mut draws = Random(20_261_130);
    for (age_days, drag) in
        [(1.0, DragModel::Published), (7.0, DragModel::StationKeeping), (20.0, DragModel::Published)]
    {
        let exposures = exposures(start, 240, &mut draws);
        let sky = sky(published(age_days, exposures[120].start, 1584)).with_drag(drag);
        let probabilities = sky.crossing_probabilities(&exposures, &field).expect("probabilities");
        let expected: Vec<f64> =
            probabilities.iter().map(|found| found.iter().map(|one| one.streak_length_rad).sum()).collect();
        let times_s: Vec<f64> = (0..30).map(|second| f64::from(second) + 0.5).collect();
        let options = SnapshotOptions {
            include_dark: false,
            positions: SnapshotPositions::Possible,
            ..SnapshotOptions::all_above(0.1)
        };
        let summed = exposures.iter().map(|exposure| {
            let (tracks, _) = sky.snapshots(exposure.start, &times_s, &options).expect("snapshots");
            let is_inside = |one: &&SatelliteSnapshot| {
                one.point.direction.separation_rad(&exposure.pointing) < 1.75f64.to_radians()
            };
            let inside = tracks.iter().flat_map(|track| &track.snapshots).filter(is_inside);
            inside.map(|one| one.probability * one.angular_rate_rad_s).sum::<f64>()
        });
        let summed: Vec<f64> = summed.collect();
        let (sum, total) = (summed.iter().sum::<f64>(), expected.iter().sum::<f64>());
        assert!(total > 0.1 && (sum / total - 1.0).abs() < 0.06, "{age_days} d: {sum} {total}");
        let product = |one: &[f64], other: &[f64]| {
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let (here, there) = (mean(one), mean(other));
            one.iter().zip(other).map(|(x, y)| (x - here) * (y - there)).sum::<f64>()
        };
        let squares = product(&summed, &summed) * product(&expected, &expected);
        let correlation = product(&summed, &expected) / squares.sqrt();
        assert!(correlation > 0.95, "{age_days} d: {correlation}");
    }
}

/// Half a year after the elements, only delays up to 300 s are searched: the expected number is that of the draws times
/// the fraction of such delays, and it is marked as a lower limit.
#[test]
fn verif_probabilities_of_old_elements_are_lower_limits() {
    const AGE_DAYS: f64 = 180.0;
    /// Tolerance of the ratio: some satellites that are delayed by whole revolutions also cross the field.
    const SHARE: std::ops::Range<f64> = 0.7..1.3;
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let mut draws = Random(20_261_121);
    let exposures = exposures(start, 360, &mut draws);
    let elements = published(AGE_DAYS, exposures[180].start, 1584);
    let sigma_s = uncertainty(OrbitClass::from_elements(&elements[0], DragModel::Published), AGE_DAYS).along_track_s;
    assert!(sigma_s > 500.0, "{sigma_s}");
    let found = sky(elements.clone()).crossing_probabilities(&exposures, &field).expect("probabilities");
    assert!(found.iter().flatten().all(|one| one.is_lower_limit) && found.iter().flatten().count() > 300);
    let drawn: Vec<f64> = (0..10)
        .map(|_| {
            let sky = sky(drawn(&elements, AGE_DAYS, &mut draws));
            let passes = sky.field_passes(&exposures, &field, &PassOptions::default()).expect("passes");
            passes.by_exposure.iter().map(Vec::len).sum::<usize>() as f64
        })
        .collect();
    let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
    // Φ(300/σ) - Φ(-300/σ) ≈ 2 φ(0) 300/σ
    let share = 2.0 * 300.0 / sigma_s / std::f64::consts::TAU.sqrt();
    let [expected, ..] = sums(&found);
    println!("{AGE_DAYS} d: {expected:.3} expected within 300 s, {mean:.3} drawn, {share:.3} of the delays");
    assert!(SHARE.contains(&(expected / (share * mean))), "{expected:.3} expected, {mean:.3} drawn, {share:.3}");
}

/// Returns the sums of expected streaks, streaked exposures and streak length in degrees.
fn sums(found: &[Vec<CrossingProbability>]) -> [f64; 3] {
    let sum = |of: &dyn Fn(&CrossingProbability) -> f64| found.iter().flatten().map(of).sum::<f64>();
    let none = |all: &Vec<CrossingProbability>| all.iter().map(|one| 1.0 - one.probability).product::<f64>();
    [
        sum(&|one| one.probability),
        found.iter().map(|all| 1.0 - none(all)).sum(),
        sum(&|one| one.streak_length_rad.to_degrees()),
    ]
}

/// Compares expected streaks, streaked exposures and streak lengths with the means of the draws.
fn compare(
    name: &str,
    exposures: &[Exposure],
    field: &Field,
    expected: [f64; 3],
    skies: impl Iterator<Item: Borrow<Sky>>,
) {
    let mut seen = [Vec::new(), Vec::new(), Vec::new()];
    for sky in skies {
        let passes = sky.borrow().field_passes(exposures, field, &PassOptions::default()).expect("passes").by_exposure;
        seen[0].push(passes.iter().map(Vec::len).sum::<usize>() as f64);
        seen[1].push(passes.iter().filter(|passes| !passes.is_empty()).count() as f64);
        seen[2].push(passes.iter().flatten().map(|pass| pass.streak_length_rad.to_degrees()).sum());
    }
    for ((what, expected), seen) in ["streaks", "exposures", "degrees"].iter().zip(expected).zip(&seen) {
        let n = seen.len() as f64;
        let mean = seen.iter().sum::<f64>() / n;
        let sigma = (seen.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
        println!("{name}: {what} {expected:.3} expected, {mean:.3} ± {sigma:.3} drawn");
        assert!(mean * n > 50.0, "{name}: too few {what} for a comparison");
        assert!(
            (expected - mean).abs() < 3.0 * sigma + 0.04 * mean,
            "{name}: {what} {expected:.3} expected, {mean:.3} ± {sigma:.3} drawn"
        );
    }
}

/// Returns copies of a satellite with all errors, and their probabilities: delays in equal steps, and tilts in
/// inclination and node by the three-point Gauss-Hermite rule for a standard normal distribution, 0 and ±√3.
fn with_all_errors(set: &ElementSet, sigma: OrbitUncertainty) -> (Vec<ElementSet>, Vec<f64>) {
    const DELAYS: usize = 200;
    const REACH_SIGMAS: f64 = 4.0;
    let shifts = [(0.0, 2.0 / 3.0), (3f64.sqrt(), 1.0 / 6.0), (-3f64.sqrt(), 1.0 / 6.0)];
    let (mut copies, mut weights) = (Vec::new(), Vec::new());
    for number in 0..DELAYS {
        let step = 2.0 * REACH_SIGMAS / DELAYS as f64;
        let late = step * (number as f64 + 0.5) - REACH_SIGMAS;
        let share = step * (-0.5 * late * late).exp() / std::f64::consts::TAU.sqrt();
        for ((inclination, of_one), (node, of_other)) in shifts.iter().flat_map(|a| shifts.map(|b| (*a, b))) {
            copies.push(moved(set, sigma, [late, inclination, node]));
            weights.push(share * of_one * of_other);
        }
    }
    (copies, weights)
}

/// Probability and streak length of single satellites in exposures of minutes, compared with the sum over all their
/// errors. The site crosses an orbital plane in two minutes, so that its position differs after a delay of minutes.
#[test]
fn verif_single_satellites_against_the_sum_over_their_errors() {
    const AGE_DAYS: f64 = 20.0;
    /// Relative tolerance: pieces of 10 s are coarse for passes that cross the field in about 120 s.
    const TOLERANCE: f64 = 0.05;
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let exposures = [(240.0, 600.0), (240.0, 900.0), (225.0, 300.0), (225.0, 900.0), (275.0, 600.0)].map(
        |(right_ascension_deg, duration_s): (f64, f64)| Exposure {
            id: "long".into(),
            start,
            duration_s,
            pointing: Direction::from_lon_lat_rad(right_ascension_deg.to_radians(), (-30f64).to_radians()),
            rotation_rad: 0.0,
        },
    );
    let mut elements = published(AGE_DAYS, start, 1584);
    for set in &mut elements {
        set.mean_motion_dot_rev_day2 = 2e-5;
    }
    let here = sky(elements.clone());
    let found = here.crossing_probabilities(&exposures, &field).expect("probabilities");
    let mut checked = 0;
    for (exposure, found) in exposures.iter().zip(&found) {
        for one in found.iter().filter(|one| one.probability > 0.2) {
            let set = &elements[one.element_index];
            let sigma = uncertainty(OrbitClass::from_elements(set, DragModel::Published), AGE_DAYS);
            let (copies, weights) = with_all_errors(set, sigma);
            let passes = sky(copies)
                .field_passes(std::slice::from_ref(exposure), &field, &PassOptions::default())
                .expect("passes")
                .by_exposure
                .concat();
            let sum = |of: &dyn Fn(&Pass) -> f64| passes.iter().map(|one| weights[one.element_index] * of(one)).sum();
            let (probability, length_rad): (f64, f64) = (sum(&|_| 1.0), sum(&|one| one.streak_length_rad));
            println!(
                "{} s: {:.4} of {probability:.4}, {:.5} of {length_rad:.5} rad",
                exposure.duration_s, one.probability, one.streak_length_rad
            );
            assert!((one.probability / probability - 1.0).abs() < TOLERANCE);
            assert!((one.streak_length_rad / length_rad - 1.0).abs() < TOLERANCE);
            checked += 1;
        }
    }
    assert!(checked >= 5, "only {checked}");
}

/// Probability of a listed pass compared with the sum over all errors of its satellite, with elements 1, 7 and 20 days
/// old. Each delay and cross-track error gives another satellite, which crosses the field or does not.
#[test]
fn verif_listed_passes_against_the_sum_over_their_errors() {
    /// Largest relative difference of the sum over the passes of one age, in which differences partly cancel.
    const OF_THE_SUM: f64 = 0.03;
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    // Largest difference of one probability. At 1 and 7 days the exposure is not divided, and only the sums over the
    // errors differ. At 20 days it is divided into pieces of 10 s, and chords change their length while the site moves
    // (0.06).
    let ages = [(20.0, 0.08), (7.0, 0.01), (1.0, 0.01)];
    for (age_days, tolerance) in ages.into_iter().take(if is_all() { 3 } else { 1 }) {
        let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
        let mut exposures = exposures(start, 360, &mut Random(20_261_123));
        exposures.retain(|exposure| exposure.id.parse::<usize>().is_ok_and(|number| number % 6 == 0));
        let elements = published(age_days, start, 1584);
        let options = PassOptions { min_probability: Some(0.05), ..PassOptions::default() };
        let passes = sky(elements.clone()).field_passes(&exposures, &field, &options).expect("passes").by_exposure;
        let (mut checked, mut worst, mut sums) = (0, 0.0_f64, [0.0; 2]);
        for (exposure, passes) in exposures.iter().zip(&passes) {
            for pass in passes {
                let set = &elements[pass.element_index];
                let sigma = uncertainty(OrbitClass::from_elements(set, DragModel::Published), pass.element_age_days);
                let (copies, weights) = with_all_errors(set, sigma);
                let crossings = sky(copies)
                    .field_passes(std::slice::from_ref(exposure), &field, &PassOptions::default())
                    .expect("passes")
                    .by_exposure
                    .concat();
                let probability: f64 = crossings.iter().map(|one| weights[one.element_index]).sum();
                worst = worst.max((pass.probability - probability).abs());
                sums = [sums[0] + pass.probability, sums[1] + probability];
                checked += 1;
                println!(
                    "{age_days} d: {:.4} of {probability:.4}, sigma {:.1} s",
                    pass.probability, sigma.along_track_s
                );
            }
        }
        println!("{age_days} d: {checked} passes, sum {:.3} of {:.3}, worst {worst:.3}", sums[0], sums[1]);
        assert!(checked >= 5 && worst < tolerance, "{age_days} d: {checked} passes, worst {worst}");
        assert!((sums[0] / sums[1] - 1.0).abs() < OF_THE_SUM, "{age_days} d: {sums:?}");
    }
}

/// In a longer exposure the expected number of satellites is not smaller, and one more second changes it little: a
/// month after the elements for satellites on station, and 150 days after them for satellites that manoeuvre.
#[test]
fn verif_longer_exposures_have_no_less() {
    /// Allowed decrease as a fraction of the expected number; the last piece of a longer exposure is divided
    /// differently.
    const OF_ALL: f64 = 0.01;
    /// Allowed increase in one second, as a fraction of the expected number: few planes are crossed, each in about a
    /// minute.
    const OF_A_SECOND: f64 = 0.03;
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    for (age_days, dot) in [(30.0, 2e-5), (150.0, 1e-3)] {
        let mut elements = published(age_days, start, 1584);
        for set in &mut elements {
            set.mean_motion_dot_rev_day2 = dot;
        }
        let here = sky(elements);
        for (right_ascension_deg, declination_deg) in [(240.0, -30.0), (225.0, -10.0)] {
            let expected = |duration_s: f64| {
                let exposures = [Exposure {
                    id: "long".into(),
                    start,
                    duration_s,
                    pointing: Direction::from_lon_lat_rad(
                        f64::to_radians(right_ascension_deg),
                        f64::to_radians(declination_deg),
                    ),
                    rotation_rad: 0.0,
                }];
                sums(&here.crossing_probabilities(&exposures, &field).expect("probabilities"))
            };
            let name = format!("{age_days} d, {right_ascension_deg} deg");
            let mut last = [0.0; 3];
            for duration_s in [30.0, 31.0, 45.0, 300.0, 600.0, 900.0, 1800.0] {
                let now = expected(duration_s);
                println!("{name}: {duration_s} s {now:.4?}");
                for (now, last) in now.iter().zip(last) {
                    assert!(now + OF_ALL * last >= last, "{name}: {duration_s} s {now} after {last}");
                }
                last = now;
            }
            let [ten_minutes, a_second_more] = [600.0, 601.0].map(expected);
            assert!(ten_minutes[0] > 0.003, "{name}: {ten_minutes:?}");
            for (one, other) in ten_minutes.iter().zip(a_second_more) {
                assert!(
                    (one - other).abs() < OF_A_SECOND * one,
                    "{name}: 600 s {ten_minutes:?}, 601 s {a_second_more:?}"
                );
            }
        }
    }
}

/// Relative tolerance: for a pass, the range and the angle of the cross-track error are those at the middle of the
/// chord; for a probability, those at the closest approach.
const SAME: f64 = 1e-3;

/// Every listed crossing is among the satellites of `crossing_probabilities`, with the same probability, also where it
/// enters or leaves the Earth's shadow.
#[test]
fn verif_probabilities_hold_every_crossing() {
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    for (age_days, at_least) in [(0.0, 12), (3.0, 12)] {
        let mut draws = Random(7);
        // Later in the evening, when half of the satellites cross the edge of the shadow.
        let exposures = exposures(Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 15, 0), 1500, &mut draws);
        let sky = sky(published(age_days, exposures[750].start, 1584));
        let passes = sky.field_passes(&exposures, &field, &PassOptions::default()).expect("passes").by_exposure;
        let found = sky.crossing_probabilities(&exposures, &field).expect("probabilities");
        let mut checked = 0;
        for (passes, found) in passes.iter().zip(&found) {
            for pass in passes.iter().filter(|pass| pass.probability > 1e-6) {
                let own = found.iter().find(|one| one.element_index == pass.element_index);
                let probability = own.map_or(0.0, |one| one.probability);
                assert!((probability - pass.probability).abs() < SAME, "{pass:?}: {probability}");
                checked += 1;
            }
        }
        assert!(checked > at_least, "{age_days} d: only {checked}");
    }
}

/// Passes computed without light equal those with light, including near misses, but have neither magnitude nor peak.
#[test]
fn verif_passes_without_light_are_the_same_but_for_it() {
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let exposures = exposures(start, 360, &mut Random(20_261_123));
    let sky = sky(published(1.0, start, 1584));
    let lit = PassOptions { min_probability: Some(0.01), samples: 3, ..PassOptions::default() };
    let passes_with =
        |options: &PassOptions| sky.field_passes(&exposures, &field, options).expect("passes").by_exposure;
    let mut expected = passes_with(&lit);
    let dark = |point: &mut TrackPoint| point.brightness = None;
    let mut bright = 0;
    for pass in expected.iter_mut().flatten() {
        bright += usize::from(pass.peak.take().is_some_and(|peak| peak.brightness.is_some()));
        [&mut pass.enter, &mut pass.mid, &mut pass.exit].into_iter().chain(&mut pass.samples).for_each(dark);
    }
    assert!(bright > 10, "{bright} passes with light");
    assert_eq!(passes_with(&PassOptions { without_light: true, ..lit }), expected);
}
