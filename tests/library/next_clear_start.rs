//! Next clear starts are clear if computed again, also if an exposure is avoided only because of its total cost.

use hifitime::{Epoch, Unit};
use streakcast::elements::{Constellation, ElementSet, Origin};
use streakcast::frames::{Direction, EopTable, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::images::Telescope;
use streakcast::passes::{Exposure, Field, ModelChoice, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::schedule::{FlagRequest, Policy, ScheduledExposure, Verdict, VerdictKind, flag_exposures};

const LIMIT_S: f64 = 0.01;

/// Returns the satellites of a shell with elements 20 days old: some are early or late by minutes.
fn old_elements(at: Epoch) -> Vec<ElementSet> {
    let mut elements = Constellation::by_name("starlink-gen1").expect("a shell").element_sets(at - 20.0 * Unit::Day);
    elements.truncate(1584);

    for set in &mut elements {
        set.origin = Origin::Published;
        set.name = "STARLINK-1".into();
        // The lateness increases with the drag.
        set.mean_motion_dot_rev_day2 = 3e-5;
    }
    elements
}

#[test]
fn verif_a_shifted_row_is_not_avoided_for_its_cost() {
    let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
    let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let sky = Sky::with_models(old_elements(start), Observer::new(site), EopTable::embedded(), &choice);
    let field = Field::circle(3.5f64.to_radians()).expect("a field");
    let telescope = Telescope::by_name("rubin").expect("a preset");
    let policy = Policy { max_cost_s: Some(LIMIT_S), ..Policy::default() };
    let photometry = PhotometryOptions::default();
    let request =
        FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: Some(&telescope), photometry: &photometry };
    let row = |number: usize, start: Epoch| ScheduledExposure {
        id: number.to_string(),
        row: number,
        band: None,
        open_s: None,
        exposure: Ok(Exposure {
            id: number.to_string(),
            start,
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(
                (200.0 + number as f64).to_radians(),
                (-50.0 + 0.5 * number as f64).to_radians(),
            ),
            rotation_rad: 0.0,
        }),
    };
    let flags_of = |rows: &[ScheduledExposure]| -> Vec<Verdict> {
        flag_exposures(&rows.iter().collect::<Vec<_>>(), &request).expect("flags").flags
    };

    let rows: Vec<ScheduledExposure> =
        (0..80).map(|number| row(number, seconds_after(start, 34.0 * number as f64))).collect();
    let flags = flags_of(&rows);
    // Some exposures are avoided without a predicted crossing; their next clear start must be later than their start.
    let by_cost_alone = || flags.iter().filter(|flag| flag.kind == VerdictKind::Avoid && flag.n_streaks == 0);
    assert!(by_cost_alone().count() > 4, "{} avoided by their cost alone", by_cost_alone().count());
    assert!(by_cost_alone().any(|flag| flag.delay_s.is_some()));
    for flag in flags.iter().filter(|flag| flag.kind == VerdictKind::Avoid) {
        assert!(flag.delay_s.is_none_or(|delay_s| delay_s > 0.0), "{flag:?}");
        assert!(flag.streak_cost_s.is_some_and(|cost_s| cost_s > LIMIT_S));
    }

    let shifted: Vec<ScheduledExposure> = flags
        .iter()
        .enumerate()
        .filter(|(_, flag)| flag.kind != VerdictKind::Clear)
        .filter_map(|(number, flag)| Some(row(number, flag.next_clear_start?)))
        .collect();
    assert!(shifted.len() > 4, "{} shifted", shifted.len());
    for flag in flags_of(&shifted) {
        assert_eq!(flag.kind, VerdictKind::Clear, "{flag:?}");
    }

    // Without a delay there is no clear start, and no exposure is reported as clear.
    let hurried = Policy { max_delay_s: Some(0.0), ..policy.clone() };
    let report = flag_exposures(&rows.iter().collect::<Vec<_>>(), &FlagRequest { policy: &hurried, ..request });
    for flag in report.expect("flags").flags.iter().filter(|flag| flag.kind == VerdictKind::Avoid) {
        assert_eq!((flag.delay_s, flag.next_clear_start), (None, None));
    }
}
