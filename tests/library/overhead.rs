//! What a page draws of a sky: who is up at a moment, where Sun and pointing stand, and the outlines of a field.

use std::collections::BTreeSet;

use hifitime::Epoch;
use streakcast::config::Config;
use streakcast::frames::{Direction, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{Field, PassOptions, Sky, SkyTrack, SkyTrackOptions};
use streakcast::photometry::PhotometryOptions;

fn dusk() -> Epoch {
    "2026-08-14T23:29:05 UTC".parse().unwrap()
}

fn sky() -> Sky {
    let config = Config::from_toml("shells = 'oneweb'\nsite = 'rubin'\n", "t.toml").unwrap();
    config.prepare(dusk(), dusk()).unwrap().sky
}

fn options(include_dark: bool) -> PassOptions {
    PassOptions { include_dark, ..PassOptions::default() }
}

#[test]
fn verif_who_is_up_is_who_has_risen_and_not_set() {
    let (sky, at, lowest_rad) = (sky(), dusk(), 10f64.to_radians());
    // Satellites at 1200 km stay up for some twenty minutes.
    let (passes, _) =
        sky.horizon_passes(seconds_after(at, -2400.0), seconds_after(at, 2400.0), lowest_rad, &options(true)).unwrap();
    let is_up = |pass: &&streakcast::passes::HorizonPass| {
        pass.rise.as_ref().is_none_or(|rise| rise.epoch <= at) && pass.set.as_ref().is_none_or(|set| set.epoch >= at)
    };
    let risen: BTreeSet<usize> = passes.iter().filter(is_up).map(|pass| pass.element_index).collect();
    let (found, left_out) = sky.overhead(at, 0.0, 1, lowest_rad, &options(true)).unwrap();
    let up: BTreeSet<usize> = found.iter().map(|one| one.element_index).collect();
    assert_eq!(up, risen);
    assert!(up.len() > 50 && left_out.is_empty(), "{} up", up.len());
    assert!(found.iter().all(|one| one.points.len() == 1 && one.points[0].altitude_rad.unwrap() >= lowest_rad));
    // Without the dark ones those are left that any sunlight reaches.
    let (lit, _) = sky.overhead(at, 0.0, 1, lowest_rad, &options(false)).unwrap();
    let expected = found.iter().filter(|one| one.points[0].illumination.lit_fraction() > 0.0).count();
    assert_eq!(lit.len(), expected);
    assert!(0 < expected && expected < found.len(), "{expected} of {} are lit", found.len());
}

#[test]
fn verif_a_stretch_holds_everybody_of_its_moments() {
    let (sky, at) = (sky(), dusk());
    let (tracks, _) = sky.overhead(at, 600.0, 7, 0.5, &options(true)).unwrap();
    let all: BTreeSet<usize> = tracks.iter().map(|one| one.element_index).collect();
    let mut moments = BTreeSet::new();
    for step in 0..7 {
        let (now, _) = sky.overhead(seconds_after(at, 100.0 * f64::from(step)), 0.0, 1, 0.5, &options(true)).unwrap();
        for one in now {
            let track = tracks.iter().find(|track| track.element_index == one.element_index).expect("in the stretch");
            let apart_rad = track.points[step as usize].direction.separation_rad(&one.points[0].direction);
            // Interpolated orbits are good to millimetres, the site's turn to a millimetre over ten minutes.
            assert!(apart_rad < 1e-7, "{apart_rad}");
            moments.insert(one.element_index);
        }
    }
    assert_eq!(all, moments);
}

#[test]
fn the_same_satellites_from_elsewhere() {
    let here = sky();
    let there = here.seen_from(Observer::new(Site::by_name("subaru").unwrap()));
    let names = |sky: &Sky| -> BTreeSet<usize> {
        let (found, _) = sky.overhead(dusk(), 0.0, 1, 0.3, &options(true)).unwrap();
        found.iter().map(|one| one.element_index).collect()
    };
    let alone = Config::from_toml("shells = 'oneweb'\nsite = 'subaru'\n", "t.toml").unwrap();
    assert_eq!(names(&there), names(&alone.prepare(dusk(), dusk()).unwrap().sky));
    assert_ne!(names(&there), names(&here));
}

#[test]
fn verif_sun_and_pointing_stand_in_one_sky() {
    /// The Sun's parallax (8.8 arcsec), with room for light time that a direction knows nothing of.
    const TOLERANCE_RAD: f64 = 1e-4;
    let sky = sky();
    let hours: Vec<Epoch> = (0..24).map(|hour| seconds_after(dusk(), 3600.0 * f64::from(hour))).collect();
    let places: Vec<_> = hours.iter().map(|at| sky.sun_over_site(*at).unwrap()).collect();
    for (&at, place) in hours.iter().zip(&places) {
        let sun = streakcast::geometry::SunState::at(at).sun.direction().unwrap();
        let pointing = sky.pointing_over_site(&sun, at).unwrap();
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

#[test]
fn what_cannot_be_asked_is_told() {
    let sky = sky();
    for (duration_s, moments, altitude_rad, words) in [
        (-1.0, 1, 0.0, "0 to 3600 s"),
        (f64::NAN, 1, 0.0, "0 to 3600 s"),
        (4000.0, 1, 0.0, "0 to 3600 s"),
        (0.0, 0, 0.0, "1 to 1000"),
        (0.0, 2000, 0.0, "1 to 1000"),
        (0.0, 1, -0.1, "0 to 90 deg"),
        (0.0, 1, 1.6, "0 to 90 deg"),
    ] {
        let message = sky.overhead(dusk(), duration_s, moments, altitude_rad, &options(true)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let early: Epoch = "1900-01-01T00:00:00 UTC".parse().unwrap();
    assert!(sky.overhead(early, 0.0, 1, 0.0, &options(true)).is_err() && sky.sun_over_site(early).is_err());
}

/// Satellites at two heights, some of them in the shadow.
fn mixed_sky() -> Sky {
    let config = Config::from_toml("shells = ['oneweb', 'starlink-gen1']\nsite = 'rubin'\n", "t.toml").unwrap();
    config.prepare(dusk(), dusk()).unwrap().sky
}

/// Places alone are those of the full answer, moment by moment, for the same satellites.
#[test]
fn verif_sky_tracks_stand_where_the_full_answer_has_them() {
    let sky = mixed_sky();
    let stretches: [(f64, Vec<f64>, f64); 4] = [
        (0.0, vec![0.0], 10.0),
        (0.0, (0..20).map(|step| 2.0 * f64::from(step)).collect(), 18.0),
        (3600.0, vec![100.0, 160.0, 1000.0, 1130.5], 0.0),
        (7200.0, vec![0.0, 1800.0, 3600.0], 25.0),
    ];
    for include_dark in [false, true] {
        for (later_s, moments_s, lowest_deg) in &stretches {
            let (at, lowest_rad) = (seconds_after(dusk(), *later_s), lowest_deg.to_radians());
            let photometry = PhotometryOptions::default();
            let asked = SkyTrackOptions { min_altitude_rad: lowest_rad, include_dark, photometry: Some(photometry) };
            let (tracks, left_out) = sky.sky_tracks(at, moments_s, &asked).unwrap();
            assert!(left_out.is_empty());
            assert!(tracks.is_sorted_by_key(|track| track.element_index));
            let mut seen = 0;
            for (number, moment_s) in moments_s.iter().enumerate() {
                let (now, _) =
                    sky.overhead(seconds_after(at, *moment_s), 0.0, 1, lowest_rad, &options(include_dark)).unwrap();
                let place = |track: &SkyTrack| {
                    track
                        .places
                        .iter()
                        .find(|(of, _)| *of == number)
                        .map(|(_, direction)| (track.element_index, *direction))
                };
                let places: Vec<_> = tracks.iter().filter_map(place).collect();
                let there: Vec<usize> = now.iter().map(|one| one.element_index).collect();
                assert_eq!(places.iter().map(|(index, _)| *index).collect::<Vec<_>>(), there);
                for (one, (_, direction)) in now.iter().zip(&places) {
                    // Interpolated orbits are good to millimetres, the site's turn to a millimetre over ten minutes.
                    let apart_rad = one.points[0].direction.separation_rad(direction);
                    assert!(apart_rad < 1e-7, "{apart_rad}");
                }
                for track in tracks.iter().filter(|track| track.places[track.places.len() / 2].0 == number) {
                    let point = &now.iter().find(|one| one.element_index == track.element_index).unwrap().points[0];
                    assert!((point.range_km - track.range_km).abs() < 1e-3);
                    let magnitudes = [point.brightness.as_ref(), track.brightness.as_ref()]
                        .map(|light| light.map(|light| light.magnitude.0));
                    match magnitudes {
                        [Some(full), Some(alone)] => assert!((full - alone).abs() < 1e-5, "{full} {alone}"),
                        other => assert_eq!(other, [None, None]),
                    }
                }
                seen += there.len();
            }
            assert!(seen > 20, "{seen} in {} moments", moments_s.len());
        }
    }
}

#[test]
fn sky_tracks_move_as_fast_as_their_places_do() {
    let (sky, moments_s) = (mixed_sky(), [0.0, 0.5, 1.0]);
    let asked = SkyTrackOptions { min_altitude_rad: 0.3, include_dark: false, photometry: None };
    let (tracks, _) = sky.sky_tracks(dusk(), &moments_s, &asked).unwrap();
    let whole = tracks.iter().filter(|track| track.places.len() == 3);
    for track in whole.clone() {
        let moved_rad = track.places[0].1.separation_rad(&track.places[2].1);
        // Over a second a track bends by some hundredths of its length at most.
        assert!((moved_rad / track.angular_rate_rad_s - 1.0).abs() < 1e-3, "{moved_rad} {}", track.angular_rate_rad_s);
        assert!(track.brightness.is_none());
    }
    assert!(whole.count() > 100);
}

#[test]
fn sky_tracks_refuse_what_they_cannot_answer() {
    let sky = sky();
    let asked = |moments_s: &[f64], min_altitude_rad: f64| {
        let options = SkyTrackOptions { min_altitude_rad, include_dark: false, photometry: None };
        sky.sky_tracks(dusk(), moments_s, &options).unwrap_err().to_string()
    };
    for (moments_s, altitude_rad, words) in [
        (vec![], 0.3, "0 moments (allowed: 1 to 10000)"),
        (vec![0.0, 2.0, 2.0], 0.3, "not in the order of time"),
        (vec![-1.0], 0.3, "-1 s after the start (allowed: 0 to 3600 s)"),
        (vec![f64::NAN], 0.3, "NaN s after the start"),
        (vec![0.0], -0.1, "allowed: 0 to 90 deg"),
    ] {
        let message = asked(&moments_s, altitude_rad);
        assert!(message.contains(words), "{message}");
    }
}
