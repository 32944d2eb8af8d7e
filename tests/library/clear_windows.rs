//! Clear windows: exposures that start inside are clear, and those that start between two windows are not.

use hifitime::Epoch;
use streakcast::elements::Constellation;
use streakcast::frames::{Direction, EopTable, seconds_after, seconds_between};
use streakcast::geometry::{EarthLimb, Observer, Site};
use streakcast::passes::{Exposure, Field, ModelChoice, OrbitingObserver, Pass, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::schedule::{
    Blocking, ClearWindow, FlagRequest, MagnitudeLimit, Policy, ScheduledExposure, VerdictKind, WindowRequest,
    WindowTarget, clear_windows, clear_windows_without_passes, flag_exposures, lowest_altitude_rad,
};

const EXPOSURE_S: f64 = 30.0;
const MARGIN_S: f64 = 2.0;
const SPAN_S: f64 = 3600.0;
/// Time beyond the end of a window at which the verdict must differ, seconds. Ends have an error of 1 ms and a guard of
/// 2 ms.
const TURN_S: f64 = 0.01;

fn dusk() -> Epoch {
    Epoch::from_gregorian_utc_hms(2026, 8, 14, 23, 20, 0)
}

fn sky() -> Sky {
    let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let elements = Constellation::by_name("starlink-gen1").expect("shells").element_sets(dusk());
    Sky::with_models(elements, Observer::new(site), EopTable::embedded(), &choice)
}

fn exposure(start: Epoch, duration_s: f64, number: usize) -> Exposure {
    let (ra_deg, dec_deg) = (185.0 + 7.0 * number as f64, -50.0 + 12.0 * number as f64);
    let pointing = Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians());
    Exposure { id: number.to_string(), start, duration_s, pointing, rotation_rad: 0.0 }
}

/// Returns the verdicts of exposures of one target; starts are seconds after dusk.
fn verdicts(starts_s: &[f64], number: usize, request: &FlagRequest<'_>) -> Vec<VerdictKind> {
    let rows: Vec<ScheduledExposure> = starts_s
        .iter()
        .enumerate()
        .map(|(row, start_s)| ScheduledExposure {
            id: row.to_string(),
            row,
            band: None,
            open_s: None,
            exposure: Ok(exposure(seconds_after(dusk(), *start_s), EXPOSURE_S, number)),
        })
        .collect();
    let report = flag_exposures(&rows.iter().collect::<Vec<_>>(), request).expect("flags");
    report.flags.iter().map(|flag| flag.kind).collect()
}

/// Returns the windows of four targets within an hour after dusk, including the exposures.
fn windows(min_altitude_rad: f64, conditions: &FlagRequest<'_>) -> Vec<Vec<ClearWindow>> {
    let target = |number| WindowTarget { exposure: exposure(dusk(), EXPOSURE_S, number), band: None };
    let targets: Vec<WindowTarget> = (0..4).map(target).collect();
    let request = WindowRequest { conditions: *conditions, min_altitude_rad, max_sun_altitude_rad: None };
    let report = clear_windows(&targets, dusk(), seconds_after(dusk(), SPAN_S), &request);
    let by_target = report.expect("windows").by_target;
    let blocked = by_target.iter().any(|one| !one.blocking_passes.is_empty());
    assert_eq!(blocked, by_target.iter().any(|one| !one.observable.is_empty()));
    let alone = clear_windows_without_passes(&targets, dusk(), seconds_after(dusk(), SPAN_S), &request);
    for (alone, one) in alone.expect("windows").by_target.iter().zip(&by_target) {
        assert_eq!(
            (&alone.windows, &alone.observable, alone.blocking_passes.len()),
            (&one.windows, &one.observable, 0)
        );
    }
    by_target.into_iter().map(|one| one.windows).collect()
}

fn ends_s(window: &ClearWindow) -> (f64, f64) {
    (seconds_between(dusk(), window.first), seconds_between(dusk(), window.last))
}

