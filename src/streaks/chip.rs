//! Chip of a camera, and the path of a moving light over it.

use super::count_scale::CountScale;
use super::light::{SkyPoint, SkyTrack};
use super::render::{PathNode, StreakPath};
use super::tracking::Tracking;
use crate::error::Error;
use crate::frames::{Direction, Gcrs};
use crate::images::{LightArea, PixelPosition, Wcs};

/// Number of points of a track over the width of a chip.
const STEPS_ACROSS: f64 = 24.0;

/// Chip of a camera with its size, world coordinates and count scale.
#[derive(Clone, Debug)]
pub struct Chip {
    /// Number of the HDU in the file, from 0.
    pub hdu: usize,
    /// Name of the HDU; empty if it has none.
    pub name: String,
    /// Pixels along a column.
    pub rows: usize,
    /// Pixels along a row.
    pub columns: usize,
    /// Region of the illuminated pixels.
    pub light_area: LightArea,
    /// World coordinates.
    pub wcs: Wcs,
    /// False if the header has no world coordinates and `wcs` is a substitute with the right pixel scale. The truth
    /// then contains no positions on the sky.
    pub is_on_sky: bool,
    /// Conversion of magnitudes to counts.
    pub scale: CountScale,
}

/// Path of a moving light over a chip, and the interval in which it shines on illuminated pixels of the chip.
#[derive(Clone, Debug, PartialEq)]
pub struct ChipPath {
    /// Path from one margin of the chip to the other; its rates are in the frame's unit per second.
    pub path: StreakPath,
    /// First and last time at which the centre of the light is on the chip and not dark, seconds after the shutter
    /// opened; `None` if only the wings of its image reach the chip.
    pub inside_s: Option<[f64; 2]>,
}

impl Chip {
    /// Returns the position of the middle of the illuminated pixels.
    pub fn middle(&self) -> PixelPosition {
        self.light_area.position_at(0.5, 0.5)
    }

    /// Returns the direction of the middle of the chip, and the radius in radians of the circle around it that contains
    /// all corners. `None` if the WCS has no direction for the middle or a corner.
    pub fn circle(&self) -> Option<(Direction<Gcrs>, f64)> {
        let middle = self.wcs.to_sky(self.middle())?;
        let mut radius_rad = 0.0f64;
        for (along_row, along_column) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let corner = self.light_area.position_at(along_row, along_column);
            radius_rad = radius_rad.max(self.wcs.to_sky(corner)?.separation_rad(&middle));
        }
        Some((middle, radius_rad))
    }

    /// Returns the angular size of the pixel in the middle of the chip, arcseconds.
    pub fn pixel_scale_arcsec(&self) -> f64 {
        self.wcs.pixel_scale_arcsec(self.middle())
    }

    /// Returns the ratio of width to height, on the sky, of the pixel in the middle of the chip.
    pub fn pixel_aspect(&self) -> f64 {
        self.wcs.pixel_aspect(self.middle())
    }

    /// Returns false if no point of the track comes within `margin_rad` of the chip.
    pub fn is_near(&self, track: &SkyTrack, tracking: &Tracking, centre: &Direction<Gcrs>, margin_rad: f64) -> bool {
        self.circle().is_some_and(|(middle, radius_rad)| {
            !near_spans(&seen(track, tracking, centre), &middle, radius_rad + margin_rad).is_empty()
        })
    }

    /// Returns the paths of a moving light over the chip and the `margin_pix` pixels around it, in order of time.
    /// `centre` is the pointing of the telescope.
    ///
    /// 1. The part of the track near the chip is found on the sky.
    /// 2. Points are added to this part, so that a chip of a few arcseconds is not missed.
    /// 3. The points are converted to pixels by the WCS. A path ends where the WCS has no pixel for the direction, or
    ///    where the track leaves the chip; if the track comes back, another path begins.
    ///
    /// # Errors
    /// The times of the track do not increase, or a number is not finite.
    #[doc(hidden)]
    pub fn paths(
        &self,
        track: &SkyTrack,
        tracking: &Tracking,
        centre: &Direction<Gcrs>,
        margin_pix: f64,
    ) -> Result<Vec<ChipPath>, Error> {
        let Some((middle, radius_rad)) = self.circle() else { return Ok(Vec::new()) };
        let margin_rad = (margin_pix * self.pixel_scale_arcsec() / 3600.0).to_radians();
        let reach_rad = radius_rad + margin_rad;
        let mut paths = Vec::new();
        for near in near_spans(&seen(track, tracking, centre), &middle, reach_rad) {
            let fine = refined_to_cross(&near, reach_rad);
            let mut run: Vec<PathNode> = Vec::new();
            for point in &fine.points {
                match self.wcs.to_pixel(point.direction) {
                    Some(at) => run.push(PathNode::new(point.time_s, at, self.scale.rate(point.magnitude))),
                    None => paths.extend(self.chip_path(std::mem::take(&mut run))?),
                }
            }
            paths.extend(self.chip_path(run)?);
        }
        Ok(paths)
    }

    fn chip_path(&self, nodes: Vec<PathNode>) -> Result<Option<ChipPath>, Error> {
        if nodes.len() < 2 {
            return Ok(None);
        }
        let path = StreakPath::new(nodes)?;
        let inside_s = self.inside_s(&path);
        Ok(Some(ChipPath { path, inside_s }))
    }

    /// Returns the first and the last time at which the path is on illuminated pixels and the light is not dark, to a
    /// microsecond. A light that fades between two nodes, as a satellite does at the edge of the umbra, is dark from
    /// the first node without light.
    fn inside_s(&self, path: &StreakPath) -> Option<[f64; 2]> {
        const SAMPLES: usize = 8;
        let nodes = path.nodes();
        let times_s: Vec<f64> = nodes
            .windows(2)
            .flat_map(|pair| {
                let step_s = (pair[1].time_s - pair[0].time_s) / SAMPLES as f64;
                (0..SAMPLES).map(move |sample| pair[0].time_s + step_s * sample as f64)
            })
            .chain(nodes.last().map(|last| last.time_s))
            .collect();
        let inside = |time_s: f64| self.light_area.contains(path.point_at(time_s)) && path.rate_at(time_s) > 0.0;
        let first = times_s.iter().position(|&time_s| inside(time_s))?;
        let last = times_s.iter().rposition(|&time_s| inside(time_s))?;
        let border = |mut out_s: f64, mut in_s: f64| {
            while (out_s - in_s).abs() > 1e-7 {
                let half_s = 0.5 * (out_s + in_s);
                if inside(half_s) { in_s = half_s } else { out_s = half_s }
            }
            in_s
        };
        let enter_s = if first > 0 { border(times_s[first - 1], times_s[first]) } else { times_s[0] };
        let exit_s = times_s.get(last + 1).map_or(times_s[last], |&next_s| border(next_s, times_s[last]));
        Some([enter_s, exit_s])
    }
}

