//! Telescopes in orbit: directions compared with Skyfield, candidate search compared with all pairs, and blocking by
//! the Earth.

use std::fmt::Write;
use std::sync::Arc;

use crate::common::agreement::Agreement;
use crate::common::random::Random;
use hifitime::{Epoch, TimeScale, Unit};
use streakcast::ErrorKind;
use streakcast::elements::{ElementSet, Ephemeris, NoradId, Origin, ReadOptions, Satellites};
use streakcast::forecast::{TrailRequest, trail_statistics};
use streakcast::frames::{Direction, EopTable, Gcrs, Orientation, OrientationTable, seconds_after, seconds_between};
use streakcast::geometry::{EarthLimb, PointingLimits, SunState, SunTable, aspect};
use streakcast::orbit::Propagator;
use streakcast::passes::{Exposure, Field, ModelChoice, OrbitingObserver, PassOptions, Sky, SnapshotOptions};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::schedule::{
    FlagRequest, Policy, ScheduledExposure, VerdictKind, WindowRequest, WindowTarget, clear_windows, flag_exposures,
};

fn active(data: &std::path::Path) -> Vec<ElementSet> {
    let path = data.join("tle/active/active_2026-04-25.txt");
    Satellites::read(&[path], &ReadOptions::default()).expect("the catalogue reads").element_sets
}

fn by_id(sets: &[ElementSet], id: u32) -> &ElementSet {
    sets.iter().find(|set| set.norad_id == NoradId(id)).expect("in the catalogue")
}

fn midnight() -> Epoch {
    Epoch::from_gregorian_utc_at_midnight(2026, 4, 26)
}

fn sky(elements: Vec<ElementSet>, observer: &ElementSet) -> Sky {
    let observer = OrbitingObserver::new(observer, EarthLimb::default()).expect("an orbit");
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    Sky::with_models(elements, observer, EopTable::embedded(), &choice)
}

/// Tolerance of directions, arcsec. Skyfield uses its own UT1, which only rotates TEME by 10⁻⁴ s, and Sun and Earth
/// from DE421 (0.01"); SGP4 is the same.
const DIRECTION_ARCSEC: f64 = 0.02;

#[test]
fn valid_directions_from_orbit_against_skyfield() {
    let Some(data) = crate::common::data_dir() else { return };
    let sets = active(&data);
    let (start, eop) = (midnight(), EopTable::embedded());
    let end = seconds_after(start, 86_400.0);
    let (orientation, sun) = (OrientationTable::new(start, end, &eop), SunTable::new(start, end));
    let mut rows = 0;
    let mut directions = Agreement::new("Directions from an orbit", "Skyfield 1.55", DIRECTION_ARCSEC, "arcsec");
    let mut ranges = Agreement::new("Ranges from an orbit", "Skyfield 1.55", 1e-3, "km");
    for line in include_str!("../data/space_observer_golden.csv").lines().filter(|line| !line.starts_with('#')).skip(1)
    {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let [observer, satellite, seconds, ra_deg, dec_deg, _, range_km, off_arcsec] = cells[..] else {
            panic!("{line}")
        };
        let state = |id: f64| {
            let propagator = Propagator::new(by_id(&sets, id as u32)).expect("an orbit");
            propagator.state(seconds_after(start, seconds), &orientation.at_s(seconds).teme_to_gcrs).expect("a state")
        };
        let (here, there) = (state(observer), state(satellite));
        let seen = aspect(&there.position, &there.velocity, &here.position, &sun.at_s(seconds).earth_velocity);
        let expected = Direction::<Gcrs>::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians());
        let arcsec = |angle: f64| angle.to_degrees() * 3600.0;
        directions.add(arcsec(seen.direction.separation_rad(&expected)));
        ranges.add(seen.range_km - range_km);
        // The effect is large enough: geometric directions differ by up to 25" in both programs.
        let plain = seen.geometric.direction().expect("apart").separation_rad(&expected);
        assert!((arcsec(plain) - off_arcsec).abs() < DIRECTION_ARCSEC, "{line}: {}", arcsec(plain));
        rows += 1;
    }
    assert_eq!(rows, 60);
}

/// Tolerance of the angles of pointings, degrees: light time and aberration of the Sun (20") are in Skyfield's
/// direction of the Sun and not in ours, and the limb is sampled at 20,000 points.
const ANGLE_DEG: f64 = 0.006;

