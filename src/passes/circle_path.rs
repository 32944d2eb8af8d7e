//! A path through a field that is taken for a circle on the sky, run through at a steady rate: chords without any search.
//!
//! Within the few degrees of a field the way of a satellite leaves the great circle along which it sets out by arc minutes, and changes its
//! rate by a few per cent, which its two halves cancel. That is nothing where what counts is by how many minutes it may be late. Beside the
//! great circle, at a shift across it, the path is the small circle parallel to it.

use nalgebra::Vector3;

use super::crossing::{Sight, merge};
use super::field::{Border, FieldOnSky, sides};
use super::track::Chord;

/// A great circle and when a satellite is where on it.
#[derive(Copy, Clone, Debug)]
pub(super) struct CirclePath {
    /// When it passes nearest to the centre of the field, seconds.
    pub closest_s: f64,
    /// Where that is.
    closest: Vector3<f64>,
    /// Where it goes from there.
    ahead: Vector3<f64>,
    /// Shifts across the path go this way.
    pub across: Vector3<f64>,
    /// Rate along the circle.
    rate_rad_s: f64,
}

impl CirclePath {
    /// The path that leaves a sight by its rate; `None` where it stands still.
    pub fn of(sight: &Sight, time_s: f64, centre: &Vector3<f64>) -> Option<Self> {
        let here = sight.vector.try_normalize(0.0)?;
        let motion = (sight.rate_s - here * here.dot(&sight.rate_s)) / sight.vector.norm();
        let rate_rad_s = motion.norm();
        let ahead = motion.try_normalize(1e-12)?;
        // s(φ) = s₀ cos φ + t sin φ is nearest to the centre C where tan φ = t·C / s₀·C.
        let turn_rad = ahead.dot(centre).atan2(here.dot(centre));
        let (sin, cos) = turn_rad.sin_cos();
        Some(Self {
            closest_s: time_s + turn_rad / rate_rad_s,
            closest: here * cos + ahead * sin,
            ahead: ahead * cos - here * sin,
            across: here.cross(&ahead),
            rate_rad_s,
        })
    }

    /// Least angle to the centre of the field, radians.
    pub fn min_separation_rad(&self, centre: &Vector3<f64>) -> f64 {
        self.across.dot(centre).abs().atan2(self.closest.dot(centre))
    }

    /// The longest that any path beside this one stays in a field of this radius, seconds.
    pub fn longest_s(&self, radius_rad: f64) -> f64 {
        2.0 * radius_rad / self.rate_rad_s
    }

    /// Stretches inside the field of the path shifted across, in time order.
    pub fn chords(&self, shift_rad: f64, field: &FieldOnSky) -> Vec<Chord> {
        // The shift lies on the tangent, as in `probability`.
        let (sin, cos) = shift_rad.atan().sin_cos();
        let mut chords = Vec::new();
        let mut add = |from_rad: f64, to_rad: f64| {
            chords.push(Chord {
                enter_s: self.closest_s + from_rad / self.rate_rad_s,
                exit_s: self.closest_s + to_rad / self.rate_rad_s,
            });
        };
        for border in field.borders() {
            match border {
                Border::Rim(axis, radius_rad) => {
                    // A·s(φ) = cos X (A·e₁ cos φ + A·e₂ sin φ) + sin X A·n ≥ cos r
                    let (along, beside) = (cos * axis.dot(&self.closest), cos * axis.dot(&self.ahead));
                    let cosine = (radius_rad.cos() - sin * axis.dot(&self.across)) / along.hypot(beside);
                    if cosine < 1.0 {
                        let (middle_rad, half_rad) = (beside.atan2(along), cosine.max(-1.0).acos());
                        add(middle_rad - half_rad, middle_rad + half_rad);
                    }
                }
                Border::Outline(corners) => {
                    // The circle's tangent at its nearest point is a straight line on the tangent plane.
                    let nearest = self.closest * cos + self.across * sin;
                    let (Some(start), Some(end)) = (field.project(&nearest), field.project(&(nearest + self.ahead)))
                    else {
                        continue;
                    };
                    let mut cuts = cuts_of(start, [end[0] - start[0], end[1] - start[1]], corners);
                    cuts.sort_by(f64::total_cmp);
                    for pair in cuts.chunks_exact(2) {
                        add(pair[0].atan() / cos, pair[1].atan() / cos);
                    }
                }
            }
        }
        merge(chords)
    }

