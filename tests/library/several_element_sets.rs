//! Several element sets of one satellite: the mean motion between their epochs, and sets that must not be used.

use hifitime::{Epoch, Unit};
use streakcast::Satellites;
use streakcast::elements::{ElementSet, Keep, NoradId, Origin, ReadOptions, format_tle};
use streakcast::geometry::{Observer, Site};
use streakcast::orbit::{DragModel, MeanMotion, OrbitKind, OrbitModel, Propagator, StarlinkClass, uncertainty};
use streakcast::passes::Sky;

const V2_MINI: &str = "STARLINK-31000";
/// Mean motion of the simulated satellite, rev/day.
const TRUE_REV_DAY: f64 = 15.28;

fn epoch() -> Epoch {
    Epoch::from_gregorian_utc_at_midnight(2026, 6, 15)
}

/// Returns an element set of a satellite that keeps its mean motion, `days` after 15 June. Its mean motion differs by
/// `noise` rev/day, as that of a published one.
fn set(name: &str, days: f64, noise: f64) -> ElementSet {
    let truth = ElementSet {
        norad_id: NoradId(60_001),
        name: name.into(),
        international_designator: "".into(),
        epoch: epoch(),
        mean_motion_rev_day: TRUE_REV_DAY,
        eccentricity: 1e-4,
        inclination_deg: 53.16,
        right_ascension_of_node_deg: 40.0,
        argument_of_perigee_deg: 90.0,
        mean_anomaly_deg: 100.0,
        bstar_per_earth_radius: 0.0,
        mean_motion_dot_rev_day2: 1e-5,
        mean_motion_ddot_rev_day3: 0.0,
        revolution_at_epoch: 0,
        decayed: None,
        origin: Origin::Published,
    };
    let mut moved =
        ElementSet { epoch: epoch() + days * Unit::Day, argument_of_perigee_deg: 90.0 + 3.6 * days, ..truth.clone() };
    // The node and the mean anomaly with which position and plane agree.
    for _ in 0..6 {
        let [expected, found] = [&truth, &moved].map(|set| node_and_phase_deg(set, moved.epoch));
        moved.right_ascension_of_node_deg =
            (moved.right_ascension_of_node_deg + expected.0 - found.0).rem_euclid(360.0);
        moved.mean_anomaly_deg = (moved.mean_anomaly_deg + expected.1 - found.1).rem_euclid(360.0);
    }
    ElementSet { mean_motion_rev_day: TRUE_REV_DAY + noise, ..moved }
}

/// Returns the right ascension of the ascending node of the predicted orbit, and the angle of the position from it,
/// degrees.
fn node_and_phase_deg(set: &ElementSet, at: Epoch) -> (f64, f64) {
    let propagator = Propagator::new(set).unwrap();
    let (r, v) = propagator.teme_state_at_minutes(propagator.minutes_since_epoch(at)).unwrap();
    let normal = [r[1] * v[2] - r[2] * v[1], r[2] * v[0] - r[0] * v[2], r[0] * v[1] - r[1] * v[0]];
    let node = [-normal[1], normal[0], 0.0];
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let size = |a: [f64; 3]| dot(a, a).sqrt();
    let cosine = dot(r, node) / (size(r) * size(node));
    let phase_deg = (cosine.clamp(-1.0, 1.0).acos().to_degrees() * r[2].signum()).rem_euclid(360.0);
    (node[1].atan2(node[0]).to_degrees(), phase_deg)
}

fn phase_deg(set: &ElementSet, at: Epoch) -> f64 {
    node_and_phase_deg(set, at).1
}

fn model(set: &ElementSet, others: &[ElementSet], days: f64) -> OrbitModel {
    OrbitModel::from_sets(set, others, epoch() + days * Unit::Day, DragModel::StationKeeping)
}

fn motion(model: &OrbitModel) -> MeanMotion {
    model.class.mean_motion()
}

/// Requires the prediction and the errors of one set.
#[track_caller]
fn assert_is_of_one_set(newest: &ElementSet, others: &[ElementSet]) {
    assert_eq!(model(newest, others, 3.0), model(newest, &[], 3.0));
}