#[test]
fn valid_angles_of_pointings_against_skyfield() {
    let Some(data) = crate::common::data_dir() else { return };
    let sets = active(&data);
    let (start, eop) = (midnight(), EopTable::embedded());
    let mut agreement = Agreement::new("Angles from zenith, Sun and limb", "Skyfield 1.55", ANGLE_DEG, "deg");
    let golden = include_str!("../data/pointing_angles_golden.csv");
    for line in golden.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let [telescope, seconds, ra_deg, dec_deg, zenith_deg, sun_deg, limb_deg] = cells[..] else { panic!("{line}") };
        let observer = OrbitingObserver::new(by_id(&sets, telescope as u32), EarthLimb::default()).expect("an orbit");
        let epoch = seconds_after(start, seconds);
        let pointing = Direction::<Gcrs>::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians());
        let (orientation, sun) = (Orientation::at(epoch, &eop), SunState::at(epoch).sun);
        let found = observer.pointing_angles(&pointing, epoch, &orientation, &sun).expect("a position");
        agreement.add(found.zenith_rad.to_degrees() - zenith_deg);
        agreement.add(found.sun_rad.to_degrees() - sun_deg);
        agreement.add(found.limb_rad.to_degrees() - limb_deg);
    }
}

/// The verdicts of exposures that break a limit are invalid, also if they do so only at closing; windows contain
/// exactly the starts of exposures that break none and that no satellite crosses.
#[test]
fn verif_limits_of_verdicts_and_windows() {
    let mut random = Random(19);
    let own = synthetic(600_000_000, &mut random, 15.09, 0.001);
    let limits = PointingLimits {
        max_zenith_angle_rad: Some(100f64.to_radians()),
        min_sun_angle_rad: Some(60f64.to_radians()),
        min_limb_angle_rad: Some(20f64.to_radians()),
    };
    let eop = EopTable::embedded();
    let observer = OrbitingObserver::new(&own, EarthLimb::default()).expect("an orbit").with_limits(limits);
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let sky = Sky::with_models(swarm(&mut random, 2000), observer.clone(), eop.clone(), &choice);
    let (field, policy, photometry) =
        (Field::circle(0.1).expect("a field"), Policy::default(), PhotometryOptions::default());
    let conditions =
        FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
    let (from, span_s, exposure_s) = (midnight(), 12_000.0, 100.0);
    let target = |pointing| WindowTarget {
        exposure: Exposure { id: String::new(), start: from, duration_s: exposure_s, pointing, rotation_rad: 0.0 },
        band: None,
    };
    let targets: Vec<WindowTarget> = (0..12).map(|_| target(Direction::from_vector(random.direction()))).collect();
    let request = WindowRequest { conditions, min_altitude_rad: 0.0, max_sun_altitude_rad: None };
    let to = seconds_after(from, span_s + exposure_s);
    let windows = clear_windows(&targets, from, to, &request).expect("windows").by_target;
    let (mut clear, mut crossed, mut broken) = (0, 0, 0);
    for (target, windows) in targets.iter().zip(&windows) {
        let rows: Vec<ScheduledExposure> = (0..100)
            .map(|_| seconds_after(from, random.between(0.0, span_s)))
            .map(|start| Exposure { start, ..target.exposure.clone() })
            .map(|exposure| ScheduledExposure {
                id: String::new(),
                row: 0,
                band: None,
                open_s: None,
                exposure: Ok(exposure),
            })
            .collect();
        let flags = flag_exposures(&rows.iter().collect::<Vec<_>>(), &conditions).expect("verdicts").flags;
        for (row, flag) in rows.iter().zip(flags) {
            let exposure = row.exposure.as_ref().expect("valid");
            let breaks = (0..=200).any(|step| {
                let epoch = seconds_after(exposure.start, exposure_s * f64::from(step) / 200.0);
                let (orientation, sun) = (Orientation::at(epoch, &eop), SunState::at(epoch).sun);
                let angles = observer.pointing_angles(&exposure.pointing, epoch, &orientation, &sun);
                limits.margin_rad(&angles.expect("a position")) < 0.0
            });
            let is_in_window =
                windows.windows.iter().any(|window| (window.first..=window.last).contains(&exposure.start));
            assert_eq!(flag.kind == VerdictKind::Invalid, breaks, "{flag:?}");
            if breaks {
                assert!(flag.reasons[0].contains("; allowed: ") || flag.reasons[0].contains("limb"), "{flag:?}");
            }
            let is_clear = flag.kind == VerdictKind::Clear;
            assert!(is_clear || !is_in_window, "{flag:?} {:?}", exposure.start);
            if is_clear && !is_in_window {
                // A satellite that is lit in a part of the field blocks also while it is in shadow.
                let dark = PassOptions { include_dark: true, without_light: true, ..PassOptions::default() };
                let found = sky.field_passes(std::slice::from_ref(exposure), &field, &dark).expect("passes");
                assert!(!found.by_exposure[0].is_empty(), "{flag:?} {:?}", exposure.start);
            }
            broken += usize::from(breaks);
            clear += usize::from(is_in_window);
            crossed += usize::from(flag.kind == VerdictKind::Streaked);
        }
    }
    assert!(clear > 50 && crossed > 20 && broken > 200, "{clear} {crossed} {broken}");
}