/// Converts each direction of a track to the direction that the frame's WCS gives to the pixel in which the light
/// appears.
fn seen(track: &SkyTrack, tracking: &Tracking, centre: &Direction<Gcrs>) -> SkyTrack {
    let in_frame =
        |point: &SkyPoint| SkyPoint { direction: tracking.seen(&point.direction, point.time_s, centre), ..*point };
    SkyTrack { points: track.points.iter().map(in_frame).collect() }
}

/// Returns the parts of a track within `reach_rad` of a direction `target`, each with one more point before and after
/// it.
fn near_spans(track: &SkyTrack, target: &Direction<Gcrs>, reach_rad: f64) -> Vec<SkyTrack> {
    let points = &track.points;
    let near = |index: usize| comes_near(&points[index], &points[index + 1], target, reach_rad);
    let mut spans = Vec::new();
    let mut first: Option<usize> = None;
    for index in 0..points.len().saturating_sub(1) {
        match (first, near(index)) {
            (None, true) => first = Some(index),
            (Some(from), false) => {
                spans.push(span_of(points, from, index));
                first = None;
            }
            _ => {}
        }
    }
    spans.extend(first.map(|from| span_of(points, from, points.len() - 1)));
    spans
}

fn span_of(points: &[SkyPoint], from: usize, to: usize) -> SkyTrack {
    let to = (to + 1).min(points.len() - 1);
    SkyTrack { points: points[from.saturating_sub(1)..=to].to_vec() }
}

/// Returns true if the track between two adjacent points may come within `reach_rad` of a direction. The test allows
/// for the curvature of the track.
fn comes_near(from: &SkyPoint, to: &SkyPoint, target: &Direction<Gcrs>, reach_rad: f64) -> bool {
    let (start, end, target) = (from.direction.vector(), to.direction.vector(), target.vector());
    let chord = end - start;
    let share = if chord.norm_squared() > 0.0 {
        ((target - start).dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0)
    } else {
        0.0
    };
    // Half of the squared chord exceeds both the curvature of any track on the sky between two points and the height of
    // the arc above its chord.
    let slack = 0.5 * chord.norm_squared();
    ((start + chord * share) - target).norm() <= reach_rad + slack
}

/// Returns the track with added points, such that at least [`STEPS_ACROSS`] of them lie within a circle of this radius.
fn refined_to_cross(track: &SkyTrack, radius_rad: f64) -> SkyTrack {
    let fastest = track
        .points
        .windows(2)
        .map(|pair| pair[0].direction.separation_rad(&pair[1].direction) / (pair[1].time_s - pair[0].time_s))
        .fold(0.0, f64::max);
    let step_s = 2.0 * radius_rad / STEPS_ACROSS / fastest;
    if step_s.is_finite() && step_s > 0.0 { track.refined(step_s) } else { track.clone() }
}

