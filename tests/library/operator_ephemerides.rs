//! Operator ephemerides: formats, frames and interpolation compared with a numerical integration and a real file; their
//! use in the search compared with brute force; errors for invalid files.

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

use hifitime::{Epoch, TimeScale, Unit};
use streakcast::elements::{
    Constellation, CovarianceAxes, ElementFormat, ElementSet, Ephemeris, Keep, NoradId, Origin, ReadOptions, Satellites,
};
use streakcast::frames::{Direction, EopTable, Gcrs, Horizontal, Orientation, Position, seconds_between};
use streakcast::geometry::{Observer, Site};
use streakcast::orbit::{
    DragModel, OrbitClass, OrbitModel, OrbitUncertainty, PositionSource, Propagator, SatelliteIndex, uncertainty,
};
use streakcast::passes::{Exposure, Field, ModelChoice, Pass, PassOptions, Sky};
use streakcast::photometry::ModelLibrary;

use crate::common::agreement::Agreement;
use crate::common::elements::{gzip, sample};

const MEME: &str = "MEME_90001_INVENTED-1_2270000_Operational_1407628800_UNCLASSIFIED.txt.gz";

fn file(name: &str) -> PathBuf {
    crate::common::golden_dir().join("ephemerides").join(name)
}

fn utc(text: &str) -> Epoch {
    text.parse::<Epoch>().expect("a time").to_time_scale(TimeScale::UTC)
}

/// Returns the propagator of the first element set with its ephemeris.
fn propagator(elements: &[ElementSet], ephemerides: &[Arc<Ephemeris>]) -> Propagator {
    let index = SatelliteIndex::new(elements, DragModel::Published).with_ephemerides(
        elements,
        ephemerides,
        &EopTable::embedded(),
    );
    let (first, last) = ephemerides[0].interval();
    let middle = first + 0.5 * (last - first);
    let found = index.propagator_over(0, [middle, middle]).expect("a propagator").clone();
    assert!(found.stated_uncertainty(middle).is_some(), "the ephemeris is not used");
    found
}

fn position(propagator: &Propagator, epoch: Epoch) -> Position<Gcrs> {
    let orientation = Orientation::at(epoch, &EopTable::embedded());
    propagator.state(epoch, &orientation.teme_to_gcrs).expect("a state").position
}

/// States are written to 1 mm or better; precession and nutation are interpolated to 10⁻⁹ rad, which is 7 mm.
const CELESTIAL_TOLERANCE_KM: f64 = 2e-5;
/// The bundled table of Earth orientation has errors of up to 0.4 ms (0.2 m) in UT1 and 1 mas in the pole; astropy also
/// applies the offsets of the celestial pole, 0.2 mas.
const EARTH_FIXED_TOLERANCE_KM: f64 = 2e-4;

#[test]
fn valid_ephemerides_against_numerical_integration() {
    let start = utc("2024-08-14T00:00:00 UTC");
    let golden = std::fs::read_to_string(file("golden.csv")).expect("goldens");
    let rows: Vec<Vec<f64>> = golden
        .lines()
        .filter(|line| !line.starts_with(['#', 't']))
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    for (name, format, states, tolerance_km) in [
        (MEME, ElementFormat::ModifiedItc, 91, CELESTIAL_TOLERANCE_KM),
        ("invented.oem", ElementFormat::OemKvn, 91, CELESTIAL_TOLERANCE_KM),
        ("invented_itrf.xml", ElementFormat::OemXml, 46, EARTH_FIXED_TOLERANCE_KM),
    ] {
        let catalogue = Satellites::read(
            &[file(name), crate::common::golden_dir().join("elements/sample.csv")],
            &ReadOptions::default(),
        )
        .expect("readable");
        let source = &catalogue.sources[0];
        assert_eq!((source.format, source.records, source.first_epoch), (format, states, start), "{name}");
        assert_eq!((catalogue.ephemerides.len(), catalogue.element_sets.len()), (1, 1));
        let propagator = propagator(&catalogue.element_sets, &catalogue.ephemerides);
        let mut distance = Agreement::new("Interpolated ephemeris", "numerical integration", tolerance_km, "km");
        for row in &rows {
            let epoch = start + row[0] * Unit::Second;
            let truth = Position::<Gcrs>::new(row[1], row[2], row[3]);
            distance.add((position(&propagator, epoch) - truth).norm_km());
            if format == ElementFormat::ModifiedItc {
                let orientation = Orientation::at(epoch, &EopTable::embedded());
                let speed_km_s =
                    propagator.state(epoch, &orientation.teme_to_gcrs).expect("a state").velocity.norm_km_s();
                let sigma_km = propagator.stated_uncertainty(epoch).expect("stated").along_track_s * speed_km_s;
                // 10 m for the interpolation are added in quadrature.
                assert!((sigma_km - row[4].hypot(0.01)).abs() < 1e-6, "{} s: {sigma_km} km", row[0]);
            }
        }
    }
}

#[test]
fn covariances_in_the_axes_of_the_states_are_rotated() {
    let text = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let elements = sample_elements();
    let at = utc("2024-08-14T00:00:00 UTC") + 1350.0 * Unit::Second;
    let sigmas = |text: &str| {
        let ephemerides = read("a.oem", text).expect("readable").ephemerides;
        propagator(&elements, &ephemerides).stated_uncertainty(at).expect("stated")
    };
    // One covariance at the first state, which is on the x axis and moves towards +y and +z: x is radial.
    let rows = "4 \n0 9 \n0 0 9 \n0 0 0 1 \n0 0 0 0 1 \n0 0 0 0 0 1";
    let begin = text.find("COVARIANCE_START").expect("covariances");
    let epoch = "EPOCH = 2024-08-14T00:00:37.000";
    let with = |axes: &str| format!("{}COVARIANCE_START\n{epoch}\n{axes}{rows}\nCOVARIANCE_STOP\n", &text[..begin]);
    for axes in ["", "COV_REF_FRAME = GCRF\n", "COV_REF_FRAME = RSW\n"] {
        let sigma = sigmas(&with(axes));
        assert!((sigma.cross_track_km - 3.0).abs() < 1e-3, "{axes}: {sigma:?}");
        assert!((sigma.along_track_s * 7.585 - 3.0).abs() < 5e-3, "{axes}: {sigma:?}");
    }
    // The first axis of TNW is along the velocity.
    let sigma = sigmas(&with("COV_REF_FRAME = TNW\n"));
    assert!((sigma.along_track_s * 7.585 - 2.0).abs() < 5e-3, "{sigma:?}");
    // Without a covariance, the errors are those of an element set with its epoch at the first state.
    let sigma = sigmas(&text[..begin]);
    let expected = unstated(&elements[0], 1350.0 / 3600.0);
    let differences = [sigma.along_track_s - expected.along_track_s, sigma.cross_track_km - expected.cross_track_km];
    assert!(differences.iter().all(|one| one.abs() < 1e-9), "{sigma:?} {expected:?}");
}