/// Trails in random exposures: the same as those of the passes of the same exposures; the exposures keep the limits.
#[test]
fn verif_trails_in_random_exposures() {
    let mut random = Random(23);
    let own = synthetic(600_000_000, &mut random, 15.09, 0.001);
    let limits = PointingLimits { max_zenith_angle_rad: Some(1.0), ..PointingLimits::default() };
    let observer = OrbitingObserver::new(&own, EarthLimb::default()).expect("an orbit").with_limits(limits);
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let sky = Sky::with_models(swarm(&mut random, 3000), observer, EopTable::embedded(), &choice);
    let field = Field::rectangle_deg(20.0, 10.0).expect("a field");
    let request = TrailRequest {
        start: midnight(),
        end: seconds_after(midnight(), 86_400.0),
        pointings: 200,
        seed: 5,
        exposure_s: 60.0,
        field: &field,
        limit_mag: Some(9.0),
        include_dark: true,
        photometry: PhotometryOptions::default(),
    };
    let found = trail_statistics(&sky, &request).expect("statistics");
    let options = PassOptions { include_dark: true, ..PassOptions::default() };
    let passes = sky.field_passes(&found.exposures, &field, &options).expect("passes").by_exposure;
    let [mean, share] = found.trails_and_share(1, None, false);
    let lit: Vec<usize> = passes.iter().map(|passes| passes.iter().filter(|pass| pass.lit).count()).collect();
    assert!((mean.mean - lit.iter().sum::<usize>() as f64 / 200.0).abs() < 1e-12 && mean.mean > 0.1, "{mean:?}");
    assert!((share.mean - lit.iter().filter(|count| **count > 0).count() as f64 / 200.0).abs() < 1e-12);
    let all = found.trails_and_share(1, None, true)[0].mean;
    assert!((all - passes.iter().map(Vec::len).sum::<usize>() as f64 / 200.0).abs() < 1e-12 && all > mean.mean);
    // The position angles are those of the passes, without a direction.
    for (trails, passes) in found.trails.iter().zip(&passes) {
        for (trail, pass) in trails.iter().zip(passes) {
            let apart = (trail.position_angle_rad - pass.position_angle_rad).rem_euclid(std::f64::consts::PI);
            assert!(apart.min(std::f64::consts::PI - apart) < 1e-9, "{trail:?}");
            assert!(trail.p_brighter == 0.0 || trail.lit);
        }
    }
    // Evenly over the cap of one radian: the mean of (1 - cos z) / (1 - cos 1) is a half, with an error of 0.29 / √200.
    let angles = found.exposures.iter().flat_map(|one| sky.pointing_angles(one).expect("angles"));
    let (mut sum, mut count) = (0.0, 0.0);
    for angles in angles {
        assert!(angles.zenith_rad <= 1.0, "{angles:?}");
        sum += (1.0 - angles.zenith_rad.cos()) / (1.0 - 1f64.cos());
        count += 1.0;
    }
    assert!((sum / count - 0.5).abs() < 0.08, "{}", sum / count);
    let none = PointingLimits { min_sun_angle_rad: Some(3.1), max_zenith_angle_rad: Some(0.001), ..limits };
    let narrow = OrbitingObserver::new(&own, EarthLimb::default()).expect("an orbit").with_limits(none);
    let error = trail_statistics(&sky.seen_from(narrow), &request).expect_err("no pointing");
    assert!(error.to_string().contains("the limits of the telescope allow 0 of"), "{error}");
}

fn synthetic(id: u32, random: &mut Random, revolutions_day: f64, eccentricity: f64) -> ElementSet {
    ElementSet {
        norad_id: NoradId(id),
        name: "".into(),
        international_designator: "".into(),
        epoch: midnight() - random.between(0.1, 4.0) * Unit::Day,
        mean_motion_rev_day: revolutions_day,
        eccentricity,
        inclination_deg: random.between(0.0, 120.0),
        right_ascension_of_node_deg: random.between(0.0, 360.0),
        argument_of_perigee_deg: random.between(0.0, 360.0),
        mean_anomaly_deg: random.between(0.0, 360.0),
        bstar_per_earth_radius: 1e-4,
        mean_motion_dot_rev_day2: 0.0,
        mean_motion_ddot_rev_day3: 0.0,
        revolution_at_epoch: 0,
        decayed: None,
        origin: Origin::Synthetic,
    }
}

/// Returns orbits near and far from those of the observers: in the same shells, above, below, eccentric,
/// geosynchronous.
fn swarm(random: &mut Random, count: usize) -> Vec<ElementSet> {
    (0..count)
        .map(|number| {
            let (revolutions_day, eccentricity) = match number % 10 {
                0..=3 => (random.between(14.9, 15.6), random.between(0.0, 0.003)),
                4..=6 => (random.between(12.0, 16.0), random.between(0.0, 0.005)),
                7 => (random.between(2.0, 12.0), random.between(0.0, 0.1)),
                8 => (random.between(2.0, 4.0), random.between(0.4, 0.65)),
                _ => (random.between(0.95, 1.05), random.between(0.0, 0.01)),
            };
            synthetic(700_000_000 + number as u32, random, revolutions_day, eccentricity)
        })
        .collect()
}