#[test]
fn verif_starts_within_are_clear_and_between_are_not() {
    let (sky, field) = (sky(), Field::circle(3.5f64.to_radians()).expect("a field"));
    let photometry = PhotometryOptions::default();
    let bright = Policy { limit_mag: Some(MagnitudeLimit::All(6.9)), ..Policy::default() };
    let patient =
        Policy { blocking: Blocking::Any, margin_s: Some(MARGIN_S), max_delay_s: Some(0.0), ..Policy::default() };
    for policy in [&patient, &bright] {
        let blocking = policy.blocking;
        let request = FlagRequest { sky: &sky, field: &field, policy, telescope: None, photometry: &photometry };
        let is_good = |verdict: &VerdictKind| match blocking {
            Blocking::Any => *verdict == VerdictKind::Clear,
            Blocking::Avoid => matches!(verdict, VerdictKind::Clear | VerdictKind::Streaked),
        };
        let answer = windows(0.0, &request);
        let (mut inside, mut outside) = (0, 0);
        for (number, windows) in answer.iter().enumerate() {
            assert!(!windows.is_empty(), "target {number}");
            let within: Vec<f64> = windows
                .iter()
                .map(ends_s)
                .flat_map(|(first_s, last_s)| [first_s, 0.5 * (first_s + last_s), last_s])
                .collect();
            let found = verdicts(&within, number, &request);
            assert!(found.iter().all(is_good), "{blocking:?}, target {number}: {within:?} {found:?}");
            let between: Vec<f64> = windows
                .windows(2)
                .map(|pair| (ends_s(&pair[0]).1, ends_s(&pair[1]).0))
                .flat_map(|(last_s, next_s)| match blocking {
                    Blocking::Any => vec![last_s + TURN_S, 0.5 * (last_s + next_s), next_s - TURN_S],
                    // A satellite that just touches the field crosses with a probability of one half, so that the
                    // probability of crossing and being brighter is below one half, although the window excludes it.
                    // The middle between two windows is used.
                    Blocking::Avoid => vec![0.5 * (last_s + next_s)],
                })
                .collect();
            let found = verdicts(&between, number, &request);
            assert!(!found.iter().any(is_good), "{blocking:?}, target {number}: {between:?} {found:?}");
            (inside, outside) = (inside + within.len(), outside + between.len());
        }
        assert!(inside > 30 && outside > 10, "{blocking:?}: {inside} inside, {outside} between");
    }
}

#[test]
fn windows_end_at_the_minimum_altitude() {
    let (sky, field) = (sky(), Field::circle(3.5f64.to_radians()).expect("a field"));
    let (photometry, policy) = (PhotometryOptions::default(), Policy::default());
    let request = FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
    let eop = EopTable::embedded();
    let altitude_rad = |exposure: &Exposure| lowest_altitude_rad(exposure, sky.viewpoint(), &eop);
    // The limit is the altitude of the second target in the middle of the time range, so that it rises or sets there.
    let limit_rad = altitude_rad(&exposure(seconds_after(dusk(), 0.5 * SPAN_S), 0.0, 1));
    let answer = windows(limit_rad, &request);
    let starts: Vec<f64> = answer[1].iter().map(ends_s).flat_map(|(first_s, last_s)| [first_s, last_s]).collect();
    assert!(!starts.is_empty());
    for start_s in &starts {
        let at_start_rad = altitude_rad(&exposure(seconds_after(dusk(), *start_s), EXPOSURE_S, 1));
        // The tolerance is the rotation of the sky in 0.01 s.
        assert!(at_start_rad > limit_rad - 1e-6, "{start_s} s: {} below", limit_rad - at_start_rad);
    }
    let all = windows(0.0, &request);
    let length_s = |windows: &[ClearWindow]| windows.iter().map(ends_s).map(|(first, last)| last - first).sum::<f64>();
    assert!(length_s(&answer[1]) < 0.7 * length_s(&all[1]));
    // With a limit above the altitude of all targets there are no windows.
    let none = windows(1.57, &request);
    assert!(none.iter().all(Vec::is_empty));
}

