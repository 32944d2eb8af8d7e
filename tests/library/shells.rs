//! Simulated constellations: names, numbers, altitude, and the same satellites at every epoch.

use hifitime::{Epoch, Unit};
use streakcast::elements::{Constellation, FIRST_SYNTHETIC_ID, NoradId, Origin};
use streakcast::orbit::Propagator;

#[test]
fn verif_shells_are_labelled_and_numbered() {
    let epoch = Epoch::from_gregorian_utc_at_noon(2026, 3, 20);
    let gen1 = Constellation::by_name("Starlink-Gen1").unwrap();
    let sets = gen1.element_sets(epoch);
    assert_eq!(sets.len(), 4408);
    assert_eq!(&*sets[0].name, "STARLINK-GEN1-S1 P01-01 (synthetic)");
    assert_eq!(&*sets[50].name, "STARLINK-GEN1-S1 P03-07 (synthetic)");
    assert_eq!(sets[4407].norad_id, NoradId(FIRST_SYNTHETIC_ID + 4407));
    assert!(sets.iter().all(|set| set.origin == Origin::Synthetic && set.epoch == epoch));
    assert_eq!(sets, gen1.element_sets(epoch));
    let mut ids: Vec<_> = Constellation::embedded()
        .iter()
        .flat_map(|constellation| constellation.element_sets(epoch))
        .map(|set| set.norad_id)
        .collect();
    let total = ids.len();
    assert_eq!(total, 4408 + 29_988 + 6372 + 3236 + 1_822_393);
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), total);
}

#[test]
fn verif_shells_have_their_altitude_and_the_same_satellites_at_every_epoch() {
    /// Tolerance of the mean radius: the closed form omits J₂² terms below 10 m, and 200 samples are averaged.
    const MEAN_RADIUS_TOLERANCE_KM: f64 = 0.02;
    /// Tolerance of the mean radius of orbits that Moon and Sun change.
    const DEEP_TOLERANCE_KM: f64 = 10.0;
    /// Tolerance after thirty days of secular rates; SGP4 itself causes a kilometre.
    const SAME_SATELLITE_TOLERANCE_KM: f64 = 1.0;
    let epoch = Epoch::from_gregorian_utc_at_midnight(2026, 3, 20);
    for constellation in Constellation::embedded() {
        let sets = constellation.element_sets(epoch);
        let later = constellation.element_sets(epoch + 30.0 * Unit::Day);
        let mut first = 0;
        for shell in &constellation.shells {
            let set = &sets[first];
            let satellites = (shell.planes * shell.satellites_per_plane) as usize;
            first += satellites;
            // Moon and Sun change orbits that are propagated with SDP4.
            let is_deep = shell.altitude_km > 5800.0;
            let propagator = Propagator::new(set).unwrap();
            let period_min = 1440.0 / set.mean_motion_rev_day;
            let mean = (0..200)
                .map(|step| {
                    let ([x, y, z], _) =
                        propagator.teme_state_at_minutes(f64::from(step) / 200.0 * period_min).unwrap();
                    (x * x + y * y + z * z).sqrt()
                })
                .sum::<f64>()
                / 200.0;
            let error = mean - 6378.137 - shell.altitude_km;
            let tolerance_km = if is_deep { DEEP_TOLERANCE_KM } else { MEAN_RADIUS_TOLERANCE_KM };
            assert!(error.abs() < tolerance_km, "{}: {error} km", set.name);
            if is_deep || shell.node_local_time_h.is_some() {
                continue;
            }
            let (r1, _) = propagator.teme_state_at_minutes(30.0 * 1440.0).unwrap();
            let (r2, _) = Propagator::new(&later[first - satellites]).unwrap().teme_state_at_minutes(0.0).unwrap();
            let apart = r1.iter().zip(r2).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            assert!(apart < SAME_SATELLITE_TOLERANCE_KM, "{}: {apart} km", set.name);
        }
    }
}

#[test]
fn verif_sets_contain_their_constellations() {
    let planned = Constellation::by_name_or_set("Planned-2026").expect("a set");
    assert_eq!(planned.iter().map(Constellation::satellites).sum::<usize>(), 1_822_393);
    let one = |name: &str| planned.iter().find(|one| one.name == name).expect(name);
    assert_eq!(one("spacex-odc").satellites(), 1_000_000);
    // CTC-2 has the shells of CTC-1, with planes midway between.
    let (first, second) = (&one("ctc-1").shells, &one("ctc-2").shells);
    assert_eq!(first.len(), second.len());
    for (first, second) in first.iter().zip(second) {
        assert_eq!((first.altitude_km, first.planes), (second.altitude_km, second.planes));
        let step_deg = first.node_spread_deg / f64::from(first.planes);
        assert!((second.node_offset_deg - first.node_offset_deg - 0.5 * step_deg).abs() < 1e-9);
    }
    assert_eq!(Constellation::by_name_or_set("kuiper").expect("a constellation").len(), 1);
    let unknown = Constellation::by_name_or_set("planned-2025").unwrap_err().to_string();
    assert!(unknown.ends_with(", telesat, planned-2026"), "{unknown}");
}

