//! Cost of streaks in seconds of open shutter: acceptance values for single satellites, and exposures of a night with
//! real satellites.

use hifitime::Epoch;
use streakcast::elements::{Constellation, Origin, ReadOptions, Satellites};
use streakcast::frames::{Direction, EopTable, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::images::{PossibleStreak, StreakCost, Telescope};
use streakcast::passes::{Exposure, Field, ModelChoice, PassOptions, Sky};
use streakcast::photometry::{Brightness, ErrorDistribution, Magnitude, MagnitudeSource, PhotometryOptions};
use streakcast::schedule::{
    FlagRequest, MagnitudeLimit, Policy, ScheduledExposure, Verdict, VerdictKind, delayed_costs_s, judge_exposures,
};

use crate::common;
use crate::common::random::Random;

fn rubin() -> Telescope {
    Telescope::by_name("rubin").expect("a preset")
}

fn brightness(magnitude: f64) -> Brightness {
    Brightness {
        magnitude: Magnitude(magnitude),
        sigma_mag: 0.5,
        scatter_mag: 0.5,
        error_distribution: ErrorDistribution::SATELLITES,
        source: MagnitudeSource::Prior,
        in_fitted_range: true,
        grey_reflectance: false,
    }
}

/// Cost of a certain streak of a satellite of 4 m in an exposure of 30 s of Rubin.
fn cost_s(bright_share: f64, magnitude: f64, range_km: f64, rate_arcsec_s: f64, length_deg: f64) -> f64 {
    let telescope = Telescope { bright_share, ..rubin() };
    let equivalent_mag = telescope.equivalent_mag_at_550_km(magnitude, range_km, rate_arcsec_s, 4.0);
    let bright_mag = telescope.bright_mag_in(None) + magnitude - equivalent_mag;
    let cost = StreakCost::new(&telescope, telescope.field.area_deg2());
    let share = cost.expected_share(&PossibleStreak {
        probability: 1.0,
        expected_length_deg: length_deg,
        width_arcsec: telescope.width_arcsec(range_km, 4.0),
        p_bright: brightness(magnitude).probability_brighter_than(bright_mag),
        p_above_limit: 0.0,
    });
    cost.seconds(30.0, share)
}

#[test]
fn valid_costs_of_single_satellites() {
    let at_550_km = |bright_share: f64, magnitude: f64| cost_s(bright_share, magnitude, 550.0, 2844.7, 3.5);
    assert!((2.4..=2.5).contains(&at_550_km(0.08, 5.0)), "{}", at_550_km(0.08, 5.0));
    assert!(at_550_km(0.08, 10.0) <= 0.05, "{}", at_550_km(0.08, 10.0));
    let geostationary = cost_s(0.08, 12.0, 36_000.0, 15.04, 0.125);
    assert!((0.05..=0.1).contains(&geostationary), "{geostationary}");
    // OneWeb at 1200 km: fainter than 7 mag, but as bright per pixel as a satellite of 6 mag at 550 km.
    assert!(cost_s(0.08, 7.3, 1200.0, 1245.0, 3.5) > 2.0);
    assert!(at_550_km(1.0, 3.0) <= 30.0 && at_550_km(3.0, 3.0) > 80.0);
}

/// Exposures of 30 s through the night, at altitudes above 30 deg.
fn exposures(sky: &Sky, start: Epoch, night_s: f64, count: usize) -> Vec<ScheduledExposure> {
    let mut random = Random(45);
    let mut rows = Vec::new();
    while rows.len() < count {
        let number = rows.len();
        let exposure = Exposure {
            id: number.to_string(),
            start: seconds_after(start, night_s * number as f64 / count as f64),
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(
                random.between(0.0, std::f64::consts::TAU),
                random.between(-1.0, 1.0).asin(),
            ),
            rotation_rad: 0.0,
        };
        let altitude_rad = sky.pointing_altaz(&exposure.pointing, exposure.start).expect("an altitude").altitude_rad;
        if altitude_rad > 0.55 {
            rows.push(ScheduledExposure {
                id: exposure.id.clone(),
                row: number,
                band: None,
                open_s: None,
                exposure: Ok(exposure),
            });
        }
    }
    rows
}

#[test]
fn verif_costs_of_a_night_with_real_satellites() {
    let Some(data) = common::data_dir() else { return };
    let path = data.join("tle/active/active_2026-04-25.txt");
    let satellites = Satellites::read(&[path], &ReadOptions::default()).expect("elements");
    let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
    let sky = Sky::new(satellites, Observer::new(site));
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let (policy, photometry) = (Policy::default(), PhotometryOptions::default());
    let rows = exposures(&sky, Epoch::from_gregorian_utc(2026, 4, 24, 23, 0, 0, 0), 11.0 * 3600.0, 300);
    let judge = |bright_share: f64, policy: &Policy| -> Vec<Verdict> {
        let telescope = Telescope { bright_share, ..rubin() };
        let request =
            FlagRequest { sky: &sky, field: &field, policy, telescope: Some(&telescope), photometry: &photometry };
        judge_exposures(&rows.iter().collect::<Vec<_>>(), &request).expect("verdicts").flags
    };
    let costs = |flags: &[Verdict]| flags.iter().map(|flag| flag.streak_cost_s.expect("a cost")).collect::<Vec<f64>>();
    let mean = |costs: &[f64]| costs.iter().sum::<f64>() / costs.len() as f64;

    // All streaks of a night cost 0.17 % of the open shutter, 0.05 s of 30 s.
    let flags = judge(0.08, &policy);
    let at_default = costs(&flags);
    assert!((0.01..0.15).contains(&mean(&at_default)), "{}", mean(&at_default));
    assert!(at_default.iter().all(|cost_s| (0.0..=30.0).contains(cost_s)));

    // The cost of an exposure is the sum over its passes, and over near misses, which are few with new elements.
    let telescope = rubin();
    let request =
        FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: Some(&telescope), photometry: &photometry };
    let of_rows: Vec<Exposure> = rows.iter().filter_map(|row| row.exposure.clone().ok()).collect();
    let passes = sky.field_passes(&of_rows, &field, &PassOptions::default()).expect("passes").by_exposure;
    let of_passes: Vec<f64> = of_rows
        .iter()
        .zip(&passes)
        .map(|(exposure, passes)| {
            passes
                .iter()
                .filter_map(|pass| request.pass_cost((exposure, None), pass, None, None).map(|cost| cost.streak_cost_s))
                .sum()
        })
        .collect();
    let (all, crossings) = (mean(&at_default), mean(&of_passes));
    assert!((crossings / all - 1.0).abs() < 0.3, "{crossings} of {all}");

    // A streak that destroys a visit costs no more than the visit, and more than one that destroys some CCDs.
    let at_one = costs(&judge(1.0, &policy));
    assert!(at_one.iter().zip(&at_default).all(|(one, default)| *one >= *default && *one <= 30.0));
    assert!(mean(&at_one) > 8.0 * mean(&at_default), "{} {}", mean(&at_one), mean(&at_default));

    // A limit fainter than all satellites costs each exposure that one crosses for certain.
    let limited = judge(0.08, &Policy::limit_mag(30.0));
    // Satellites of unknown brightness, and those in the Earth's shadow only at the nearest point, are brighter as
    // well. With elements twelve days old, many satellites have no nominal pass.
    let late = exposures(&sky, Epoch::from_gregorian_utc(2026, 5, 6, 23, 0, 0, 0), 11.0 * 3600.0, 300);
    let request = FlagRequest { policy: &Policy::limit_mag(30.0), ..request };
    let of_late = judge_exposures(&late.iter().collect::<Vec<_>>(), &request).expect("verdicts").flags;
    for flag in limited.iter().chain(&of_late) {
        assert!((flag.p_any - flag.p_crossing).abs() < 1e-6, "{flag:?}");
    }
    for flag in limited.iter().filter(|flag| flag.passes.iter().any(|pass| pass.probability > 0.999)) {
        assert!(flag.streak_cost_s.is_some_and(|cost_s| cost_s > 29.9), "{flag:?}");
    }

    // The policy's limit on the cost.
    let costly = judge(0.08, &Policy { max_cost_s: Some(1.0), ..Policy::default() });
    for (flag, cost_s) in costly.iter().zip(&at_default) {
        assert_eq!(flag.kind == VerdictKind::Avoid, *cost_s > 1.0, "{flag:?}");
    }
    assert!(costly.iter().any(|flag| flag.kind == VerdictKind::Avoid));
}

