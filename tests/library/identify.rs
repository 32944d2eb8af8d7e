//! Identification of streaks: streaks observed by telescopes with known satellites, and predicted passes.

use std::path::Path;

use hifitime::Epoch;
use streakcast::elements::{Keep, ReadOptions, Satellites};
use streakcast::frames::{Direction, EopTable, Gcrs, seconds_after, seconds_between};
use streakcast::geometry::{Observer, Site};
use streakcast::identify::{Identified, IdentifyOptions, MeasuredStreak, Timing, fit_line, identify_streak};
use streakcast::images::{OUTLINES, Outline, parse_regions};
use streakcast::passes::{Exposure, Field, ModelChoice, PassOptions, Sky};
use streakcast::photometry::ModelLibrary;

fn sky(files: &[&Path], site: &str, moment: Epoch) -> Sky {
    let paths: Vec<_> = files.iter().map(|file| file.to_path_buf()).collect();
    let options = ReadOptions { keep: Keep::Nearest(moment), ..Default::default() };
    let catalogue = Satellites::read(&paths, &options).unwrap();
    let choice = ModelChoice::new(&ModelLibrary::embedded()).unwrap();
    let observer = Observer::new(Site::from_mpc(site).unwrap());
    Sky::with_models(catalogue.at(moment), observer, EopTable::embedded().without_polar_motion(), &choice)
}

fn arcsec(arcsec: f64) -> f64 {
    (arcsec / 3600.0).to_radians()
}

fn identify(sky: &Sky, streak: &MeasuredStreak) -> Identified {
    identify_streak(sky, streak, &IdentifyOptions::default()).unwrap()
}

fn name_of(sky: &Sky, found: &Identified, rank: usize) -> String {
    found.candidates.get(rank).map_or("none".into(), |one| sky.elements()[one.element_index].name.to_string())
}

/// Frames of Boley et al. (2021). Box N belongs to the satellite in row N (from 0) of their target list `plan.ran`;
/// their table of photometry has the same names in the same order. Row N gives the time at which the satellite passes
/// the centre of the frame, in the middle of the exposure of 30 s.
#[test]
fn valid_the_regions_of_plaskett_are_of_the_target_satellites() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("photometry/boley2021_plaskett");
    let plan = std::fs::read_to_string(folder.join("plan.ran")).unwrap();
    let rows: Vec<(&str, Epoch)> = plan
        .lines()
        .map(|line| {
            let (name, rest) = line.split_once(".txt: ").unwrap();
            let time = rest.split_whitespace().nth(1).unwrap();
            (name, format!("2021-07-16T{time} UTC").parse().unwrap())
        })
        .collect();
    let sky = sky(&[&folder.join("starlink.15JUL2021")], "658", rows[0].1);
    let mut frames: Vec<_> = std::fs::read_dir(folder.join("regFiles"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "reg"))
        .collect();
    frames.sort();
    let mut numbers = std::collections::BTreeSet::new();
    for path in &frames {
        let file = path.file_stem().unwrap().to_str().unwrap();
        let number: usize = file.split('-').nth(1).unwrap().parse().unwrap();
        numbers.insert(number);
        let (name, passage) = rows[number];
        let regions = parse_regions(file, &std::fs::read_to_string(path).unwrap(), OUTLINES).unwrap().into_iter();
        let outlines = regions.map(|region| match region.outline {
            Outline::Sky(corners) => corners,
            pixels => panic!("{file}: {pixels:?}"),
        });
        let line = fit_line(&outlines.collect::<Vec<_>>()).unwrap();
        let time = (seconds_after(passage, -15.0), 30.0);
        let streak =
            MeasuredStreak::from_ends(line.ends, time, Timing::Within, 0.5 * line.half_width_rad, 1.0).unwrap();
        let found = identify(&sky, &streak);
        let first = &found.candidates[0];
        assert_eq!(name_of(&sky, &found, 0), name, "{file}");
        // The second candidate is improbable, and the offsets are typical of elements half a day old.
        assert!(first.probability > 0.99, "{file}: {}", first.probability);
        assert!(first.chi_square < 12.0 && first.along_track_s.value.abs() < 1.0, "{file}: {first:?}");
        assert!(first.angle_rad.value.to_degrees().abs() < 0.6, "{file}: {}", first.angle_rad.value.to_degrees());
    }
    assert_eq!((frames.len(), numbers.len()), (13, 11));
}

