//! A source drawn on a chip: its light in pixels, and its true parameters.

use hifitime::Epoch;

use super::chip::{Chip, ChipPath};
use super::light::{SkyPoint, Source, SourcePart};
use super::optics::Optics;
use super::render::{StreakPath, draw};
#[cfg(all(feature = "fits", unix))]
use super::render::{draw_image, image_width_pix};
use super::tracking::Tracking;
use crate::error::Error;
use crate::frames::{Direction, Gcrs, seconds_after};
#[cfg(all(feature = "fits", unix))]
use crate::images::PsfGrid;
use crate::images::{Patch, PixelPosition};
use crate::streaks::RadialProfile;
#[cfg(all(feature = "fits", unix))]
use crate::watch::Watch;

/// Exposure data that are common to all chips of a frame.
#[derive(Copy, Clone, Debug)]
pub struct Shot<'a> {
    /// Time at which the shutter opened.
    pub opened: Epoch,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Pointing of the telescope.
    pub centre: Direction<Gcrs>,
    /// Tracking of the telescope.
    pub tracking: &'a Tracking,
    /// Seeing and telescope.
    pub optics: &'a Optics,
    /// Number of points along each streak in the table of points, 2 or more.
    pub truth_points: usize,
}

/// One streak on one chip, with its true parameters.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DrawnStreak<'a> {
    /// Source of the streak.
    pub source: &'a Source,
    /// `whole`, or `chassis` or `array` if the two panels of a satellite are drawn separately.
    pub part: &'static str,
    /// Number of the chip's HDU, from 0.
    pub hdu: usize,
    /// Name of the chip.
    pub chip: &'a str,
    /// False if the frame has no world coordinates.
    pub is_on_sky: bool,
    /// Light of each pixel in the frame's unit, before the effects of the detector.
    pub patch: Patch,
    /// Points evenly spaced in time, from the first to the last time at which the light is on the chip and not dark.
    /// Empty if only the wings of the image reach the chip.
    pub points: Vec<StreakPoint>,
    /// Full width at half maximum of the streak across its length, arcsec. For a light that does not move,
    /// approximately the width of its image.
    pub width_arcsec: f64,
    /// Full width at half maximum of the streak across its length, pixels.
    pub width_pix: f64,
    /// Length between the two ends of the streak on the chip, pixels.
    pub length_pix: f64,
    /// Point at the middle of the time during which the light is on the chip and not dark; `None` if only the wings of
    /// the image reach the chip.
    pub middle: Option<StreakPoint>,
    /// Brightest magnitude while the light is on the chip; `None` if it is always dark.
    pub peak_magnitude: Option<f64>,
    /// Mean angular speed relative to the stars, arcsec/s.
    pub rate_arcsec_s: f64,
    /// Mean angular speed relative to the pixels, arcsec/s. It differs from `rate_arcsec_s` if the telescope tracks a
    /// moving target.
    pub frame_rate_arcsec_s: f64,
    /// Distance half way, km; `None` if the width of the image is given instead.
    pub range_km: Option<f64>,
    /// Diameter of the light, m; `None` if the width of the image is given instead.
    pub size_m: Option<f64>,
    /// Zero point used: magnitude of a star whose pixels sum to 1 in the frame's unit.
    pub zero_point_mag: f64,
}

/// True position and brightness of a light at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StreakPoint {
    /// Time of the point.
    pub epoch: Epoch,
    /// Position in the frame, pixels.
    pub at: PixelPosition,
    /// Direction of the light relative to the stars, ICRS, whatever the telescope tracks. For a frame without world
    /// coordinates it is a direction in the substitute coordinates of the chip.
    pub direction: Direction<Gcrs>,
    /// Direction that the frame's world coordinates give to this pixel.
    pub frame_direction: Direction<Gcrs>,
    /// Magnitude of the light, irrespective of its motion; `None` if it is dark.
    pub magnitude: Option<f64>,
    /// Light per second, in the frame's unit.
    pub rate: f64,
}

/// Draws the lights of a source on a chip, each as a separate streak. Empty if no light falls on the chip.
///
/// The image of a light has the same width everywhere on the chip. The width is computed for the distance of the light
/// at its closest approach to the middle of the chip.
///
/// # Errors
/// The width of the image is out of range or the path is invalid.
pub fn draw_on_chip<'a>(source: &'a Source, chip: &'a Chip, shot: &Shot<'_>) -> Result<Vec<DrawnStreak<'a>>, Error> {
    draw_lights(source, chip, shot, None, &|part, nearest_s, optics| {
        let (scale_arcsec, aspect) = (chip.pixel_scale_arcsec(), chip.pixel_aspect());
        let profile = optics.profile(range_at(part, nearest_s), part.radius_m, scale_arcsec, aspect)?;
        Ok(Box::new(profile))
    })
}