/// Windows of several nights are those of each, and only passes while a target is observable block it.
#[test]
fn windows_of_several_nights() {
    const DAY_S: f64 = 86_400.0;
    let (sky, field) = (sky(), Field::circle(3.5f64.to_radians()).expect("a field"));
    let photometry = PhotometryOptions::default();
    let policy = Policy { min_probability: Some(0.1), margin_s: Some(5.0), ..Policy::default() };
    let conditions =
        FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
    let (min_altitude_rad, max_sun_altitude_rad) = (30f64.to_radians(), Some(-6f64.to_radians()));
    let request = WindowRequest { conditions, min_altitude_rad, max_sun_altitude_rad };
    let noon = seconds_after(dusk(), -0.25 * DAY_S);
    let over = |first: f64, last: f64| {
        let pointing = Direction::from_lon_lat_rad(300f64.to_radians(), -30f64.to_radians());
        let target = WindowTarget { exposure: Exposure { pointing, ..exposure(noon, EXPOSURE_S, 0) }, band: None };
        let [from, to] = [first, last].map(|days| seconds_after(noon, days * DAY_S));
        clear_windows(&[target], from, to, &request).expect("windows").by_target.remove(0)
    };
    let all = over(0.0, 3.0);
    let each: Vec<_> = [0.0, 1.0, 2.0].map(|day| over(day, day + 1.0)).into();
    let windows: Vec<_> = each.iter().flat_map(|night| night.windows.clone()).collect();
    assert!(windows.len() > 10, "{} windows", windows.len());
    assert_eq!(all.windows.len(), windows.len());
    for (one, other) in all.windows.iter().zip(&windows) {
        for (one, other) in [(one.first, other.first), (one.last, other.last)] {
            assert!(seconds_between(one, other).abs() < 0.0015, "{one} {other}");
        }
    }
    assert_eq!(all.blocking_passes.len(), each.iter().map(|night| night.blocking_passes.len()).sum::<usize>());
    let is_observable = |pass: &Pass| {
        // The margin, and three sigmas for satellites that are late or early.
        let beyond_s = 5.0 + 3.0 * pass.along_track_sigma_s;
        let [enter, exit] = [(&pass.enter, -beyond_s), (&pass.exit, beyond_s)]
            .map(|(point, seconds)| seconds_after(point.epoch, seconds));
        all.observable.iter().any(|one| exit >= one.first && enter <= seconds_after(one.last, EXPOSURE_S))
    };
    assert!(all.blocking_passes.iter().all(is_observable));
}

#[test]
fn windows_from_an_orbit_end_at_the_limb() {
    let elements = Constellation::by_name("starlink-gen1").expect("shells").element_sets(dusk());
    let observer = OrbitingObserver::new(&elements[0], EarthLimb::default()).expect("an orbit");
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let (sky, eop) = (Sky::with_models(elements, observer, EopTable::embedded(), &choice), EopTable::embedded());
    let field = Field::circle(0.5f64.to_radians()).expect("a field");
    let (photometry, policy) = (PhotometryOptions::default(), Policy::default());
    let conditions =
        FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
    // The time range is two thirds of an orbit, in which every target that the Earth can block rises or sets.
    let target = WindowTarget { exposure: exposure(dusk(), EXPOSURE_S, 1), band: None };
    let windows_with = |max_sun_altitude_rad| {
        let request = WindowRequest { conditions, min_altitude_rad: 0.0, max_sun_altitude_rad };
        clear_windows(std::slice::from_ref(&target), dusk(), seconds_after(dusk(), SPAN_S + EXPOSURE_S), &request)
    };
    let lowest_rad = |start: Epoch| lowest_altitude_rad(&exposure(start, EXPOSURE_S, 1), sky.viewpoint(), &eop);
    let found = windows_with(None).expect("windows").by_target.remove(0);
    let (first, last) = (dusk(), seconds_after(dusk(), SPAN_S));
    let ends: Vec<Epoch> = found.observable.iter().flat_map(|window| [window.first, window.last]).collect();
    assert!(!ends.is_empty() && ends.iter().any(|end| *end != first && *end != last), "{ends:?}");
    for window in &found.observable {
        assert!(lowest_rad(window.first) >= -1e-5 && lowest_rad(window.last) >= -1e-5, "{window:?}");
        // One second outside the window, the Earth blocks the target.
        for beyond in [seconds_after(window.first, -1.0), seconds_after(window.last, 1.0)] {
            assert!(beyond < first || beyond > last || lowest_rad(beyond) < 0.0, "{window:?}");
        }
    }
    assert!(windows_with(Some(-0.2)).is_err_and(|error| error.to_string().contains("has no horizon")));
}