/// Starlink-1102 in exposure 941420 of the Dark Energy Camera (see streak_real.rs), with elements 11.5 days old, and
/// 9.5 days old during a manoeuvre.
#[cfg(all(feature = "fits", unix))]
#[test]
fn valid_starlink_1102_is_identified_in_decam() {
    use streakcast::images::{FrameFile, PixelPosition, Wcs};
    let Some(data) = crate::common::data_dir() else { return };
    let frame = FrameFile::open(&data.join("frames/trailblazer/cutout_c4d_200306_000415_ori.fits.fz")).unwrap();
    let chip = frame.hdus().iter().find(|hdu| hdu.name == "S28").unwrap();
    let wcs = Wcs::from_header(frame.header(chip.index).unwrap()).unwrap();
    let ends =
        [PixelPosition { x: 0.0, y: 67.5 }, PixelPosition { x: 70.0, y: -3.0 }].map(|end| wcs.to_sky(end).unwrap());
    let start: Epoch = "2020-03-06T00:04:15.410235 UTC".parse().unwrap();
    // The error of each end is half a pixel of 0.26".
    let streak = MeasuredStreak::from_ends(ends, (start, 120.0), Timing::Within, arcsec(0.13), 0.5).unwrap();
    for file in ["supgp/starlink_supgp_2020-02-23.tle", "supgp/starlink_supgp_2020-02-25.tle"] {
        let sky = sky(&[&data.join("tle").join(file)], "W84", start);
        let found = identify(&sky, &streak);
        assert_eq!(name_of(&sky, &found, 0), "STARLINK-1102", "{file}");
        assert!(found.candidates[0].probability > 0.9, "{file}: {:?}", found.candidates[0]);
    }
}

/// Streaks made from predicted tracks, specified in all ways: the satellite of the track is the first candidate.
#[test]
fn verif_passes_identify_themselves() {
    let Some(data) = crate::common::data_dir() else { return };
    let night: Epoch = "2024-08-14T00:00:00 UTC".parse().unwrap();
    let sky = sky(&[&data.join("tle/active/active_2024-08-14.txt")], "X05", night);
    let field = Field::circle(3.5_f64.to_radians()).unwrap();
    let mut random = crate::common::random::Random(7);
    let mut crossings = 0;
    while crossings < 60 {
        // From dusk to dawn over Rubin Observatory, at altitudes above 20°.
        let exposure = Exposure {
            id: String::new(),
            start: seconds_after(night, random.between(-0.5, 10.5) * 3600.0),
            duration_s: 30.0,
            pointing: Direction::from_vector(random.direction()),
            rotation_rad: 0.0,
        };
        let orientation = sky.orientation_over(exposure.start, exposure.start).at_s(0.0);
        let altitude_rad = sky.viewpoint().pointing_altitude_rad(&exposure.pointing, exposure.start, &orientation);
        if altitude_rad.unwrap() < 20_f64.to_radians() {
            continue;
        }
        let passes = sky.field_passes(std::slice::from_ref(&exposure), &field, &PassOptions::default()).unwrap();
        for pass in &passes.by_exposure[0] {
            let [enter, mid, exit] = [&pass.enter, &pass.mid, &pass.exit];
            let length_rad = enter.direction.separation_rad(&exit.direction);
            // Excluded are short lines at a corner, the geostationary ring, whose satellites move together, and objects
            // that stay together (docked or in a pair).
            if length_rad < 0.1_f64.to_radians() || mid.range_km > 5_000.0 || has_companion(&sky, pass.element_index) {
                continue;
            }
            let ends = [enter.direction, exit.direction];
            let timed = (enter.epoch, seconds_between(enter.epoch, exit.epoch));
            let shutter = (exposure.start, exposure.duration_s);
            let angle = (pass.position_angle_rad, 0.2_f64.to_radians());
            let (place, clock_s) = (arcsec(5.0), 0.5);
            let forms = [
                MeasuredStreak::from_ends(ends, timed, Timing::FirstToSecond, place, clock_s),
                MeasuredStreak::from_ends([ends[1], ends[0]], shutter, Timing::Within, place, clock_s),
                MeasuredStreak::from_ends(ends, timed, Timing::Whole, place, clock_s),
                MeasuredStreak::from_middle(mid.direction, angle, None, shutter, Timing::Within, place, clock_s),
                MeasuredStreak::from_middle(
                    mid.direction,
                    angle,
                    Some(length_rad),
                    shutter,
                    Timing::Within,
                    place,
                    clock_s,
                ),
            ];
            for (form, streak) in forms.into_iter().enumerate() {
                let found = identify(&sky, &streak.unwrap());
                let first = &found.candidates[0];
                assert_eq!(first.norad_id, pass.norad_id, "form {form}: {pass:?} {first:?}");
                if form != 3 {
                    // At the predicted position. The time within the exposure is free except for the length of the
                    // streak.
                    let beside_arcsec = first.cross_track_rad.value.to_degrees() * 3600.0;
                    assert!(beside_arcsec.abs() < 30.0, "form {form}: {beside_arcsec} arcsec of {pass:?}");
                }
                if form == 0 {
                    // Ends and times are the predicted ones. The correction for non-uniform rates has errors of 0.01 s.
                    assert!(first.along_track_s.value.abs() < 0.05, "{first:?}");
                    assert!(first.chi_square < 1e-3, "{first:?}");
                }
            }
            crossings += 1;
        }
    }
}

