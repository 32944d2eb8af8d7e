//! Several element sets of one satellite: the nearest to a time, the newest, and the phase of its orbit.

use crate::common::elements::{pair, read, read_all, sample};
use hifitime::{Epoch, Unit};
use proptest::prelude::*;
use streakcast::elements::{
    ElementSet, History, Keep, NoradId, ReadOptions, Satellites, StationRule, orbit_phases, semi_major_axis_km,
};

#[test]
fn verif_history_and_selection() {
    let text = [
        pair(90001, "079.50000000"),
        pair(90001, "081.50000000"),
        pair(90001, "080.50000000"),
        pair(90002, "070.00000000"),
        pair(90001, "080.50000000"),
    ]
    .concat();
    let epoch = |day: f64| Epoch::from_gregorian_utc_at_midnight(2026, 1, 1) + (day - 1.0) * Unit::Day;
    let all = read_all(text.as_bytes());
    assert_eq!((all.element_sets.len(), all.duplicates, all.superseded), (4, 1, 0));
    assert_eq!((all.sources[0].first_epoch, all.sources[0].last_epoch), (epoch(70.0), epoch(81.5)));
    let at = all.at(epoch(80.4));
    let history = all.into_history();
    assert_eq!(at, history.at(epoch(80.4)));
    let epochs: Vec<_> = history.sets_of(NoradId(90001)).iter().map(|set| set.epoch).collect();
    assert_eq!(epochs, [epoch(79.5), epoch(80.5), epoch(81.5)]);
    for (day, nearest) in [(10.0, 79.5), (79.9, 79.5), (80.0, 80.5), (80.9, 80.5), (81.1, 81.5), (300.0, 81.5)] {
        let found = history.nearest(NoradId(90001), epoch(day)).unwrap();
        assert_eq!(found.epoch, epoch(nearest), "requested day {day}");
    }
    assert!(history.nearest(NoradId(1), epoch(80.0)).is_none());
    assert_eq!(history.sets_of(NoradId(1)), []);

    let kept = |keep| {
        let options = ReadOptions { keep, ..Default::default() };
        let catalogue = Satellites::from_bytes("test", text.as_bytes(), &options).unwrap();
        assert_eq!((catalogue.duplicates, catalogue.superseded), (1, 2));
        catalogue.element_sets
    };
    let newest = kept(Keep::Newest);
    assert_eq!(newest.iter().map(|set| set.epoch).collect::<Vec<_>>(), [epoch(81.5), epoch(70.0)]);
    assert_eq!(newest, history.newest());
    let near = kept(Keep::Nearest(epoch(80.4)));
    assert_eq!(near.iter().map(|set| set.epoch).collect::<Vec<_>>(), [epoch(80.5), epoch(70.0)]);
    assert_eq!(near, history.at(epoch(80.4)));
}

#[test]
fn verif_the_station_rule() {
    let base = read(&sample("sample.2le")).unwrap().element_sets.remove(0);
    // The semi-major axis a decreases by 2/3 a dn/n: at 15.06 rev/day, 1e-5 rev/day are 3 m.
    let history = |changes: &[f64]| -> Vec<ElementSet> {
        let mut mean_motion = base.mean_motion_rev_day;
        changes
            .iter()
            .enumerate()
            .map(|(day, change)| {
                mean_motion += change;
                let mut set = base.clone();
                set.epoch = base.epoch + day as f64 * Unit::Day;
                set.mean_motion_rev_day = mean_motion;
                set
            })
            .collect()
    };
    let names = |changes: &[f64], rule: &StationRule| -> Vec<&str> {
        orbit_phases(&history(changes), rule).into_iter().map(|phase| phase.name()).collect()
    };
    let rule = StationRule::default();
    assert!((semi_major_axis_km(&base) - 6378.137 - 547.8).abs() < 1.0, "{}", semi_major_axis_km(&base));
    assert_eq!(names(&[0.0, 1e-5, -1e-5, 2e-5], &rule), ["on_station"; 4]);
    assert_eq!(names(&[0.0, -1e-2, -1e-2, -1e-2], &rule), ["raising"; 4]);
    assert_eq!(names(&[0.0, 1e-2, 1e-2, 1e-2], &rule), ["decaying"; 4]);
    assert_eq!(names(&[0.0, 1e-2, -1e-2], &rule), ["unknown"; 3]);
    assert_eq!(names(&[0.0, 0.0], &rule), ["unknown"; 2]);
    assert_eq!(names(&[], &rule), [""; 0]);
    assert_eq!(names(&[0.0, 0.0, 0.0], &StationRule { min_height_km: 560.0, ..rule }), ["parked"; 3]);
    // The sets after the manoeuvre are steady, and therefore on station.
    let phases = names(&[0.0, -1e-2, -1e-2, 0.0, 0.0, 0.0], &rule);
    assert_eq!(phases, ["raising", "raising", "on_station", "on_station", "on_station", "on_station"]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// The nearest element set of a history equals that found by comparing all sets.
    #[test]
    fn verif_nearest_equals_brute_force(
        minutes in proptest::collection::vec(0_i32..5000, 1..40),
        minute in -500_i32..5500,
    ) {
        let base = read(&sample("sample.2le")).unwrap().element_sets.remove(0);
        let at = |minute: i32| base.epoch + f64::from(minute) * Unit::Minute;
        let sets = minutes.iter().enumerate().map(|(index, minute)| {
            let mut set = base.clone();
            set.norad_id = NoradId(1 + index as u32 % 3);
            set.epoch = at(*minute);
            set
        });
        let history = History::new(sets.collect());
        for id in 1..=3 {
            let best = history
                .element_sets()
                .iter()
                .filter(|set| set.norad_id.0 == id)
                .map(|set| (set.epoch - at(minute)).abs())
                .min();
            let found = history.nearest(NoradId(id), at(minute)).map(|set| (set.epoch - at(minute)).abs());
            prop_assert_eq!(found, best);
        }
    }
}
