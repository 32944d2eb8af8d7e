//! Ephemerides compared with Skyfield, and with passes and snapshots of the same sky. The tests of `horizons.rs`
//! compare them with JPL Horizons.

use std::collections::BTreeSet;

use hifitime::Epoch;
use streakcast::config::{Config, EphemerisConfig};
use streakcast::elements::{ElementSet, Keep, ReadOptions, Satellites};
use streakcast::forecast::{EphemerisRow, ephemeris, ephemeris_table};
use streakcast::frames::{Direction, EopTable, Gcrs, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::orbit::DragModel;
use streakcast::passes::{EphemerisPoint, ModelChoice, Sky, SnapshotOptions};
use streakcast::photometry::PhotometryOptions;

use crate::common::agreement::Agreement;

/// Tolerance of directions. Both programs use SGP4 with the same elements, IAU 2000A/2006 and the same UT1 and pole,
/// and neither rounds the times; the remaining difference is the interpolation of arcs and of the Earth's orientation.
const DIRECTION_ARCSEC: f64 = 0.01;
/// Tolerance of altitude and azimuth: 0.01", and the rotation of the horizon.
const HORIZON_ARCSEC: f64 = 0.02;
const RANGE_KM: f64 = 1e-4;
/// Relative tolerance of rates, which are central differences over 0.4 s in the golden file: their error (ω h)²/3 with
/// h = 0.2 s is 4e-6 at 1 deg/s.
const RATE_RELATIVE: f64 = 1e-5;
/// Tolerance of range rates: Skyfield uses SGP4's velocities v, which differ from the derivative of its positions by
/// J₂ e v, where e is the eccentricity.
const RANGE_RATE_KM_S: f64 = 2e-4;
/// Tolerance of the Sun at reception compared with DE421: aberration of 20", which neither includes, and 1e-5 au.
const SUN_DEG: f64 = 0.006;

fn columns(line: &str) -> Vec<f64> {
    line.split(',').map(|cell| cell.parse().expect("a number")).collect()
}

#[test]
fn valid_ephemeris_against_skyfield() {
    let Some(data) = crate::common::data_dir() else { return };
    let golden = std::fs::read_to_string(crate::common::golden_dir().join("ephemeris_golden.csv")).expect("goldens");
    let rows: Vec<Vec<f64>> = golden.lines().skip(2).map(columns).collect();
    assert!(rows.len() > 60, "{}", rows.len());
    let finals = std::fs::read_to_string(data.join("aux/finals2000A.all")).expect("Earth orientation");
    let eop = EopTable::from_finals2000a(&finals).expect("Earth orientation");
    let start: Epoch = "2026-04-25T23:00:00 UTC".parse().expect("an epoch");
    let catalogue = data.join("tle/active/active_2026-04-25.txt");
    let options = ReadOptions { keep: Keep::Nearest(start), ..ReadOptions::default() };
    let wanted: BTreeSet<u32> = rows.iter().map(|row| row[0] as u32).collect();
    let sets: Vec<ElementSet> = Satellites::read(&[catalogue], &options)
        .expect("element sets")
        .element_sets
        .into_iter()
        .filter(|set| wanted.contains(&set.norad_id.0))
        .collect();
    let site =
        Site::new_deg("Rubin", -(30.0 + 14.0 / 60.0 + 40.7 / 3600.0), -(70.0 + 44.0 / 60.0 + 57.9 / 3600.0), 2662.75);
    let sky = Sky::with_models(sets, Observer::new(site.expect("a site")), eop, &ModelChoice::default())
        .with_drag(DragModel::Published);
    let authority = "Skyfield";
    let mut direction = Agreement::new("Ephemeris: astrometric directions", authority, DIRECTION_ARCSEC, "arcsec");
    let mut horizon = Agreement::new("Ephemeris: altitude and azimuth", authority, HORIZON_ARCSEC, "arcsec");
    let mut range = Agreement::new("Ephemeris: ranges", authority, RANGE_KM, "km");
    let mut rate = Agreement::new("Ephemeris: rates, relative", authority, RATE_RELATIVE, "");
    let mut range_rate = Agreement::new("Ephemeris: range rates", authority, RANGE_RATE_KM_S, "km/s");
    let mut sun = Agreement::new("Ephemeris: phase angle and elongation", authority, SUN_DEG, "deg");
    for row in &rows {
        let index = sky.elements().iter().position(|set| set.norad_id.0 == row[0] as u32).expect("the satellite");
        let (points, left_out) = sky.ephemeris(&[index], &[seconds_after(start, row[1])], None).expect("a place");
        assert!(left_out.is_empty());
        let [point] = points.as_slice() else { panic!("{} places", points.len()) };
        let seen = &point.point;
        let lon_lat = |lon_deg: f64, lat_deg: f64| {
            Direction::<Gcrs>::from_lon_lat_rad(lon_deg.to_radians(), lat_deg.to_radians())
        };
        direction.add(seen.direction.separation_rad(&lon_lat(row[2], row[3])).to_degrees() * 3600.0);
        let apparent =
            Direction::from_lon_lat_rad(seen.azimuth_rad.expect("a site"), seen.altitude_rad.expect("a site"));
        horizon.add(apparent.separation_rad(&lon_lat(row[7], row[6])).to_degrees() * 3600.0);
        range.add((seen.range_km - row[8]).abs());
        let rates = [point.ra_cos_dec_rate_rad_s.to_degrees() - row[4], point.dec_rate_rad_s.to_degrees() - row[5]];
        // Values of the golden file have nine decimals.
        rate.add((rates[0].hypot(rates[1]) - 1e-9).max(0.0) / row[4].hypot(row[5]));
        range_rate.add((point.range_rate_km_s - row[9]).abs());
        sun.add((seen.geometry.phase_angle_rad().to_degrees() - row[10]).abs());
        sun.add((point.elongation_rad.to_degrees() - row[11]).abs());
    }
}

fn oneweb() -> (Sky, Epoch) {
    let start: Epoch = "2026-08-14T23:29:05 UTC".parse().expect("an epoch");
    let config = Config::from_toml("shells = 'oneweb'\nsite = 'rubin'\n", "t.toml").expect("a configuration");
    (config.prepare(start, start).expect("a sky").sky, start)
}

/// Points equal those of the snapshots above the site; rates equal differences of positions before and after.
#[test]
fn verif_positions_are_those_of_snapshots_and_rates_their_differences() {
    let (sky, start) = oneweb();
    let photometry = PhotometryOptions::default();
    let options = SnapshotOptions { photometry: Some(photometry), ..SnapshotOptions::all_above(0.5) };
    let (tracks, _) = sky.snapshots(start, &[0.0], &options).expect("snapshots");
    assert!(tracks.len() > 20, "{}", tracks.len());
    let indices: Vec<usize> = tracks.iter().map(|track| track.element_index).collect();
    let step_s = 0.5;
    let times = [0.0, -step_s, step_s].map(|seconds| seconds_after(start, seconds));
    let (points, left_out) = sky.ephemeris(&indices, &times, Some(&photometry)).expect("places");
    assert!(left_out.is_empty());
    assert_eq!(points.len(), 3 * indices.len());
    let mut lit = 0;
    for (track, points) in tracks.iter().zip(points.chunks(3)) {
        let [now, before, after] = points else { panic!("three times") };
        assert_eq!((now.element_index, now.time_index, after.time_index), (track.element_index, 0, 2));
        let snapshot = &track.snapshots[0];
        // Arcs with other nodes differ by millimetres at a range of 1200 km.
        assert!(now.point.direction.separation_rad(&snapshot.point.direction) < 1e-8);
        assert!((now.point.range_km - snapshot.point.range_km).abs() < 1e-5);
        assert_eq!(now.point.illumination.name(), snapshot.point.illumination.name());
        let magnitudes =
            [&now.point, &snapshot.point].map(|point| point.brightness.as_ref().map(|one| one.magnitude.0));
        assert_eq!(magnitudes[0].is_some(), magnitudes[1].is_some());
        if let [Some(magnitude), Some(expected)] = magnitudes {
            assert!((magnitude - expected).abs() < 1e-4, "{magnitude} {expected}");
            lit += 1;
        }
        let rate_rad_s = now.ra_cos_dec_rate_rad_s.hypot(now.dec_rate_rad_s);
        assert!((rate_rad_s / snapshot.angular_rate_rad_s - 1.0).abs() < 3e-4, "{rate_rad_s}");
        let moved = |rate: f64, change: f64| (rate - change / (2.0 * step_s)).abs();
        let altitude = |point: &EphemerisPoint| point.point.altitude_rad.expect("a site");
        let azimuth = |point: &EphemerisPoint| point.point.azimuth_rad.expect("a site");
        // The third derivative changes the rate by at most 1e-7 rad/s over half a second.
        assert!(moved(now.altitude_rate_rad_s.expect("a site"), altitude(after) - altitude(before)) < 1e-6);
        let half_turn = std::f64::consts::PI;
        let turned = (azimuth(after) - azimuth(before) + half_turn).rem_euclid(2.0 * half_turn) - half_turn;
        let rate = now.azimuth_cos_altitude_rate_rad_s.expect("a site");
        assert!(moved(rate, turned * altitude(now).cos()) < 2e-5, "{rate} {turned}");
        assert!(moved(now.range_rate_km_s, after.point.range_km - before.point.range_km) < 1e-4);
        // Angles of the triangle Sun, observer, satellite; the angle at the Sun is below 0.001 degrees.
        let sum_rad = now.elongation_rad + now.point.geometry.phase_angle_rad();
        assert!((sum_rad - std::f64::consts::PI).abs() < 2e-4, "{sum_rad}");
        assert!(now.uncertainty.along_track_s > 0.0 && now.cross_track_sigma_rad() > 0.0);
    }
    assert!(lit > 5, "{lit}");
}

#[test]
fn requests_are_filtered_by_name_and_altitude() {
    let (sky, start) = oneweb();
    let config = Config::from_toml("shells = 'oneweb'\nsite = 'rubin'\n", "t.toml").expect("a configuration");
    let request = |more: &str| {
        let text = format!(r#"{{"times": ["2026-08-14T23:29:05Z", "2026-08-14T23:39:05Z"], "name": ["S1 P"]{more}}}"#);
        serde_json::from_str::<EphemerisConfig>(&text).expect("a request").resolve(&config).expect("a request")
    };
    let all = ephemeris(&sky, &request("")).expect("places");
    let up = ephemeris(&sky, &request(r#", "min_altitude": 10"#)).expect("places");
    let above = |point: &&EphemerisPoint| point.point.altitude_rad.is_some_and(|rad| rad >= 10f64.to_radians());
    let expected: Vec<_> = all.points.iter().filter(above).cloned().collect();
    assert_eq!(up.points, expected);
    assert!(!expected.is_empty() && expected.len() < all.points.len(), "{} of {}", expected.len(), all.points.len());
    let elements = sky.elements();
    assert!(all.points.iter().all(|point| elements[point.element_index].name.contains("S1 P")));
    let rows = all.points.iter().map(|point| EphemerisRow { point, elements: &elements[point.element_index] });
    assert_eq!(ephemeris_table(rows).rows.len(), all.points.len());

    let mut none = request("");
    none.selection.names = vec!["NO SUCH".to_owned()];
    let message = ephemeris(&sky, &none).expect_err("an empty selection").to_string();
    assert!(message.contains("none of the 6372 satellites has a name with NO SUCH"), "{message}");
    let many = vec![start; 1_000_001];
    let error = sky.ephemeris(&[0], &many, None).expect_err("too many points").to_string();
    assert!(error.contains("(satellites times times) is 1000001; allowed: at most 1000000"), "{error}");
    let early: Epoch = "1950-01-01T00:00:00 UTC".parse().expect("an epoch");
    assert!(
        sky.ephemeris(&[0], &[early], None)
            .is_err_and(|error| error.to_string().contains("is outside the years of the ephemeris"))
    );
}