/// 3e-4 rev/day are 1.7 s/day. After a week the error is below 0.1 s with a second set, before, around and after.
#[test]
fn verif_mean_motion_between_two_epochs() {
    let newest = set(V2_MINI, 0.0, 3e-4);
    let error_s = |model: &OrbitModel, days: f64| {
        let at = epoch() + days * Unit::Day;
        let turned_deg = phase_deg(&model.elements, at) - phase_deg(&set(V2_MINI, days, 0.0), at);
        ((turned_deg + 180.0).rem_euclid(360.0) - 180.0) / 360.0 * 86_400.0 / TRUE_REV_DAY
    };
    let one = model(&newest, &[], 7.0);
    assert!(error_s(&one, 7.0).abs() > 8.0, "{}", error_s(&one, 7.0));
    for (other_days, at_days, source) in [
        (-7.0, 7.0, MeanMotion::TwoSets),
        (-3.0, 7.0, MeanMotion::TwoSets),
        (7.0, 3.0, MeanMotion::Enclosed),
        (-7.0, -3.0, MeanMotion::Enclosed),
        (7.0, -7.0, MeanMotion::TwoSets),
    ] {
        let two = model(&newest, &[set(V2_MINI, other_days, -2e-4)], at_days);
        let error_s = error_s(&two, at_days);
        assert_eq!(motion(&two), source, "{other_days} {at_days}");
        assert!(error_s.abs() < 0.1, "{other_days} {at_days}: {error_s} s");
        let [with, without] = [&two, &one].map(|model| uncertainty(model.class, at_days).along_track_s);
        assert!(with < 0.75 * without, "{other_days} {at_days}: {with} s, {without} s without");
    }
    let four = model(&newest, &[-3.0, -7.0, -14.0].map(|days| set(V2_MINI, days, 2e-4)), 7.0);
    assert_eq!(motion(&four), MeanMotion::FourSets);
    assert!(error_s(&four, 7.0).abs() < 0.1, "{}", error_s(&four, 7.0));
}

#[test]
fn verif_sets_that_are_not_used() {
    let newest = set(V2_MINI, 0.0, 3e-4);
    let older = set(V2_MINI, -7.0, 0.0);
    // 1. The same epoch twice, and epochs that are too close or too far.
    for days in [0.0, 1e-6, -0.5, -2.0, -30.0, 2.0] {
        assert_is_of_one_set(&newest, &[set(V2_MINI, days, 0.0)]);
    }
    // 2. Another object under the same number: another plane, or another orbit.
    let plane = ElementSet { right_ascension_of_node_deg: 310.0, ..older.clone() };
    let inclined = ElementSet { inclination_deg: 43.0, ..older.clone() };
    let high = ElementSet { mean_motion_rev_day: 13.16, ..older.clone() };
    // 3. Elements that SGP4 cannot propagate to the epoch.
    let eccentric = ElementSet { eccentricity: 0.9, ..older.clone() };
    let invalid = ElementSet { mean_motion_rev_day: 0.0, ..older.clone() };
    let nothing = ElementSet { mean_motion_rev_day: f64::NAN, mean_anomaly_deg: f64::NAN, ..older.clone() };
    for other in [plane, inclined, high, eccentric, invalid, nothing] {
        assert_is_of_one_set(&newest, &[other]);
    }
    // 4. Satellites that are raised, that descend, and those of other constellations.
    for (name, change) in [("STARLINK-31000", -2e-3), ("STARLINK-1100", 1e-5), ("ONEWEB-0012", 0.0), ("", 0.0)] {
        let named = |days| ElementSet { mean_motion_dot_rev_day2: change, ..set(name, days, 0.0) };
        assert_is_of_one_set(&named(0.0), &[named(-7.0)]);
    }
    // 5. A neighbour in the same plane, which has another designator.
    let with = |set: &ElementSet, text: &str| ElementSet { international_designator: text.into(), ..set.clone() };
    assert_is_of_one_set(&with(&newest, "2025-189B"), &[with(&older, "2025-189AD")]);
    for same in ["25189B", ""] {
        let two = model(&with(&newest, "2025-189B"), &[with(&older, same)], 7.0);
        assert_eq!(motion(&two), MeanMotion::TwoSets, "{same}");
    }
    let published = OrbitModel::from_sets(&newest, &[older], epoch(), DragModel::Published);
    assert_eq!(published.elements, newest);
}

