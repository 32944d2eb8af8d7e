//! A source drawn on a chip: its light in pixels, and the truth about it.

use hifitime::Epoch;

use super::chip::{Chip, ChipPath};
use super::error::StreaksError;
use super::light::{SkyPoint, Source, SourcePart};
use super::optics::Optics;
use super::render::draw;
use super::tracking::Tracking;
use crate::frames::{Direction, Gcrs, seconds_after};
use crate::images::{Patch, PixelPosition};
use crate::streaks::RadialProfile;

/// What all chips of an exposure share.
#[derive(Copy, Clone, Debug)]
pub struct Shot<'a> {
    /// When the shutter opened.
    pub opened: Epoch,
    /// For how long, seconds.
    pub exposure_s: f64,
    /// What the telescope points at.
    pub centre: Direction<Gcrs>,
    /// What it follows.
    pub tracking: &'a Tracking,
    /// What air and telescope do.
    pub optics: &'a Optics,
    /// Points of the truth along each streak, 2 or more.
    pub truth_points: usize,
}

/// One streak on one chip.
#[derive(Clone, Debug)]
pub struct DrawnStreak<'a> {
    /// Whose.
    pub source: &'a Source,
    /// Which of its lights.
    pub part: &'static str,
    /// Number of the chip's HDU.
    pub hdu: usize,
    /// Name of the chip.
    pub chip: &'a str,
    /// False where the frame says nothing of the sky.
    pub is_on_sky: bool,
    /// The light, in the frame's unit, before any detector.
    pub patch: Patch,
    /// Evenly spaced in time from the first to the last moment over the chip; empty where only the light's fringe touches it.
    pub points: Vec<StreakPoint>,
    /// Full width at half maximum of the light across the streak, arcsec; of a light that stands still about the same.
    pub width_arcsec: f64,
    /// The same in pixels.
    pub width_pix: f64,
    /// Length between its ends on the chip, pixels.
    pub length_pix: f64,
    /// Half way in time over the chip; `None` where only the light's fringe touches it.
    pub middle: Option<StreakPoint>,
    /// Brightest magnitude over the chip; `None` in the dark.
    pub peak_magnitude: Option<f64>,
    /// Mean speed among the stars, arcsec/s.
    pub rate_arcsec_s: f64,
    /// Mean speed over the pixels, arcsec/s: another one where the telescope follows something.
    pub frame_rate_arcsec_s: f64,
    /// Counts of a star of magnitude 0 in the chip's frame, as -2.5 log10: the zero point that was used.
    pub zero_point_mag: f64,
}

/// The truth at one moment.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StreakPoint {
    /// When.
    pub epoch: Epoch,
    /// Where in the frame.
    pub at: PixelPosition,
    /// Where on the sky: the place among the stars, whatever the telescope follows. In the stand-in's sky where the frame has none.
    pub direction: Direction<Gcrs>,
    /// The place that the frame's world coordinates give to this pixel.
    pub frame_direction: Direction<Gcrs>,
    /// Magnitude as if it stood still; `None` in the dark.
    pub magnitude: Option<f64>,
    /// Light per second, in the frame's unit.
    pub rate: f64,
}

