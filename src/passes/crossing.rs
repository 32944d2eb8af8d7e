//! Crossing of a field: the times at which a track enters and leaves the field, accurate to well under a millisecond.
//!
//! The track is any smooth function of time. It is divided into steps in which the line of sight turns by at most about
//! two degrees. In each step, the angle between the line of sight and the centre of a circle has at most one extremum,
//! which is found from the sign of the angle's derivative. The step is divided at the extremum, so that in each part
//! the angle is monotonic and equals the radius at most once. Crossings of polygons are computed on the tangent plane,
//! where the track is nearly straight.

use nalgebra::Vector3;

use super::field::{Border, FieldOnSky, edges, polygon_contains};
use super::track::{Chord, Sight};

impl Sight {
    /// Returns the angle between the line of sight and an axis, radians.
    fn angle_rad(&self, axis: &Vector3<f64>) -> f64 {
        axis.cross(&self.vector).norm().atan2(axis.dot(&self.vector))
    }

    /// Returns a number with the sign of the derivative of the cosine of the angle to an axis: positive while the
    /// satellite approaches the axis.
    fn approach(&self, axis: &Vector3<f64>) -> f64 {
        let square = self.vector.norm_squared();
        (axis.dot(&self.rate_s) * square - axis.dot(&self.vector) * self.vector.dot(&self.rate_s)) / square.powf(1.5)
    }

    /// Speed on the sky, rad/s.
    pub(super) fn angular_rate_rad_s(&self) -> f64 {
        self.vector.cross(&self.rate_s).norm() / self.vector.norm_squared()
    }
}

/// Parts of a track inside a field, and the closest approach to the centre of the field.
#[derive(Clone, Debug)]
pub(super) struct Crossing {
    /// Parts of the track inside the field, in time order, without overlaps.
    pub chords: Vec<Chord>,
    /// Smallest angle to the centre of the field, radians.
    pub min_separation_rad: f64,
    /// Time of the smallest angle, seconds.
    pub closest_s: f64,
}

/// Longest step at any speed, seconds. It is limited because parallax changes the direction of a distant satellite
/// within hours.
const LONGEST_STEP_S: f64 = 60.0;
/// Approximate largest turn of the line of sight in a step, radians.
const LARGEST_TURN_RAD: f64 = 0.03;
/// Largest motion of the satellite in a step as a fraction of its distance. If a satellite comes straight towards the
/// observer, the line of sight turns suddenly as it passes.
const LARGEST_APPROACH: f64 = 0.25;
/// Tolerance of roots, seconds.
const ROOT_S: f64 = 1e-7;
/// Largest turn in a step inside the bounding circle of a polygon, radians. The arc then deviates from its chord by at
/// most 0.01 arcsec.
const POLYGON_TURN_RAD: f64 = 5e-4;

/// Returns the parts of a track inside a field from `start_s` to `end_s`, and the closest approach.
pub(super) fn cross(track: &impl Fn(f64) -> Sight, start_s: f64, end_s: f64, field: &FieldOnSky) -> Crossing {
    cross_samples(track, &sample(track, start_s, end_s), field)
}

/// Returns the result of [`cross`] for a track that is already sampled by [`sample`].
pub(super) fn cross_samples(track: &impl Fn(f64) -> Sight, samples: &[(f64, Sight)], field: &FieldOnSky) -> Crossing {
    let with_extremes = extremes(track, samples, field.centre());
    let (closest_s, min_separation_rad) = nearest(&with_extremes, field);
    let mut chords = Vec::new();
    if min_separation_rad <= field.bounding_radius_rad() {
        let mut near = None;
        for border in field.borders() {
            match border {
                Border::Rim(axis, radius_rad) if axis == *field.centre() => {
                    inside_circle(track, &with_extremes, &axis, radius_rad, &mut chords);
                }
                Border::Rim(axis, radius_rad) => {
                    inside_circle(track, &extremes(track, samples, &axis), &axis, radius_rad, &mut chords);
                }
                Border::Outline(corners) => {
                    let near = near.get_or_insert_with(|| near_polygons(track, &with_extremes, field));
                    for part in near.iter() {
                        inside_polygon(track, part, corners, field, &mut chords);
                    }
                }
            }
        }
    }
    Crossing { chords: merge(chords), min_separation_rad, closest_s }
}

