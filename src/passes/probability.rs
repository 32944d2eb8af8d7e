//! How likely a crossing is, given how wrong the element set may be.
//!
//! First form. The error of the predicted place is taken as a shift in time along the track (Gaussian, `along_track_s`) and an
//! independent shift across it (Gaussian, `cross_track_rad` as seen by the observer); both are constant over the exposure.
//! A satellite that is late by δ stands at time t where it was predicted for t - δ. The track shifted across by x meets the
//! field during chords [a, b] of its own time, so it crosses the exposure [0, T] when -b ≤ δ ≤ T - a:
//!
//! P = ∫ dx N(x; σ_c) Σ_chords [Φ((T - a)/σ_t) - Φ(-b/σ_t)]
//!
//! and spends there, on average, the time
//!
//! ∫ dx N(x; σ_c) Σ_chords ∫₀ᵀ dt [Φ((t - a)/σ_t) - Φ((t - b)/σ_t)]
//!
//! The integrals over δ and t are exact. That over x is a Gauss-Hermite sum where the field is wide against the error across the
//! track, else a Gauss-Legendre sum over the shifts that lead through the field. Before the shutter opens and after it closes
//! the site stands still, so that a satellite brought in by its delay is seen from the right place.

use nalgebra::Vector3;

use super::crossing::{Crossing, Sight, cross, cross_samples, sample};
use super::delays::{Delays, Odds, normal_cdf};
use super::field::FieldOnSky;
use super::track::Chord;

/// Shifts further than this from the prediction are not looked for, in sigmas.
pub(super) const REACH_SIGMAS: f64 = 3.5;
/// A near miss that is listed is not looked for beyond this time, seconds. None more probable than T / (300 s √(2πe)) in an exposure
/// of T is lost by that: 2.4 % in 30 s. How likely *any* satellite is does not stop here (`chance.rs`).
pub(super) const LONGEST_REACH_S: f64 = 300.0;
/// Errors across the track beyond this share of the field's radius are too wide for five nodes.
const WIDE_SHARE: f64 = 0.3;

/// Nodes and weights of the five-point Gauss-Hermite rule for a unit normal distribution (Abramowitz & Stegun, table 25.10).
const GAUSS_HERMITE: [(f64, f64); 5] = [
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (2.856_970_013_872_806, 0.011_257_411_327_720_69),
    (-2.856_970_013_872_806, 0.011_257_411_327_720_69),
];

/// Nodes and weights of the eight-point Gauss-Legendre rule on [-1, 1] (Abramowitz & Stegun, table 25.4), positive half.
const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (0.183_434_642_495_650, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887),
    (0.796_666_477_413_627, 0.222_381_034_453_374),
    (0.960_289_856_497_536, 0.101_228_536_290_376),
];

/// How far along the track a search for this sigma goes, seconds.
pub(super) fn reach_s(along_track_sigma_s: f64) -> f64 {
    (REACH_SIGMAS * along_track_sigma_s).min(LONGEST_REACH_S)
}

/// Probability that the satellite is inside the field at any time of [`start_s`, `end_s`].
///
/// `track` is that of the prediction over `searched_s`: the part of the exposure in which it may matter, widened by
/// [`reach_s`] on both sides.
pub(super) fn crossing_probability(
    track: &impl Fn(f64) -> Sight,
    searched_s: (f64, f64),
    exposure_s: (f64, f64),
    field: &FieldOnSky,
    along_track_sigma_s: f64,
    cross_track_sigma_rad: f64,
) -> f64 {
    let nominal = cross(track, searched_s.0, searched_s.1, field);
    let delays = Delays::new(exposure_s, along_track_sigma_s);
    crossing_odds(track, &nominal, searched_s, &delays, field, cross_track_sigma_rad).probability
}