/// Same as [`draw_on_chip`], with a point spread function from a file in place of seeing, defocus and size.
///
/// # Errors
/// The errors of [`draw_on_chip`], a point spread function without light, and a stop of the computation.
#[cfg(all(feature = "fits", unix))]
pub(crate) fn draw_image_on_chip<'a>(
    source: &'a Source,
    chip: &'a Chip,
    shot: &Shot<'_>,
    psf: &PsfGrid,
    watch: &Watch,
) -> Result<Vec<DrawnStreak<'a>>, Error> {
    let reach_rad = (psf.reach_pix() * chip.pixel_scale_arcsec() / 3600.0).to_radians();
    let image = |_: &SourcePart, _: f64, _: &Optics| -> Result<Box<dyn PointImage + '_>, Error> {
        Ok(Box::new(FileImage { psf, watch }))
    };
    let mut drawn = draw_lights(source, chip, shot, Some(reach_rad), &image)?;
    drawn.iter_mut().for_each(|streak| streak.size_m = None);
    Ok(drawn)
}

/// Image of a light at one place.
trait PointImage {
    /// Returns the distance of the farthest pixel with light, pixels.
    fn reach_pix(&self) -> f64;

    /// Draws a path of the light on a chip.
    ///
    /// # Errors
    /// The image has no light somewhere on the path, or the computation is stopped.
    fn draw(&self, path: &StreakPath, chip: &Chip) -> Result<Patch, Error>;

    /// Returns the full width at half maximum of a line at this position and angle, measured across the line, in pixels
    /// and in arcsec.
    fn width(&self, chip: &Chip, at: PixelPosition, angle_rad: f64) -> [f64; 2];
}

impl PointImage for RadialProfile {
    fn reach_pix(&self) -> f64 {
        self.pixel_reach_pix()
    }

    fn draw(&self, path: &StreakPath, chip: &Chip) -> Result<Patch, Error> {
        Ok(draw(path, self, chip.rows, chip.columns))
    }

    fn width(&self, chip: &Chip, _: PixelPosition, angle_rad: f64) -> [f64; 2] {
        let width_pix = width_across(self, angle_rad);
        [width_pix, width_pix * self.mean_pixels_across(angle_rad) * chip.pixel_scale_arcsec()]
    }
}

/// Image of a light from a file.
#[cfg(all(feature = "fits", unix))]
struct FileImage<'a> {
    psf: &'a PsfGrid,
    watch: &'a Watch,
}

#[cfg(all(feature = "fits", unix))]
impl PointImage for FileImage<'_> {
    fn reach_pix(&self) -> f64 {
        self.psf.reach_pix()
    }

    fn draw(&self, path: &StreakPath, chip: &Chip) -> Result<Patch, Error> {
        draw_image(path, self.psf, chip.rows, chip.columns, self.watch)
    }

    fn width(&self, chip: &Chip, at: PixelPosition, angle_rad: f64) -> [f64; 2] {
        let width_pix = image_width_pix(self.psf, at, angle_rad).unwrap_or(f64::NAN);
        let side = chip.pixel_aspect().sqrt();
        let (sin, cos) = angle_rad.sin_cos();
        // A pixel has unit area, so the product of the lengths across and along is 1.
        [width_pix, width_pix / (cos * side).hypot(sin / side) * chip.pixel_scale_arcsec()]
    }
}

/// Returns the image of a part of a source that is nearest to the middle of the chip at a time.
type ImageOf<'b> = &'b dyn Fn(&SourcePart, f64, &Optics) -> Result<Box<dyn PointImage + 'b>, Error>;