/// After a manoeuvre between the sets, and with another satellite of the same plane, the prediction is that of one set
/// and its sigma is not smaller.
#[test]
fn verif_a_manoeuvre_between_the_sets() {
    let newest = set(V2_MINI, 0.0, 3e-4);
    let older = set(V2_MINI, -7.0, 0.0);
    // 3 km lower before the manoeuvre, and so behind by 7 × 0.01 turns; and 20 degrees ahead in the same orbit.
    let lower = ElementSet {
        mean_motion_rev_day: TRUE_REV_DAY + 0.01,
        mean_anomaly_deg: (older.mean_anomaly_deg - 360.0 * 0.07).rem_euclid(360.0),
        ..older.clone()
    };
    let ahead = ElementSet { mean_anomaly_deg: older.mean_anomaly_deg + 20.0, ..older };
    for other in [lower, ahead] {
        let (with, without) = (model(&newest, &[other], 3.0), model(&newest, &[], 3.0));
        assert_eq!((motion(&with), &with.elements), (MeanMotion::Changed, &without.elements));
        for age in [0.5, 1.0, 3.0, 7.0, 14.0, 40.0] {
            let [with, without] = [&with, &without].map(|model| uncertainty(model.class, age).along_track_s);
            assert!(with >= 0.8 * without, "{age} d: {with} s, {without} s without");
        }
    }
}

/// A V2 Mini in strong drag, or a Direct-to-Cell, that has arrived at its height: its mean motion lags behind, n₀ +
/// 0.45 d ṅ/2. A set after the exposures says nothing of a change before them.
#[test]
fn verif_mean_motion_after_a_change_of_the_orbit() {
    const RATE: f64 = 6e-4;
    for name in [V2_MINI, "STARLINK-11100 [DTC]"] {
        let of = |set: ElementSet| ElementSet {
            mean_motion_dot_rev_day2: RATE,
            bstar_per_earth_radius: 1e-3,
            mean_anomaly_deg: (set.mean_anomaly_deg + 30.0).rem_euclid(360.0),
            ..set
        };
        let newest = ElementSet { mean_motion_dot_rev_day2: RATE, ..set(name, 0.0, 0.0) };
        let kept = model(&newest, &[], 3.0).elements.mean_motion_rev_day;
        for (other_days, expected) in [(-7.0, TRUE_REV_DAY + 0.45 * RATE), (7.0, kept)] {
            // The exposures are on the far side of the newest set.
            let with = model(&newest, &[of(set(name, other_days, 0.0))], -3.0 * other_days.signum());
            assert_eq!(motion(&with), MeanMotion::Changed, "{name} {other_days}");
            assert_eq!(with.elements.bstar_per_earth_radius, 0.0);
            let found = with.elements.mean_motion_rev_day;
            assert!((found - expected).abs() < 1e-12, "{name} {other_days}: {found}, expected {expected}");
        }
    }
}

#[test]
fn verif_order_and_number_of_the_sets() {
    let newest = set(V2_MINI, 0.0, 3e-4);
    let mut others: Vec<ElementSet> = (1..=100).map(|half| set(V2_MINI, -0.5 * f64::from(half), 1e-4)).collect();
    let sorted = model(&newest, &others, 3.0);
    others.reverse();
    assert_eq!(model(&newest, &others, 3.0), sorted);
    others.swap(3, 90);
    others.swap(17, 60);
    // A duplicate of each set, and the newest one itself.
    others.extend(others.clone());
    others.push(newest.clone());
    assert_eq!(model(&newest, &others, 3.0), sorted);
    assert_eq!(motion(&sorted), MeanMotion::FourSets);
    assert!((sorted.elements.mean_motion_rev_day - TRUE_REV_DAY).abs() < 1e-5);
}