/// As [`crossing_probability`], with the expected length of the streak; `nominal` is the crossing of the track itself, `sigma_rad`
/// the error across it.
pub(super) fn crossing_odds(
    track: &impl Fn(f64) -> Sight,
    nominal: &Crossing,
    searched_s: (f64, f64),
    delays: &Delays,
    field: &FieldOnSky,
    sigma_rad: f64,
) -> Odds {
    let radius_rad = field.bounding_radius_rad();
    if sigma_rad > 0.0 && nominal.min_separation_rad > radius_rad + 2.0 * REACH_SIGMAS * sigma_rad {
        return Odds::default();
    }
    let through_rad = || across(&track(nominal.closest_s)).map_or(0.0, |across| field.centre().dot(&across));
    over_shifts(sigma_rad, radius_rad, through_rad, |shift_rad| {
        if shift_rad == 0.0 {
            return delays.odds(&nominal.chords, length_on(track));
        }
        let shifted = |time_s: f64| shifted_across(&track(time_s), shift_rad);
        let chords = cross(&shifted, searched_s.0, searched_s.1, field).chords;
        delays.odds(&chords, length_on(&shifted))
    })
}

/// The odds of shifted paths, averaged over a normal distribution of shifts; `through_rad` is the shift that leads through the centre of the field.
pub(super) fn over_shifts(
    sigma_rad: f64,
    radius_rad: f64,
    through_rad: impl FnOnce() -> f64,
    shifted: impl Fn(f64) -> Odds,
) -> Odds {
    if sigma_rad <= 0.0 {
        return shifted(0.0);
    }
    let mut total = Odds::default();
    let mut add = |shift_rad: f64, weight: f64| {
        if weight > 1e-9 {
            let odds = shifted(shift_rad);
            total.probability += weight * odds.probability;
            total.streak_length_rad += weight * odds.streak_length_rad;
        }
    };
    if sigma_rad <= WIDE_SHARE * radius_rad {
        for (node, weight) in GAUSS_HERMITE {
            add(node * sigma_rad, weight);
        }
    } else {
        // Those on both sides of the one through the centre that lead through the field.
        let through_rad = through_rad();
        let low_rad = (through_rad - radius_rad).max(-REACH_SIGMAS * sigma_rad);
        let high_rad = (through_rad + radius_rad).min(REACH_SIGMAS * sigma_rad);
        let (middle_rad, half_rad) = (0.5 * (low_rad + high_rad), 0.5 * (high_rad - low_rad));
        if half_rad > 0.0 {
            for (node, weight) in
                GAUSS_LEGENDRE.into_iter().flat_map(|(node, weight)| [(node, weight), (-node, weight)])
            {
                let shift_rad = middle_rad + half_rad * node;
                // N(x; σ_c) dx
                let z = shift_rad / sigma_rad;
                let density = (-0.5 * z * z).exp() / (sigma_rad * std::f64::consts::TAU.sqrt());
                add(shift_rad, weight * half_rad * density);
            }
        }
    }
    total.probability = total.probability.clamp(0.0, 1.0);
    total
}

/// The direction across the track, a unit vector; `None` where it stands still.
fn across(sight: &Sight) -> Option<Vector3<f64>> {
    sight.vector.cross(&sight.rate_s).try_normalize(0.0)
}

/// The angle between the ends of a chord, radians.
fn length_on(track: &impl Fn(f64) -> Sight) -> impl Fn(&Chord) -> f64 {
    move |chord| {
        let (enter, exit) = (track(chord.enter_s).vector, track(chord.exit_s).vector);
        enter.cross(&exit).norm().atan2(enter.dot(&exit))
    }
}

/// Delays that are tried for an observer in orbit.
const TRIED_DELAYS: usize = 81;