    /// Angle run through in a chord of the shifted path, radians.
    pub fn length_rad(&self, chord: &Chord, shift_rad: f64) -> f64 {
        (chord.exit_s - chord.enter_s) * self.rate_rad_s * shift_rad.atan().cos()
    }
}

/// Where a straight line `start` + τ `way` cuts the sides of a polygon: an even number of τ.
fn cuts_of(start: [f64; 2], way: [f64; 2], corners: &[[f64; 2]]) -> Vec<f64> {
    let beside = |point: [f64; 2]| way[0] * (point[1] - start[1]) - way[1] * (point[0] - start[0]);
    let square = way[0] * way[0] + way[1] * way[1];
    sides(corners)
        .filter_map(|(from, to)| {
            let (one, other) = (beside(from), beside(to));
            ((one >= 0.0) != (other >= 0.0)).then(|| {
                let share = one / (one - other);
                let cut = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share - start[axis]);
                (cut[0] * way[0] + cut[1] * way[1]) / square
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Direction;
    use crate::passes::Field;
    use crate::passes::crossing::cross;

    /// The same small circles, cut by search.
    #[test]
    fn verif_chords_of_circles_against_searched_ones() {
        /// What a search closes its roots to, and what the straight tangent in place of a small circle leaves (0.5 X φ² ≈ 3″ here), seconds.
        const RIM_S: f64 = 1e-6;
        const OUTLINE_S: f64 = 5e-3;
        let mosaic = r#"{"shapes": [{"name": "W", "rectangle_deg": [1, 2], "center_deg": [-1, 0]},
            {"name": "L", "polygon_deg": [[0.2, -1], [1.4, -1], [1.4, 1], [1.0, 1], [1.0, 0], [0.2, 0]]},
            {"name": "O", "circle_deg": 0.6, "center_deg": [0.4, 1.2]}], "unit": "deg"}"#;
        let pointing = Direction::from_lon_lat_rad(0.7, -0.4);
        let mut cut = 0;
        for (field, tolerance_s) in
            [(Field::circle(3.5f64.to_radians()).unwrap(), RIM_S), (Field::from_json(mosaic).unwrap(), OUTLINE_S)]
        {
            let on_sky = field.on_sky(&pointing, 0.3);
            let (east, north) = pointing.east_north();
            for step in 0..60 {
                let angle = f64::from(step) * 0.37;
                let aside = 0.02 * f64::from(step % 7 - 3);
                let here = (pointing.vector() + (east * angle.cos() + north * angle.sin()) * aside).normalize();
                let towards = east * (angle + 1.1).cos() + north * (angle + 1.1).sin();
                let ahead = (towards - here * here.dot(&towards)).normalize();
                let sight = Sight { vector: here, rate_s: ahead * 0.011 };
                let path = CirclePath::of(&sight, 40.0, on_sky.centre()).expect("a path");
                for shift_rad in [0.0, 0.01, -0.025, 0.04] {
                    let track = |time_s: f64| {
                        let (sin, cos) = (0.011 * (time_s - 40.0)).sin_cos();
                        let vector = here * cos + ahead * sin + here.cross(&ahead) * shift_rad;
                        Sight { vector, rate_s: (ahead * cos - here * sin) * 0.011 }
                    };
                    let searched = cross(&track, path.closest_s - 30.0, path.closest_s + 30.0, &on_sky).chords;
                    let found = path.chords(shift_rad, &on_sky);
                    assert_eq!(found.len(), searched.len(), "step {step} shift {shift_rad}: {found:?} {searched:?}");
                    for (found, searched) in found.iter().zip(&searched) {
                        cut += 1;
                        assert!((found.enter_s - searched.enter_s).abs() < tolerance_s, "{found:?} {searched:?}");
                        assert!((found.exit_s - searched.exit_s).abs() < tolerance_s, "{found:?} {searched:?}");
                    }
                }
            }
        }
        assert!(cut > 150, "{cut}");
    }
}