/// Everything that a source leaves on a chip, its lights apart. Empty where it leaves nothing.
///
/// The image of a light keeps one width along a chip: that at the distance where it passes nearest to the chip's middle.
///
/// # Errors
/// [`StreaksError`] where a width is out of range or the way is none.
pub fn draw_on_chip<'a>(
    source: &'a Source,
    chip: &'a Chip,
    shot: &Shot<'_>,
) -> Result<Vec<DrawnStreak<'a>>, StreaksError> {
    let mut drawn = Vec::new();
    let Some((middle, _)) = chip.circle() else { return Ok(drawn) };
    let farthest_rad = shot.optics.farthest_rad();
    for part in source.parts.iter().filter(|part| chip.is_near(&part.track, shot.tracking, &shot.centre, farthest_rad))
    {
        let seen = |point: &SkyPoint| shot.tracking.seen(&point.direction, point.time_s, &shot.centre);
        let Some(nearest_s) = part.track.closest_s(&middle, seen) else { continue };
        let (scale_arcsec, aspect) = (chip.pixel_scale_arcsec(), chip.pixel_aspect());
        let profile = shot.optics.profile(range_at(part, nearest_s), part.radius_m, scale_arcsec, aspect)?;
        let paths = chip
            .paths(&part.track, shot.tracking, &shot.centre, profile.pixel_reach_pix())
            .map_err(|source| StreaksError::Path { hdu: chip.hdu, source })?;
        for way in paths.iter().filter(|way| way.path.total() > 0.0) {
            let patch = draw(&way.path, &profile, chip.rows, chip.columns).within(&chip.light_area);
            if !patch.is_empty() && patch.sum() > 0.0 {
                drawn.push(told(source, part, chip, shot, way, patch, &profile));
            }
        }
    }
    Ok(drawn)
}

/// Full width at half maximum of a line of light across its direction, pixels averaged as the detector does. A ring may have two maxima: the width is that between the
/// outermost places of half the greatest.
fn width_across(profile: &RadialProfile, angle_rad: f64) -> f64 {
    const LOOKS: usize = 400;
    let step_pix = profile.pixel_reach_pix().min(4.0 * profile.fwhm_pix() + 2.0) / LOOKS as f64;
    let light = |across_pix: f64| profile.line(across_pix, angle_rad);
    let half = 0.5 * (0..=LOOKS).map(|look| light(look as f64 * step_pix)).fold(0.0, f64::max);
    let last = (0..LOOKS).rev().find(|look| light(*look as f64 * step_pix) >= half).unwrap_or(0) as f64 * step_pix;
    let (mut inside, mut outside) = (last, last + step_pix);
    for _ in 0..40 {
        let middle = 0.5 * (inside + outside);
        if light(middle) >= half { inside = middle } else { outside = middle }
    }
    2.0 * inside
}

/// Distance at a moment, km: the straight line between the two nearest points.
fn range_at(part: &SourcePart, time_s: f64) -> f64 {
    let points = &part.track.points;
    let after = points.partition_point(|point| point.time_s <= time_s).clamp(1, points.len().max(2) - 1);
    match (points.get(after - 1), points.get(after)) {
        (Some(a), Some(b)) if b.time_s > a.time_s => {
            a.range_km + (b.range_km - a.range_km) * (time_s - a.time_s) / (b.time_s - a.time_s)
        }
        (Some(only), _) => only.range_km,
        _ => f64::NAN,
    }
}

fn told<'a>(
    source: &'a Source,
    part: &SourcePart,
    chip: &'a Chip,
    shot: &Shot<'_>,
    way: &ChipPath,
    patch: Patch,
    profile: &RadialProfile,
) -> DrawnStreak<'a> {
    let path = &way.path;
    let told_at = |time_s: f64| point(path.point_at(time_s), path.rate_at(time_s), time_s, chip, shot);
    let points: Vec<StreakPoint> = way.inside_s.map_or_else(Vec::new, |[from_s, to_s]| {
        let last = shot.truth_points.max(2) - 1;
        (0..=last).filter_map(|index| told_at(from_s + (to_s - from_s) * index as f64 / last as f64)).collect()
    });
    let brightest = way.inside_s.map(|[from_s, to_s]| {
        let inside = path.nodes().iter().filter(|node| (from_s..=to_s).contains(&node.time_s));
        inside.map(|node| node.rate).chain([path.rate_at(from_s), path.rate_at(to_s)]).fold(0.0, f64::max)
    });
    let ends = points.first().zip(points.last());
    let angle_rad = ends.map_or(0.0, |(from, to)| (to.at.y - from.at.y).atan2(to.at.x - from.at.x));
    let width_pix = width_across(profile, angle_rad);
    let seconds = way.inside_s.map_or(0.0, |[from_s, to_s]| to_s - from_s);
    let length_pix = ends.map_or(0.0, |_| points.windows(2).map(|pair| pair[0].at.distance(pair[1].at)).sum());
    let arc_arcsec: f64 =
        points.windows(2).map(|pair| pair[0].direction.separation_rad(&pair[1].direction).to_degrees() * 3600.0).sum();
    let frame_arc_arcsec: f64 = points
        .windows(2)
        .map(|pair| pair[0].frame_direction.separation_rad(&pair[1].frame_direction).to_degrees() * 3600.0)
        .sum();
    let a_second = |way: f64| if seconds > 0.0 { way / seconds } else { 0.0 };
    DrawnStreak {
        source,
        part: part.label,
        hdu: chip.hdu,
        chip: &chip.name,
        is_on_sky: chip.is_on_sky,
        patch,
        length_pix,
        middle: way.inside_s.and_then(|[from_s, to_s]| told_at(0.5 * (from_s + to_s))),
        peak_magnitude: brightest.and_then(|rate| chip.scale.magnitude(rate)),
        width_arcsec: width_pix * profile.mean_pixels_across(angle_rad) * chip.pixel_scale_arcsec(),
        width_pix,
        rate_arcsec_s: a_second(arc_arcsec),
        frame_rate_arcsec_s: a_second(frame_arc_arcsec),
        points,
        zero_point_mag: chip.scale.zero_point_mag(),
    }
}