/// The first node of a dawn-dusk shell is at its local mean solar time on any day.
#[test]
fn verif_nodes_by_local_time_follow_the_mean_sun() {
    let text = "[[constellation]]\nname = 'dusk'\nshell = [{ altitude_km = 600, inclination_deg = 97.8, planes = 1, \
                satellites_per_plane = 1, node_local_time_h = 18 }]";
    let dusk = Constellation::from_toml(text).expect("a constellation").remove(0);
    // Right ascension of the Sun at the equinoxes and solstices of 2026 (0, 90, 180, 270 deg); the equation of time is
    // up to 4 deg.
    for (text, sun_deg) in
        [("2026-03-20T15:00:00Z", 0.0), ("2026-06-21T08:00:00Z", 90.0), ("2026-12-21T21:00:00Z", 270.0)]
    {
        let node_deg = dusk.element_sets(text.parse().expect("a time"))[0].right_ascension_of_node_deg;
        let off_deg = (node_deg - sun_deg - 90.0 + 180.0_f64).rem_euclid(360.0) - 180.0;
        assert!(off_deg.abs() < 4.0, "{text}: {off_deg} deg");
    }
}

#[test]
fn limits_of_constellations_are_stated() {
    let read = |text: &str| Constellation::from_toml(text).map_err(|error| error.to_string());
    let of = |name: &str, planes: u32, rest: &str| {
        format!(
            "[[constellation]]\nname = '{name}'\n{rest}\nshell = [{{ altitude_km = [20200, 35786], inclination_deg = 55, \
             planes = {planes}, satellites_per_plane = 500 }}]\n"
        )
    };
    assert_eq!(read(&of("a", 1000, "")).expect("a million")[0].satellites(), 1_000_000);
    assert_eq!(read(&of("a", 10_000, "")).expect("ten millions")[0].satellites(), 10_000_000);
    let wrong = [
        (of("a", 10_001, ""), "constellation \"a\" has 10001000 satellites; allowed: 1 to 10000000"),
        (of("a", 1, "satellites = 999"), "constellation \"a\" states 999 satellites, but its shells have 1000"),
        (
            of("a", 1, "").replace("35786", "40001"),
            "constellation \"a\", shell 1: altitude_km 40001 is out of range: allowed 120 to 40000 km",
        ),
        (
            of("a", 1, "shells_of = 'b'"),
            "constellation file: constellation \"a\": shell and shells_of exclude each other; specify one of them",
        ),
        (
            "[[constellation]]\nname = 'a'\nshells_of = 'b'".to_owned(),
            "constellation file: constellation \"a\": shells_of \"b\" is not the name of a constellation before it in the file",
        ),
        (
            (0..6).map(|number| of(&number.to_string(), 9000, "")).collect(),
            "the constellations of the files have more than 49999999 satellites in all; allowed: at most 49999999",
        ),
        (
            (0..201).map(|number| of(&number.to_string(), 1, "")).collect(),
            "constellation file: 201 constellations; allowed: at most 200",
        ),
    ];
    for (text, expected) in wrong {
        assert_eq!(read(&text).unwrap_err(), expected);
    }
    // 200 constellations, with numbers that follow one another.
    let all: String = (0..200).map(|number| of(&number.to_string(), 1, "")).collect();
    let all = read(&all).expect("200 constellations");
    assert!(all.windows(2).all(|pair| pair[1].first_id.0 == pair[0].first_id.0 + 1000));
    let epoch = Epoch::from_gregorian_utc_at_midnight(2026, 3, 20);
    // Satellites of high shells have positions at their altitudes.
    for set in all[0].element_sets(epoch).iter().step_by(100) {
        let ([x, y, z], _) = Propagator::new(set).unwrap().teme_state_at_minutes(100.0).unwrap();
        let altitude_km = (x * x + y * y + z * z).sqrt() - 6378.137;
        assert!([20_200.0, 35_786.0].iter().any(|km| (altitude_km - km).abs() < 20.0), "{altitude_km}");
    }
}