/// Largest relative speed of two objects in bound orbits, km/s.
const FASTEST_KM_S: f64 = 22.0;
/// Satellites that are inside a field for less than this time may be omitted, seconds.
const FINEST_S: f64 = 5e-4;

/// Returns true if a satellite is inside the field at any time. It is computed in time steps, which depend on how soon
/// the field can be reached, without candidate search, arcs or root finding.
fn is_inside(
    observer: &Propagator,
    satellite: &Propagator,
    exposure: &Exposure,
    radius_rad: f64,
    orientation: &OrientationTable,
    sun: &SunTable,
) -> bool {
    let mut time_s = 0.0;
    let minutes = |propagator: &Propagator| propagator.minutes_since_epoch(orientation.reference());
    let (observer_minutes, satellite_minutes) = (minutes(observer), minutes(satellite));
    let opened_s = seconds_between(orientation.reference(), exposure.start);
    let teme_to_gcrs = orientation.at_s(opened_s).teme_to_gcrs;
    let earth_velocity = sun.at_s(opened_s).earth_velocity;
    while time_s <= exposure.duration_s {
        let after = (opened_s + time_s) / 60.0;
        let (Ok(here), Ok(there)) = (
            observer.state_at_minutes(observer_minutes + after, &teme_to_gcrs),
            satellite.state_at_minutes(satellite_minutes + after, &teme_to_gcrs),
        ) else {
            return false;
        };
        let seen = aspect(&there.position, &there.velocity, &here.position, &earth_velocity);
        let angle_rad = seen.direction.separation_rad(&exposure.pointing);
        if angle_rad <= radius_rad {
            return EarthLimb::default().clearance_km(&here.position, &there.position) > 0.0;
        }
        // Squared distance from the edge of the cone.
        let gap_km = seen.range_km * (angle_rad - radius_rad).min(1.5).sin();
        time_s += (gap_km / FASTEST_KM_S).max(FINEST_S);
    }
    false
}

/// In 120 exposures of 1,000 satellites, all crossings are found, and none is false.
#[test]
fn verif_no_crossing_is_lost_from_orbit() {
    let mut random = Random(7);
    let start = midnight();
    let eop = EopTable::embedded();
    let end = seconds_after(start, 6.0 * 3600.0);
    let (orientation, sun) = (OrientationTable::new(start, end, &eop), SunTable::new(start, end));
    let satellites = swarm(&mut random, 1000);
    let propagators: Vec<Propagator> = satellites.iter().map(|set| Propagator::new(set).expect("an orbit")).collect();
    let (mut pairs, mut crossings, mut near) = (0, 0, 0);
    // Low circular orbit, sun-synchronous height, transfer orbit, geosynchronous orbit.
    for (revolutions_day, eccentricity) in [(15.3, 0.0002), (14.2, 0.001), (2.3, 0.72), (1.0027, 0.0003)] {
        let own = synthetic(600_000_000, &mut random, revolutions_day, eccentricity);
        let observer = Propagator::new(&own).expect("an orbit");
        let sky = sky(satellites.clone(), &own);
        for number in 0..30 {
            let diameter_deg = [0.05, 1.0, 10.0, 40.0][number % 4];
            let field = Field::circle(f64::to_radians(diameter_deg)).expect("a field");
            let exposure = Exposure {
                id: number.to_string(),
                start: seconds_after(start, random.between(0.0, 5.0 * 3600.0)),
                duration_s: [0.0, 20.0, 120.0, 660.0][(number / 4) % 4],
                pointing: Direction::from_lon_lat_rad(
                    random.between(0.0, std::f64::consts::TAU),
                    random.between(-1.0, 1.0).asin(),
                ),
                rotation_rad: 0.0,
            };
            let options = PassOptions { include_dark: true, ..PassOptions::default() };
            let passes = sky.field_passes(std::slice::from_ref(&exposure), &field, &options).expect("passes");
            let found: Vec<usize> = passes.by_exposure[0].iter().map(|pass| pass.element_index).collect();
            for (element_index, propagator) in propagators.iter().enumerate() {
                let radius_rad = 0.5 * f64::to_radians(diameter_deg);
                let inside = is_inside(&observer, propagator, &exposure, radius_rad, &orientation, &sun);
                let is_reported = found.contains(&element_index);
                assert!(!inside || is_reported, "{revolutions_day} {exposure:?}: {element_index} was lost");
                if is_reported && !inside {
                    // The satellite may be inside for less than a step, or behind the Earth at entry.
                    let pass = passes.by_exposure[0].iter().find(|pass| pass.element_index == element_index);
                    let pass = pass.expect("a reported pass");
                    let stay_s: f64 = pass.chords.iter().map(|chord| chord.exit_s - chord.enter_s).sum();
                    let cut = pass.chords.iter().any(|chord| chord.enter_s > 0.0);
                    assert!(stay_s < 2.0 * FINEST_S || cut, "{exposure:?}: {pass:?}");
                    near += 1;
                }
                pairs += 1;
                crossings += usize::from(inside);
            }
            // Every reported crossing is above the Earth's limb, and has no altitude above a horizon.
            for pass in &passes.by_exposure[0] {
                assert!(pass.mid.altitude_rad.is_none() && pass.mid.azimuth_rad.is_none());
                assert!(pass.mid.range_km > 0.0 && pass.angular_rate_rad_s.is_finite());
            }
        }
    }
    println!("{pairs} pairs, {crossings} crossings, {near} cut by the limb");
    assert!(pairs >= 100_000 && crossings > 400, "{pairs} {crossings}");
    assert!(near * 10 < crossings, "{near} of {crossings}");
}