fn point(at: PixelPosition, rate: f64, time_s: f64, chip: &Chip, shot: &Shot<'_>) -> Option<StreakPoint> {
    let frame = chip.wcs.to_sky(at)?;
    Some(StreakPoint {
        epoch: seconds_after(shot.opened, time_s),
        at,
        direction: shot.tracking.stood(&frame, time_s, &shot.centre),
        frame_direction: frame,
        magnitude: chip.scale.magnitude(rate),
        rate,
    })
}

impl DrawnStreak<'_> {
    /// The first and the last moment on the chip.
    pub fn ends(&self) -> Option<[&StreakPoint; 2]> {
        Some([self.points.first()?, self.points.last()?])
    }

    /// Direction of motion in the frame, degrees from the x axis (columns growing) towards the y axis, [0, 360).
    pub fn angle_deg(&self) -> Option<f64> {
        let [from, to] = self.ends()?;
        let (dx, dy) = (to.at.x - from.at.x, to.at.y - from.at.y);
        (dx.hypot(dy) > 0.0).then(|| dy.atan2(dx).to_degrees().rem_euclid(360.0))
    }

    /// Direction of motion on the sky, degrees from north through east, [0, 360).
    pub fn position_angle_deg(&self) -> Option<f64> {
        let [from, to] = self.ends().filter(|_| self.is_on_sky)?;
        let moved = from.direction.separation_rad(&to.direction) > 0.0;
        moved.then(|| from.direction.position_angle_rad(&to.direction).to_degrees())
    }

    /// Light of the whole streak in the frame, as the magnitude of a star of as many counts.
    pub fn total_magnitude(&self) -> f64 {
        self.zero_point_mag - 2.5 * self.patch.sum().log10()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streaks::{Blur, Seeing};

    #[test]
    fn verif_a_streak_of_moffats_is_wider_than_a_star() {
        let width = |seeing| width_across(&RadialProfile::of(&Blur::seeing(seeing)).unwrap(), 0.0);
        // Along a line a Gaussian stays what it is; a Moffat of exponent β becomes one of β - 1/2. Pixels add 1/12 to the variance.
        assert!(
            (width(Seeing::Gaussian { fwhm_pix: 8.0 }) - 8.0f64.hypot(2.3548 * (1.0f64 / 12.0).sqrt())).abs() < 0.02
        );
        let (beta, alpha) = (3.5, 8.0 / (2.0 * (2f64.powf(1.0 / 3.5) - 1.0).sqrt()));
        let line = 2.0 * alpha * (2f64.powf(1.0 / (beta - 0.5)) - 1.0).sqrt();
        let moffat = width(Seeing::Moffat { fwhm_pix: 8.0, beta });
        assert!(moffat > line && moffat < line + 0.1, "{moffat} {line}");
    }
}