/// A V1.5 whose mean motion increases by 2 ρ t with ρ = 5e-3 rev/day², published as 7e-4.
#[test]
fn verif_rate_of_a_lowered_satellite() {
    const RATE: f64 = 5e-3;
    let name = "STARLINK-4000";
    let published = |set: ElementSet| ElementSet { mean_motion_dot_rev_day2: 7e-4, ..set };
    let newest = published(set(name, 0.0, 0.0));
    assert_eq!(StarlinkClass::from_elements(&newest), Some(StarlinkClass::MovingV15));
    // Seven days before, the mean motion was smaller by 2 ρ 7, and the satellite was ahead of one of constant period by
    // ρ 7² turns.
    let mut older = published(set(name, -7.0, -14.0 * RATE));
    older.mean_anomaly_deg = (older.mean_anomaly_deg + 360.0 * 49.0 * RATE).rem_euclid(360.0);
    let with = model(&newest, &[older], 3.0);
    assert_eq!(motion(&with), MeanMotion::Rate);
    // M gains ρ t² from the drag, and loses 0.72 ρ t from the mean motion at epoch.
    let at = epoch() + 3.0 * Unit::Day;
    let gained_deg = phase_deg(&with.elements, at) - phase_deg(&newest, at);
    let gained = (gained_deg + 180.0).rem_euclid(360.0) / 360.0 - 0.5;
    assert!((gained - RATE * (9.0 - 0.72 * 3.0)).abs() < 0.03 * RATE * 9.0, "{gained}");
}

/// The mean motion increases as by the published drag: the satellite does not cancel it. Direct-to-Cell satellites do
/// at any drag.
#[test]
fn verif_a_coasting_satellite_has_its_published_drag() {
    for (name, rate, expected) in [
        (V2_MINI, 6e-4, MeanMotion::Coasting),
        (V2_MINI, 2.5e-4, MeanMotion::Coasting),
        ("STARLINK-11100 [DTC]", 6e-4, MeanMotion::Changed),
    ] {
        let of = |set: ElementSet| ElementSet { mean_motion_dot_rev_day2: rate, bstar_per_earth_radius: 1e-3, ..set };
        let newest = of(set(name, 0.0, 0.0));
        let mut older = of(set(name, -7.0, -14.0 * rate));
        older.mean_anomaly_deg = (older.mean_anomaly_deg + 360.0 * 49.0 * rate).rem_euclid(360.0);
        let with = model(&newest, &[older], 3.0);
        assert_eq!(motion(&with), expected, "{name} {rate}");
        assert_eq!(with.elements == newest, expected == MeanMotion::Coasting);
    }
}

fn text(sets: &[ElementSet]) -> String {
    let lines = sets.iter().map(|set| {
        let [line1, line2] = format_tle(set).unwrap();
        format!("{}\n{line1}\n{line2}\n", set.name)
    });
    lines.collect()
}

/// Returns a catalogue of 60 satellites of a shell, with sets of a week before, and one more satellite: its set in use
/// and its older one.
fn shell_and(satellite: &ElementSet, older: &ElementSet) -> (Vec<ElementSet>, Vec<ElementSet>) {
    let member = |k: u32, days: f64| {
        let noise = 2e-4 * (f64::from(k * 37 % 60) / 30.0 - 1.0);
        ElementSet { norad_id: NoradId(50_000 + k), ..set(V2_MINI, days, noise) }
    };
    let of_day = |days: f64, last: &ElementSet| (0..60).map(|k| member(k, days)).chain([last.clone()]).collect();
    (of_day(0.0, satellite), of_day(-7.0, older))
}

