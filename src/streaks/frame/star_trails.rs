//! Star trails in a synthetic frame whose telescope does not track the stars.

use rayon::prelude::*;

use super::super::chip::Chip;
use super::super::light::{SkyPoint, SkyTrack};
use super::super::render::draw;
use super::super::tracking::Tracking;
use super::synthetic_shot::SyntheticShot;
use crate::error::Error;
use crate::frames::{Direction, Gcrs};
use crate::images::{Patch, PixelPosition, Plane};
use crate::streaks::{BRIGHTEST_E, RadialProfile, RandomStars, Star};

/// A star with a direction on the sky.
#[derive(Copy, Clone, Debug)]
pub(super) struct SkyStar {
    /// Direction of the star.
    pub direction: Direction<Gcrs>,
    /// Light that the star would give if it were in the frame for the whole exposure, electrons.
    pub flux_e: f64,
    /// Interval in which the star may be over the frame, seconds after the shutter opened.
    pub over_s: [f64; 2],
}

/// Distance of stars, km: so large that they are in focus.
const RANGE_KM: f64 = 1e15;

/// Number of points of a trail, enough for cubic interpolation even if the telescope turns by tens of degrees.
const MOMENTS: u32 = 16;

/// Largest expected number of stars that trail over a frame.
const MAX_MEAN_STARS: f64 = 1e6;

/// Number of trails kept in memory at once.
const TRAILS_AT_ONCE: usize = 256;

/// Draws random stars that pass over the chip, or within `reach_pix` of it, at some time of the exposure.
///
/// The stars are distributed uniformly in a strip along their motion. Its width is the diagonal of the chip plus
/// `reach_pix` on both sides; its length is this width plus the length of a trail. The direction of each star is
/// computed from its position in the strip at the time when the star is nearest to the middle of the chip.
///
/// # Errors
/// The errors of [`RandomStars::draw`], and an expected number of more than a million stars.
pub(super) fn draw_stars(
    field: &RandomStars,
    chip: &Chip,
    shot: &SyntheticShot<'_>,
    reach_pix: f64,
) -> Result<Vec<SkyStar>, Error> {
    let Tracking::Rate { reference_s, .. } = shot.tracking else { return Ok(Vec::new()) };
    // Motion of the stars in pixels per second, at the middle of the chip and at the reference time of the WCS.
    let step_s = 1e-3 * shot.exposure_s;
    let at = |time_s: f64| chip.wcs.to_pixel(shot.tracking.seen(&shot.centre, time_s, &shot.centre));
    let Some((before, after)) = at(reference_s - step_s).zip(at(reference_s + step_s)) else { return Ok(Vec::new()) };
    let motion = [(after.x - before.x) / (2.0 * step_s), (after.y - before.y) / (2.0 * step_s)];
    let speed = motion[0].hypot(motion[1]);
    let along = if speed > 0.0 { motion.map(|part| part / speed) } else { [1.0, 0.0] };
    let width = (chip.rows as f64).hypot(chip.columns as f64) + 2.0 * reach_pix;
    let (rows, columns) = (width.ceil() as usize, (width + speed * shot.exposure_s).ceil() as usize);
    let expected = field.per_megapixel * 1e-6 * rows as f64 * columns as f64;
    Error::check_range("background: stars that trail over the frame", expected, 0.0, MAX_MEAN_STARS)?;
    let middle = chip.middle();
    let on_sky = |star: Star| {
        // Position of the star in the strip at the reference time of the WCS.
        let (u, v) = (star.at.x - 0.5 * (columns as f64 - 1.0), star.at.y - 0.5 * (rows as f64 - 1.0));
        let nearest_s = if speed > 0.0 { (reference_s - u / speed).clamp(0.0, shot.exposure_s) } else { reference_s };
        let u = u + speed * (nearest_s - reference_s);
        let position =
            PixelPosition { x: middle.x + u * along[0] - v * along[1], y: middle.y + u * along[1] + v * along[0] };
        let seen = chip.wcs.to_sky(position)?;
        // Time before and after `nearest_s`: the time in which a star crosses the width of the strip, so that both ends
        // of the trail are off the chip.
        let half_s = if speed > 0.0 { width / speed } else { shot.exposure_s };
        Some(SkyStar {
            direction: shot.tracking.on_sky(&seen, nearest_s, &shot.centre),
            flux_e: star.flux_e,
            over_s: [(nearest_s - half_s).max(0.0), (nearest_s + half_s).min(shot.exposure_s)],
        })
    };
    Ok(field.draw(rows, columns, 0.0, shot.seed)?.into_iter().filter_map(on_sky).collect())
}

/// Adds the trails of stars, each of constant brightness, to the light of a frame. The count scale of `chip` is such
/// that a star of magnitude 0 gives one electron in the exposure.
///
/// # Errors
/// A path is invalid, or a star over the frame is too bright.
pub(super) fn add_trails(
    light: &mut Plane,
    stars: &[SkyStar],
    chip: &Chip,
    shot: &SyntheticShot<'_>,
    profile: &RadialProfile,
) -> Result<(), Error> {
    let trail = |star: &SkyStar| -> Result<Vec<Patch>, Error> {
        shot.watch.check()?;
        let [first_s, last_s] = star.over_s;
        let point = |moment: u32| SkyPoint {
            time_s: first_s + (last_s - first_s) * f64::from(moment) / f64::from(MOMENTS),
            direction: star.direction,
            range_km: RANGE_KM,
            magnitude: (star.flux_e > 0.0).then(|| -2.5 * star.flux_e.log10()),
        };
        let track = SkyTrack { points: (0..=MOMENTS).map(point).collect() };
        let paths = chip.paths(&track, &shot.tracking, &shot.centre, profile.pixel_reach_pix())?;
        if !paths.is_empty() {
            Error::check_range("background: flux_e", star.flux_e, 0.0, BRIGHTEST_E)?;
        }
        Ok(paths.iter().map(|chip_path| draw(&chip_path.path, profile, chip.rows, chip.columns)).collect())
    };
    for batch in stars.chunks(TRAILS_AT_ONCE) {
        // Trails are drawn in parallel and added in order, so that the sums do not depend on the number of threads.
        let trails = batch.par_iter().map(trail).collect::<Result<Vec<_>, Error>>()?;
        trails.iter().flatten().for_each(|patch| patch.add_to(light));
    }
    Ok(())
}