/// Returns the middle of several chips on the sky, and the radius in radians of the circle around it that contains them
/// all.
pub fn circle_of<'a>(chips: impl Iterator<Item = &'a Chip> + Clone) -> Option<(Direction<Gcrs>, f64)> {
    let circles: Vec<(Direction<Gcrs>, f64)> = chips.filter_map(Chip::circle).collect();
    let sum = circles.iter().fold(nalgebra::Vector3::zeros(), |sum, (middle, _)| sum + middle.vector());
    let centre = Direction::from_vector(sum.try_normalize(0.0)?);
    let radius_rad =
        circles.iter().map(|(middle, radius_rad)| middle.separation_rad(&centre) + radius_rad).fold(0.0, f64::max);
    Some((centre, radius_rad))
}

/// Returns a direction on one of several chips, from three numbers in [0, 1): the first selects a chip with a
/// probability proportional to its area, the other two a position on that chip.
pub fn direction_on<'a>(chips: impl Iterator<Item = &'a Chip> + Clone, drawn: [f64; 3]) -> Option<Direction<Gcrs>> {
    let pixels = |chip: &Chip| chip.light_area.pixels() as f64;
    let mut left = drawn[0] * chips.clone().map(pixels).sum::<f64>();
    let chip = chips.clone().find(|chip| {
        left -= pixels(chip);
        left < 0.0
    });
    let chip = chip.or(chips.last())?;
    chip.wcs.to_sky(chip.light_area.position_at(drawn[1], drawn[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

    fn chip(side: usize, scale_arcsec: f64) -> Chip {
        let centre = Direction::from_lon_lat_rad(1.2, -0.4);
        Chip {
            hdu: 0,
            name: String::new(),
            rows: side,
            columns: side,
            light_area: LightArea::whole(side, side),
            wcs: Wcs::tangent(centre, scale_arcsec, 0.0, side, side).unwrap(),
            is_on_sky: true,
            scale: CountScale::of_frame(25.0, 30.0).unwrap(),
        }
    }

    /// Track from north to south through a position east of the centre, 2000"/s, with points a second apart.
    fn southwards(east_arcsec: f64) -> SkyTrack {
        let centre = Direction::<Gcrs>::from_lon_lat_rad(1.2, -0.4);
        let (east, north) = centre.east_north();
        let point = |second: i32| SkyPoint {
            time_s: 15.3 + f64::from(second),
            direction: Direction::from_vector(
                (centre.vector() + (east * east_arcsec - north * 2000.0 * f64::from(second)) * ARCSEC).normalize(),
            ),
            range_km: 600.0,
            magnitude: Some(5.0),
        };
        SkyTrack { points: (-6..=6).map(point).collect() }
    }

    #[test]
    fn verif_a_small_chip_between_two_points_is_not_missed() {
        // 100 pixels of 0.26" are crossed in 13 ms; the points are a second apart.
        let chip = chip(100, 0.26);
        let (centre, _) = chip.circle().unwrap();
        let paths = chip.paths(&southwards(5.0), &Tracking::Sidereal, &centre, 20.0).unwrap();
        assert_eq!(paths.len(), 1);
        let [enter_s, exit_s] = paths[0].inside_s.unwrap();
        assert!(((exit_s - enter_s) - 26.0 / 2000.0).abs() < 1e-5, "{enter_s} {exit_s}");
        assert!((0.5 * (enter_s + exit_s) - 15.3).abs() < 1e-5);
        let middle = paths[0].path.point_at(15.3);
        // East is to the left, and the middle is between pixels 49 and 50.
        assert!((middle.x - (49.5 - 5.0 / 0.26)).abs() < 1e-4 && (middle.y - 49.5).abs() < 0.1, "{middle:?}");
        // 20 mag brighter than the zero point: 1e8 counts in 30 s.
        assert!((paths[0].path.rate_at(15.3) * 30.0 / 1e8 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn verif_tracks_that_miss_the_chip_have_no_path_and_fringes_are_not_inside() {
        let chip = chip(1000, 1.0);
        let (centre, _) = chip.circle().unwrap();
        let paths =
            |east_arcsec: f64| chip.paths(&southwards(east_arcsec), &Tracking::Sidereal, &centre, 30.0).unwrap();
        assert!(paths(2000.0).is_empty());
        assert!(paths(520.0).iter().all(|path| path.inside_s.is_none()));
        assert!(paths(490.0)[0].inside_s.is_some());
    }

    #[test]
    fn verif_a_tracked_satellite_stays_at_one_position() {
        let chip = chip(1000, 1.0);
        let (centre, _) = chip.circle().unwrap();
        let following = Tracking::Rate { east_rad_s: 0.0, north_rad_s: -2000.0 * ARCSEC, reference_s: 15.3 };
        let paths = chip.paths(&southwards(0.0), &following, &centre, 30.0).unwrap();
        assert_eq!(paths.len(), 1);
        // The frame moves at a constant rate along the great circle, the track along its tangent. Over 12000" they
        // differ by a third of the cube of the angle, 13".
        assert!(paths[0].path.length_pix() < 60.0, "{}", paths[0].path.length_pix());
        assert_eq!(paths[0].inside_s, Some([9.3, 21.3]));
    }
}