/// Returns the time and the angle of the sample that is nearest to the centre of a field.
fn nearest(samples: &[(f64, Sight)], field: &FieldOnSky) -> (f64, f64) {
    let first_s = samples.first().map_or(0.0, |(time_s, _)| *time_s);
    samples
        .iter()
        .map(|(time_s, sight)| (*time_s, sight.angle_rad(field.centre())))
        .fold((first_s, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
}

/// Returns times and lines of sight from start to end, in steps so short that each contains at most one extremum of an
/// angle.
pub(super) fn sample(track: &impl Fn(f64) -> Sight, start_s: f64, end_s: f64) -> Vec<(f64, Sight)> {
    let mut samples = Vec::with_capacity(16);
    let (mut time_s, mut sight) = (start_s, track(start_s));
    samples.push((time_s, sight));
    while time_s < end_s {
        let passing_s = LARGEST_APPROACH * sight.vector.norm() / sight.rate_s.norm().max(1e-9);
        let mut step_s = (LARGEST_TURN_RAD / sight.angular_rate_rad_s().max(1e-9)).min(passing_s).min(LONGEST_STEP_S);
        let mut next = track((time_s + step_s).min(end_s));
        // The satellite may be faster at the end of the step than at its beginning.
        while next.angular_rate_rad_s() * step_s > 2.0 * LARGEST_TURN_RAD && step_s > 1e-3 {
            step_s *= 0.5;
            next = track((time_s + step_s).min(end_s));
        }
        time_s = (time_s + step_s).min(end_s);
        sight = next;
        samples.push((time_s, sight));
    }
    samples
}

/// Returns the samples with the points added at which the track is nearest to or farthest from an axis, so that the
/// angle is monotonic in every interval.
fn extremes(track: &impl Fn(f64) -> Sight, samples: &[(f64, Sight)], axis: &Vector3<f64>) -> Vec<(f64, Sight)> {
    let mut all = Vec::with_capacity(samples.len() + 2);
    for pair in samples.windows(2) {
        let [(a_s, a), (b_s, b)] = [pair[0], pair[1]];
        all.push((a_s, a));
        let (rate_a, rate_b) = (a.approach(axis), b.approach(axis));
        if rate_a * rate_b < 0.0 {
            let time_s = root(|time_s| track(time_s).approach(axis), (a_s, rate_a), (b_s, rate_b));
            all.push((time_s, track(time_s)));
        }
    }
    all.extend(samples.last());
    all
}

fn inside_circle(
    track: &impl Fn(f64) -> Sight,
    samples: &[(f64, Sight)],
    axis: &Vector3<f64>,
    radius_rad: f64,
    chords: &mut Vec<Chord>,
) {
    let depth = |sight: &Sight| radius_rad - sight.angle_rad(axis);
    let (first_s, first) = samples[0];
    let mut before = (first_s, depth(&first));
    let mut enter_s = (before.1 >= 0.0).then_some(first_s);
    for (time_s, sight) in &samples[1..] {
        let now = (*time_s, depth(sight));
        if (before.1 >= 0.0) != (now.1 >= 0.0) {
            let border_s = root(|time_s| depth(&track(time_s)), before, now);
            match enter_s.take() {
                Some(enter_s) => chords.push(Chord { enter_s, exit_s: border_s }),
                None => enter_s = Some(border_s),
            }
        }
        before = now;
    }
    chords.extend(enter_s.map(|enter_s| Chord { enter_s, exit_s: before.0 }));
}

/// Part of a track inside the bounding circle, finely sampled on the tangent plane: times and positions.
type Part = Vec<(f64, [f64; 2])>;

fn near_polygons(track: &impl Fn(f64) -> Sight, samples: &[(f64, Sight)], field: &FieldOnSky) -> Vec<Part> {
    let mut inside = Vec::new();
    inside_circle(track, samples, field.centre(), field.bounding_radius_rad() * (1.0 + 1e-9), &mut inside);
    inside
        .iter()
        .map(|chord| {
            let length_s = chord.exit_s - chord.enter_s;
            let middle = track(0.5 * (chord.enter_s + chord.exit_s));
            let turn_rad = middle.angular_rate_rad_s() * length_s;
            let steps = (turn_rad / POLYGON_TURN_RAD).ceil().clamp(8.0, 4096.0) as usize;
            (0..=steps)
                .filter_map(|step| {
                    let time_s = chord.enter_s + length_s * step as f64 / steps as f64;
                    field.project(&track(time_s).vector).map(|point| (time_s, point))
                })
                .collect()
        })
        .collect()
}

fn inside_polygon(
    track: &impl Fn(f64) -> Sight,
    part: &Part,
    corners: &[[f64; 2]],
    field: &FieldOnSky,
    chords: &mut Vec<Chord>,
) {
    let (Some((first_s, _)), Some((last_s, _))) = (part.first(), part.last()) else { return };
    let mut times_s = vec![*first_s];
    for pair in part.windows(2) {
        let ((a_s, a), (b_s, b)) = (pair[0], pair[1]);
        for (from, to) in edges(corners) {
            // Positive on one side of the line through the edge, negative on the other.
            let side =
                |point: [f64; 2]| (to[0] - from[0]) * (point[1] - from[1]) - (to[1] - from[1]) * (point[0] - from[0]);
            let (side_a, side_b) = (side(a), side(b));
            if (side_a >= 0.0) == (side_b >= 0.0) {
                continue;
            }
            let across = |point: [f64; 2]| (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
            if (across(from) >= 0.0) == (across(to) >= 0.0) {
                continue;
            }
            let on_track = |time_s: f64| field.project(&track(time_s).vector).map_or(side_a, side);
            times_s.push(root(on_track, (a_s, side_a), (b_s, side_b)));
        }
    }
    times_s.push(*last_s);
    times_s.sort_by(f64::total_cmp);
    for pair in times_s.windows(2) {
        let middle = field.project(&track(0.5 * (pair[0] + pair[1])).vector);
        if middle.is_some_and(|point| polygon_contains(corners, point)) {
            chords.push(Chord { enter_s: pair[0], exit_s: pair[1] });
        }
    }
}

/// Sorts chords and joins those that touch or overlap.
pub(super) fn merge(mut chords: Vec<Chord>) -> Vec<Chord> {
    chords.sort_by(|a, b| a.enter_s.total_cmp(&b.enter_s));
    let mut merged: Vec<Chord> = Vec::with_capacity(chords.len());
    for chord in chords {
        match merged.last_mut() {
            Some(last) if chord.enter_s <= last.exit_s + 2.0 * ROOT_S => last.exit_s = last.exit_s.max(chord.exit_s),
            _ => merged.push(chord),
        }
    }
    merged
}

/// Returns a root between two times at which the function has opposite signs, to [`ROOT_S`]. The method is inverse
/// quadratic interpolation where that is safe, otherwise bisection (Chandrupatla 1997, Adv. Eng. Software 28, 145).
pub(super) fn root(function: impl Fn(f64) -> f64, first: (f64, f64), other: (f64, f64)) -> f64 {
    let ((mut a, mut fa), (mut b, mut fb)) = (first, other);
    let mut share = 0.5;
    // Bisection halves the bracket at each step, so 100 steps suffice for any bracket.
    for _ in 0..100 {
        let x = a + share * (b - a);
        let fx = function(x);
        let (c, fc);
        if (fx >= 0.0) == (fa >= 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc) = (b, fb);
            (b, fb) = (a, fa);
        }
        (a, fa) = (x, fx);
        let least = ROOT_S / (b - a).abs();
        if least > 0.5 || fx == 0.0 {
            break;
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        share = if phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        share = share.clamp(least, 1.0 - least);
    }
    if fa.abs() < fb.abs() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Direction, Gcrs};
    use crate::passes::Field;

    /// Satellite on a great circle: at longitude `rate · t` on the equator, tilted about the x axis.
    fn great_circle(rate_rad_s: f64, offset_rad: f64) -> impl Fn(f64) -> Sight {
        move |time_s: f64| {
            let (sin, cos) = (rate_rad_s * time_s).sin_cos();
            let (so, co) = offset_rad.sin_cos();
            Sight {
                vector: Vector3::new(cos * co, sin * co, so) * 700.0,
                rate_s: Vector3::new(-sin * co, cos * co, 0.0) * (700.0 * rate_rad_s),
            }
        }
    }

    fn pointing() -> Direction<Gcrs> {
        Direction::from_lon_lat_rad(0.0, 0.0)
    }

    /// Compares entry and exit with the closed form cos r = cos b cos(ω t) of a small circle at latitude b.
    #[test]
    fn verif_circle_against_closed_form() {
        let rate = 0.013;
        for (diameter_deg, offset_deg) in
            [(3.5_f64, 0.0_f64), (3.5, 1.2), (3.5, 1.749_999), (0.01, 0.004), (60.0, 20.0)]
        {
            let field = Field::circle(diameter_deg.to_radians()).expect("a field");
            let track = great_circle(rate, offset_deg.to_radians());
            let crossing = cross(&track, -100.0, 100.0, &field.on_sky(&pointing(), 0.3));
            let half_s = ((0.5 * diameter_deg).to_radians().cos() / offset_deg.to_radians().cos()).acos() / rate;
            assert_eq!(crossing.chords.len(), 1, "{diameter_deg} {offset_deg}");
            let chord = crossing.chords[0];
            // The grazing case is sensitive to rounding: its tolerance is 1e-4 s, that of the other cases 1e-6 s.
            let tolerance_s = if offset_deg > 1.7 && offset_deg < 2.0 { 1e-4 } else { 1e-6 };
            assert!(
                (chord.enter_s + half_s).abs() < tolerance_s && (chord.exit_s - half_s).abs() < tolerance_s,
                "{diameter_deg} {offset_deg}: {chord:?} {half_s}"
            );
            assert!((crossing.min_separation_rad - offset_deg.to_radians()).abs() < 1e-9);
        }
        let field = Field::circle(3.5_f64.to_radians()).expect("a field");
        let miss =
            cross(&great_circle(rate, 1.750_001_f64.to_radians()), -100.0, 100.0, &field.on_sky(&pointing(), 0.0));
        assert!(miss.chords.is_empty());
    }

    /// The equator is a straight line on the tangent plane: tan(ω t) = x at the border of a rectangle, and the gap of a
    /// mosaic has no chord.
    #[test]
    fn verif_rectangle_and_mosaic_against_closed_form() {
        let rate = 0.01;
        let field = Field::from_json(
            r#"{"shapes": [{"name": "W", "rectangle_deg": [1, 2], "center_deg": [-1, 0]},
                           {"name": "E", "rectangle_deg": [1, 2], "center_deg": [1, 0]}], "unit": "deg"}"#,
        )
        .expect("a field");
        // At rotation 0 x is east: the track at rate > 0 moves from -x to +x.
        let crossing = cross(&great_circle(rate, 0.0), -10.0, 10.0, &field.on_sky(&pointing(), 0.0));
        let expected: Vec<f64> = [-1.5_f64, -0.5, 0.5, 1.5].iter().map(|x| x.to_radians().atan() / rate).collect();
        let found: Vec<f64> = crossing.chords.iter().flat_map(|chord| [chord.enter_s, chord.exit_s]).collect();
        assert_eq!(found.len(), 4, "{crossing:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        // Rotated by 90 degrees the two chips lie north and south of the track, which passes through the gap.
        let turned = cross(&great_circle(rate, 0.0), -10.0, 10.0, &field.on_sky(&pointing(), 90f64.to_radians()));
        assert!(turned.chords.is_empty(), "{turned:?}");
    }

    /// Shutter times limit a chord; a stationary satellite is inside all the time or never.
    #[test]
    fn verif_shutter_and_standstill() {
        let field = Field::circle(2f64.to_radians()).expect("a field");
        let sky = field.on_sky(&pointing(), 0.0);
        let cut = cross(&great_circle(0.01, 0.0), -0.5, 0.25, &sky);
        assert_eq!(cut.chords, vec![Chord { enter_s: -0.5, exit_s: 0.25 }]);
        let still = cross(&great_circle(0.0, 0.5_f64.to_radians()), 0.0, 300.0, &sky);
        assert_eq!(still.chords, vec![Chord { enter_s: 0.0, exit_s: 300.0 }]);
        assert!(cross(&great_circle(0.0, 1.5_f64.to_radians()), 0.0, 300.0, &sky).chords.is_empty());
        let nothing = cross(&great_circle(0.01, 0.0), 0.0, 0.0, &sky);
        assert_eq!(nothing.chords, vec![Chord { enter_s: 0.0, exit_s: 0.0 }]);
    }
}