/// A satellite that changed its orbit takes the mean motion of the shell at which it has arrived, and not that of a
/// shell 1 km away. In a catalogue without shells the prediction is that of one set.
#[test]
fn verif_mean_motion_of_a_shell() {
    let at = epoch() + 7.0 * Unit::Day;
    let in_catalogue = |sets: &[ElementSet], others: &[ElementSet]| {
        OrbitModel::of_catalogue(sets, others, at, DragModel::StationKeeping).pop().unwrap()
    };
    let period_s = 86_400.0 / TRUE_REV_DAY;
    for (noise_s_day, moved_deg, inclination_deg, expected) in [
        // In the shell: the error of its own sets is not in the prediction.
        (1.5, 0.0, 53.16, MeanMotion::Shell),
        // It was at another place a week before.
        (8.0, 20.0, 53.16, MeanMotion::Arrived),
        (-8.0, 20.0, 53.16, MeanMotion::Arrived),
        (17.0, 20.0, 53.16, MeanMotion::OffShell),
        // No shell has its inclination.
        (8.0, 20.0, 53.5, MeanMotion::Changed),
    ] {
        let inclined = |set: ElementSet| ElementSet { inclination_deg, ..set };
        let newest = inclined(set(V2_MINI, 0.0, noise_s_day / period_s));
        let mut older = inclined(set(V2_MINI, -7.0, 0.0));
        older.mean_anomaly_deg += moved_deg;
        let (sets, others) = shell_and(&newest, &older);
        let found = in_catalogue(&sets, &others);
        assert_eq!(motion(&found), expected, "{noise_s_day}");
        let of_one = OrbitModel::from_sets(&newest, &[], at, DragModel::StationKeeping);
        let error_s_day = (found.elements.mean_motion_rev_day - TRUE_REV_DAY) * period_s;
        let is_at_shell = matches!(expected, MeanMotion::Shell | MeanMotion::Arrived);
        assert_eq!(error_s_day.abs() < 0.05, is_at_shell, "{noise_s_day}: {error_s_day}");
        if !is_at_shell {
            assert_eq!(found.elements, of_one.elements);
        }
        // Half of the shell is too few.
        let is_even = |set: &&ElementSet| set.norad_id.0.is_multiple_of(2) || set.norad_id == newest.norad_id;
        let few = in_catalogue(
            &sets.iter().filter(is_even).cloned().collect::<Vec<_>>(),
            &others.iter().filter(is_even).cloned().collect::<Vec<_>>(),
        );
        assert_eq!(few, OrbitModel::from_sets(&newest, &[older], at, DragModel::StationKeeping));
    }
    // For exposures between its two sets it is not known whether it had arrived.
    let inclined = |set: ElementSet| ElementSet { inclination_deg: 53.16, ..set };
    let between = epoch() + 0.5 * Unit::Day;
    let (newest, mut older) = (inclined(set(V2_MINI, 1.0, 8.0 / period_s)), inclined(set(V2_MINI, -7.0, 0.0)));
    older.mean_anomaly_deg += 20.0;
    let (sets, others) = shell_and(&newest, &older);
    let found = OrbitModel::of_catalogue(&sets, &others, between, DragModel::StationKeeping).pop().unwrap();
    assert_eq!(found, OrbitModel::from_sets(&newest, &[older], between, DragModel::StationKeeping));
}

/// Files of two days, a folder of them, and one file with both, give the same sky.
#[test]
fn verif_files_and_folders() {
    let folder = tempfile::tempdir().unwrap();
    let (newest, older) = (set(V2_MINI, 0.0, 3e-4), set(V2_MINI, -7.0, 0.0));
    let files = [("a.tle", &newest), ("b.tle", &older)].map(|(name, set)| {
        let file = folder.path().join(name);
        std::fs::write(&file, text(std::slice::from_ref(set))).unwrap();
        file
    });
    let observer = Observer::new(Site::from_mpc("X05").unwrap());
    let sigma_s = |satellites: Satellites| {
        let sky = Sky::new(satellites, observer.clone());
        assert_eq!(sky.elements().len(), 1);
        sky.uncertainty(0, 7.0).along_track_s
    };
    let two_s = sigma_s(Satellites::from_files(&files).unwrap());
    assert!(two_s < 0.5 * sigma_s(Satellites::from_files(&files[..1]).unwrap()));
    // Records of `fetch`, hidden files and subfolders are not read.
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    for name in ["a.tle.fetch.json", ".hidden"] {
        std::fs::write(folder.path().join(name), "{}").unwrap();
    }
    assert_eq!(sigma_s(Satellites::from_files([folder.path()]).unwrap()), two_s);
    let both = text(&[older.clone(), newest.clone()]);
    assert_eq!(sigma_s(Satellites::from_bytes("both", both.as_bytes(), &ReadOptions::default()).unwrap()), two_s);
    // Between the two epochs, either of the two sets is used with the other one.
    for days in [-2.0, -5.0] {
        let keep = Keep::Nearest(epoch() + days * Unit::Day);
        let options = ReadOptions { keep, ..ReadOptions::default() };
        let satellites = Satellites::read(&files, &options).unwrap();
        assert_eq!((satellites.element_sets.len(), satellites.other_epochs.len(), satellites.superseded), (1, 1, 1));
        let sky = Sky::new(satellites, observer.clone());
        assert_eq!(sky.mean_motions()[&MeanMotion::Enclosed], 1);
    }
    let class = model(&newest, &[older], 3.0).class;
    assert_eq!(class.kind, OrbitKind::Starlink(StarlinkClass::Station, MeanMotion::TwoSets));
}