#[test]
fn verif_close_encounters_are_found_and_the_observer_is_excluded() {
    let mut random = Random(3);
    let own = synthetic(600_000_000, &mut random, 15.3, 0.0002);
    // The same orbit in the opposite direction: the satellite approaches at 15 km/s and passes at a few kilometres.
    let mut other = own.clone();
    other.norad_id = NoradId(600_000_001);
    other.inclination_deg = 180.0 - own.inclination_deg + 0.1;
    other.right_ascension_of_node_deg = (own.right_ascension_of_node_deg + 180.0).rem_euclid(360.0);
    let sky = sky(vec![own.clone(), other.clone()], &own);
    let (a, b) = (Propagator::new(&own).expect("an orbit"), Propagator::new(&other).expect("an orbit"));
    let start = midnight();
    let orientation = OrientationTable::new(start, seconds_after(start, 7200.0), &EopTable::embedded());
    let apart = |seconds: f64| {
        let state = |p: &Propagator| {
            p.state(seconds_after(start, seconds), &orientation.at_s(seconds).teme_to_gcrs).expect("a state").position
        };
        state(&b) - state(&a)
    };
    let nearest_of = |from: f64, step_s: f64, count: u32| {
        (0..count)
            .map(|step| from + f64::from(step) * step_s)
            .min_by(|s, t| apart(*s).norm_km().total_cmp(&apart(*t).norm_km()))
            .expect("some")
    };
    let nearest = nearest_of(nearest_of(0.0, 1.0, 7000) - 1.0, 1e-3, 2000);
    let miss_km = apart(nearest).norm_km();
    assert!((0.5..60.0).contains(&miss_km), "{miss_km}");
    // Field in the direction at closest approach, exposed for two minutes around it.
    let pointing = apart(nearest).direction().expect("apart");
    let exposure = Exposure {
        id: "1".into(),
        start: seconds_after(start, nearest - 63.0),
        duration_s: 120.0,
        pointing,
        rotation_rad: 0.0,
    };
    let field = Field::circle(2f64.to_radians()).expect("a field");
    let options = PassOptions { include_dark: true, min_probability: Some(0.01), ..PassOptions::default() };
    let passes = sky.field_passes(&[exposure], &field, &options).expect("passes");
    let pass = match &passes.by_exposure[0][..] {
        [pass] => pass,
        others => panic!("{others:?}"),
    };
    assert_eq!(pass.norad_id, NoradId(600_000_001));
    // 15 km/s at this range.
    let rate = pass.angular_rate_rad_s * pass.mid.range_km;
    println!("passes at {miss_km:.1} km, {:.1} deg/s", pass.angular_rate_rad_s.to_degrees());
    assert!(pass.is_crossing() && (10.0..16.0).contains(&rate), "{rate}");
    assert!((0.0..=1.0).contains(&pass.probability));
}

