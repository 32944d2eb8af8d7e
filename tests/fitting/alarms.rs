//! Alarms: simulated changes of attitude, trends and tumbling among quiet passes, and false alarms of quiet passes,
//! simulated and of MMT-9.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use hifitime::{Epoch, Unit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use streakcast::Watch;
use streakcast::elements::{Generation, NoradId};
use streakcast::learn::{Alarm, AlarmKind, Pass, PassPoint, find_alarms, learn};
use streakcast::passes::{LearnedFile, ModelChoice};

use super::learning::{mmt, simulated_with};

/// Probability below which an alarm is raised.
const P: f64 = 1e-4;

fn learned(passes: &[Pass]) -> LearnedFile {
    learn(passes, &BTreeMap::new(), &ModelChoice::default(), serde_json::Map::new(), &Watch::default()).unwrap().file
}

/// Simulated passes before and after the end of learning. Differences between passes are drawn from the two normal
/// distributions of learned magnitudes, in units of the scale of Student's t. Student's t itself has one pass in a
/// thousand beyond nine scales, which would be an alarm.
fn halves(satellites: u32, passes: u32, seed: u64) -> (LearnedFile, Vec<Pass>) {
    let difference = |random: &mut ChaCha8Rng| {
        let width = if random.random_bool(0.31) { 1.75 } else { 0.78 };
        1.1416 * width * Normal::new(0.0, 1.0).unwrap().sample(random)
    };
    let (all, _) = simulated_with(satellites, passes, seed, difference);
    let middle = Epoch::from_gregorian_utc_at_midnight(2026, 1, 1) + f64::from(passes / 2) * Unit::Day;
    let (before, after): (Vec<Pass>, Vec<Pass>) = all.into_iter().partition(|pass| pass.last() < middle);
    (learned(&before), after)
}

fn changed(pass: &Pass, by_mag: impl Fn(&PassPoint) -> f64) -> Pass {
    let points =
        pass.points().iter().map(|point| PassPoint { residual_mag: point.residual_mag + by_mag(point), ..*point });
    Pass::new(pass.norad_id(), pass.kind(), points.collect()).unwrap()
}

fn of_kind(alarms: &[Alarm], kind: AlarmKind) -> Vec<&Alarm> {
    alarms.iter().filter(|one| one.alarm == kind).collect()
}

/// A pass of 600 measurements in 60 s with noise of 0.2 mag, a slow change, and a sine of some amplitude and period.
fn track(number: u32, amplitude_mag: f64, period_s: f64, random: &mut ChaCha8Rng) -> Pass {
    let noise = Normal::new(0.0, 0.2).unwrap();
    let start = Epoch::from_gregorian_utc_at_midnight(2026, 3, 1);
    let mut point = |tenth: u32| {
        let second = 0.1 * f64::from(tenth);
        PassPoint {
            epoch: start + second * Unit::Second,
            residual_mag: 0.5 * (second / 30.0 - 1.0).powi(2)
                + amplitude_mag * (TAU * second / period_s).sin()
                + noise.sample(random),
            sigma_mag: None,
        }
    };
    Pass::new(NoradId(number), Generation::OneWeb, (0..600).map(&mut point).collect()).unwrap()
}

#[test]
fn verif_quiet_simulated_passes_raise_no_alarm() {
    // Thirty nights of 600 passes each; an alarm is expected in one of 10,000 nights.
    for seed in 0..30 {
        let (file, after) = halves(30, 40, seed);
        let found = find_alarms(&after, &file, P);
        assert_eq!((found.passes, found.trends, found.not_learned), (600, 30, 0));
        assert!(found.alarms.is_empty(), "{seed}: {:?}", found.alarms);
    }
}

