//! Probability of a crossing for an observer in orbit. The observer moves so fast that a late satellite crosses the
//! field on a different path from the predicted one.

use super::super::crossing::{cross, cross_samples, sample};
use super::super::field::FieldOnSky;
use super::super::track::Sight;
use super::odds::{GAUSS_HERMITE, shifted_across};
use crate::orbit::Lateness;

/// Number of delays for which the crossing is computed.
const TRIED_DELAYS: usize = 81;

/// Returns the probability that the satellite is inside the field at any time of an exposure.
///
/// `track` returns the line of sight to the satellite as a function of time and delay, both in seconds. The
/// distribution of the delay is divided into equal steps. Delays between two tested delays are skipped if the satellite
/// misses the field by a wide margin with both.
///
/// The result is accurate to a few hundredths if the field is wider than the error across the track, which is
/// represented by five shifts. For narrower fields, the probability of one satellite can have only a few values (0.53
/// instead of 0.38 for a track through the middle of a field half as wide as the error), and only sums over many
/// satellites are accurate.
pub(in crate::passes) fn crossing_probability_in_flight(
    track: &impl Fn(f64, f64) -> Sight,
    (start_s, end_s): (f64, f64),
    field: &FieldOnSky,
    lateness: &Lateness,
    cross_track_sigma_rad: f64,
) -> f64 {
    let reach_s = lateness.reach_s();
    let late = DelayedTracks { track, exposure_s: (start_s, end_s), field, cross_track_sigma_rad };
    if reach_s <= 0.0 {
        return late.at(0.0).share.clamp(0.0, 1.0);
    }
    let step_s = 2.0 * reach_s / TRIED_DELAYS as f64;
    let delay_s = |delay: usize| step_s * (delay as f64 + 0.5) - reach_s;
    let share = |delay: usize| lateness.share(delay_s(delay) - 0.5 * step_s, delay_s(delay) + 0.5 * step_s);
    let (first, last) = (late.at(delay_s(0)), late.at(delay_s(TRIED_DELAYS - 1)));
    let mut total = share(0) * first.share + share(TRIED_DELAYS - 1) * last.share;
    // An interval between two delays is halved until no delay in it leads into the field, or its ends are adjacent.
    let mut gaps = vec![(0, first, TRIED_DELAYS - 1, last)];
    while let Some((from, before, to, after)) = gaps.pop() {
        if to - from < 2 || late.misses_between(&before, &after) {
            continue;
        }
        let middle = usize::midpoint(from, to);
        let between = late.at(delay_s(middle));
        total += share(middle) * between.share;
        gaps.push((from, before, middle, between.clone()));
        gaps.push((middle, between, to, after));
    }
    total.clamp(0.0, 1.0)
}

/// Tracks of one satellite past one field, for all delays.
struct DelayedTracks<'a, T> {
    /// Returns the line of sight as a function of time and delay, seconds.
    track: &'a T,
    exposure_s: (f64, f64),
    field: &'a FieldOnSky<'a>,
    cross_track_sigma_rad: f64,
}

/// Result for one delay.
#[derive(Clone)]
struct Tried {
    late_s: f64,
    samples: Vec<(f64, Sight)>,
    closest_rad: f64,
    /// Probability of the shifts across the track with which the satellite crosses the field.
    share: f64,
}

/// Margin for the curvature of the path. At a delay between two others, a satellite is no farther from its positions at
/// these two delays than this factor times the distance between the two positions.
const STRAYING: f64 = 1.1;

impl<T: Fn(f64, f64) -> Sight> DelayedTracks<'_, T> {
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
            // No point of the track is shifted farther than `shift_rad`.
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

    /// Returns true if no delay between two others leads into the field, with any shift across the track.
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

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::frames::Direction;
    use crate::passes::Field;

    /// Reference for [`crossing_probability_in_flight`]: the sum over all delays and all shifts.
    fn plain_sum(
        track: &impl Fn(f64, f64) -> Sight,
        (start_s, end_s): (f64, f64),
        field: &FieldOnSky,
        lateness: &Lateness,
        cross_track_sigma_rad: f64,
    ) -> f64 {
        let reach_s = lateness.reach_s();
        let step_s = 2.0 * reach_s / TRIED_DELAYS as f64;
        let mut total = 0.0;
        for delay in 0..TRIED_DELAYS {
            let late_s = step_s * (delay as f64 + 0.5) - reach_s;
            let density = lateness.share(late_s - 0.5 * step_s, late_s + 0.5 * step_s);
            for (node, weight) in GAUSS_HERMITE {
                let shifted = |time_s: f64| shifted_across(&track(time_s, late_s), node * cross_track_sigma_rad);
                if !cross(&shifted, start_s, end_s, field).chords.is_empty() {
                    total += density * weight;
                }
            }
        }
        total
    }

    /// Position and velocity on a circle, km and km/s.
    fn circling(radius_km: f64, node_rad: f64, tilt_rad: f64, from_rad: f64, time_s: f64) -> [Vector3<f64>; 2] {
        let rate_s = (398_600.44 / radius_km.powi(3)).sqrt();
        let (x, y) =
            (Vector3::new(node_rad.cos(), node_rad.sin(), 0.0), Vector3::new(-node_rad.sin(), node_rad.cos(), 0.0));
        let y = y * tilt_rad.cos() + Vector3::z() * tilt_rad.sin();
        let (sin, cos) = (from_rad + rate_s * time_s).sin_cos();
        [(x * cos + y * sin) * radius_km, (y * cos - x * sin) * radius_km * rate_s]
    }

    #[test]
    fn verif_skipped_delays_contribute_nothing() {
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
            // Pointed near the satellite in the middle of the exposure.
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
            let (lateness, across_rad) = (Lateness::gaussian(between(0.1, 4.0)), between(0.0, 0.01));
            let found = crossing_probability_in_flight(&track, (0.0, 10.0), &field, &lateness, across_rad);
            let expected = plain_sum(&track, (0.0, 10.0), &field, &lateness, across_rad);
            assert!((found - expected).abs() < ROUNDING, "case {case}: {found} {expected}");
            if expected > 0.0 { met += 1 } else { none += 1 }
        }
        assert!(met > 30 && none > 5, "{met} {none}");
    }
}
