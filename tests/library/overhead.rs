//! Satellites above a site at given times, altitudes of Sun and pointing, and outlines of a field.

use std::collections::BTreeSet;

use hifitime::Epoch;
use streakcast::config::Config;
use streakcast::frames::{Direction, Horizontal, Position, seconds_after};
use streakcast::geometry::{Observer, Site, SunTable, ellipsoidal_height_km};
use streakcast::orbit::Propagator;
use streakcast::passes::{Field, SatelliteTrack, Sky, SnapshotOptions, SnapshotPositions, VisiblePass, VisibleRequest};
use streakcast::photometry::PhotometryOptions;

/// Largest difference of two heights, km. A satellite moves by 0.03 km while its light travels, and the tables of the
/// Earth's orientation are exact to millimetres.
const HEIGHT_KM: f64 = 0.05;

fn dusk() -> Epoch {
    "2026-08-14T23:29:05 UTC".parse().unwrap()
}

fn sky() -> Sky {
    let config = Config::from_toml("shells = 'oneweb'\nsite = 'rubin'\n", "t.toml").unwrap();
    config.prepare(dusk(), dusk()).unwrap().sky
}

fn options(min_altitude_rad: f64, include_dark: bool) -> SnapshotOptions {
    SnapshotOptions { include_dark, ..SnapshotOptions::all_above(min_altitude_rad) }
}

#[test]
fn verif_satellites_that_are_up_have_risen_and_not_set() {
    let (sky, at, lowest_rad) = (sky(), dusk(), 10f64.to_radians());
    // Satellites at 1200 km stay above the horizon for about twenty minutes.
    let request = VisibleRequest {
        start: seconds_after(at, -2400.0),
        end: seconds_after(at, 2400.0),
        dark: Vec::new(),
        min_altitude_rad: lowest_rad,
        min_culmination_rad: lowest_rad,
        limit: None,
        include_dark: true,
        samples: 0,
        photometry: PhotometryOptions::default(),
    };
    let passes = sky.visible_passes(&request, &|_| true).unwrap().passes;
    let is_up = |pass: &&VisiblePass| {
        pass.rise.as_ref().is_none_or(|rise| rise.epoch <= at) && pass.set.as_ref().is_none_or(|set| set.epoch >= at)
    };
    let risen: BTreeSet<usize> = passes.iter().filter(is_up).map(|pass| pass.element_index).collect();
    let (found, left_out) = sky.snapshots(at, &[0.0], &options(lowest_rad, true)).unwrap();
    let up: BTreeSet<usize> = found.iter().map(|one| one.element_index).collect();
    assert_eq!(up, risen);
    // The height above the ellipsoid, from site, altitude, azimuth and range.
    let site = sky.viewpoint().site().unwrap().site();
    for one in &found {
        let point = &one.snapshots[0].point;
        let seen = Direction::<Horizontal>::from_lon_lat_rad(point.azimuth_rad.unwrap(), point.altitude_rad.unwrap());
        let line = (site.horizon().inverse() * seen).vector() * point.range_km;
        let height_km = ellipsoidal_height_km(&Position::from_vector(site.itrs().vector() + line));
        assert!((height_km - point.height_km).abs() < HEIGHT_KM, "{height_km} {}", point.height_km);
    }
    assert!(up.len() > 50 && left_out.is_empty(), "{} up", up.len());
    let altitude_rad = |one: &SatelliteTrack| one.snapshots[0].point.altitude_rad.unwrap();
    assert!(found.iter().all(|one| one.snapshots.len() == 1 && altitude_rad(one) >= lowest_rad));
    // Without satellites in the shadow, those with any sunlight are kept.
    let (lit, _) = sky.snapshots(at, &[0.0], &options(lowest_rad, false)).unwrap();
    let expected = found.iter().filter(|one| one.snapshots[0].is_lit()).count();
    assert_eq!(lit.len(), expected);
    assert!(0 < expected && expected < found.len(), "{expected} of {} are lit", found.len());
}

#[test]
fn verif_whole_tracks_contain_all_times_of_the_same_satellites() {
    let (sky, at) = (sky(), dusk());
    let times_s: Vec<f64> = (0..7).map(|step| 100.0 * f64::from(step)).collect();
    let photometry = Some(PhotometryOptions::default());
    let parts = SnapshotOptions { photometry, ..options(0.5, false) };
    let (tracks, _) =
        sky.snapshots(at, &times_s, &SnapshotOptions { positions: SnapshotPositions::WholeTrack, ..parts }).unwrap();
    let (partial, _) = sky.snapshots(at, &times_s, &parts).unwrap();
    assert!(tracks.len() > 50 && partial.iter().any(|one| one.snapshots.len() < times_s.len()));
    assert_eq!(tracks.len(), partial.len());
    for (whole, part) in tracks.iter().zip(&partial) {
        assert_eq!(whole.element_index, part.element_index);
        assert_eq!(whole.snapshots.len(), times_s.len());
        for one in &part.snapshots {
            let other = &whole.snapshots[one.time_index];
            assert_eq!((other.time_index, other.point.epoch), (one.time_index, one.point.epoch));
            // Interpolated orbits have errors of millimetres, and the rotation of the site one millimetre in ten
            // minutes.
            let apart_rad = one.point.direction.separation_rad(&other.point.direction);
            assert!(apart_rad < 1e-7, "{apart_rad}");
            let sigmas = [one, other].map(|one| one.point.brightness.as_ref().map(|light| light.sigma_mag));
            assert!(sigmas[0].zip(sigmas[1]).is_none_or(|(one, other)| (one - other).abs() < 1e-4), "{sigmas:?}");
        }
    }
}