/// Covariance with all terms, given in radial, along-track and normal axes, and rotated to the frame of the states
/// here: C = A Cᵣₜₙ Aᵀ with the unit vectors in the columns of A.
#[test]
fn verif_rotated_covariances_against_those_along_the_track() {
    let text = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let elements = sample_elements();
    let (epoch, state) = text
        .lines()
        .filter(|line| line.starts_with("2024-"))
        .nth(17)
        .and_then(|line| line.split_once(' '))
        .expect("a state");
    let numbers: Vec<f64> = state.split_whitespace().map(|one| one.parse().expect("a number")).collect();
    let (r, v) = ([numbers[0], numbers[1], numbers[2]], [numbers[3], numbers[4], numbers[5]]);
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let unit = |a: [f64; 3]| {
        let length = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
        a.map(|one| one / length)
    };
    let (radial, normal) = (unit(r), unit(cross(r, v)));
    let along = cross(normal, radial);
    assert!(radial.iter().all(|one| one.abs() > 0.2), "not along an axis of the frame: {radial:?}");
    let columns = [radial, along, normal];
    // Standard deviations 1, 5 and 2 km, correlations 0.5, -0.4 and 0.3.
    let given = [[1.0, 2.5, -0.8], [2.5, 25.0, 3.0], [-0.8, 3.0, 4.0]];
    let mut rotated = [[0.0; 3]; 3];
    for (row, column) in (0..9).map(|term| (term / 3, term % 3)) {
        for (i, j) in (0..9).map(|term| (term / 3, term % 3)) {
            rotated[row][column] += columns[i][row] * given[i][j] * columns[j][column];
        }
    }
    assert!(rotated[1][0].abs() > 1.0 && rotated[2][0].abs() > 1.0, "{rotated:?}");
    let begin = text.find("COVARIANCE_START").expect("covariances");
    let sigma = |axes: &str, terms: [[f64; 3]; 3]| {
        let [[xx, ..], [yx, yy, _], [zx, zy, zz]] = terms;
        let text = format!(
            "{}COVARIANCE_START\nEPOCH = {epoch}\n{axes}{xx:e}\n{yx:e} {yy:e}\n{zx:e} {zy:e} {zz:e}\n\
             0 0 0 1\n0 0 0 0 1\n0 0 0 0 0 1\nCOVARIANCE_STOP\n",
            &text[..begin]
        );
        let ephemerides = read("a.oem", &text).expect("readable").ephemerides;
        // TAI - UTC is 37 s.
        let at = utc(&format!("{epoch} UTC")) - 37.0 * Unit::Second;
        propagator(&elements, &ephemerides).stated_uncertainty(at).expect("stated")
    };
    let speed_km_s = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    for (axes, terms) in [("COV_REF_FRAME = RTN\n", given), ("", rotated), ("COV_REF_FRAME = GCRF\n", rotated)] {
        let sigma = sigma(axes, terms);
        // 10 m for the interpolation are added in quadrature.
        assert!((sigma.along_track_s * speed_km_s - 5.0_f64.hypot(0.01)).abs() < 1e-4, "{axes}: {sigma:?}");
        assert!((sigma.cross_track_km - 2.0_f64.hypot(0.01)).abs() < 1e-4, "{axes}: {sigma:?}");
    }
}

/// After the last covariance, errors are at least those without a covariance; at the covariance, they are the stated
/// ones.
#[test]
fn errors_beyond_the_last_covariance_are_at_least_those_without_any() {
    let text = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let elements = sample_elements();
    let begin = text.find("COVARIANCE_START").expect("covariances");
    let rows = "1e-4\n0 1e-4\n0 0 1e-4\n0 0 0 1\n0 0 0 0 1\n0 0 0 0 0 1";
    let one = |minute: u32| format!("EPOCH = 2024-08-14T00:{minute:02}:37.000\nCOV_REF_FRAME = RTN\n{rows}\n");
    let text = format!("{}COVARIANCE_START\n{}{}COVARIANCE_STOP\n", &text[..begin], one(10), one(20));
    let ephemerides = read("a.oem", &text).expect("readable").ephemerides;
    let propagator = propagator(&elements, &ephemerides);
    let at = |minutes: f64| {
        let epoch = utc("2024-08-14T00:00:00 UTC") + minutes * Unit::Minute;
        propagator.stated_uncertainty(epoch).expect("stated")
    };
    for minutes in [10.0, 15.0, 20.0] {
        assert!((at(minutes).cross_track_km - 0.01_f64.hypot(0.01)).abs() < 1e-9, "{minutes}");
    }
    for minutes in [1.0, 9.0, 21.0, 80.0] {
        let (found, expected) = (at(minutes), unstated(&elements[0], minutes / 60.0));
        assert!((found.along_track_s - expected.along_track_s).abs() < 1e-9, "{minutes}: {found:?}");
        assert!((found.cross_track_km - expected.cross_track_km).abs() < 1e-9, "{minutes}: {found:?}");
    }
}

/// Tolerance for unequal steps, as documented, km.
const UNEVEN_TOLERANCE_KM: f64 = 0.02;

/// States of SGP4 at unequal steps, rounded to a metre, with wrong velocities, which must not be used. Polynomials
/// through the eight neighbours would have errors of up to 137 km.
#[test]
fn verif_unequal_steps_against_sgp4() {
    let start = utc("2026-04-26T00:00:00 UTC");
    let set = Constellation::by_name("starlink-gen1").expect("shells").element_sets(start).remove(0);
    let sgp4 = Propagator::new(&set).expect("elements");
    let cycles: [(&str, &[f64]); 6] = [
        ("pairs 10 s apart every 240 s", &[10.0, 230.0]),
        ("pairs 1 s apart every 280 s", &[1.0, 279.0]),
        ("ten states 1 s apart, then 270 s", &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 270.0]),
        ("dense and sparse quarters of an hour", &[5.0; 180]),
        ("growing steps", &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0]),
        ("equal steps", &[240.0]),
    ];
    for (name, cycle) in cycles {
        let mut times_s = vec![0.0];
        let mut steps = cycle.iter().copied().cycle();
        while times_s[times_s.len() - 1] < 20_000.0 {
            times_s.push(times_s[times_s.len() - 1] + steps.next().expect("a step"));
            if name.starts_with("dense") && (times_s.len() - 1) % cycle.len() == 0 {
                let last = times_s[times_s.len() - 1];
                times_s.extend((1..=4).map(|step| last + 225.0 * f64::from(step)));
            }
        }
        let mut text = oem_header(&set.norad_id.to_string(), "TEME");
        for time_s in &times_s {
            let epoch = start + *time_s * Unit::Second;
            let (position, velocity) = sgp4.teme_state_at_minutes(sgp4.minutes_since_epoch(epoch)).expect("in orbit");
            // Polynomials through states that are close together amplify the rounding.
            let position = position.map(|one| (1e3 * one).round() / 1e3);
            write_state(&mut text, epoch, &position, &velocity.map(|one| 1e-3 * one));
        }
        let ephemerides = read("test.oem", &text).expect("readable").ephemerides;
        let interpolated = propagator(std::slice::from_ref(&set), &ephemerides);
        let mut distance = Agreement::new(name, "SGP4", UNEVEN_TOLERANCE_KM, "km");
        let (mut covered_s, mut all_s) = (0.0, 0.0);
        for step in times_s.windows(2) {
            all_s += step[1] - step[0];
            let is_covered = [0.1, 0.3, 0.5, 0.8].into_iter().all(|share| {
                let epoch = start + (step[0] + share * (step[1] - step[0])) * Unit::Second;
                let orientation = Orientation::at(epoch, &EopTable::embedded());
                let Ok(state) = interpolated.state(epoch, &orientation.teme_to_gcrs) else { return false };
                distance.add((state.position - position(&sgp4, epoch)).norm_km());
                true
            });
            covered_s += if is_covered { step[1] - step[0] } else { 0.0 };
        }
        // There may be gaps at the ends of the file.
        assert!(covered_s > 0.9 * all_s, "{name}: {covered_s} s of {all_s} s are covered");
    }
}