/// Without a telescope, below the horizon, and with unknown positions the cost is unknown.
#[test]
fn verif_exposures_that_cannot_be_judged_have_no_cost() {
    let start = Epoch::from_gregorian_utc(2026, 4, 24, 23, 30, 0, 0);
    let elements = |at: Epoch| {
        let mut elements = Constellation::by_name("starlink-gen1").expect("a shell").element_sets(at);
        elements.iter_mut().for_each(|one| one.origin = Origin::Published);
        elements
    };
    let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let (policy, photometry, telescope) = (Policy::default(), PhotometryOptions::default(), rubin());
    let cost = |elements_at: Epoch, telescope: Option<&Telescope>, is_up: bool| {
        let sky = Sky::with_models(
            elements(elements_at),
            Observer::new(site.clone()),
            EopTable::embedded(),
            &ModelChoice::default(),
        );
        let mut rows = exposures(&sky, start, 1.0, 1);
        if !is_up && let Ok(exposure) = &mut rows[0].exposure {
            exposure.pointing = Direction::from_lon_lat_rad(
                exposure.pointing.longitude_rad() + std::f64::consts::PI,
                -exposure.pointing.latitude_rad(),
            );
        }
        let request = FlagRequest { sky: &sky, field: &field, policy: &policy, telescope, photometry: &photometry };
        judge_exposures(&[&rows[0]], &request).expect("a verdict").flags.remove(0)
    };
    let judged = cost(start, Some(&telescope), true);
    assert!(judged.streak_cost_s.is_some_and(|cost_s| cost_s >= 0.0));
    assert_eq!(cost(start, None, true).streak_cost_s, None);
    let below = cost(start, Some(&telescope), false);
    assert_eq!((below.kind, below.streak_cost_s), (VerdictKind::Invalid, None));
    let old = cost(start - 1500.0 * hifitime::Unit::Day, Some(&telescope), true);
    assert_eq!((old.kind, old.streak_cost_s), (VerdictKind::Unknown, None));
}