#[test]
fn the_same_satellites_from_elsewhere() {
    let here = sky();
    let there = here.seen_from(Observer::new(Site::by_name("subaru").unwrap()));
    let names = |sky: &Sky| -> BTreeSet<usize> {
        let (found, _) = sky.snapshots(dusk(), &[0.0], &options(0.3, true)).unwrap();
        found.iter().map(|one| one.element_index).collect()
    };
    let alone = Config::from_toml("shells = 'oneweb'\nsite = 'subaru'\n", "t.toml").unwrap();
    assert_eq!(names(&there), names(&alone.prepare(dusk(), dusk()).unwrap().sky));
    assert_ne!(names(&there), names(&here));
}

#[test]
fn verif_sun_and_pointing_share_one_frame() {
    /// Tolerance: parallax of the Sun (8.8 arcsec) and a margin for light time, which directions do not include.
    const TOLERANCE_RAD: f64 = 1e-4;
    let sky = sky();
    let hours: Vec<Epoch> = (0..24).map(|hour| seconds_after(dusk(), 3600.0 * f64::from(hour))).collect();
    let places: Vec<_> = hours.iter().map(|at| sky.sun_altaz(*at).unwrap()).collect();
    for (&at, place) in hours.iter().zip(&places) {
        let sun = streakcast::geometry::SunState::at(at).sun.direction().unwrap();
        let pointing = sky.pointing_altaz(&sun, at).unwrap();
        assert!((pointing.altitude_rad - place.altitude_rad).abs() < TOLERANCE_RAD, "{at}");
        let around = (pointing.azimuth_rad - place.azimuth_rad).sin().abs() * place.altitude_rad.cos();
        assert!(around < TOLERANCE_RAD, "{at}: {around}");
    }
    assert!(
        places.iter().any(|place| place.altitude_rad > 0.5) && places.iter().any(|place| place.altitude_rad < -0.5)
    );
}

#[test]
fn verif_outlines_run_between_inside_and_outside() {
    let text = r#"{"shapes": [{"circle_deg": 2.0, "center_deg": [3, -1]}, {"rectangle_deg": [1, 2]}, {"circle_deg": 0.4, "center_deg": [-2, 0]}]}"#;
    let field = Field::from_json(text).unwrap();
    let pointing = Direction::from_lon_lat_rad(1.0, -0.6);
    let rotation_rad = 0.7_f64;
    let on_sky = field.on_sky(&pointing, rotation_rad);
    let (east, north) = pointing.east_north();
    let outlines = field.outlines_deg(60);
    assert_eq!(outlines.iter().map(Vec::len).collect::<Vec<_>>(), [60, 4, 60]);
    for outline in outlines {
        let count = outline.len() as f64;
        let middle = [0, 1].map(|axis| outline.iter().map(|point| point[axis]).sum::<f64>() / count);
        for point in &outline {
            let holds = |share: f64| {
                let [x, y] = [0, 1].map(|axis| (middle[axis] + share * (point[axis] - middle[axis])).to_radians());
                let (sin, cos) = rotation_rad.sin_cos();
                let sight = pointing.vector() + east * (x * cos + y * sin) + north * (y * cos - x * sin);
                on_sky.contains(&Direction::from_vector(sight.normalize()))
            };
            assert!(holds(0.999) && !holds(1.001), "{point:?}");
        }
    }
}

/// Returns satellites at two heights, some of them in the shadow.
fn mixed_sky() -> Sky {
    let config = Config::from_toml("shells = ['oneweb', 'starlink-gen1']\nsite = 'rubin'\n", "t.toml").unwrap();
    config.prepare(dusk(), dusk()).unwrap().sky
}

/// Returns all satellites above the altitude, computed by SGP4 without a search; only lit ones unless `include_dark`.
fn reference(sky: &Sky, at: Epoch, min_altitude_rad: f64, include_dark: bool) -> Vec<(usize, f64, f64)> {
    let orientation = sky.orientation_over(at, at).at_s(0.0);
    let here = sky.viewpoint().site().unwrap().state(&orientation);
    let sun = SunTable::new(at, at).at_s(0.0).sun;
    let one = |(index, set): (usize, _)| {
        let state = Propagator::new(set).unwrap().state(at, &orientation.teme_to_gcrs).unwrap();
        let away = state.position - here.position;
        let is_lit = || sky.shadow().illumination(&state.position, &sun).lit_fraction() > 0.0;
        let (altitude_rad, azimuth_rad) = here.altitude_azimuth_rad(&away).unwrap();
        (altitude_rad >= min_altitude_rad && (include_dark || is_lit())).then_some((index, altitude_rad, azimuth_rad))
    };
    sky.elements().iter().enumerate().filter_map(one).collect()
}