/// A step of a whole revolution is a gap, although the positions at its ends are nearly equal.
#[test]
fn a_gap_of_a_revolution_is_not_interpolated() {
    let start = utc("2026-04-26T00:00:00 UTC");
    let set = Constellation::by_name("starlink-gen1").expect("shells").element_sets(start).remove(0);
    let sgp4 = Propagator::new(&set).expect("elements");
    let revolution_min = (sgp4.period_s() / 60.0).round();
    let mut text = oem_header(&set.norad_id.to_string(), "TEME");
    for minutes in (0..60).map(f64::from).chain((0..60).map(|minutes| f64::from(minutes) + 59.0 + revolution_min)) {
        let epoch = start + minutes * Unit::Minute;
        let (position, _) = sgp4.teme_state_at_minutes(sgp4.minutes_since_epoch(epoch)).expect("in orbit");
        write_state(&mut text, epoch, &position, &[0.0; 3]);
    }
    let ephemerides = read("gap.oem", &text).expect("readable").ephemerides;
    let sets = [set];
    let index =
        SatelliteIndex::new(&sets, DragModel::Published).with_ephemerides(&sets, &ephemerides, &EopTable::embedded());
    let is_used = |minutes: f64| {
        let epochs = [start + minutes * Unit::Minute; 2];
        index.propagator_over(0, epochs).expect("a propagator").position_source() != PositionSource::ElementSet
    };
    assert!(is_used(30.0) && is_used(89.0 + revolution_min));
    assert!(!is_used(59.0 + 0.5 * revolution_min) && !is_used(55.0) && !is_used(62.0 + revolution_min));
}

/// Of several ephemerides of a satellite, that with the latest creation time is used, in any order of the files.
#[test]
fn the_last_created_ephemeris_is_used_whatever_the_order_of_the_files() {
    let oem = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let without = |created: &str| oem.replace("CREATION_DATE = 2024-08-13T23:30:00", created);
    let of = |name: &str, created: &str| read(name, &without(created)).expect("readable").ephemerides.remove(0);
    let old = of("old.oem", "CREATION_DATE = 2024-08-13T21:00:00");
    let new = of("new.oem", "CREATION_DATE = 2024-08-13T22:00:00");
    // Without a creation time, the first state (midnight) is compared.
    let latest = of("latest.oem", "COMMENT none");
    let elements = sample_elements();
    let used = |ephemerides: &[Arc<Ephemeris>]| propagator(&elements, ephemerides).position_source().to_string();
    assert_eq!(used(&[old.clone(), new.clone()]), "ephemeris new.oem");
    assert_eq!(used(&[new.clone(), old.clone()]), "ephemeris new.oem");
    assert_eq!(used(&[latest.clone(), new.clone(), old.clone()]), "ephemeris latest.oem");
    assert_eq!(used(&[old, new, latest]), "ephemeris latest.oem");
}

fn sample_elements() -> Vec<ElementSet> {
    let path = crate::common::golden_dir().join("elements/sample.csv");
    Satellites::from_files([path]).expect("a sample").element_sets
}

fn read(name: &str, text: &str) -> Result<Satellites, String> {
    Satellites::from_bytes(name, text.as_bytes(), &ReadOptions::default()).map_err(|error| error.to_string())
}

/// Tolerance of interpolation as required for states 60 s apart, km. The states that are kept are 120 s apart.
const LEFT_OUT_TOLERANCE_KM: f64 = 0.01;
/// Tolerances for element sets of the same day, along the track and out of the plane, km: a kilometre at epoch and its
/// growth over half a day. A wrong frame would cause tens of kilometres.
const ELEMENTS_OF_THE_DAY_TOLERANCE_KM: f64 = 4.0;
const PLANE_OF_THE_DAY_TOLERANCE_KM: f64 = 1.0;

#[test]
fn valid_interpolation_against_the_states_of_a_starlink() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("tle/ephemerides");
    let name = "MEME_48430_STARLINK-2729_0291124_Operational_1359285900_UNCLASSIFIED.txt.gz";
    let full = Satellites::read(&[folder.join(name)], &ReadOptions::default()).expect("readable");
    let states = &full.ephemerides[0].states;
    assert_eq!((states.len(), full.ephemerides[0].covariances.len()), (4321, 4321));
    // Every second state is written to an OEM.
    let mut text = oem_header("48430", "EME2000");
    for state in states.iter().step_by(2) {
        write_state(&mut text, state.epoch, &state.position_km, &state.velocity_km_s);
    }
    let half = read("half.oem", &text).expect("readable").ephemerides;
    let options = ReadOptions { keep: Keep::Nearest(states[0].epoch), ..ReadOptions::default() };
    let gp = Satellites::read(&[folder.join("gp_48430.txt")], &options).expect("element sets").element_sets;
    let (all, half) = (propagator(&gp, &full.ephemerides), propagator(&gp, &half));
    let mut distance = Agreement::new(
        "Ephemeris of a Starlink, every second state",
        "the omitted states",
        LEFT_OUT_TOLERANCE_KM,
        "km",
    );
    for state in states.iter().skip(1).step_by(2) {
        distance.add((position(&half, state.epoch) - position(&all, state.epoch)).norm_km());
    }
    let mut of_the_day = Agreement::new(
        "Ephemeris of a Starlink, first 12 hours",
        "SGP4 with the element sets of the day",
        ELEMENTS_OF_THE_DAY_TOLERANCE_KM,
        "km",
    );
    let mut plane = Agreement::new(
        "Plane of the ephemeris of a Starlink, first 12 hours",
        "SGP4 with the element sets of the day",
        PLANE_OF_THE_DAY_TOLERANCE_KM,
        "km",
    );
    let sgp4 = Propagator::new(&gp[0]).expect("elements");
    for state in states.iter().take(720).step_by(10) {
        let orientation = Orientation::at(state.epoch, &EopTable::embedded());
        let here = all.state(state.epoch, &orientation.teme_to_gcrs).expect("a state");
        let missed = position(&sgp4, state.epoch) - here.position;
        of_the_day.add(missed.norm_km());
        plane.add(missed.vector().dot(&here.position.vector().cross(here.velocity.vector()).normalize()));
    }
}