#[test]
fn the_earth_blocks_and_requests_with_a_horizon_are_rejected() {
    let mut random = Random(5);
    let own = synthetic(600_000_000, &mut random, 12.5, 0.0002);
    let sky = sky(swarm(&mut random, 3000), &own);
    let start = midnight();
    let orientation = OrientationTable::new(start, seconds_after(start, 60.0), &EopTable::embedded());
    let place = Propagator::new(&own)
        .and_then(|propagator| propagator.state(start, &orientation.at_s(0.0).teme_to_gcrs))
        .expect("a state");
    let up = place.position.direction().expect("in orbit");
    let down = Direction::from_vector(-up.vector());
    let seen = |pointing| {
        let exposure = Exposure { id: "1".into(), start, duration_s: 10.0, pointing, rotation_rad: 0.0 };
        let field = Field::circle(100f64.to_radians()).expect("a field");
        let options = PassOptions { include_dark: true, ..PassOptions::default() };
        sky.field_passes(&[exposure], &field, &options).expect("passes").by_exposure.swap_remove(0)
    };
    // Downwards, only satellites between the telescope and the ground are visible; upwards, all up to geosynchronous
    // orbits.
    let below = seen(down);
    assert!(!below.is_empty() && below.iter().all(|pass| pass.mid.range_km < 4800.0), "{}", below.len());
    assert!(seen(up).iter().any(|pass| pass.mid.range_km > 20_000.0));
    let refused = sky.snapshots(start, &[0.0], &SnapshotOptions::all_above(0.0));
    assert!(refused.is_err_and(|error| error.to_string().contains("has no horizon")));
    // A decayed telescope is an error, and not an empty sky.
    let mut fallen = own.clone();
    fallen.mean_motion_rev_day = 16.6;
    fallen.bstar_per_earth_radius = 0.1;
    fallen.epoch = (start - 20.0 * Unit::Day).to_time_scale(TimeScale::UTC);
    let lost = self::sky(vec![own], &fallen);
    let exposure = Exposure { id: "1".into(), start, duration_s: 10.0, pointing: up, rotation_rad: 0.0 };
    let field = Field::circle(0.1).expect("a field");
    assert!(
        lost.field_passes(&[exposure], &field, &PassOptions::default())
            .is_err_and(|error| error.to_string().contains("cannot compute the position of observer"))
    );
}

/// Returns an OEM in TEME with the positions of an element set at every `step_s`, rounded to a millimetre.
fn oem(elements: &ElementSet, start: Epoch, step_s: f64, states: usize) -> Vec<Arc<Ephemeris>> {
    let stamp = |epoch: Epoch| streakcast::output::format_utc(epoch, 3).trim_end_matches('Z').to_owned();
    let at = |number: usize| seconds_after(start, step_s * number as f64);
    let mut text = format!(
        "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-04-26T00:00:00\nORIGINATOR = TEST\nMETA_START\nOBJECT_NAME = \
         TELESCOPE\nOBJECT_ID = {}\nCENTER_NAME = EARTH\nREF_FRAME = TEME\nTIME_SYSTEM = UTC\nSTART_TIME = {}\nSTOP_TIME \
         = {}\nMETA_STOP\n",
        elements.norad_id,
        stamp(at(0)),
        stamp(at(states - 1))
    );
    let propagator = Propagator::new(elements).expect("an orbit");
    for number in 0..states {
        let epoch = at(number);
        let ([x, y, z], [u, v, w]) =
            propagator.teme_state_at_minutes(propagator.minutes_since_epoch(epoch)).expect("a state");
        writeln!(text, "{} {x:.6} {y:.6} {z:.6} {u:.9} {v:.9} {w:.9}", stamp(epoch)).expect("a text");
    }
    let read = Satellites::from_bytes("telescope.oem", text.as_bytes(), &ReadOptions::default());
    read.expect("an ephemeris").ephemerides
}

fn seen_from(elements: Vec<ElementSet>, ephemerides: &[Arc<Ephemeris>]) -> Sky {
    let eop = EopTable::embedded();
    let observer = OrbitingObserver::from_ephemerides(ephemerides, &eop, EarthLimb::default()).expect("ephemerides");
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    Sky::with_models(elements, observer, eop, &choice)
}

/// Largest error of the interpolation between the states, km.
const INTERPOLATION_KM: f64 = 1e-5;
/// Largest differences of the crossings: seconds and arcsec. A relative speed of 15 km/s moves a satellite by 0.15 m in
/// 10 us; at 100 km this is 0.3 arcsec, and the nearest satellites of the test are farther away.
const CROSSING_S: f64 = 1e-4;
const CROSSING_ARCSEC: f64 = 0.05;