#[test]
fn verif_a_change_of_attitude_is_found_in_its_pass() {
    let (file, mut after) = halves(30, 40, 7);
    // A satellite that lies flat is 3 mag brighter or more: six sigmas of a pass.
    after[100] = changed(&after[100], |_| -3.0);
    let found = find_alarms(&after, &file, P).alarms;
    let found = of_kind(&found, AlarmKind::Brightness);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].norad_id, found[0].first), (after[100].norad_id(), after[100].first()));
    assert!(found[0].value < -2.0 && found[0].p_after_looks < P && found[0].looks == 600, "{found:?}");
    // Half a magnitude is within the scatter of passes.
    after[100] = changed(&after[100], |_| 2.5);
    assert!(of_kind(&find_alarms(&after, &file, P).alarms, AlarmKind::Brightness).is_empty());
}

#[test]
fn verif_a_trend_over_weeks_is_found_for_its_satellite() {
    let (file, mut after) = halves(30, 80, 8);
    let start = after[0].first();
    // 1.2 mag in 40 days.
    for pass in after.iter_mut().filter(|pass| pass.norad_id() == NoradId(5)) {
        *pass = changed(pass, |point| 0.03 * (point.epoch - start).to_unit(Unit::Day));
    }
    let found = find_alarms(&after, &file, P).alarms;
    let found = of_kind(&found, AlarmKind::Trend);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].norad_id, found[0].passes), (NoradId(5), 40));
    assert!((found[0].value - 0.03).abs() < 3.0 * found[0].sigma, "{found:?}");
}

#[test]
fn verif_tumbling_is_found_with_its_period_and_quiet_tracks_are_not() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let (file, _) = halves(5, 10, 9);
    let quiet: Vec<Pass> = (1..=500).map(|number| track(number, 0.0, 7.0, &mut random)).collect();
    let found = find_alarms(&quiet, &file, P);
    assert_eq!((found.searched, of_kind(&found.alarms, AlarmKind::Period).len()), (500, 0), "{:?}", found.alarms);
    for (period_s, amplitude_mag) in [(0.9, 0.15), (3.1, 0.15), (7.0, 0.2), (13.0, 0.3)] {
        let mut tracks = quiet[..50].to_vec();
        tracks[20] = track(21, amplitude_mag, period_s, &mut random);
        let found = find_alarms(&tracks, &file, P).alarms;
        let found = of_kind(&found, AlarmKind::Period);
        assert_eq!(found.len(), 1, "{period_s}: {found:?}");
        assert_eq!(found[0].norad_id, NoradId(21));
        // The step of the frequencies is 1/60 Hz.
        let difference_hz = 1.0 / found[0].period_s.unwrap() - 1.0 / period_s;
        assert!(difference_hz.abs() < 1.0 / 60.0, "{period_s}: {found:?}");
    }
}

#[test]
fn valid_quiet_tracks_of_mmt9_raise_few_alarms() {
    let Some(data) = crate::common::data_dir() else { return };
    let models = ModelChoice::default();
    let mut all = mmt(&data, "mmt9_oneweb.csv.gz", 1200.0, Generation::OneWeb, &models);
    all.extend(mmt(&data, "mmt9_iridium2.csv.gz", 780.0, Generation::IridiumNext, &models));
    all.extend(mmt(&data, "mmt9_starlink_visorsat.csv.gz", 540.0, Generation::StarlinkVisorSat, &models));
    all.sort_by_key(Pass::first);
    let after = all.split_off(all.len() / 2);
    let found = find_alarms(&after, &learned(&all), P);
    println!("{} passes, {} searched for periods", found.passes, found.searched);
    found.alarms.iter().for_each(|one| println!("{one:?}"));
    assert!(found.searched > 50, "{found:?}");
    let counts =
        [AlarmKind::Brightness, AlarmKind::Trend, AlarmKind::Period].map(|kind| of_kind(&found.alarms, kind).len());
    // Nothing is known of changes of attitude among these passes, and some satellites flare. The bound set before the
    // first run was two alarms of each kind.
    assert_eq!((found.passes, counts), (61, [0, 0, 1]), "{:?}", found.alarms);
}