/// As [`crossing_probability`] for an observer that moves as fast as the satellites: a late satellite then takes another way through the field,
/// not the same one later.
///
/// `track` gives the line of sight at a time to a satellite that is late by a number of seconds. Delays of up to [`REACH_SIGMAS`] are tried in equal steps,
/// each for the stretch of the normal distribution around it, but for those between two that both pass the field so far off that none between them meets it: good to a few
/// hundredths where the field is wider than the error across the track. Where it is narrower, five shifts stand for all: the chance of one satellite is then
/// a few fixed numbers or 0 (0.53 instead of 0.38 for a track through the middle of a field of half the error), and only sums over many are right.
pub(super) fn crossing_probability_in_flight(
    track: &impl Fn(f64, f64) -> Sight,
    (start_s, end_s): (f64, f64),
    field: &FieldOnSky,
    along_track_sigma_s: f64,
    cross_track_sigma_rad: f64,
) -> f64 {
    let reach_s = reach_s(along_track_sigma_s);
    let late = Late { track, exposure_s: (start_s, end_s), field, cross_track_sigma_rad };
    if reach_s <= 0.0 {
        return late.at(0.0).share.clamp(0.0, 1.0);
    }
    let step_s = 2.0 * reach_s / TRIED_DELAYS as f64;
    let delay_s = |delay: usize| step_s * (delay as f64 + 0.5) - reach_s;
    let density = |delay: usize| {
        normal_cdf(delay_s(delay) + 0.5 * step_s, along_track_sigma_s)
            - normal_cdf(delay_s(delay) - 0.5 * step_s, along_track_sigma_s)
    };
    let (first, last) = (late.at(delay_s(0)), late.at(delay_s(TRIED_DELAYS - 1)));
    let mut total = density(0) * first.share + density(TRIED_DELAYS - 1) * last.share;
    // Halved again and again where the satellite may meet the field at a delay between two that were tried.
    let mut gaps = vec![(0, first, TRIED_DELAYS - 1, last)];
    while let Some((from, before, to, after)) = gaps.pop() {
        if to - from < 2 || late.misses_between(&before, &after) {
            continue;
        }
        let middle = usize::midpoint(from, to);
        let between = late.at(delay_s(middle));
        total += density(middle) * between.share;
        gaps.push((from, before, middle, between.clone()));
        gaps.push((middle, between, to, after));
    }
    total.clamp(0.0, 1.0)
}

/// Tracks of one satellite that is late, past one field.
struct Late<'a, T> {
    /// Of time and delay.
    track: &'a T,
    exposure_s: (f64, f64),
    field: &'a FieldOnSky<'a>,
    cross_track_sigma_rad: f64,
}

/// One delay that was tried.
#[derive(Clone)]
struct Tried {
    late_s: f64,
    samples: Vec<(f64, Sight)>,
    closest_rad: f64,
    /// Of the errors across the track, those that lead through the field.
    share: f64,
}

/// Between two delays a satellite is taken to stand no farther from where it is at either than this many times their distance.
const STRAYING: f64 = 1.1;

impl<T: Fn(f64, f64) -> Sight> Late<'_, T> {
    fn at(&self, late_s: f64) -> Tried {
        let track = |time_s: f64| (self.track)(time_s, late_s);
        let (start_s, end_s) = self.exposure_s;
        let samples = sample(&track, start_s, end_s);
        let nominal = cross_samples(&track, &samples, self.field);
        let closest_rad = nominal.min_separation_rad;
        let crosses = |shift_rad: f64| {
            if shift_rad == 0.0 {
                return !nominal.chords.is_empty();
            }
            // No place on the track is shifted farther than that.
            let may_cross = closest_rad <= self.field.bounding_radius_rad() + shift_rad.abs();
            let shifted = |time_s: f64| shifted_across(&track(time_s), shift_rad);
            may_cross && !cross(&shifted, start_s, end_s, self.field).chords.is_empty()
        };
        let share = if self.cross_track_sigma_rad > 0.0 {
            GAUSS_HERMITE
                .iter()
                .filter(|(node, _)| crosses(node * self.cross_track_sigma_rad))
                .map(|(_, weight)| weight)
                .sum()
        } else {
            f64::from(u8::from(crosses(0.0)))
        };
        Tried { late_s, samples, closest_rad, share }
    }

    /// True where no delay between two leads into the field, whatever the error across the track.
    fn misses_between(&self, before: &Tried, after: &Tried) -> bool {
        let widest_shift_rad = GAUSS_HERMITE.iter().fold(0.0, |most: f64, (node, _)| most.max(node.abs()));
        let clear_rad = before.closest_rad.min(after.closest_rad)
            - self.field.bounding_radius_rad()
            - widest_shift_rad * self.cross_track_sigma_rad;
        clear_rad > 0.0
            && before.samples.iter().all(|(time_s, sight)| {
                let later = (self.track)(*time_s, after.late_s).vector;
                STRAYING * sight.vector.cross(&later).norm().atan2(sight.vector.dot(&later)) < clear_rad
            })
    }
}