/// Returns true if another object follows the same orbit within ten seconds.
fn has_companion(sky: &Sky, element_index: usize) -> bool {
    let own = &sky.elements()[element_index];
    let turn = |degrees: f64| (degrees + 180.0).rem_euclid(360.0) - 180.0;
    sky.elements().iter().enumerate().any(|(other_index, other)| {
        let days = seconds_between(other.epoch, own.epoch) / 86_400.0;
        let phase = |set: &streakcast::elements::ElementSet| set.mean_anomaly_deg + set.argument_of_perigee_deg;
        let ahead_deg = turn(phase(other) + 360.0 * other.mean_motion_rev_day * days - phase(own));
        other_index != element_index
            && (own.inclination_deg - other.inclination_deg).abs() < 0.05
            && turn(own.right_ascension_of_node_deg - other.right_ascension_of_node_deg).abs() < 0.5
            && (own.mean_motion_rev_day - other.mean_motion_rev_day).abs() < 0.01
            && ahead_deg.abs() < 1.0
    })
}

/// The fast search finds all candidates that `compare` accepts, as shown by a search over all delays of all satellites.
#[test]
fn verif_a_late_satellite_is_found_at_its_position() {
    let Some(data) = crate::common::data_dir() else { return };
    let night: Epoch = "2024-08-14T00:30:00 UTC".parse().unwrap();
    let sky = sky(&[&data.join("tle/active/active_2024-08-14.txt")], "X05", night);
    let exposure = Exposure {
        id: String::new(),
        start: night,
        duration_s: 20.0,
        pointing: Direction::from_lon_lat_rad(0.0, 0.0),
        rotation_rad: 0.0,
    };
    let interval = sky.exposure_interval(&exposure).unwrap();
    let mut random = crate::common::random::Random(11);
    let mut tried = 0;
    while tried < 150 {
        let element_index = (random.uniform() * sky.elements().len() as f64) as usize;
        let late_s = random.between(-20.0, 20.0);
        let Ok(track) = interval.track(element_index, late_s) else { continue };
        if !(track.is_up(0.0) && track.is_up(20.0)) || has_companion(&sky, element_index) {
            continue;
        }
        let ends: [Direction<Gcrs>; 2] = [track.direction(0.0).0, track.direction(20.0).0];
        // Above low orbits, the motion in 20 s may be too short for a line.
        if ends[0].separation_rad(&ends[1]) < arcsec(60.0) {
            continue;
        }
        // The clock error is as large as the delay; otherwise the delay would be incompatible with recent elements.
        let streak = MeasuredStreak::from_ends(ends, (night, 20.0), Timing::FirstToSecond, arcsec(2.0), 20.0).unwrap();
        let options = IdentifyOptions { include_dark: true, ..IdentifyOptions::default() };
        let found = identify_streak(&sky, &streak, &options).unwrap();
        let own = found.candidates.iter().find(|one| one.element_index == element_index);
        let set = &sky.elements()[element_index];
        let own = own.unwrap_or_else(|| panic!("{} e {} late {late_s} s", set.name, set.eccentricity));
        // The delay is recovered to the accuracy of the correction for non-uniform rates (sigma is at least 0.14 s).
        assert!((own.along_track_s.value - late_s).abs() < 0.05, "{}: {own:?} {late_s}", set.name);
        assert!(own.cross_track_rad.value.abs() < arcsec(1.0), "{}: {own:?}", set.name);
        tried += 1;
    }
}
