//! A moving light on the sky while the shutter is open: what every streak is made from.

use nalgebra::Vector3;

use crate::frames::{Direction, Gcrs, seconds_between};
use crate::passes::{Exposure, Pass};

/// The light at one moment.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SkyPoint {
    /// Seconds after the shutter opened.
    pub time_s: f64,
    /// ICRS astrometric topocentric direction: the place among catalogue stars.
    pub direction: Direction<Gcrs>,
    /// Distance from the observer, km: it sets the defocus and the apparent size.
    pub range_km: f64,
    /// Apparent magnitude, as if it stood still; `None` where nothing is seen (the Earth's shadow).
    pub magnitude: Option<f64>,
}

/// Points in time order. Between them the place is smooth and the light changes evenly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkyTrack {
    /// The points, their times growing.
    pub points: Vec<SkyPoint>,
}

impl SkyTrack {
    /// The sampled track of a pass, from entry to exit.
    ///
    /// The pass must have been asked for with samples ([`crate::passes::PassOptions::samples`]), enough that the light changes little from one
    /// to the next; without them the track is empty.
    pub fn of_pass(pass: &Pass, exposure: &Exposure) -> Self {
        let points = pass.samples.iter().map(|sample| SkyPoint {
            time_s: seconds_between(exposure.start, sample.epoch),
            direction: sample.direction,
            range_km: sample.range_km,
            magnitude: sample.brightness.as_ref().map(|brightness| brightness.magnitude.0),
        });
        Self { points: points.collect() }
    }

    /// The same track with more points: none farther apart than `longest_s`, the old ones kept.
    ///
    /// The place comes from a cubic through the four nearest points, the light from the straight line between two; from a point to one in the
    /// dark it stays dark.
    pub fn refined(&self, longest_s: f64) -> Self {
        let mut points = Vec::with_capacity(self.points.len());
        for (index, pair) in self.points.windows(2).enumerate() {
            let [from, to] = [pair[0], pair[1]];
            points.push(from);
            let pieces = ((to.time_s - from.time_s) / longest_s).ceil();
            let pieces = if pieces.is_finite() { pieces.max(1.0) as usize } else { 1 };
            points.extend((1..pieces).map(|piece| {
                let share = piece as f64 / pieces as f64;
                let between = |a: f64, b: f64| a + share * (b - a);
                SkyPoint {
                    time_s: between(from.time_s, to.time_s),
                    direction: self.direction_between(index, share),
                    range_km: between(from.range_km, to.range_km),
                    magnitude: from.magnitude.zip(to.magnitude).map(|(a, b)| between(a, b)),
                }
            }));
        }
        points.extend(self.points.last());
        Self { points }
    }

    /// The direction at a share of the way from point `index` to the next, by Lagrange's cubic in time.
    fn direction_between(&self, index: usize, share: f64) -> Direction<Gcrs> {
        let last = self.points.len() - 1;
        let first = index.saturating_sub(1).min(last.saturating_sub(3));
        let near = &self.points[first..=last.min(first + 3)];
        let [from, to] = [self.points[index].time_s, self.points[index + 1].time_s];
        let time_s = from + share * (to - from);
        // r(t) = Σ_i r_i Π_{j≠i} (t - t_j) / (t_i - t_j)
        let mut sum = Vector3::zeros();
        for (i, point) in near.iter().enumerate() {
            let others = near.iter().enumerate().filter(|(j, _)| *j != i);
            let weight: f64 =
                others.map(|(_, other)| (time_s - other.time_s) / (point.time_s - other.time_s)).product();
            sum += point.direction.vector() * weight;
        }
        Direction::from_vector(sum.normalize())
    }

    /// When it passes most closely by a place that may move: `seen` turns a point's direction into that of the place's own sky. Seconds after the shutter
    /// opened; `None` for a track without points.
    pub fn closest_s(&self, place: &Direction<Gcrs>, seen: impl Fn(&SkyPoint) -> Direction<Gcrs>) -> Option<f64> {
        let away = |index: usize| seen(&self.points[index]).separation_rad(place);
        let nearest = (0..self.points.len()).min_by(|&a, &b| away(a).total_cmp(&away(b)))?;
        if nearest == 0 || nearest + 1 == self.points.len() {
            return Some(self.points[nearest].time_s);
        }
        // The vertex of the parabola through the squares of three distances.
        let [before, here, after] = [nearest - 1, nearest, nearest + 1].map(|index| away(index).powi(2));
        let (from_s, to_s) = (self.points[nearest - 1].time_s, self.points[nearest + 1].time_s);
        let bend = before - 2.0 * here + after;
        let shift = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        Some(self.points[nearest].time_s + shift.clamp(-1.0, 1.0) * 0.5 * (to_s - from_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(time_s: f64) -> Direction<Gcrs> {
        Direction::from_lon_lat_rad(0.014 * time_s, 0.3 * (0.02 * time_s).sin())
    }

    #[test]
    fn verif_points_between_lie_on_the_smooth_track() {
        let point = |time_s: f64| SkyPoint {
            time_s,
            direction: circle(time_s),
            range_km: 600.0,
            magnitude: (time_s < 6.5).then_some(5.0 + time_s),
        };
        let track = SkyTrack { points: (0..9).map(|second| point(f64::from(second))).collect() };
        let fine = track.refined(0.1);
        assert_eq!(fine.points.len(), 81);
        for point in &fine.points {
            // A cubic through points 14 mrad apart on a curve of this bend: 1e-9 of the square-square of the step.
            assert!(point.direction.separation_rad(&circle(point.time_s)) < 2e-8, "{}", point.time_s);
            let lit = point.time_s < 6.0 + 1e-9;
            assert_eq!(point.magnitude.is_some(), lit, "{}", point.time_s);
            assert!(point.magnitude.is_none_or(|magnitude| (magnitude - 5.0 - point.time_s).abs() < 1e-9));
        }
        assert_eq!(track.refined(100.0), track);
        let nearest_s = track.closest_s(&circle(3.3), |point| point.direction).unwrap();
        assert!((nearest_s - 3.3).abs() < 0.01, "{nearest_s}");
    }

    #[test]
    fn verif_short_tracks_are_refined_too() {
        let point = |time_s: f64| SkyPoint { time_s, direction: circle(time_s), range_km: 600.0, magnitude: Some(5.0) };
        for count in 0..4 {
            let track = SkyTrack { points: (0..count).map(|second| point(f64::from(second))).collect() };
            let fine = track.refined(0.5);
            assert_eq!(fine.points.len(), if count == 0 { 0 } else { 2 * count as usize - 1 });
            assert!(fine.points.iter().all(|point| point.direction.vector().norm() > 0.999_999));
        }
    }
}