/// Element sets 6.6 days old: with the published drag they are 14 s late, without drag about 1.8 s (as in the
/// literature), and less with the lag of the mean motion.
#[test]
fn valid_lateness_of_old_elements_against_a_starlink_ephemeris() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("tle/ephemerides");
    let name = "MEME_48430_STARLINK-2729_0291124_Operational_1359285900_UNCLASSIFIED.txt.gz";
    let full = Satellites::read(&[folder.join(name)], &ReadOptions::default()).expect("readable");
    let history = Satellites::read(
        &[folder.join("history_48430.txt")],
        &ReadOptions { keep: Keep::All, ..ReadOptions::default() },
    )
    .expect("a history");
    let at = full.ephemerides[0].interval().0;
    let age_days = |set: &ElementSet| seconds_between(set.epoch, at) / 86_400.0;
    let mut old = history
        .element_sets
        .iter()
        .min_by(|a, b| (age_days(a) - 6.6).abs().total_cmp(&(age_days(b) - 6.6).abs()))
        .expect("sets")
        .clone();
    old.name = "STARLINK-2729".into();
    assert!((age_days(&old) - 6.6).abs() < 0.3, "{} days", age_days(&old));
    let truth = propagator(std::slice::from_ref(&old), &full.ephemerides);
    let orientation = Orientation::at(at, &EopTable::embedded());
    let state = truth.state(at, &orientation.teme_to_gcrs).expect("a state");
    // A set of about a week before.
    let far = |set: &&ElementSet| (age_days(set) - age_days(&old) - 7.0).abs();
    let older = history.element_sets.iter().min_by(|a, b| far(a).total_cmp(&far(b))).expect("sets").clone();
    let late_s = |drag, others: &[ElementSet]| {
        let sgp4 = Propagator::new(&OrbitModel::from_sets(&old, others, at, drag).elements).expect("elements");
        let missed = *(position(&sgp4, at) - state.position).vector();
        missed.dot(state.velocity.vector()).abs() / state.velocity.vector().norm_squared()
    };
    let (published_s, kept_s) = (late_s(DragModel::Published, &[]), late_s(DragModel::StationKeeping, &[]));
    assert!((10.0..20.0).contains(&published_s) && kept_s < 3.0, "{published_s} s, {kept_s} s");
    let both_s = late_s(DragModel::StationKeeping, &[older]);
    println!("elements 6.6 d old: published {published_s:.2} s, one set {kept_s:.2} s, two sets {both_s:.2} s");
    assert!(both_s < 1.0, "{both_s} s with an older set, {kept_s} s without");
}

fn oem_header(object: &str, frame: &str) -> String {
    format!(
        "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-01-01T00:00:00\nORIGINATOR = TEST\nMETA_START\nOBJECT_NAME = TEST\n\
         OBJECT_ID = {object}\nCENTER_NAME = EARTH\nREF_FRAME = {frame}\nTIME_SYSTEM = UTC\nMETA_STOP\n"
    )
}

/// Returns the errors (one sigma) without a covariance, at a time after the first state.
fn unstated(set: &ElementSet, hours: f64) -> OrbitUncertainty {
    uncertainty(OrbitClass::from_elements(set, DragModel::Published), hours / 24.0)
}

fn write_state(text: &mut String, epoch: Epoch, position_km: &[f64; 3], velocity_km_s: &[f64; 3]) {
    let (year, month, day, hour, minute, second, nanosecond) = epoch.to_gregorian_utc();
    let [x, y, z] = position_km;
    let [u, v, w] = velocity_km_s;
    writeln!(
        text,
        "{year}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{nanosecond:09} {x:.9} {y:.9} {z:.9} {u:.12} {v:.12} {w:.12}"
    )
    .expect("text");
}

/// Returns an ephemeris computed by SGP4 from an element set, in steps of two minutes.
fn sgp4_ephemeris(set: &ElementSet, from: Epoch, hours: u32) -> Arc<Ephemeris> {
    let propagator = Propagator::new(set).expect("elements");
    let mut text = oem_header(&set.norad_id.to_string(), "TEME");
    for step in 0..=30 * hours {
        let epoch = from + f64::from(2 * step) * Unit::Minute;
        let minutes = propagator.minutes_since_epoch(epoch);
        let (position_km, velocity_km_s) = propagator.teme_state_at_minutes(minutes).expect("in orbit");
        write_state(&mut text, epoch, &position_km, &velocity_km_s);
    }
    read("test.oem", &text).expect("readable").ephemerides.remove(0)
}

/// Tolerance of times, seconds: interpolation and arcs with other nodes differ by 4 mm, which may be a hundred times as
/// much along the track where it meets the border at a small angle.
const SAME_TIME_S: f64 = 2e-3;