/// Draws the lights of a source. `reach_rad` is the distance of the farthest light from a point, radians; `None` for
/// that of seeing, defocus and size.
fn draw_lights<'a>(
    source: &'a Source,
    chip: &'a Chip,
    shot: &Shot<'_>,
    reach_rad: Option<f64>,
    image_of: ImageOf<'_>,
) -> Result<Vec<DrawnStreak<'a>>, Error> {
    let mut drawn = Vec::new();
    let Some((middle, _)) = chip.circle().filter(|_| source.hdu.is_none_or(|hdu| hdu == chip.hdu)) else {
        return Ok(drawn);
    };
    // A given width contains defocus and size.
    let optics = match source.image_fwhm_arcsec {
        Some(fwhm_arcsec) => {
            Optics { seeing_arcsec: fwhm_arcsec, outer_radius_m: 0.0, inner_radius_m: 0.0, ..*shot.optics }
        }
        None => *shot.optics,
    };
    let farthest_rad = reach_rad.unwrap_or_else(|| optics.farthest_rad());
    for part in source.parts.iter().filter(|part| chip.is_near(&part.track, shot.tracking, &shot.centre, farthest_rad))
    {
        let seen = |point: &SkyPoint| shot.tracking.seen(&point.direction, point.time_s, &shot.centre);
        let Some(nearest_s) = part.track.closest_s(&middle, seen) else { continue };
        let image = image_of(part, nearest_s, &optics)?;
        let paths = chip
            .paths(&part.track, shot.tracking, &shot.centre, image.reach_pix())
            .map_err(|error| error.at(format_args!("HDU {}: path", chip.hdu)))?;
        for chip_path in paths.iter().filter(|chip_path| chip_path.path.total() > 0.0) {
            let patch = image.draw(&chip_path.path, chip)?.within(&chip.light_area);
            if !patch.is_empty() && patch.sum() > 0.0 {
                drawn.push(drawn_streak(source, part, chip, shot, chip_path, patch, &*image));
            }
        }
    }
    Ok(drawn)
}

/// Returns the full width at half maximum of a line of light at this angle, measured across the line and including the
/// average over pixels. The profile of a ring may have two maxima; its width is the distance between the outermost
/// positions with half of the greatest brightness.
fn width_across(profile: &RadialProfile, angle_rad: f64) -> f64 {
    const SAMPLES: usize = 400;
    let step_pix = profile.pixel_reach_pix().min(4.0 * profile.fwhm_pix() + 2.0) / SAMPLES as f64;
    let light = |across_pix: f64| profile.line(across_pix, angle_rad);
    let half = 0.5 * (0..=SAMPLES).map(|sample| light(sample as f64 * step_pix)).fold(0.0, f64::max);
    let last =
        (0..SAMPLES).rev().find(|sample| light(*sample as f64 * step_pix) >= half).unwrap_or(0) as f64 * step_pix;
    let (mut inside, mut outside) = (last, last + step_pix);
    for _ in 0..40 {
        let middle = 0.5 * (inside + outside);
        if light(middle) >= half { inside = middle } else { outside = middle }
    }
    2.0 * inside
}

/// Returns the distance of a light at a time, km, interpolated linearly between the two nearest points.
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

fn drawn_streak<'a>(
    source: &'a Source,
    part: &SourcePart,
    chip: &'a Chip,
    shot: &Shot<'_>,
    chip_path: &ChipPath,
    patch: Patch,
    image: &dyn PointImage,
) -> DrawnStreak<'a> {
    let path = &chip_path.path;
    let point_at = |time_s: f64| point(path.point_at(time_s), path.rate_at(time_s), time_s, chip, shot);
    let points: Vec<StreakPoint> = chip_path.inside_s.map_or_else(Vec::new, |[from_s, to_s]| {
        let last = shot.truth_points.max(2) - 1;
        (0..=last).filter_map(|index| point_at(from_s + (to_s - from_s) * index as f64 / last as f64)).collect()
    });
    let brightest = chip_path.inside_s.map(|[from_s, to_s]| {
        let inside = path.nodes().iter().filter(|node| (from_s..=to_s).contains(&node.time_s));
        inside.map(|node| node.rate).chain([path.rate_at(from_s), path.rate_at(to_s)]).fold(0.0, f64::max)
    });
    let ends = points.first().zip(points.last());
    let angle_rad = ends.map_or(0.0, |(from, to)| (to.at.y - from.at.y).atan2(to.at.x - from.at.x));
    let middle = ends.map_or_else(
        || chip.middle(),
        |(from, to)| PixelPosition { x: 0.5 * (from.at.x + to.at.x), y: 0.5 * (from.at.y + to.at.y) },
    );
    let [width_pix, width_arcsec] = image.width(chip, middle, angle_rad);
    let seconds = chip_path.inside_s.map_or(0.0, |[from_s, to_s]| to_s - from_s);
    let length_pix = ends.map_or(0.0, |_| points.windows(2).map(|pair| pair[0].at.distance(pair[1].at)).sum());
    let arc_arcsec: f64 =
        points.windows(2).map(|pair| pair[0].direction.separation_rad(&pair[1].direction).to_degrees() * 3600.0).sum();
    let frame_arc_arcsec: f64 = points
        .windows(2)
        .map(|pair| pair[0].frame_direction.separation_rad(&pair[1].frame_direction).to_degrees() * 3600.0)
        .sum();
    let per_second = |arc: f64| if seconds > 0.0 { arc / seconds } else { 0.0 };
    let has_distance = source.image_fwhm_arcsec.is_none();
    let middle_s = chip_path.inside_s.map_or_else(
        || 0.5 * (path.nodes()[0].time_s + path.nodes()[path.nodes().len() - 1].time_s),
        |[from_s, to_s]| 0.5 * (from_s + to_s),
    );
    DrawnStreak {
        source,
        range_km: has_distance.then(|| range_at(part, middle_s)),
        size_m: has_distance.then_some(2.0 * part.radius_m),
        part: part.label,
        hdu: chip.hdu,
        chip: &chip.name,
        is_on_sky: chip.is_on_sky,
        patch,
        length_pix,
        middle: chip_path.inside_s.and_then(|[from_s, to_s]| point_at(0.5 * (from_s + to_s))),
        peak_magnitude: brightest.and_then(|rate| chip.scale.magnitude(rate)),
        width_arcsec,
        width_pix,
        rate_arcsec_s: per_second(arc_arcsec),
        frame_rate_arcsec_s: per_second(frame_arc_arcsec),
        points,
        zero_point_mag: chip.scale.zero_point_mag(),
    }
}

