//! Corridors: the pixels of a chip that the light of one satellite may reach, given the errors of its position.
//!
//! A satellite that is late by δ is at time t where it was predicted for t - δ, but it is seen from the position of the
//! site at t: its streak begins and ends elsewhere on the track, and is shifted across the track by the motion of the
//! site during the delay. A corridor is the predicted track, longer at both ends of the exposure by the delay, and
//! widened by the error across the track, which includes the shift by the delay, and by the width of the light.

use nalgebra::Vector3;

use super::super::chip::Chip;
use super::super::light::{SkyPoint, SkyTrack};
use super::super::render::StreakPath;
use super::super::tracking::Tracking;
use crate::error::Error;
use crate::frames::{Direction, Gcrs};
use crate::images::PixelPosition;

/// Largest time between two sampled directions of a track, seconds. Directions between them are interpolated by cubics.
const STEP_S: f64 = 1.0;
/// Largest number of sampled directions of a track.
const MOST_SAMPLES: f64 = 4000.0;
/// Smallest number of sampled directions, which a cubic needs.
const FEWEST_SAMPLES: f64 = 4.0;
/// Length of a cell along the track, pixels: half of a cell of the noise.
const CELL_PIX: f64 = 32.0;
/// Shortest corridor, seconds.
const LEAST_S: f64 = 1e-6;

/// Track of a satellite with its errors.
#[derive(Copy, Clone)]
pub struct UncertainTrack<'a> {
    /// Direction and distance, km, at a predicted time, seconds after the shutter opened.
    pub sight: &'a (dyn Fn(f64) -> (Direction<Gcrs>, f64) + Sync),
    /// First and last predicted time at which the satellite may be seen while the shutter is open.
    pub times_s: [f64; 2],
    /// Largest distance across the track, radians.
    pub across_rad: f64,
}

/// Part of a corridor: a line of the track, and the distance from it up to which there may be light.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Cell {
    /// Ends of the line, pixels.
    pub ends: [PixelPosition; 2],
    /// Distance from the line that is covered, pixels.
    pub radius_pix: f64,
    /// The part of it that is due to the width of the light, pixels.
    pub light_pix: f64,
    /// Predicted times at both ends, seconds after the shutter opened.
    pub times_s: [f64; 2],
}

impl Cell {
    /// Returns the predicted time at the middle of the line.
    pub fn time_s(&self) -> f64 {
        0.5 * (self.times_s[0] + self.times_s[1])
    }

    /// Returns the light at the middle of the line; the rate is the greatest of those at the middle and at both ends.
    fn light(&self, rate: &dyn Fn(f64) -> f64) -> LocalLight {
        let ([from, to], [from_s, to_s]) = (self.ends, self.times_s);
        LocalLight {
            at: self.middle(),
            rate: [from_s, self.time_s(), to_s].into_iter().map(rate).fold(0.0, f64::max),
            motion_pix_s: [(to.x - from.x) / (to_s - from_s), (to.y - from.y) / (to_s - from_s)],
        }
    }

    /// Returns the middle of the line.
    pub fn middle(&self) -> PixelPosition {
        let [from, to] = self.ends;
        PixelPosition { x: 0.5 * (from.x + to.x), y: 0.5 * (from.y + to.y) }
    }

    /// Returns true if the cell may cover a pixel of a chip.
    fn reaches(&self, chip: &Chip) -> bool {
        let overlaps = |of: fn(&PixelPosition) -> f64, pixels: &std::ops::Range<usize>| {
            let [from, to] = [of(&self.ends[0]), of(&self.ends[1])];
            from.max(to) + self.radius_pix >= pixels.start as f64
                && from.min(to) - self.radius_pix <= pixels.end as f64 - 1.0
        };
        let area = &chip.light_area;
        overlaps(|end| end.x, &area.columns) && overlaps(|end| end.y, &area.rows)
    }
}

/// Light of a satellite at one position of a chip.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LocalLight {
    /// Position, pixels.
    pub at: PixelPosition,
    /// Light per second, in the unit of the frame; 0 in the Earth's shadow.
    pub rate: f64,
    /// Motion, pixels per second.
    pub motion_pix_s: [f64; 2],
}