/// The cost of a delayed start is an upper limit for all shutter openings within the margin, with each kind of limit,
/// and for exposures that are shorter than the margin.
#[test]
fn valid_costs_of_delayed_starts_are_upper_limits() {
    let start = Epoch::from_gregorian_utc(2026, 4, 24, 23, 30, 0, 0);
    let mut elements = Constellation::by_name("starlink-gen1").expect("a shell").element_sets(start);
    elements.iter_mut().for_each(|one| one.origin = Origin::Published);
    let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
    let sky = Sky::with_models(elements, Observer::new(site), EopTable::embedded(), &ModelChoice::default());
    let field = Field::circle(4f64.to_radians()).expect("a field");
    let (photometry, telescope) = (PhotometryOptions::default(), rubin());
    let rows = exposures(&sky, start, 1800.0, 60);
    let (mut costly, mut below) = (0, 0);
    for (duration_s, margin_s) in [(30.0, 2.0), (10.0, 10.0), (2.0, 5.0), (5.0, 0.0)] {
        for limits in [
            Policy::default(),
            Policy::limit_mag(6.5),
            Policy { limit_surface_brightness: Some(MagnitudeLimit::All(16.0)), ..Policy::default() },
        ] {
            let policy = Policy { margin_s: Some(margin_s), ..limits };
            let request = FlagRequest {
                sky: &sky,
                field: &field,
                policy: &policy,
                telescope: Some(&telescope),
                photometry: &photometry,
            };
            for row in &rows {
                let at = |delay_s: f64| {
                    let mut row = row.clone();
                    if let Ok(exposure) = &mut row.exposure {
                        exposure.duration_s = duration_s;
                        exposure.start = seconds_after(exposure.start, delay_s);
                    }
                    row
                };
                let limit_s = delayed_costs_s(&at(0.0), &[0.0], &request).expect("costs")[0].expect("a cost");
                let openings: Vec<_> = (0..=10).map(|tenth| at(0.1 * f64::from(tenth) * margin_s)).collect();
                let flags = judge_exposures(&openings.iter().collect::<Vec<_>>(), &request).expect("verdicts").flags;
                let costs_s = flags.iter().map(|flag| flag.streak_cost_s.expect("a cost"));
                let largest_s = costs_s.fold(0.0, f64::max);
                // Track lengths and probabilities are sums over steps.
                assert!(limit_s >= largest_s * 0.995 - 1e-3, "{limit_s} {largest_s} {duration_s} {margin_s} {row:?}");
                assert!(limit_s <= duration_s * (1.0 + 1e-9), "{limit_s}");
                costly += usize::from(largest_s > 0.01);
                below += usize::from(limit_s < duration_s * 0.999 && largest_s > 0.01);
                if margin_s == 0.0 {
                    assert!((limit_s - largest_s).abs() < 1e-9, "{limit_s} {largest_s}");
                }
            }
        }
    }
    assert!(costly > 20 && below > 5, "{costly} {below}");
    // Without a length and a margin there is no cost, and no panic.
    let policy = Policy { margin_s: Some(0.0), ..Policy::default() };
    let request =
        FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: Some(&telescope), photometry: &photometry };
    let mut row = rows[0].clone();
    if let Ok(exposure) = &mut row.exposure {
        exposure.duration_s = 0.0;
    }
    assert_eq!(delayed_costs_s(&row, &[0.0], &request).expect("costs"), [Some(0.0)]);
}