fn point(at: PixelPosition, rate: f64, time_s: f64, chip: &Chip, shot: &Shot<'_>) -> Option<StreakPoint> {
    let frame = chip.wcs.to_sky(at)?;
    Some(StreakPoint {
        epoch: seconds_after(shot.opened, time_s),
        at,
        direction: shot.tracking.on_sky(&frame, time_s, &shot.centre),
        frame_direction: frame,
        magnitude: chip.scale.magnitude(rate),
        rate,
    })
}

impl DrawnStreak<'_> {
    /// Returns the first and the last point on the chip.
    pub fn ends(&self) -> Option<[&StreakPoint; 2]> {
        Some([self.points.first()?, self.points.last()?])
    }

    /// Returns the direction of motion in the frame, degrees from the x axis (columns increasing) towards the y axis,
    /// [0, 360). `None` if only the wings of the image reach the chip.
    pub fn angle_deg(&self) -> Option<f64> {
        let [from, to] = self.ends()?;
        let (dx, dy) = (to.at.x - from.at.x, to.at.y - from.at.y);
        (dx.hypot(dy) > 0.0).then(|| dy.atan2(dx).to_degrees().rem_euclid(360.0))
    }

    /// Returns the direction of motion on the sky, degrees from north through east, [0, 360). `None` without world
    /// coordinates.
    pub fn position_angle_deg(&self) -> Option<f64> {
        let [from, to] = self.ends().filter(|_| self.is_on_sky)?;
        let moved = from.direction.separation_rad(&to.direction) > 0.0;
        moved.then(|| from.direction.position_angle_rad(&to.direction).to_degrees())
    }

    /// Returns the light of the whole streak in the frame, as the magnitude of a star with the same counts.
    pub fn total_magnitude(&self) -> f64 {
        self.zero_point_mag - 2.5 * self.patch.sum().log10()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streaks::{Blur, Seeing};

    #[test]
    fn verif_a_streak_of_a_moffat_profile_is_wider_than_a_star() {
        let width = |seeing| width_across(&RadialProfile::new(&Blur::seeing(seeing)).unwrap(), 0.0);
        // A line with a Gaussian profile is as wide as the profile. A line with a Moffat profile of exponent β has a
        // Moffat profile of exponent β - 1/2. Pixels add 1/12 to the variance.
        assert!(
            (width(Seeing::Gaussian { fwhm_pix: 8.0 }) - 8.0f64.hypot(2.3548 * (1.0f64 / 12.0).sqrt())).abs() < 0.02
        );
        let (beta, alpha) = (3.5, 8.0 / (2.0 * (2f64.powf(1.0 / 3.5) - 1.0).sqrt()));
        let line = 2.0 * alpha * (2f64.powf(1.0 / (beta - 0.5)) - 1.0).sqrt();
        let moffat = width(Seeing::Moffat { fwhm_pix: 8.0, beta });
        assert!(moffat > line && moffat < line + 0.1, "{moffat} {line}");
    }
}