/// Satellites with wrong element sets and correct ephemerides cross as with correct element sets where the ephemerides
/// cover the exposure, and as with the wrong ones elsewhere. The search finds the same as brute force in windows that
/// are not covered, partly covered, and completely covered.
#[test]
fn verif_crossings_of_ephemerides_against_right_elements_and_brute_force() {
    let start = utc("2026-04-26T00:00:00 UTC");
    let right: Vec<ElementSet> = Constellation::by_name("starlink-gen1")
        .expect("shells")
        .element_sets(start)
        .into_iter()
        .step_by(20)
        // The errors of simulated satellites do not grow, so that they are marked as published.
        .map(|set| ElementSet { origin: Origin::Published, ..set })
        .collect();
    let wrong: Vec<ElementSet> =
        right.iter().map(|set| ElementSet { mean_anomaly_deg: set.mean_anomaly_deg - 3.0, ..set.clone() }).collect();
    // The ephemerides cover 3 h to 33 h.
    let ephemerides: Vec<_> = right.iter().map(|set| sgp4_ephemeris(set, start + 3.0 * Unit::Hour, 30)).collect();
    let observer = Observer::new(Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site"));
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let sky = |sets: &[ElementSet]| {
        Sky::with_models(sets.to_vec(), observer.clone(), EopTable::embedded(), &choice).with_drag(DragModel::Published)
    };
    let (right, wrong) = (sky(&right), sky(&wrong));
    let mixed = wrong.clone().with_ephemerides(ephemerides);
    let field = Field::circle(80_f64.to_radians()).expect("a field");
    let options = PassOptions { include_dark: true, ..PassOptions::default() };
    let (mut covered, mut uncovered) = (0, 0);
    for step in 0..150 {
        let hours = 0.245 * f64::from(step);
        let opened = start + hours * Unit::Hour;
        let here = observer.state(&Orientation::at(opened, &EopTable::embedded()));
        let direction = Direction::<Horizontal>::from_lon_lat_rad(f64::from(step), 1.0);
        let exposure = Exposure {
            id: format!("{hours} h"),
            start: opened,
            duration_s: 30.0 + 200.0 * f64::from(step % 3),
            pointing: here.horizon.inverse() * direction,
            rotation_rad: 0.0,
        };
        // Ephemerides are not used in the last six minutes.
        let end_h = hours + exposure.duration_s / 3600.0;
        let is_covered = hours > 3.1 && end_h < 32.9;
        let exposures = [exposure];
        let of = |sky: &Sky| sky.field_passes(&exposures, &field, &options).expect("passes").by_exposure.remove(0);
        let found = of(&mixed);
        let brute = mixed.field_passes_by_brute_force(&exposures, &field, &options).expect("passes").remove(0);
        same_passes(&found, &brute, &exposures[0].id);
        same_passes(&found, &of(if is_covered { &right } else { &wrong }), &exposures[0].id);
        *(if is_covered { &mut covered } else { &mut uncovered }) += found.len();
        let odds = mixed.crossing_probabilities(&exposures, &field).expect("passes").remove(0);
        for pass in found.iter().filter(|pass| pass.lit && pass.mid.altitude_rad.is_some_and(|altitude| altitude > 0.3))
        {
            assert!(odds.iter().any(|one| one.element_index == pass.element_index), "{}: {pass:?}", exposures[0].id);
            // An ephemeris without a covariance has the errors of an element set with its epoch at the first state.
            let age_h = if is_covered { hours - 3.0 } else { hours };
            let expected_s = unstated(&mixed.elements()[pass.element_index], age_h).along_track_s;
            assert!((pass.along_track_sigma_s - expected_s).abs() < 2e-2 * expected_s, "{expected_s} s: {pass:?}");
            assert_eq!(matches!(pass.position_source, PositionSource::Ephemeris(_)), is_covered, "{pass:?}");
        }
    }
    assert!(covered > 150 && uncovered > 20, "{covered} {uncovered}");
}

fn same_passes(found: &[Pass], expected: &[Pass], what: &str) {
    let key = |pass: &&Pass| pass.norad_id;
    let sorted = |passes: &[Pass]| {
        let mut ids: Vec<NoradId> = passes.iter().map(|pass| key(&pass)).collect();
        ids.sort_unstable();
        ids
    };
    assert_eq!(sorted(found), sorted(expected), "{what}");
    for pass in found {
        let other = expected.iter().find(|one| one.norad_id == pass.norad_id).expect("the same satellites");
        for (chord, other) in pass.chords.iter().zip(&other.chords) {
            let worst_s = (chord.enter_s - other.enter_s).abs().max((chord.exit_s - other.exit_s).abs());
            assert!(worst_s < SAME_TIME_S, "{what} {}: {chord:?} {other:?}", pass.norad_id);
        }
    }
}

#[test]
fn gaps_are_not_interpolated() {
    let start = utc("2026-04-26T00:00:00 UTC");
    let set = Constellation::by_name("starlink-gen1").expect("shells").element_sets(start).remove(0);
    let whole = sgp4_ephemeris(&set, start, 3);
    let text = |skipped: std::ops::Range<usize>| {
        let mut text = oem_header(&set.norad_id.to_string(), "TEME");
        for (_, state) in whole.states.iter().enumerate().filter(|(index, _)| !skipped.contains(index)) {
            write_state(&mut text, state.epoch, &state.position_km, &state.velocity_km_s);
        }
        read("gap.oem", &text).expect("readable").ephemerides
    };
    let sets = [set.clone()];
    // A twentieth of a revolution is 4.8 minutes: a step of four minutes is interpolated, one of six minutes is a gap.
    let (short, long) = (text(40..41), text(40..42));
    let at = |minutes: f64| [start + minutes * Unit::Minute; 2];
    for (ephemerides, is_used) in [(&short, true), (&long, false)] {
        let index = SatelliteIndex::new(&sets, DragModel::Published).with_ephemerides(
            &sets,
            ephemerides,
            &EopTable::embedded(),
        );
        let used = |minutes: f64| {
            let epochs = at(minutes);
            index.propagator_over(0, epochs).expect("a propagator").stated_uncertainty(epochs[0]).is_some()
        };
        assert!(used(40.0) && used(120.0));
        assert_eq!(used(80.0), is_used);
        assert!(!used(1.0) && !used(179.0));
    }
}

#[test]
fn invalid_ephemerides_are_rejected_with_file_line_and_value() {
    let oem = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let xml = std::fs::read_to_string(file("invented_itrf.xml")).expect("a sample");
    let meme = {
        use std::io::Read;
        let mut text = String::new();
        let bytes = std::fs::read(file(MEME)).expect("a sample");
        flate2::read::GzDecoder::new(bytes.as_slice()).read_to_string(&mut text).expect("gzip");
        text
    };
    let lines = |text: &str, to: usize| text.lines().take(to).map(|line| line.to_owned() + "\n").collect::<String>();
    let swapped = {
        let mut all: Vec<&str> = oem.lines().collect();
        all.swap(20, 21);
        all.join("\n")
    };
    let name = "MEME_90001_X_1.txt";
    for (name, text, expected) in [
        (name, lines(&meme, 4 + 4 * 20), ":84: time of the last state is 2024-08-14T00:19:00"),
        (name, lines(&meme, 4 + 4 * 20 - 1), ":81: number of terms of the covariance is 14; allowed: 21"),
        (name, meme.replace("\nUVW\n", "\nECI\n"), ":4: frame of the covariance is \"ECI\"; allowed: UVW"),
        ("a.txt", meme.clone(), "a.txt:1: name of the file is \"a.txt\"; allowed: MEME_"),
        (
            name,
            meme.replace("\n2024227000100.000 ", "\n2024227006100.000 "),
            ":9: time of the state is \"2024227006100.000\"",
        ),
        (
            name,
            meme.replace("\n2024227000200.000 ", "\n2024227000100.000 "),
            ":13: time of the state is 2024-08-14T00:01:00",
        ),
        ("b.oem", oem.replace("= GCRF", "= MOONME"), "b.oem:10: REF_FRAME is MOONME; allowed: EME2000, J2000, GCRF"),
        ("b.oem", oem.replace("= RTN", "= VNC"), "COV_REF_FRAME is VNC; allowed: RTN"),
        ("b.oem", oem.replace("= TAI", "= MRT"), "b.oem:11: TIME_SYSTEM is MRT; allowed: UTC"),
        ("b.oem", oem.replace("= EARTH", "= MARS"), "b.oem:9: CENTER_NAME is MARS; allowed: EARTH"),
        (
            "b.oem",
            oem.replacen("META_STOP", "USABLE_STOP_TIME = 2024-08-14T00:10:00\nMETA_STOP", 1),
            "keyword in the metadata is USABLE_STOP_TIME; allowed: USEABLE_STOP_TIME, the most similar of OBJECT_NAME",
        ),
        (
            "c.xml",
            xml.replace("STOP_TIME>", "END_TIME>"),
            "c.xml:7: keyword in the metadata is END_TIME; allowed: STOP_TIME, the most similar",
        ),
        ("b.oem", swapped, "b.oem:22: time of the state is "),
        ("b.oem", lines(&oem, 50), "b.oem:50: time of the last state is 2024-08-14T00:32:00"),
        ("b.oem", lines(&oem, 113), "end of the file is inside the covariances"),
        (
            "b.oem",
            oem.replace("4.0000000000e-04\n", "-4.0000000000e-04\n"),
            "least eigenvalue of the correlation matrix is",
        ),
        (
            "b.oem",
            oem.replace("4.0000000000e-04\n", "4.0000000000e-07\n"),
            "least eigenvalue of the correlation matrix is -",
        ),
        ("b.oem", oem.replace("\nMETA_STOP\n", "\n"), "b.oem:17: line is \"2024-08-14T00:00:37.000 6928.000000000"),
        ("b.oem", oem.replace("META_START\n", ""), "b.oem:15: line is META_STOP before the metadata; allowed: KEYWORD"),
        (
            "b.oem",
            oem.replace("\nMETA_STOP\n", "\nMETA_STOP\nMETA_STOP\n"),
            "b.oem:17: line is META_STOP among the states; allowed: a state",
        ),
        (
            "b.oem",
            oem.replace("COVARIANCE_STOP\n", ""),
            "end of the file is inside the covariances; allowed: EPOCH = time",
        ),
        (
            "b.oem",
            oem.replace("COVARIANCE_STOP\n", "META_START\n"),
            "line is META_START inside the covariances; allowed: EPOCH",
        ),
        (
            "b.oem",
            oem.replace("COVARIANCE_START\n", "COVARIANCE_STOP\n"),
            "line is COVARIANCE_STOP among the states; allowed: a state",
        ),
        (
            "b.oem",
            oem.replace("META_START\n", "2024-08-14T00:00:37.000 6928 0 0 0 4.5 6\nMETA_START\n"),
            "b.oem:6: line is \"2024-08-14T00:00:37.000 6928 0 0 0 4.5 6\" before the metadata",
        ),
        (
            "b.oem",
            oem.replace("COV_REF_FRAME = RTN\n4.0000000000e-04\n", "4.0000000000e-04\nCOV_REF_FRAME = RTN\n"),
            "line is \"COV_REF_FRAME = RTN\" inside the covariances",
        ),
        (
            "b.oem",
            oem.replace("= GCRF\n", "= TEME\nREF_FRAME_EPOCH = 2024-08-14T00:00:00\n"),
            "b.oem:11: REF_FRAME_EPOCH is 2024-08-14T00:00:00; allowed: omitted with TEME",
        ),
        (
            "b.oem",
            oem.replace("2024-08-14T00:00:37.000 6928", "2023-08-14T00:00:37.000 6928"),
            "b.oem:19: time after the first state is 366.001 days; allowed: at most 366 days",
        ),
        ("c.xml", xml.replace("INVENTED-1", "A &unknown; B"), "c.xml:5: entity is &unknown;; allowed: &amp; &lt;"),
        (
            "c.xml",
            xml.replace("<metadata>", "<data><stateVector></stateVector></data><metadata>"),
            "c.xml:5: element is <stateVector> before the metadata",
        ),
        ("c.xml", xml[..xml.len() / 2].to_owned(), "c.xml:30: XML is "),
        ("c.xml", xml.replace("<X>", "<W>").replace("</X>", "</W>"), "X is missing; allowed: a value"),
        ("c.xml", xml.replace("<X>", "<X>0"), ""),
    ] {
        match read(name, &text) {
            Err(message) => {
                assert!(message.contains(expected) && message.contains("; allowed: "), "{expected}: {message}")
            }
            Ok(_) => assert_eq!(expected, "", "{name} is accepted"),
        }
    }
    // Positions in metres.
    let metres = oem.replace(" 6928.000000000 ", " 6928000.000000000 ");
    let message = read("m.oem", &metres).expect_err("metres");
    assert!(
        message.contains("distance from the Earth's centre is 6928000 km; allowed: 6378 to 1000000 km"),
        "{message}"
    );
}

/// COV_REF_FRAME applies only to its own matrix; without it, the axes are those of the states.
#[test]
fn axes_of_covariances_are_not_inherited() {
    let oem = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let axes = |text: &str| -> Vec<CovarianceAxes> {
        let ephemeris = read("a.oem", text).expect("readable").ephemerides.remove(0);
        ephemeris.covariances.iter().map(|one| one.axes).collect()
    };
    assert_eq!(axes(&oem), [CovarianceAxes::Radial; 2]);
    let last = oem.rfind("COV_REF_FRAME = RTN\n").expect("axes");
    let text = format!("{}{}", &oem[..last], &oem[last + "COV_REF_FRAME = RTN\n".len()..]);
    assert_eq!(axes(&text), [CovarianceAxes::Radial, CovarianceAxes::States]);
    let text = oem.replacen("COV_REF_FRAME = RTN\n", "", 1);
    assert_eq!(axes(&text), [CovarianceAxes::States, CovarianceAxes::Radial]);
    // Also in a second segment.
    let start = oem.find("META_START").expect("metadata");
    let text = format!("{oem}{}", oem[start..].replace("COV_REF_FRAME = RTN\n", ""));
    let both = read("a.oem", &text).expect("readable").ephemerides;
    assert_eq!(both.len(), 2);
    assert!(both[1].covariances.iter().all(|one| one.axes == CovarianceAxes::States));
}

/// If no end is stated, a file that ends within a line may be truncated: the rest of a number may be a valid number.
#[test]
fn files_cut_inside_a_line_are_rejected() {
    let oem = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let stop = oem.lines().find(|line| line.starts_with("STOP_TIME")).expect("an end");
    let text = oem.replace(&format!("{stop}\n"), "");
    let whole = &text[..text.find("COVARIANCE_START").expect("covariances")];
    assert!(read("a.oem", whole).is_ok());
    let lines: Vec<&str> = whole.trim_end().lines().collect();
    let cut = |characters: usize| {
        let text = whole.trim_end();
        read("a.oem", &text[..text.len() - characters]).expect_err("cut")
    };
    let line = format!("a.oem:{}: ", lines.len());
    assert_eq!(
        cut(3),
        format!(
            "{line}end of the file is inside a line; allowed: a line end after the last line, or a last state at the stated end (the file may be truncated)"
        )
    );
    assert!(cut(0).starts_with(&line) && cut(30).starts_with(&line), "{}", cut(30));
    // With a stated end, truncation before it is detected too, and the last line needs no line break.
    let stated = &oem[..oem.find("COVARIANCE_START").expect("covariances")];
    assert!(read("a.oem", stated.trim_end()).is_ok());
    let (before, _) = stated.trim_end().rsplit_once('\n').expect("lines");
    let message = read("a.oem", &before[..before.len() - 3]).expect_err("cut");
    assert!(message.contains(": end of the file is inside a line"), "{message}");
    let bytes = std::fs::read(file(MEME)).expect("a sample");
    let mut meme = String::new();
    std::io::Read::read_to_string(&mut flate2::read::GzDecoder::new(bytes.as_slice()), &mut meme).expect("gzip");
    let without = meme.replacen("ephemeris_stop:2024-08-14 01:30:00 UTC", "", 1);
    let name = "MEME_90001_X_1.txt";
    assert!(without != meme && read(name, &without).is_ok());
    let message = read(name, &without.trim_end()[..without.trim_end().len() - 4]).expect_err("cut");
    assert!(message.contains(":368: end of the file is inside a line"), "{message}");
}

/// NDM with element sets and an ephemeris, entities in names, and elements in another order.
#[test]
fn messages_of_both_kinds_in_one_document_are_read() {
    let oem = std::fs::read_to_string(file("invented_itrf.xml")).expect("a sample");
    let omm = String::from_utf8(sample("sample.xml")).expect("text");
    let body = |text: &str, tag: &str| {
        let (from, to) = (text.find(&format!("<{tag}")).expect(tag), text.rfind(&format!("</{tag}>")).expect(tag));
        text[from..to + tag.len() + 3].to_owned()
    };
    let (oem, omm) = (body(&oem, "oem"), body(&omm, "omm"));
    let expected = read("a.xml", &format!("<ndm>{oem}</ndm>")).expect("readable").ephemerides.remove(0);
    let alone = read("b.xml", &format!("<ndm>{omm}</ndm>")).expect("readable").element_sets;
    assert!(!alone.is_empty());
    for both in [format!("<ndm>{omm}{oem}</ndm>"), format!("<ndm>{oem}{omm}</ndm>")] {
        let found = read("a.xml", &both).expect("readable");
        assert_eq!((found.element_sets.len(), found.rejected.len()), (alone.len(), 0));
        assert_eq!(found.ephemerides, std::slice::from_ref(&expected));
    }
    let name = "<OBJECT_NAME>INVENTED-1</OBJECT_NAME>";
    let text = oem.replace(name, "").replace(
        "<TIME_SYSTEM>UTC</TIME_SYSTEM>",
        "<TIME_SYSTEM>UTC</TIME_SYSTEM><OBJECT_NAME>A &amp; B &#60;<![CDATA[C>]]></OBJECT_NAME>",
    );
    // The time of each state is moved after its position.
    let text: String = text
        .lines()
        .map(|line| {
            match (line.find("<EPOCH>"), line.find("</EPOCH>"), line.find("<X>"), line.find("</stateVector>")) {
                (Some(from), Some(to), Some(rest), Some(end)) => {
                    format!("{}{}{}</stateVector>\n", &line[..from], &line[rest..end], &line[from..to + 8])
                }
                _ => format!("{line}\n"),
            }
        })
        .collect();
    let found = read("a.xml", &text).expect("readable").ephemerides.remove(0);
    assert_eq!(found.name.as_ref(), "A & B <C>");
    assert_eq!(found.states, expected.states);
}

#[test]
fn ephemerides_are_read_among_element_sets_and_compressed() {
    let oem = std::fs::read(file("invented.oem")).expect("a sample");
    let options = ReadOptions::default();
    let packed = Satellites::from_bytes("a.oem.gz", &gzip(&oem), &options).expect("readable");
    assert!(packed.sources[0].gzipped && packed.element_sets.is_empty());
    let ephemeris = &packed.ephemerides[0];
    assert_eq!(ephemeris.to_string(), "INVENTED-1 (2026-001A)");
    assert!(ephemeris.is_of(&sample_elements()[0]));
    // TAI - UTC is 37 s.
    assert_eq!(ephemeris.interval().0, utc("2024-08-14T00:00:00 UTC"));
    let other = Satellites::from_bytes("b.2le", &sample("sample.2le"), &options).expect("readable");
    assert!(other.ephemerides.is_empty());
}

/// States outside the usable interval serve for the interpolation, but give no positions.
#[test]
fn only_the_usable_interval_of_an_oem_is_used() {
    let text = std::fs::read_to_string(file("invented.oem")).expect("a sample");
    let all = read("a.oem", &text).expect("an ephemeris");
    let (first, last) = all.ephemerides[0].interval();
    let with = |cards: &str| text.replacen("META_STOP", &format!("{cards}\nMETA_STOP"), 1);
    // The times of the message are in TAI.
    let iso = |epoch: Epoch| epoch.to_time_scale(TimeScale::TAI).to_string().replace(" TAI", "");
    let (from, to) = (first + 20.0 * Unit::Minute, last - 20.0 * Unit::Minute);
    let cards = format!("USEABLE_START_TIME = {}\nUSEABLE_STOP_TIME = {}", iso(from), iso(to));
    let usable = read("a.oem", &with(&cards)).expect("an ephemeris");
    assert_eq!(usable.ephemerides[0].interval(), (from, to));
    assert_eq!(usable.ephemerides[0].states.len(), all.ephemerides[0].states.len());
    // The same interval as the stated start and end, beyond which there are states.
    let start = text.lines().find(|line| line.starts_with("START_TIME")).expect("a start");
    let stop = text.lines().find(|line| line.starts_with("STOP_TIME")).expect("an end");
    let stated =
        text.replace(start, &format!("START_TIME = {}", iso(from))).replace(stop, &format!("STOP_TIME = {}", iso(to)));
    assert_eq!(read("a.oem", &stated).expect("an ephemeris").ephemerides, usable.ephemerides);
    let rounded = text.replace(stop, &format!("STOP_TIME = {}", iso(last - 0.5 * Unit::Second)));
    assert_eq!(read("a.oem", &rounded).expect("an ephemeris").ephemerides[0].interval(), (first, last));
    let elements = sample_elements();
    let index = |catalogue: &Satellites| {
        SatelliteIndex::new(&elements, DragModel::Published).with_ephemerides(
            &elements,
            &catalogue.ephemerides,
            &EopTable::embedded(),
        )
    };
    let is_used = |index: &SatelliteIndex, epoch: Epoch| {
        let propagator = index.propagator_over(0, [epoch, epoch]).expect("a propagator");
        matches!(propagator.position_source(), PositionSource::Ephemeris(_))
    };
    let middle = from + 0.5 * (to - from);
    let (of_all, of_usable) = (index(&all), index(&usable));
    let minute = Unit::Minute;
    // States outside are used for late and early satellites, so that an exposure may be up to the end of the interval.
    let times = [(from - 1.0 * minute, false), (from + 1.0 * minute, true), (middle, true), (to + 1.0 * minute, false)];
    for (epoch, expected) in times {
        assert!(is_used(&of_all, epoch), "{epoch}");
        assert_eq!(is_used(&of_usable, epoch), expected, "{epoch}");
    }
    let wrong = format!("USEABLE_START_TIME = {}\nUSEABLE_STOP_TIME = {}", iso(to), iso(from));
    let error = read("a.oem", &with(&wrong)).expect_err("reversed");
    assert!(error.contains("USEABLE_STOP_TIME"), "{error}");
    let error = read("a.oem", &with("USEABLE_START_TIME = 2024-08-14")).expect_err("a date");
    assert!(error.contains("USEABLE_START_TIME is \"2024-08-14\""), "{error}");
}

/// Returns the segments of one message, each with some minutes of the states of `whole` (two minutes apart) as they
/// are, or of a later orbit.
fn segments(set: &ElementSet, whole: &[&Ephemeris], minutes: &[[usize; 2]]) -> Vec<Arc<Ephemeris>> {
    let mut text = String::new();
    for (whole, [from, to]) in whole.iter().zip(minutes) {
        let header = oem_header(&set.norad_id.to_string(), "TEME");
        text += if text.is_empty() { &header } else { &header[header.find("META_START").expect("metadata")..] };
        for state in &whole.states[from / 2..=to / 2] {
            write_state(&mut text, state.epoch, &state.position_km, &state.velocity_km_s);
        }
    }
    read("segments.oem", &text).expect("readable").ephemerides
}

/// Adjoining and overlapping segments of a message are used without a hole, also for exposures across their ends; a
/// time between segments that neither covers is not.
#[test]
fn segments_of_a_satellite_are_used_without_a_hole() {
    let start = utc("2026-04-26T00:00:00 UTC");
    let set = Constellation::by_name("starlink-gen1").expect("shells").element_sets(start).remove(0);
    let whole = sgp4_ephemeris(&set, start, 3);
    let sets = [set.clone()];
    let of = |ephemerides: &[Arc<Ephemeris>]| {
        SatelliteIndex::new(&sets, DragModel::Published).with_ephemerides(&sets, ephemerides, &EopTable::embedded())
    };
    let sgp4 = of(&[]);
    let at = |minutes: f64| start + minutes * Unit::Minute;
    for (what, minutes, hole) in [
        ("adjoining", vec![[0, 60], [60, 120], [120, 180]], None),
        ("overlapping", vec![[0, 70], [60, 180]], None),
        ("with a hole", vec![[0, 80], [90, 180]], Some(74.0..=96.0)),
    ] {
        let index = of(&segments(&set, &[&whole, &whole, &whole], &minutes));
        assert!(index.contradictory_ephemerides().is_empty(), "{what}");
        for tenths in 60..=1740 {
            let minute = f64::from(tenths) / 10.0;
            // 20 s long.
            let ends = [at(minute - 1.0 / 6.0), at(minute + 1.0 / 6.0)];
            let propagator = index.propagator_over(0, ends).expect("a propagator");
            let is_near = |bounds: &std::ops::RangeInclusive<f64>| {
                (bounds.start() - minute).abs().min((bounds.end() - minute).abs()) < 0.2
            };
            if !(6.2..=173.8).contains(&minute) || hole.as_ref().is_some_and(is_near) {
                continue;
            }
            let expected = !hole.as_ref().is_some_and(|hole| hole.contains(&minute));
            assert_eq!(propagator.has_ephemeris(), expected, "{what}: {minute}");
            // Also for the delays that are searched.
            for late_s in [-300.0, -20.0, 0.0, 20.0, 300.0] {
                let epoch = at(minute) + late_s * Unit::Second;
                let right = position(sgp4.propagator(0).expect("SGP4"), epoch);
                let away_km = (position(propagator, epoch).vector() - right.vector()).norm();
                assert!(away_km < LEFT_OUT_TOLERANCE_KM, "{what}: {minute}, {late_s} s: {away_km} km");
            }
        }
    }
}

/// Segments of one message that overlap and differ are named; those that only adjoin are not.
#[test]
fn contradictory_segments_are_named() {
    let start = utc("2026-04-26T00:00:00 UTC");
    let set = Constellation::by_name("starlink-gen1").expect("shells").element_sets(start).remove(0);
    let other = ElementSet { mean_anomaly_deg: set.mean_anomaly_deg + 1.4, ..set.clone() };
    let (one, two) = (sgp4_ephemeris(&set, start, 3), sgp4_ephemeris(&other, start, 3));
    let sets = [set.clone()];
    for (minutes, contradictory) in [([[0, 90], [60, 180]], &[0][..]), ([[0, 90], [90, 180]], &[][..])] {
        let ephemerides = segments(&set, &[&one, &two], &minutes);
        let index = SatelliteIndex::new(&sets, DragModel::Published).with_ephemerides(
            &sets,
            &ephemerides,
            &EopTable::embedded(),
        );
        assert_eq!(index.contradictory_ephemerides(), contradictory, "{minutes:?}");
        // No position is interpolated across the jump.
        let ends = [start + 89.9 * Unit::Minute, start + 90.2 * Unit::Minute];
        let propagator = index.propagator_over(0, ends).expect("a propagator");
        let [first, last] = ends.map(|epoch| position(propagator, epoch));
        assert!((last.vector() - first.vector()).norm() < 18.0 * 8.0, "{minutes:?}");
    }
    // Those that overlap are not neighbours in the order of preference.
    let ephemerides = segments(&set, &[&one, &one, &two], &[[0, 180], [60, 76], [120, 180]]);
    let index = SatelliteIndex::new(&sets, DragModel::Published);
    let index = index.with_ephemerides(&sets, &ephemerides, &EopTable::embedded());
    assert_eq!(index.contradictory_ephemerides(), [0]);
}

/// Several ephemerides are used for an interval only if they agree wherever positions change from one to another: here
/// the preferred one from 80 to 120 min is of another orbit, while those from 0 to 140 and from 140 to 180 min agree.
#[test]
fn ephemerides_must_agree_where_they_are_exchanged() {
    let start = utc("2026-04-26T00:00:00 UTC");
    let set = Constellation::by_name("starlink-gen1").expect("shells").element_sets(start).remove(0);
    let other = ElementSet { mean_anomaly_deg: set.mean_anomaly_deg + 1.4, ..set.clone() };
    let (right, wrong) = (sgp4_ephemeris(&set, start, 3), sgp4_ephemeris(&other, start, 3));
    let sets = [set.clone()];
    let is_used = |minutes: &[[usize; 2]], from: f64, to: f64| {
        let ephemerides = segments(&set, &[&right, &wrong, &right], minutes);
        let index = SatelliteIndex::new(&sets, DragModel::Published);
        let index = index.with_ephemerides(&sets, &ephemerides, &EopTable::embedded());
        let ends = [from, to].map(|minutes| start + minutes * Unit::Minute);
        index.propagator_over(0, ends).expect("a propagator").has_ephemeris()
    };
    let minutes = [[0, 140], [80, 120], [140, 180]];
    assert!(!is_used(&minutes, 40.0, 165.0));
    // The other orbit is not in the interval and the delays that are searched.
    assert!(is_used(&minutes, 130.0, 165.0) && is_used(&minutes, 20.0, 40.0));
    // It begins, or ends, in the interval.
    assert!(!is_used(&minutes, 110.0, 165.0) && !is_used(&[[0, 100], [120, 178], [100, 180]], 60.0, 150.0));
}