/// The next starts of verdicts and the windows follow one definition: the first window of an exposure begins at the
/// next acceptable start for `avoid`, and at the next clear start for `any`.
#[test]
fn verif_windows_begin_at_the_next_starts_of_verdicts() {
    let (sky, field) = (sky(), Field::circle(3.5f64.to_radians()).expect("a field"));
    let photometry = PhotometryOptions::default();
    let (mut delayed, mut different) = (0, 0);
    for blocking in [Blocking::Any, Blocking::Avoid] {
        for (limit_mag, margin_s) in [(Some(6.9), 0.0), (Some(5.5), 0.0), (Some(5.5), MARGIN_S), (None, 0.0)] {
            let limit_mag = limit_mag.map(MagnitudeLimit::All);
            let policy = Policy { limit_mag, blocking, margin_s: Some(margin_s), ..Policy::default() };
            let conditions =
                FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
            let request = WindowRequest { conditions, min_altitude_rad: 0.0, max_sun_altitude_rad: None };
            for number in 0..4 {
                for step in 0..12 {
                    let start = seconds_after(dusk(), 150.0 * f64::from(step));
                    let exposure = exposure(start, EXPOSURE_S, number);
                    let row = ScheduledExposure {
                        id: "e".into(),
                        row: 0,
                        band: None,
                        open_s: None,
                        exposure: Ok(exposure.clone()),
                    };
                    let report = flag_exposures(&[&row], &conditions).expect("flags");
                    let flag = &report.flags[0];
                    let target = WindowTarget { exposure, band: None };
                    let longest_s = policy.max_delay_or_default_s();
                    let end = seconds_after(start, longest_s + EXPOSURE_S);
                    let windows = clear_windows(&[target], start, end, &request);
                    let first = windows.expect("windows").by_target[0].windows.first().copied();
                    let window_s = first.map(|window| seconds_between(start, window.first));
                    let delay_s = flag.next_start(blocking).map(|(_, delay_s)| delay_s);
                    // The next start has an additional guard of 1 ms and is rounded to 1 ms.
                    let agree = match (window_s, delay_s) {
                        (Some(window_s), Some(delay_s)) => (window_s - delay_s).abs() < 0.0031,
                        (window_s, delay_s) => window_s.is_none() && delay_s.is_none(),
                    };
                    assert!(agree, "{blocking:?} {number} {step}: window {window_s:?}, {flag:?}");
                    delayed += usize::from(delay_s.is_some_and(|delay_s| delay_s > 0.0));
                    different += usize::from(flag.acceptable_delay_s != flag.delay_s);
                    if policy.limit_mag.is_none() {
                        assert_eq!(flag.acceptable_delay_s, flag.delay_s);
                    }
                }
            }
        }
    }
    assert!(delayed > 20 && different > 10, "{delayed} delayed, {different} with different starts");
}