/// A line of sight shifted square to the track, on the sky.
fn shifted_across(sight: &Sight, shift_rad: f64) -> Sight {
    let unit = sight.vector.normalize();
    let across = unit.cross(&sight.rate_s);
    let norm = across.norm();
    let vector = if norm > 0.0 { unit + across * (shift_rad / norm) } else { unit };
    Sight { vector, rate_s: sight.rate_s }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Direction;
    use crate::passes::Field;

    /// What [`crossing_probability_in_flight`] is: all delays times all shifts.
    fn plain_sum(
        track: &impl Fn(f64, f64) -> Sight,
        (start_s, end_s): (f64, f64),
        field: &FieldOnSky,
        along_track_sigma_s: f64,
        cross_track_sigma_rad: f64,
    ) -> f64 {
        let reach_s = reach_s(along_track_sigma_s);
        let step_s = 2.0 * reach_s / TRIED_DELAYS as f64;
        let mut total = 0.0;
        for delay in 0..TRIED_DELAYS {
            let late_s = step_s * (delay as f64 + 0.5) - reach_s;
            let density = normal_cdf(late_s + 0.5 * step_s, along_track_sigma_s)
                - normal_cdf(late_s - 0.5 * step_s, along_track_sigma_s);
            for (node, weight) in GAUSS_HERMITE {
                let shifted = |time_s: f64| shifted_across(&track(time_s, late_s), node * cross_track_sigma_rad);
                if !cross(&shifted, start_s, end_s, field).chords.is_empty() {
                    total += density * weight;
                }
            }
        }
        total
    }

    /// A place on a circle, km and km/s.
    fn circling(radius_km: f64, node_rad: f64, tilt_rad: f64, from_rad: f64, time_s: f64) -> [Vector3<f64>; 2] {
        let rate_s = (398_600.44 / radius_km.powi(3)).sqrt();
        let (x, y) =
            (Vector3::new(node_rad.cos(), node_rad.sin(), 0.0), Vector3::new(-node_rad.sin(), node_rad.cos(), 0.0));
        let y = y * tilt_rad.cos() + Vector3::z() * tilt_rad.sin();
        let (sin, cos) = (from_rad + rate_s * time_s).sin_cos();
        [(x * cos + y * sin) * radius_km, (y * cos - x * sin) * radius_km * rate_s]
    }

    #[test]
    fn verif_delays_that_are_spared_bring_nothing() {
        const ROUNDING: f64 = 1e-12;
        let mut state = 7_u64;
        let mut between = |least: f64, greatest: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            least + (greatest - least) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut met, mut none) = (0, 0);
        for case in 0..150 {
            let observer =
                [6918.0, between(0.0, std::f64::consts::TAU), between(0.0, 1.7), between(0.0, std::f64::consts::TAU)];
            let radius_km = if case % 5 == 0 { 6925.0 } else { between(6800.0, 9000.0) };
            let satellite = [
                radius_km,
                between(0.0, std::f64::consts::TAU),
                between(0.0, 3.0),
                between(0.0, std::f64::consts::TAU),
            ];
            let track = |time_s: f64, late_s: f64| {
                let [here, flying] = circling(observer[0], observer[1], observer[2], observer[3], time_s);
                let [there, passing] =
                    circling(satellite[0], satellite[1], satellite[2], satellite[3], time_s - late_s);
                let range_km = (there - here).norm();
                Sight { vector: (there - here) / range_km, rate_s: (passing - flying) / range_km }
            };
            // Pointed near where the satellite stands in the middle.
            let middle = track(5.0, between(-2.0, 2.0)).vector;
            let pointing = Direction::from_vector(
                (middle + Vector3::new(between(-0.02, 0.02), between(-0.02, 0.02), between(-0.02, 0.02))).normalize(),
            );
            let radius_rad = between(0.0005, 0.03);
            let shape = if case % 3 == 0 {
                Field::rectangle_deg(radius_rad.to_degrees(), 2.0 * radius_rad.to_degrees())
            } else {
                Field::circle(2.0 * radius_rad)
            }
            .unwrap();
            let field = shape.on_sky(&pointing, 0.3);
            let (along_s, across_rad) = (between(0.1, 4.0), between(0.0, 0.01));
            let found = crossing_probability_in_flight(&track, (0.0, 10.0), &field, along_s, across_rad);
            let expected = plain_sum(&track, (0.0, 10.0), &field, along_s, across_rad);
            assert!((found - expected).abs() < ROUNDING, "case {case}: {found} {expected}");
            if expected > 0.0 { met += 1 } else { none += 1 }
        }
        assert!(met > 30 && none > 5, "{met} {none}");
    }
}
