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
    assert_eq!(total, 4408 + 29_988 + 6372 + 3236 + 1296 + 12_992);
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), total);
}

#[test]
fn verif_shells_have_their_altitude_and_the_same_satellites_at_every_epoch() {
    /// Tolerance of the mean radius: the closed form omits J₂² terms below 10 m, and 200 samples are averaged.
    const MEAN_RADIUS_TOLERANCE_KM: f64 = 0.02;
    /// Tolerance after thirty days of secular rates; SGP4 itself causes a kilometre.
    const SAME_SATELLITE_TOLERANCE_KM: f64 = 1.0;
    let epoch = Epoch::from_gregorian_utc_at_midnight(2026, 3, 20);
    for constellation in Constellation::embedded() {
        let sets = constellation.element_sets(epoch);
        let later = constellation.element_sets(epoch + 30.0 * Unit::Day);
        let mut first = 0;
        for shell in &constellation.shells {
            let set = &sets[first + 1];
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
            assert!(error.abs() < MEAN_RADIUS_TOLERANCE_KM, "{}: {error} km", set.name);

            let (r1, _) = propagator.teme_state_at_minutes(30.0 * 1440.0).unwrap();
            let (r2, _) = Propagator::new(&later[first + 1]).unwrap().teme_state_at_minutes(0.0).unwrap();
            let apart = r1.iter().zip(r2).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            assert!(apart < SAME_SATELLITE_TOLERANCE_KM, "{}: {apart} km", set.name);
            first += (shell.planes * shell.satellites_per_plane) as usize;
        }
    }
}