/// Crossings seen from an ephemeris with a state every 60 s are those seen from the element set from which it was made.
#[test]
fn verif_crossings_from_an_ephemeris_equal_those_from_its_element_set() {
    let mut random = Random(11);
    let own = synthetic(600_000_000, &mut random, 15.09, 0.001);
    let (satellites, start) = (swarm(&mut random, 3000), midnight());
    let states = oem(&own, start, 60.0, 182);
    let (of_set, of_states) = (sky(satellites.clone(), &own), seen_from(satellites, &states));
    let observers = [&of_set, &of_states].map(|sky| sky.viewpoint().orbit().expect("in orbit").clone());
    for number in 0..500 {
        let epoch = seconds_after(start, f64::from(number) * 21.7);
        let orientation = Orientation::at(epoch, &EopTable::embedded());
        let [expected, found] = observers.each_ref().map(|one| one.position(epoch, &orientation).expect("a position"));
        assert!((found - expected).norm_km() < INTERPOLATION_KM, "{epoch}: {} km", (found - expected).norm_km());
    }
    let field = Field::circle(20f64.to_radians()).expect("a field");
    let mut exposures: Vec<Exposure> = (0..30)
        .map(|number| Exposure {
            id: number.to_string(),
            start: seconds_after(start, random.between(0.0, 10_000.0)),
            duration_s: 112.5,
            pointing: Direction::from_lon_lat_rad(
                random.between(0.0, std::f64::consts::TAU),
                random.between(-1.0, 1.0).asin(),
            ),
            rotation_rad: 0.0,
        })
        .collect();
    // The first and the last exposure that are possible.
    exposures[0].start = start;
    exposures[1].start = seconds_after(start, 181.0 * 60.0 - 112.5);
    let options = PassOptions { include_dark: true, min_probability: Some(0.05), ..PassOptions::default() };
    let [expected, found] =
        [&of_set, &of_states].map(|sky| sky.field_passes(&exposures, &field, &options).expect("passes").by_exposure);
    let mut compared = 0;
    for (expected, found) in expected.iter().flatten().zip(found.iter().flatten()) {
        assert_eq!(expected.norad_id, found.norad_id);
        assert!(seconds_between(expected.enter.epoch, found.enter.epoch).abs() < CROSSING_S, "{expected:?} {found:?}");
        let apart_rad = expected.mid.direction.separation_rad(&found.mid.direction);
        assert!(apart_rad.to_degrees() * 3600.0 < CROSSING_ARCSEC, "{expected:?} {found:?}");
        compared += 1;
    }
    assert_eq!(expected.iter().map(Vec::len).collect::<Vec<_>>(), found.iter().map(Vec::len).collect::<Vec<_>>());
    assert!(compared > 100, "{compared}");
}

/// Exposures that no ephemeris covers as a whole are invalid; starts are searched only where the position is known.
#[test]
fn exposures_outside_the_ephemerides_of_the_telescope_are_invalid() {
    let mut random = Random(13);
    let own = synthetic(600_000_000, &mut random, 15.09, 0.001);
    let start = midnight();
    // Two ephemerides with a gap from 30 to 40 min, and one state missing in the second.
    let mut all = oem(&own, start, 60.0, 31);
    let mut second = (*oem(&own, seconds_after(start, 2400.0), 60.0, 41)[0]).clone();
    second.states.drain(20..28);
    all.push(Arc::new(second));
    let sky = seen_from(swarm(&mut random, 2000), &all);
    let zenith = |after_s: f64| {
        let epoch = seconds_after(start, after_s);
        let orientation = Orientation::at(epoch, &EopTable::embedded());
        let state = Propagator::new(&own).and_then(|one| one.state(epoch, &orientation.teme_to_gcrs));
        state.expect("a state").position.direction().expect("in orbit")
    };
    let rows: Vec<ScheduledExposure> = [
        (-1.0, false),
        (0.0, true),
        (1750.0, true),
        (1751.0, false),
        (2000.0, false),
        (2390.0, false),
        (2400.0, true),
        (3490.0, true),
        (3600.0, false),
        (4020.0, false),
        (4080.0, true),
        (4750.0, true),
        (4760.0, false),
        (86_400.0, false),
    ]
    .into_iter()
    .map(|(after_s, is_known)| {
        let exposure = Exposure {
            id: is_known.to_string(),
            start: seconds_after(start, after_s),
            duration_s: 50.0,
            pointing: zenith(after_s),
            rotation_rad: 0.0,
        };
        ScheduledExposure { id: exposure.id.clone(), row: 0, band: None, open_s: None, exposure: Ok(exposure) }
    })
    .collect();
    let field = Field::circle(30f64.to_radians()).expect("a field");
    let photometry = PhotometryOptions::default();
    for max_delay_s in [None, Some(1800.0)] {
        let policy = Policy { max_delay_s, margin_s: Some(5.0), ..Policy::default() };
        let request =
            FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
        let report = flag_exposures(&rows.iter().collect::<Vec<_>>(), &request).expect("verdicts");
        for verdict in &report.flags {
            assert_eq!(verdict.kind != VerdictKind::Invalid, verdict.exposure_id == "true", "{verdict:?}");
            if verdict.kind == VerdictKind::Invalid {
                let reason = verdict.reasons[0].strip_prefix("no ephemeris of TELESCOPE covers the whole exposure");
                let gap = reason.expect("the ephemeris");
                assert!(gap.is_empty() || gap.contains("states 540 s apart; allowed: "), "{verdict:?}");
            }
        }
    }
}