/// Snapshots contain exactly the satellites that are above the altitude by SGP4 at each time.
#[test]
fn verif_snapshots_against_sgp4_of_every_satellite() {
    /// Tolerance of interpolated orbits: millimetres at 500 km.
    const TOLERANCE_RAD: f64 = 1e-7;
    let sky = mixed_sky();
    let queries: [(f64, Vec<f64>, f64); 4] = [
        (0.0, vec![0.0], 10.0),
        (0.0, (0..20).map(|step| 2.0 * f64::from(step)).collect(), 18.0),
        (3600.0, vec![100.0, 160.0, 1000.0, 1130.5], 0.0),
        (7200.0, vec![0.0, 1800.0, 3600.0], 25.0),
    ];
    for include_dark in [false, true] {
        for (later_s, times_s, lowest_deg) in &queries {
            let (at, lowest_rad) = (seconds_after(dusk(), *later_s), lowest_deg.to_radians());
            let photometry = Some(PhotometryOptions::default());
            let options_of_case = SnapshotOptions { photometry, ..options(lowest_rad, include_dark) };
            let (tracks, left_out) = sky.snapshots(at, times_s, &options_of_case).unwrap();
            assert!(left_out.is_empty());
            assert!(tracks.is_sorted_by_key(|track| track.element_index));
            let mut seen = 0;
            for (index, time_s) in times_s.iter().enumerate() {
                let expected = reference(&sky, seconds_after(at, *time_s), lowest_rad, include_dark);
                let found: Vec<_> = tracks
                    .iter()
                    .flat_map(|track| track.snapshots.iter().map(|one| (track.element_index, one)))
                    .filter(|(_, one)| one.time_index == index)
                    .collect();
                assert_eq!(
                    found.iter().map(|(index, _)| *index).collect::<Vec<_>>(),
                    expected.iter().map(|(index, ..)| *index).collect::<Vec<_>>()
                );
                for ((element_index, one), (_, altitude_rad, azimuth_rad)) in found.iter().zip(&expected) {
                    let off_rad = one.point.altitude_rad.unwrap() - altitude_rad;
                    let beside_rad = (one.point.azimuth_rad.unwrap() - azimuth_rad).sin() * altitude_rad.cos();
                    assert!(off_rad.hypot(beside_rad) < TOLERANCE_RAD, "{off_rad} {beside_rad}");
                    let alone = sky.brightness(*element_index, &one.point, &PhotometryOptions::default());
                    let magnitudes =
                        [one.point.brightness.as_ref(), alone.as_ref()].map(|light| light.map(|light| light.magnitude));
                    assert_eq!(magnitudes[0], magnitudes[1]);
                }
                seen += found.len();
            }
            assert!(seen > 20, "{seen} in {} times", times_s.len());
        }
    }
}

#[test]
fn tracks_move_as_fast_as_their_points() {
    let (sky, times_s) = (mixed_sky(), [0.0, 0.5, 1.0]);
    let (tracks, _) = sky.snapshots(dusk(), &times_s, &options(0.3, false)).unwrap();
    let whole = tracks.iter().filter(|track| track.snapshots.len() == 3);
    for track in whole.clone() {
        let direction = |index: usize| track.snapshots[index].point.direction;
        let moved_rad = direction(0).separation_rad(&direction(2));
        let rate_rad_s = track.middle().unwrap().angular_rate_rad_s;
        // The curvature of a track in a second is at most some hundredths of its length.
        assert!((moved_rad / rate_rad_s - 1.0).abs() < 1e-3, "{moved_rad} {rate_rad_s}");
        assert!(track.snapshots.iter().all(|one| one.point.brightness.is_none()));
    }
    assert!(whole.count() > 100);
}

#[test]
fn snapshots_reject_invalid_times_and_altitudes() {
    let sky = sky();
    for (times_s, altitude_rad, words) in [
        (vec![], 0.3, "number of times is 0; allowed: 1 to 10000"),
        (vec![0.0, 2.0, 2.0], 0.3, "order of the times is not increasing"),
        (vec![-1.0], 0.3, "time is -1 s; allowed: 0 to 3600 s"),
        (vec![4000.0], 0.3, "time is 4000 s; allowed: 0 to 3600 s"),
        (vec![f64::NAN], 0.3, "time is NaN s"),
        (vec![0.0], -0.1, "allowed: 0 to 90 deg"),
        (vec![0.0], 1.6, "allowed: 0 to 90 deg"),
    ] {
        let message = sky.snapshots(dusk(), &times_s, &options(altitude_rad, false)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let early: Epoch = "1900-01-01T00:00:00 UTC".parse().unwrap();
    assert!(sky.snapshots(early, &[0.0], &options(0.0, true)).is_err() && sky.sun_altaz(early).is_err());
}
