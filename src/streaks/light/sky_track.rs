//! Track of a moving light on the sky while the shutter is open.

use nalgebra::Vector3;

use crate::frames::{Direction, Gcrs, seconds_between};
use crate::passes::{Exposure, Pass};

/// Direction, distance and magnitude of a light at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SkyPoint {
    /// Seconds after the shutter opened.
    pub time_s: f64,
    /// ICRS astrometric topocentric direction: the position relative to catalogue stars.
    pub direction: Direction<Gcrs>,
    /// Distance from the observer, km; it determines the defocus and the apparent size.
    pub range_km: f64,
    /// Apparent magnitude of the light, irrespective of its motion; `None` if it is dark (in the Earth's shadow).
    pub magnitude: Option<f64>,
}

impl SkyPoint {
    /// Distance of a light whose distance is unknown, km: it is a point in focus.
    pub(crate) const FAR_KM: f64 = 1e9;
}

/// Track of a moving light. Between its points, directions are interpolated smoothly and magnitudes linearly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkyTrack {
    /// Points in order of time.
    #[doc(hidden)]
    pub points: Vec<SkyPoint>,
}

impl SkyTrack {
    /// Returns the sampled track of a pass, from entry to exit.
    ///
    /// The pass must have samples ([`crate::passes::PassOptions::samples`]), so close that the brightness changes
    /// little from one sample to the next. The track of a pass without samples is empty.
    pub fn of_pass(pass: &Pass, exposure: &Exposure) -> Self {
        let points = pass.samples.iter().map(|sample| SkyPoint {
            time_s: seconds_between(exposure.start, sample.epoch),
            direction: sample.direction,
            range_km: sample.range_km,
            magnitude: sample.brightness.as_ref().map(|brightness| brightness.magnitude.0),
        });
        Self { points: points.collect() }
    }

    /// Returns the same track with points added so that adjacent points are at most `longest_s` seconds apart.
    ///
    /// Directions are interpolated by a cubic through the four nearest points, magnitudes linearly between two points.
    /// If one of the two points is dark, the interpolated light is dark.
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

    /// Returns the direction at a fraction (0 to 1) of the time from point `index` to the next, by cubic interpolation
    /// in time.
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

    /// Returns the time at which the light is nearest to the direction `target`, seconds after the shutter opened;
    /// `None` for a track without points. `seen` converts a point of the track to the frame of `target`, which may move
    /// with the telescope.
    pub(crate) fn closest_s(
        &self,
        target: &Direction<Gcrs>,
        seen: impl Fn(&SkyPoint) -> Direction<Gcrs>,
    ) -> Option<f64> {
        let away = |index: usize| seen(&self.points[index]).separation_rad(target);
        let nearest = (0..self.points.len()).min_by(|&a, &b| away(a).total_cmp(&away(b)))?;
        if nearest == 0 || nearest + 1 == self.points.len() {
            return Some(self.points[nearest].time_s);
        }
        // Vertex of the parabola through the squares of the three smallest distances.
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
            // On this curve, with points 14 mrad apart, the error of a cubic is about 1e-9 times the fourth power of
            // the step in seconds.
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
    fn verif_tracks_of_few_points_are_refined() {
        let point = |time_s: f64| SkyPoint { time_s, direction: circle(time_s), range_km: 600.0, magnitude: Some(5.0) };
        for count in 0..4 {
            let track = SkyTrack { points: (0..count).map(|second| point(f64::from(second))).collect() };
            let fine = track.refined(0.5);
            assert_eq!(fine.points.len(), if count == 0 { 0 } else { 2 * count as usize - 1 });
            assert!(fine.points.iter().all(|point| point.direction.vector().norm() > 0.999_999));
        }
    }
}