/// A wrong position in the ephemeris of the telescope makes the times around it unknown.
#[test]
fn no_position_is_interpolated_from_a_wrong_state() {
    let mut random = Random(17);
    let own = synthetic(600_000_000, &mut random, 15.09, 0.001);
    let start = midnight();
    // The state after 1200 s.
    for (error_km, is_wrong) in [(0.0, false), (0.05, false), (0.5, true), (5.0, true), (300.0, true)] {
        let mut ephemeris = (*oem(&own, start, 60.0, 41)[0]).clone();
        ephemeris.states[20].position_km[1] += error_km;
        let sky = seen_from(swarm(&mut random, 20), &[Arc::new(ephemeris)]);
        for (after_s, is_near) in [(300.0, false), (1100.0, true), (1190.0, true), (1300.0, true), (2000.0, false)] {
            let exposure = Exposure {
                id: String::new(),
                start: seconds_after(start, after_s),
                duration_s: 30.0,
                pointing: Direction::from_lon_lat_rad(1.0, 0.5),
                rotation_rad: 0.0,
            };
            let field = Field::circle(0.1).expect("a field");
            let found = sky.field_passes(&[exposure], &field, &PassOptions::default());
            let is_unknown = found.is_err_and(|error| error.kind() == ErrorKind::NoPosition);
            assert_eq!(is_unknown, is_wrong && is_near, "{error_km} km, after {after_s} s");
        }
    }
}

/// The telescope is recognised by its orbit, whatever the number of its ephemeris or element set is: it does not cross
/// its own field, and a satellite that has its number is searched.
#[test]
fn the_telescope_is_recognised_by_its_orbit() {
    let (mut random, start) = (Random(19), midnight());
    let own = synthetic(600_000_000, &mut random, 15.09, 0.001);
    let catalogued = ElementSet { origin: Origin::Published, norad_id: NoradId(20_580), ..own.clone() };
    let other = ElementSet {
        origin: Origin::Published,
        norad_id: NoradId(25_544),
        mean_anomaly_deg: (own.mean_anomaly_deg + 120.0) % 360.0,
        ..own.clone()
    };
    // A neighbour at 42 km in the same orbit, such as one of a train.
    let near = ElementSet {
        norad_id: NoradId(30_000),
        mean_anomaly_deg: (own.mean_anomaly_deg + 0.35) % 360.0,
        ..catalogued.clone()
    };
    let end = seconds_after(start, 1800.0);
    let numbered = |number: u32| oem(&ElementSet { norad_id: NoradId(number), ..own.clone() }, start, 60.0, 61);
    let all = || vec![catalogued.clone(), other.clone(), near.clone()];
    let field = Field::circle(179f64.to_radians()).expect("a field");
    let crossing = |sky: &Sky| {
        let exposure = Exposure {
            id: "1".into(),
            start: seconds_after(start, 600.0),
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(0.0, 0.0),
            rotation_rad: 0.0,
        };
        let opposite =
            Exposure { pointing: Direction::from_lon_lat_rad(std::f64::consts::PI, 0.0), ..exposure.clone() };
        let options = PassOptions { include_dark: true, ..PassOptions::default() };
        let passes = sky.field_passes(&[exposure, opposite], &field, &options).expect("passes").by_exposure;
        let mut ids: Vec<u32> = passes.concat().iter().map(|pass| pass.norad_id.0).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    };
    // The number of another satellite: before, the telescope crossed its field, and the other satellite was left out.
    let (sky, found) = seen_from(all(), &numbered(25_544)).recognising_observer(start, end);
    assert_eq!(found.by_orbit, [0]);
    let (index, km) = found.other_orbit.expect("another orbit");
    assert!(index == 1 && (9_000.0..14_000.0).contains(&km), "{km}");
    assert!(!crossing(&sky).contains(&20_580) && crossing(&sky).contains(&30_000), "{:?}", crossing(&sky));
    assert!(crossing(&seen_from(all(), &numbered(25_544))).contains(&20_580));
    // A number that no satellite has, and the right one.
    let (sky, found) = seen_from(all(), &numbered(99_999)).recognising_observer(start, end);
    assert_eq!((found.by_orbit, found.other_orbit), (vec![0], None));
    assert!(!crossing(&sky).contains(&20_580));
    let (_, found) = seen_from(all(), &numbered(20_580)).recognising_observer(start, end);
    assert_eq!((found.by_orbit, found.other_orbit), (vec![], None));
    // An element set of the telescope with another number; two docked spacecraft.
    let docked = ElementSet { norad_id: NoradId(40_000), ..catalogued.clone() };
    let (sky, found) = self::sky(vec![catalogued.clone(), docked, near.clone()], &own).recognising_observer(start, end);
    assert_eq!(found.by_orbit, [0, 1]);
    assert_eq!(crossing(&sky), [30_000]);
    // Nothing is recognised if the ephemeris has no positions in the request.
    let later = seconds_after(start, 86_400.0);
    let (_, found) = seen_from(all(), &numbered(25_544)).recognising_observer(later, seconds_after(later, 60.0));
    assert_eq!((found.by_orbit, found.other_orbit), (vec![], None));
}
