//! Streaks of satellites that enter or leave the Earth's shadow inside a field.

use hifitime::Epoch;
use streakcast::elements::Constellation;
use streakcast::frames::{Direction, EopTable, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{Chord, Exposure, Field, ModelChoice, Pass, PassOptions, Sky};
use streakcast::photometry::ModelLibrary;

/// Points along each track.
const SAMPLES: usize = 401;
/// Tolerance of the lit length, steps between points: one at each of at most two ends of the lit part.
const STEPS: f64 = 2.0;

/// Tolerance of expected lengths, relative to the whole track: the lit share is a share of the time and not of the
/// length, and delays of some tenths of a second move the track during the exposure.
const EXPECTED_LENGTH: f64 = 0.05;

/// Field east of the zenith, in which many satellites enter the shadow during an evening.
struct Evening {
    sky: Sky,
    exposures: Vec<Exposure>,
    field: Field,
}

impl Evening {
    fn new() -> Self {
        let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
        let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).expect("a site");
        let elements = Constellation::by_name("starlink-gen1").expect("a shell").element_sets(start);
        let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("built-in models");
        let sky = Sky::with_models(elements, Observer::new(site), EopTable::embedded(), &choice);
        let exposures = (0..360)
            .map(|number| Exposure {
                id: number.to_string(),
                start: seconds_after(start, 20.0 * f64::from(number)),
                duration_s: 120.0,
                pointing: Direction::from_lon_lat_rad(
                    (255.0 + 0.083 * f64::from(number)).to_radians(),
                    (-30f64).to_radians(),
                ),
                rotation_rad: 0.0,
            })
            .collect();
        Self { sky, exposures, field: Field::circle(20f64.to_radians()).expect("a field") }
    }

    fn passes(&self, samples: usize) -> Vec<Vec<Pass>> {
        let options = PassOptions { include_dark: true, samples, ..PassOptions::default() };
        self.sky.field_passes(&self.exposures, &self.field, &options).expect("passes").by_exposure
    }
}

/// The expected length of a streak, from which the lost pixels are computed, is that of its lit part.
#[test]
fn verif_expected_lengths_count_the_lit_part() {
    let evening = Evening::new();
    let probabilities = evening.sky.crossing_probabilities(&evening.exposures, &evening.field).expect("probabilities");
    let mut compared = 0;
    for (passes, probabilities) in evening.passes(2).iter().zip(&probabilities) {
        for pass in passes.iter().filter(|pass| pass.chords.len() == 1 && pass.probability > 0.999) {
            let seconds = |chords: &[Chord]| chords.iter().map(|chord| chord.exit_s - chord.enter_s).sum::<f64>();
            let (lit_s, whole_s) = (seconds(&pass.lit_chords), seconds(&pass.chords));
            if lit_s > 0.8 * whole_s || lit_s < 0.2 * whole_s {
                continue;
            }
            let expected = probabilities.iter().find(|one| one.element_index == pass.element_index);
            let expected_rad = expected.expect("a probability").streak_length_rad;
            let whole_rad = pass.streak_length_rad * whole_s / lit_s;
            assert!(
                (expected_rad - pass.streak_length_rad).abs() < EXPECTED_LENGTH * whole_rad,
                "{pass:?} {expected:?}"
            );
            compared += 1;
        }
    }
    assert!(compared > 10, "{compared}");
}

/// The length of a streak is the sum of the distances between successive lit points of its track, and satellites in the
/// umbra have neither length nor peak.
#[test]
fn verif_streaks_are_as_long_as_their_lit_part() {
    let passes = Evening::new().passes(SAMPLES);
    let (mut lit, mut partly_lit, mut dark) = (0, 0, 0);
    // Tracks with two chords have points outside the field.
    for pass in passes.iter().flatten().filter(|pass| pass.chords.len() == 1) {
        let pairs: Vec<(f64, bool)> = pass
            .samples
            .windows(2)
            .map(|pair| {
                let is_lit = pair.iter().all(|point| point.illumination.is_lit());
                (pair[0].direction.separation_rad(&pair[1].direction), is_lit)
            })
            .collect();
        let expected: f64 = pairs.iter().filter(|(_, is_lit)| *is_lit).map(|(length, _)| length).sum();
        let step = pairs.iter().map(|(length, _)| *length).fold(0.0, f64::max);
        assert!((pass.streak_length_rad - expected).abs() <= STEPS * step, "{pass:?}: {expected} rad");
        let whole: f64 = pass.chords.iter().map(|chord| chord.exit_s - chord.enter_s).sum();
        let of_light: f64 = pass.lit_chords.iter().map(|chord| chord.exit_s - chord.enter_s).sum();
        assert_eq!(pass.lit, !pass.lit_chords.is_empty());
        if pass.lit_chords.is_empty() {
            assert!(pass.peak.is_none() && pass.streak_length_rad == 0.0, "{pass:?}");
            dark += 1;
        } else if of_light < 0.99 * whole {
            assert!(pass.peak.is_some(), "{pass:?}");
            partly_lit += 1;
        } else {
            lit += 1;
        }
    }
    println!("{lit} lit, {partly_lit} partly lit, {dark} dark");
    assert!(lit > 10 && partly_lit > 10 && dark > 10, "{lit} lit, {partly_lit} partly lit, {dark} dark");
}
