//! Predicted track of a streak as a function of the pixel index along it.

use crate::images::PixelPosition;
use crate::streaks::StreakPath;

/// Number of points of the path between two of its nodes.
const SAMPLES: usize = 8;

/// Track across a frame, with one position for each column of the frame (or for each row, if the direction of the track
/// is nearer to that of the columns).
///
/// The axis of the frame whose direction is nearer to that of the track is the major axis, the other one the minor
/// axis.
#[derive(Clone, Debug)]
pub struct Corridor {
    /// True if the major axis is the x axis.
    pub is_along_rows: bool,
    /// Index of the first pixel on the major axis.
    pub first: usize,
    /// Position on the minor axis at the centre of each pixel of the major axis, pixels.
    pub centre: Vec<f64>,
    /// Time at which the predicted satellite is at this position, seconds after the shutter opened.
    pub time_s: Vec<f64>,
    /// Unit vector of the motion at the middle, pixels.
    pub motion: [f64; 2],
    /// Position at the middle of the track, pixels.
    pub middle: PixelPosition,
    /// Speed at the middle, pixels per second.
    pub speed_pix_s: f64,
    /// Number of pixels of the frame on the minor axis.
    pub minor_count: usize,
}

impl Corridor {
    /// Creates the corridor of a path; `None` if fewer than `least` pixels of the major axis are in the frame.
    pub fn new(path: &StreakPath, rows: usize, columns: usize, least: usize) -> Option<Self> {
        let points = sampled(path);
        let (start, end) = (points.first()?, points.last()?);
        let is_along_rows = (end.1.x - start.1.x).abs() >= (end.1.y - start.1.y).abs();
        let axes = |at: PixelPosition| if is_along_rows { (at.x, at.y) } else { (at.y, at.x) };
        let (major_count, minor_count) = if is_along_rows { (columns, rows) } else { (rows, columns) };
        let mut line: Vec<(f64, f64, f64)> =
            points.iter().map(|(time, at)| (axes(*at).0, axes(*at).1, *time)).collect();
        if line[0].0 > line[line.len() - 1].0 {
            line.reverse();
        }
        // Only the part in which the track advances on the major axis is kept.
        let mut farthest = f64::NEG_INFINITY;
        line.retain(|(major, ..)| {
            let advances = *major > farthest;
            farthest = farthest.max(*major);
            advances
        });
        let first = line.first()?.0.ceil().max(0.0);
        let last = line.last()?.0.floor().min(major_count as f64 - 1.0);
        if last - first + 1.0 < least.max(2) as f64 {
            return None;
        }
        let (first, last) = (first as usize, last as usize);
        let (mut centre, mut time_s) = (Vec::new(), Vec::new());
        let mut segment = 0;
        for index in first..=last {
            let at = index as f64;
            while segment + 2 < line.len() && line[segment + 1].0 < at {
                segment += 1;
            }
            let (from, to) = (line[segment], line[segment + 1]);
            let share = (at - from.0) / (to.0 - from.0);
            centre.push(from.1 + share * (to.1 - from.1));
            time_s.push(from.2 + share * (to.2 - from.2));
        }
        let count = centre.len();
        let (major, minor) = ((count - 1) as f64, centre[count - 1] - centre[0]);
        let sense = (time_s[count - 1] - time_s[0]).signum();
        let length = major.hypot(minor);
        let (along, beside) = (sense * major / length, sense * minor / length);
        let motion = if is_along_rows { [along, beside] } else { [beside, along] };
        let middle = count / 2;
        let (at_major, at_minor) = ((first + middle) as f64, centre[middle]);
        let (x, y) = if is_along_rows { (at_major, at_minor) } else { (at_minor, at_major) };
        Some(Self {
            is_along_rows,
            first,
            speed_pix_s: length / (time_s[count - 1] - time_s[0]).abs(),
            motion,
            middle: PixelPosition { x, y },
            minor_count,
            centre,
            time_s,
        })
    }

    /// Returns the number of pixels of the major axis.
    pub fn len(&self) -> usize {
        self.centre.len()
    }

    /// Returns row and column of the pixels on the track that are in the frame.
    pub fn pixels(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.centre.iter().enumerate().filter_map(|(index, minor)| {
            let (major, minor) = (self.first + index, minor.round());
            let is_inside = (0.0..self.minor_count as f64).contains(&minor);
            let minor = minor as usize;
            is_inside.then_some(if self.is_along_rows { [minor, major] } else { [major, minor] })
        })
    }

    /// Returns the delay of a position of the search, seconds. A shift along the minor axis is the sum of a shift
    /// across the track and one along the track.
    pub fn delay_s(&self, late_s: f64, minor_pix: f64) -> f64 {
        let along = if self.is_along_rows { self.motion[1] } else { self.motion[0] };
        late_s - minor_pix * along / self.speed_pix_s
    }

    /// Returns the cosine of the angle between the track and the major axis, from 0.7 to 1.
    pub fn cos(&self) -> f64 {
        if self.is_along_rows { self.motion[0].abs() } else { self.motion[1].abs() }
    }

    /// Returns the unit vector across the track, such that positive distances have larger minor coordinates.
    pub fn normal(&self) -> [f64; 2] {
        let [x, y] = self.motion;
        let (normal, sign) = if self.is_along_rows { ([-y, x], x.signum()) } else { ([y, -x], y.signum()) };
        normal.map(|part| part * sign)
    }

    /// Returns the angle of the motion from the rows, radians.
    pub fn angle_rad(&self) -> f64 {
        self.motion[1].atan2(self.motion[0])
    }
}

/// Returns times and positions along a path.
fn sampled(path: &StreakPath) -> Vec<(f64, PixelPosition)> {
    let nodes = path.nodes();
    let mut points = Vec::with_capacity(nodes.len() * SAMPLES);
    for pair in nodes.windows(2) {
        let step_s = (pair[1].time_s - pair[0].time_s) / SAMPLES as f64;
        points.extend((0..SAMPLES).map(|sample| {
            let time_s = pair[0].time_s + sample as f64 * step_s;
            (time_s, path.point_at(time_s))
        }));
    }
    points.extend(nodes.last().map(|last| (last.time_s, last.at)));
    points
}