impl UncertainTrack<'_> {
    /// Returns the first and the last time at which the satellite may be within `radius_rad` of a direction; `None` if
    /// it is never near.
    pub fn near_s(&self, middle: &Direction<Gcrs>, radius_rad: f64) -> Option<[f64; 2]> {
        let times_s = evenly(self.times_s);
        let directions: Vec<Direction<Gcrs>> = times_s.iter().map(|time_s| (self.sight)(*time_s).0).collect();
        let step_rad = directions.windows(2).map(|pair| pair[0].separation_rad(&pair[1])).fold(0.0, f64::max);
        let reach_rad = radius_rad + self.across_rad + step_rad;
        let is_near = |index: &usize| directions[*index].separation_rad(middle) <= reach_rad;
        let (from, to) = ((0..times_s.len()).find(is_near)?, (0..times_s.len()).rfind(is_near)?);
        Some([times_s[from.saturating_sub(1)], times_s[(to + 1).min(times_s.len() - 1)]])
    }

    /// Returns the cells of the corridor on a chip, in order of time. Cells that cannot reach the chip, and those
    /// without light, are omitted.
    ///
    /// `rate` returns the light per second at a predicted time, in the unit of the frame, 0 if the satellite is dark;
    /// `half_width_pix` the distance up to which the light is to be covered, `None` if it is nowhere bright enough; and
    /// `reach_pix` is the largest such distance.
    ///
    /// # Errors
    /// A position is not finite.
    pub fn cells(
        &self,
        chip: &Chip,
        rate: &dyn Fn(f64) -> f64,
        reach_pix: f64,
        mut half_width_pix: impl FnMut(&LocalLight) -> Option<f64>,
    ) -> Result<Vec<Cell>, Error> {
        let Some((middle, radius_rad)) = chip.circle() else { return Ok(Vec::new()) };
        let pixel_rad = (chip.pixel_scale_arcsec() / 3600.0).to_radians();
        let near_rad = radius_rad + reach_pix * pixel_rad;
        let near_s = self.near_s(&middle, near_rad).filter(|[from_s, to_s]| to_s - from_s >= LEAST_S);
        let Some(near_s) = near_s else { return Ok(Vec::new()) };
        let point = |time_s: f64| {
            let (direction, range_km) = (self.sight)(time_s);
            SkyPoint { time_s, direction, range_km, magnitude: None }
        };
        let track = SkyTrack { points: evenly(near_s).into_iter().map(point).collect() };
        // Of wide errors across the track, only those that lead near the chip are used, because world coordinates may
        // not be defined far from it.
        let [from_rad, to_rad] = if self.across_rad > near_rad {
            let away_rad = distance_across(&track, &middle);
            [(-self.across_rad).max(away_rad - near_rad), self.across_rad.min(away_rad + near_rad)]
        } else {
            [-self.across_rad, self.across_rad]
        };
        if from_rad > to_rad {
            return Ok(Vec::new());
        }
        // Pixels are counted along their shorter side.
        let aspect = chip.pixel_aspect();
        let across_pix = 0.5 * (to_rad - from_rad) / pixel_rad * aspect.max(1.0 / aspect).sqrt();
        let shifted = shifted(&track, 0.5 * (from_rad + to_rad));
        let mut cells = Vec::new();
        for path in chip.paths(&shifted, &Tracking::Sidereal, &middle, reach_pix + across_pix)? {
            for mut cell in cells_of(&path.path, across_pix + reach_pix).filter(|cell| cell.reaches(chip)) {
                let light = cell.light(rate);
                if light.rate > 0.0
                    && let Some(light_pix) = half_width_pix(&light)
                {
                    (cell.radius_pix, cell.light_pix) = (across_pix + light_pix, light_pix);
                    cells.push(cell);
                }
            }
        }
        cells.retain(|cell| cell.reaches(chip));
        Ok(cells)
    }
}

/// Returns the cells of a path, all with the same radius.
fn cells_of(path: &StreakPath, radius_pix: f64) -> impl Iterator<Item = Cell> {
    let nodes = path.nodes();
    let [from_s, to_s] = [nodes[0].time_s, nodes[nodes.len() - 1].time_s];
    let count = (path.length_pix() / CELL_PIX).ceil().max(1.0) as usize;
    let step_s = (to_s - from_s) / count as f64;
    (0..count).map(move |step| {
        let times_s = [step, step + 1].map(|step| from_s + step_s * step as f64);
        Cell { ends: times_s.map(|time_s| path.point_at(time_s)), times_s, radius_pix, light_pix: 0.0 }
    })
}

/// Returns the unit vector across a track at one of its points; zero if it does not move.
fn across(track: &SkyTrack, index: usize) -> Vector3<f64> {
    let points = &track.points;
    let [from, to] =
        [index.saturating_sub(1), (index + 1).min(points.len() - 1)].map(|at| *points[at].direction.vector());
    points[index].direction.vector().cross(&(to - from)).try_normalize(0.0).unwrap_or_default()
}

/// Returns the angle from a track to a direction, measured across it.
fn distance_across(track: &SkyTrack, direction: &Direction<Gcrs>) -> f64 {
    let away = |index: &usize| track.points[*index].direction.separation_rad(direction);
    let nearest = (0..track.points.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0);
    across(track, nearest).dot(direction.vector()).clamp(-1.0, 1.0).asin()
}

/// Returns a track that is shifted across its direction.
fn shifted(track: &SkyTrack, angle_rad: f64) -> SkyTrack {
    if angle_rad == 0.0 {
        return track.clone();
    }
    let shifted = |(index, point): (usize, &SkyPoint)| {
        let vector = point.direction.vector() * angle_rad.cos() + across(track, index) * angle_rad.sin();
        SkyPoint { direction: Direction::from_vector(vector.normalize()), ..*point }
    };
    SkyTrack { points: track.points.iter().enumerate().map(shifted).collect() }
}

/// Returns evenly spaced times from the first to the last.
fn evenly([from_s, to_s]: [f64; 2]) -> Vec<f64> {
    let steps = ((to_s - from_s) / STEP_S).ceil().clamp(FEWEST_SAMPLES - 1.0, MOST_SAMPLES);
    (0..=steps as usize).map(|step| from_s + (to_s - from_s) * step as f64 / steps).collect()
}
