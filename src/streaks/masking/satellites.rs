//! Corridors of the satellites in a frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use hifitime::Epoch;
use rayon::prelude::*;

use super::super::chip::Chip;
use super::super::error::StreaksError;
use super::super::frame::{TargetFrame, noise_of_chip};
use super::super::optics::Optics;
use super::super::truth::{NoiseMap, SHARE_WITHOUT_NOISE};
use super::area::{Area, polygons};
use super::corridor::{Cell, ErringTrack, LocalLight};
use super::light_width::LightWidth;
use super::measured::MeasuredStreak;
use crate::elements::NoradId;
use crate::frames::{Direction, Gcrs, seconds_after};
use crate::images::PixelPosition;
use crate::orbit::{Lateness, LeftOut};
use crate::passes::{DelayedTrack, Exposure, ExposureInterval, Field, PassOptions, Sky};
use crate::photometry::{Brightness, PhotometryOptions};

/// Number of points of a track at which the magnitude is computed.
const LIGHT_POINTS: usize = 33;
/// Margin around the frame on the sky, radians (0.1°), in which satellites are searched.
const MARGIN_RAD: f64 = 1.7e-3;
/// Errors at the end of a fitted line are twice those at its middle.
const ERROR_AT_ENDS: f64 = 2.0;

/// Options of a mask.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MaskOptions {
    /// Probability that the streak of a satellite is in its corridor, (0, 1), and the probability that it is not brighter
    /// than the magnitude for which the corridor is computed.
    pub coverage: f64,
    /// Light is covered down to this multiple of the local noise of a pixel.
    pub threshold: f64,
    /// Smallest probability with which a satellite whose nominal track misses the frame is considered.
    pub min_probability: f64,
    /// Full width of the light of a streak, arcsec; `None` to compute it from brightness and noise.
    pub width_arcsec: Option<f64>,
    /// Seeing and telescope.
    pub optics: Optics,
    /// Band and system of the magnitudes.
    pub photometry: PhotometryOptions,
}

/// Source of the position of a masked streak.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum StreakOrigin {
    /// Element sets.
    Predicted,
    /// A measurement of the streak.
    Measured,
}

/// Corridor of one satellite on one chip.
#[derive(Clone, Debug)]
pub struct MaskedStreak {
    /// Index of the chip in [`TargetFrame::chips`].
    pub chip: usize,
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Name in the element set; empty if it has none.
    pub name: Arc<str>,
    /// Source of its position.
    pub origin: StreakOrigin,
    /// Time at which the predicted track is nearest to the middle of the chip.
    pub epoch: Epoch,
    /// Age of the elements, days.
    pub element_age_days: f64,
    /// Probability that the satellite is in the frame during the exposure; 1 for a measured streak.
    pub probability: f64,
    /// Probability that the streak is in the corridor.
    pub coverage: f64,
    /// Smallest and largest delay, seconds.
    pub late_s: [f64; 2],
    /// Largest distance across the track, radians.
    pub across_rad: f64,
    /// Predicted magnitude at that time, and the magnitude for which the corridor is computed; `None` if the width of the
    /// light is given.
    pub brightness: Option<(Brightness, f64)>,
    /// Light of the brightest pixel, in multiples of the local noise; infinite in a frame without noise, `None` if the
    /// width of the light is given.
    pub peak_to_noise: Option<f64>,
    /// Greatest full width of the light that is covered, arcsec.
    pub width_arcsec: f64,
    /// Covered pixels.
    pub area: Area,
    /// Polygons around the corridor, on the sky.
    pub polygons: Vec<Vec<Direction<Gcrs>>>,
}

/// Reason why a satellite is not masked.
#[derive(Clone, Debug, PartialEq)]
pub enum NotMasked {
    /// Its brightest pixel is fainter than the threshold, at its bright magnitude.
    Faint {
        /// Light of the brightest pixel, in multiples of the local noise.
        peak_to_noise: f64,
        /// Magnitude for which the light is computed.
        magnitude: f64,
    },
    /// It is sunlit, but its model gives no magnitude.
    UnknownMagnitude,
    /// Its position cannot be computed.
    UnknownPosition(String),
    /// Its streak was measured, but it has no element set.
    NoElements,
}

/// Satellite that is not masked.
#[derive(Clone, Debug, PartialEq)]
pub struct Omitted {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Name in the element set; empty if it has none.
    pub name: Arc<str>,
    /// Reason.
    pub reason: NotMasked,
}

/// Mask of a frame.
#[derive(Clone, Debug, Default)]
pub struct FrameMask {
    /// Corridors, in the order of chips and times.
    pub streaks: Vec<MaskedStreak>,
    /// Satellites that may be in the frame and are not masked, and those of unknown position.
    pub omitted: Vec<Omitted>,
}

impl FrameMask {
    /// Returns the masked pixels of a chip.
    pub fn area(&self, chip: usize) -> Area {
        Area::union(self.streaks.iter().filter(|streak| streak.chip == chip).map(|streak| &streak.area))
    }
}

/// Computes the corridors of the satellites in a frame, on all threads of the current pool.
///
/// Streaks in `measured` replace the predictions of their satellites on their chips.
///
/// # Errors
/// Passes cannot be computed, pixels cannot be read, or the image of a star cannot be drawn.
pub fn mask_frame(
    sky: &Sky,
    frame: &TargetFrame,
    measured: &[MeasuredStreak],
    options: &MaskOptions,
) -> Result<FrameMask, StreaksError> {
    let (pointing, radius_rad) = frame.circle().ok_or_else(|| {
        let what = format!("{}: position of the corners of the frame on the sky", frame.file.path().display());
        StreaksError::invalid(what, "undefined", "world coordinates that cover the frame")
    })?;
    let exposure =
        Exposure { id: String::new(), start: frame.opened, duration_s: frame.exposure_s, pointing, rotation_rad: 0.0 };
    let field = Field::circle(2.0 * (radius_rad + MARGIN_RAD))?;
    let query = PassOptions {
        min_probability: Some(options.min_probability),
        photometry: options.photometry,
        without_light: true,
        ..PassOptions::default()
    };
    let mut found = sky.field_passes(std::slice::from_ref(&exposure), &field, &query)?;
    let mut probabilities: BTreeMap<usize, f64> = BTreeMap::new();
    for pass in found.by_exposure.pop().unwrap_or_default() {
        let probability = probabilities.entry(pass.element_index).or_default();
        *probability = (*probability + pass.probability).min(1.0);
    }
    let mut mask = FrameMask::default();
    let elements = sky.elements();
    let mut of_satellite: BTreeMap<usize, Vec<&MeasuredStreak>> = BTreeMap::new();
    for streak in measured {
        match elements.iter().position(|set| set.norad_id == streak.norad_id) {
            Some(index) => of_satellite.entry(index).or_default().push(streak),
            None => mask.omitted.push(Omitted {
                norad_id: streak.norad_id,
                name: streak.name.as_str().into(),
                reason: NotMasked::NoElements,
            }),
        }
    }
    let is_measured = |left_out: &LeftOut| of_satellite.contains_key(&left_out.element_index);
    mask.omitted.extend(found.left_out.iter().filter(|one| !is_measured(one)).map(|one| Omitted {
        norad_id: one.norad_id,
        name: elements[one.element_index].name.clone(),
        reason: NotMasked::UnknownPosition(one.reason.to_string()),
    }));
    for index in of_satellite.keys() {
        probabilities.entry(*index).or_insert(1.0);
    }

    let noise = frame
        .chips
        .par_iter()
        .map(|target| match options.width_arcsec {
            None if !probabilities.is_empty() => noise_of_chip(frame, target),
            _ => Ok(NoiseMap::uniform(0.0)),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let interval = sky.exposure_interval(&exposure)?;
    let masking = Masking { frame, exposure: &exposure, radius_rad, interval: &interval, noise: &noise, options };
    let candidates: Vec<(usize, f64)> = probabilities.into_iter().collect();
    let done = candidates.par_iter().map(|(element_index, probability)| {
        sky.watch().check()?;
        let measured = of_satellite.get(element_index).map_or(&[][..], Vec::as_slice);
        masking.satellite(*element_index, *probability, measured)
    });
    for (streaks, reason) in done.collect::<Result<Vec<_>, StreaksError>>()? {
        mask.streaks.extend(streaks);
        mask.omitted.extend(reason);
    }
    mask.streaks.sort_by(|a, b| a.chip.cmp(&b.chip).then(a.epoch.cmp(&b.epoch)));
    Ok(mask)
}

/// Data that the satellites of a frame share.
struct Masking<'a> {
    frame: &'a TargetFrame,
    /// Exposure, pointed at the middle of the frame.
    exposure: &'a Exposure,
    /// Radius of the frame.
    radius_rad: f64,
    interval: &'a ExposureInterval<'a>,
    /// Noise of each chip.
    noise: &'a [NoiseMap],
    options: &'a MaskOptions,
}

/// Light of a satellite at evenly spaced predicted times.
struct TrackLight {
    times_s: [f64; 2],
    points: Vec<LightPoint>,
}

#[derive(Clone, Default)]
struct LightPoint {
    is_lit: bool,
    /// Brightness, and the magnitude for which the corridor is computed.
    brightness: Option<(Brightness, f64)>,
}

impl TrackLight {
    fn of(track: &DelayedTrack<'_>, margin_s: f64, times_s: [f64; 2], options: &MaskOptions) -> Self {
        let point = |index: usize| {
            let time_s = times_s[0] + (times_s[1] - times_s[0]) * index as f64 / (LIGHT_POINTS - 1) as f64;
            let Some(point) = track.point(time_s + margin_s, &options.photometry) else { return LightPoint::default() };
            let bright = |light: Brightness| {
                let magnitude = light.exceeded_with(1.0 - options.coverage);
                (light, magnitude)
            };
            LightPoint { is_lit: point.illumination.is_lit(), brightness: point.brightness.map(bright) }
        };
        Self { times_s, points: (0..LIGHT_POINTS).map(point).collect() }
    }

    /// Returns the two points around a time. Before the first and after the last point it is that point.
    fn around(&self, time_s: f64) -> [&LightPoint; 2] {
        let [from_s, to_s] = self.times_s;
        let last = self.points.len() - 1;
        let index = (time_s - from_s) / (to_s - from_s) * last as f64;
        let before = if index.is_finite() { (index.max(0.0) as usize).min(last) } else { 0 };
        [&self.points[before], &self.points[(before + 1).min(last)]]
    }

    /// Returns true if the satellite may be sunlit at a time.
    fn is_lit(&self, time_s: f64) -> bool {
        self.around(time_s).iter().any(|point| point.is_lit)
    }

    /// Returns the brighter of the magnitudes near a time for which the corridor is computed.
    fn bright_mag(&self, time_s: f64) -> Option<f64> {
        let magnitudes = self.around(time_s).into_iter().filter_map(|point| Some(point.brightness.as_ref()?.1));
        magnitudes.min_by(f64::total_cmp)
    }
}

/// Corridor to be computed on one chip.
struct Request<'a> {
    element_index: usize,
    chip: usize,
    track: ErringTrack<'a>,
    range_km: f64,
    optics: Optics,
    /// True if the streak was found in the pixels.
    is_found: bool,
    /// Light per second at a predicted time.
    rate: &'a dyn Fn(f64) -> f64,
}

impl Masking<'_> {
    /// Returns the corridors of a satellite on all chips, and the reason if it is not masked although it may be in the
    /// frame.
    fn satellite(
        &self,
        element_index: usize,
        probability: f64,
        measured: &[&MeasuredStreak],
    ) -> Result<(Vec<MaskedStreak>, Option<Omitted>), StreaksError> {
        let (sky, options) = (self.interval.sky(), self.options);
        let elements = &sky.elements()[element_index];
        let omitted = |reason: NotMasked| {
            Ok((Vec::new(), Some(Omitted { norad_id: elements.norad_id, name: elements.name.clone(), reason })))
        };
        let exposure_s = self.frame.exposure_s;
        let Some(propagator) = self.interval.propagator(element_index) else { return Ok((Vec::new(), None)) };
        let uncertainty = self.interval.uncertainty(element_index, propagator, 0.5 * exposure_s);
        // Satellites that have manoeuvred may be anywhere on their orbit; they are not covered.
        let (lateness, not_manoeuvred) = uncertainty.lateness.without_manoeuvres();
        let normal = Lateness::gaussian(1.0);
        let share = options.coverage.sqrt();
        let reach_s = lateness.half_width_s(share).min(Lateness::LONGEST_S);
        let measured_s = measured.iter().filter_map(|streak| streak.late_s);
        let longest_s = measured_s
            .map(|(late_s, sigma_s)| late_s.abs() + normal.half_width_s(share) * sigma_s)
            .fold(reach_s, f64::max);
        // Positions are computed for all times at which a delayed satellite was predicted. The motion of the site moves an
        // end of the streak by at most as much as the delay.
        let margin_s = 2.0 * longest_s + 1.0;
        let wide = Exposure {
            start: seconds_after(self.frame.opened, -margin_s),
            duration_s: exposure_s + 2.0 * margin_s,
            ..self.exposure.clone()
        };
        let interval = sky.exposure_interval(&wide)?;
        let track = match interval.track(element_index, 0.0) {
            Ok(track) => track,
            Err(error) => return omitted(NotMasked::UnknownPosition(error.to_string())),
        };
        let sight = |time_s: f64, late_s: f64| track.delayed(time_s + late_s + margin_s, late_s);
        let predicted_sight = |time_s: f64| sight(time_s, 0.0);
        let times_s = |late_s: [f64; 2]| [-late_s[1], exposure_s - late_s[0]];
        let search_rad = self.radius_rad + MARGIN_RAD;
        let rough = ErringTrack { sight: &predicted_sight, times_s: times_s([-reach_s, reach_s]), across_rad: 0.0 };
        // Error across the track with the shift by the delay, for a share of the errors, at a time.
        let across_rad = |time_s: f64, share: f64| {
            let (drift_rad_s, _) = drift(&sight, time_s);
            let sigma_rad = uncertainty.cross_track_km / sight(time_s, 0.0).1;
            lateness.scaled(drift_rad_s).blurred(sigma_rad).half_width_s(share)
        };
        let nearest_s = nearest(&rough, &self.exposure.pointing);
        let widest_rad = across_rad(nearest_s, share);
        let wide = ErringTrack { across_rad: widest_rad, ..rough };
        let Some(near_s) = wide.near_s(&self.exposure.pointing, search_rad) else {
            let reason = "measured, but predicted far from the frame";
            return if measured.is_empty() {
                Ok((Vec::new(), None))
            } else {
                omitted(NotMasked::UnknownPosition(reason.into()))
            };
        };
        // An end of the streak moves by the delay less the motion of the site along the track.
        let reach_s = reach_s * (1.0 + drift(&sight, nearest_s).1.min(1.0));
        // If no end of the streak can be in the frame, only the error across the track matters.
        let has_end = near_s[0] <= reach_s || near_s[1] >= exposure_s - reach_s;
        let of_ends = if has_end { share.min(lateness.share(-reach_s, reach_s)) } else { 1.0 };
        let across_share = if has_end { share } else { options.coverage };
        let predicted = ErringTrack {
            times_s: times_s([-reach_s, reach_s]),
            across_rad: if has_end { widest_rad } else { across_rad(nearest_s, across_share) },
            ..rough
        };
        let range_km = sight(nearest_s, 0.0).1;
        let light = TrackLight::of(&track, margin_s, near_s, options);
        if !light.points.iter().any(|point| point.is_lit) && measured.is_empty() {
            return Ok((Vec::new(), None));
        }
        let is_given = options.width_arcsec.is_some();
        let is_unknown = !is_given && light.points.iter().all(|point| point.brightness.is_none());
        let (mut streaks, mut reason) = (Vec::new(), None);
        for (index, target) in self.frame.chips.iter().enumerate() {
            let scale = target.chip.scale;
            let lit_rate = |time_s: f64, rate: f64| if light.is_lit(time_s) { rate } else { 0.0 };
            let of_chip = measured.iter().find(|streak| streak.hdu == target.chip.hdu);
            let of_chip = of_chip.and_then(|streak| {
                let late_s = streak.late_s.map_or(0.0, |(late_s, _)| late_s);
                Some((streak, streak.fitted(&target.chip, self.frame.opened, late_s, &sight)?))
            });
            let (late_s, across_rad, found) = match &of_chip {
                Some((streak, fitted)) => {
                    let sigmas = normal.half_width_s(share);
                    let (late_s, error_s) =
                        streak.late_s.map_or((0.0, reach_s), |(late_s, sigma_s)| (late_s, sigmas * sigma_s));
                    let late_s = [late_s - error_s, late_s + error_s];
                    let pixel_rad = (target.chip.pixel_scale_arcsec() / 3600.0).to_radians();
                    let across_rad = ERROR_AT_ENDS * sigmas * streak.across_sigma_pix * pixel_rad;
                    let brightest = |time_s: f64| match light.bright_mag(time_s) {
                        // The light of a saturated streak is a lower limit.
                        Some(magnitude) if streak.is_saturated => streak.rate.max(scale.rate(Some(magnitude))),
                        _ => streak.rate,
                    };
                    let seeing_arcsec = streak.seeing_arcsec.unwrap_or(options.optics.seeing_arcsec);
                    let request = Request {
                        element_index,
                        chip: index,
                        track: ErringTrack { sight: fitted, times_s: times_s(late_s), across_rad },
                        range_km,
                        optics: Optics { seeing_arcsec, ..options.optics },
                        is_found: true,
                        rate: &|time_s| if is_given { 1.0 } else { brightest(time_s) },
                    };
                    (late_s, across_rad, self.corridor(&request)?)
                }
                None if is_unknown => {
                    reason = Some(NotMasked::UnknownMagnitude);
                    continue;
                }
                None => {
                    let request = Request {
                        element_index,
                        chip: index,
                        track: predicted,
                        range_km,
                        optics: options.optics,
                        is_found: false,
                        rate: &|time_s| {
                            lit_rate(time_s, if is_given { 1.0 } else { scale.rate(light.bright_mag(time_s)) })
                        },
                    };
                    ([-reach_s, reach_s], predicted.across_rad, self.corridor(&request)?)
                }
            };
            let Found { cells, peak_to_noise } = found;
            let area = Area::of_cells(&cells, &target.chip.light_area);
            let middle = target.chip.middle();
            let nearest =
                cells.iter().min_by(|a, b| middle.distance(a.middle()).total_cmp(&middle.distance(b.middle())));
            let Some(nearest) = nearest.filter(|_| area.pixels() > 0) else {
                if let (Some(peak_to_noise), None) = (peak_to_noise, &of_chip)
                    && peak_to_noise < options.threshold
                {
                    let magnitude = light.points.iter().filter_map(|point| Some(point.brightness.as_ref()?.1));
                    let magnitude = magnitude.fold(f64::INFINITY, f64::min);
                    reason = Some(NotMasked::Faint { peak_to_noise, magnitude });
                }
                continue;
            };
            let widest_pix = cells.iter().map(|cell| cell.light_pix).fold(0.0, f64::max);
            let on_sky = |polygon: Vec<PixelPosition>| -> Vec<Direction<Gcrs>> {
                polygon.into_iter().filter_map(|corner| target.chip.wcs.to_sky(corner)).collect()
            };
            streaks.push(MaskedStreak {
                chip: index,
                norad_id: elements.norad_id,
                name: elements.name.clone(),
                origin: if of_chip.is_some() { StreakOrigin::Measured } else { StreakOrigin::Predicted },
                epoch: seconds_after(self.frame.opened, nearest.time_s()),
                element_age_days: self.interval.element_age_days(propagator, 0.5 * exposure_s),
                probability: if of_chip.is_some() { 1.0 } else { probability },
                coverage: if of_chip.is_some() { options.coverage } else { not_manoeuvred * of_ends * across_share },
                late_s,
                across_rad,
                brightness: light.around(nearest.time_s())[0].brightness.clone().filter(|_| !is_given),
                peak_to_noise,
                width_arcsec: 2.0 * widest_pix * target.chip.pixel_scale_arcsec(),
                polygons: polygons(&cells, &target.chip.light_area).into_iter().map(on_sky).collect(),
                area,
            });
        }
        // A satellite that is masked on one chip may be too faint for another.
        match reason.filter(|_| streaks.is_empty()) {
            Some(reason) => omitted(reason),
            None => Ok((streaks, None)),
        }
    }

    /// Returns the cells of a corridor on a chip, and the light of the brightest pixel of the chip.
    fn corridor(&self, request: &Request<'_>) -> Result<Found, StreaksError> {
        let chip: &Chip = &self.frame.chips[request.chip].chip;
        let scale_arcsec = chip.pixel_scale_arcsec();
        if let Some(width_arcsec) = self.options.width_arcsec {
            let half_pix = 0.5 * width_arcsec / scale_arcsec;
            let cells = request.track.cells(chip, request.rate, half_pix, |_| Some(half_pix))?;
            return Ok(Found { cells, peak_to_noise: None });
        }
        let radius_m = 0.5 * self.interval.sky().model(request.element_index).size_m();
        let profile = request.optics.profile(request.range_km, radius_m, scale_arcsec, chip.pixel_aspect())?;
        let noise = &self.noise[request.chip];
        let (mut width, mut brightest) = (None, None);
        let half_width = |light: &LocalLight| {
            let [x, y] = light.motion_pix_s;
            let width: &LightWidth = width.get_or_insert_with(|| LightWidth::of(&profile, y.atan2(x)));
            // Light per pixel of length; a slow satellite is a point.
            let per_pixel = (light.rate / x.hypot(y)).min(light.rate * self.frame.exposure_s);
            let inside = |at: f64, count: usize| (at.round().max(0.0) as usize).min(count - 1);
            let sigma = f64::from(noise.at(inside(light.at.y, chip.rows), inside(light.at.x, chip.columns)));
            let without_noise = f64::from(SHARE_WITHOUT_NOISE) * width.peak();
            let level = if noise.is_noisy() {
                let ratio = per_pixel * width.peak() / sigma;
                brightest = Some(brightest.map_or(ratio, |known: f64| known.max(ratio)));
                self.options.threshold * sigma / per_pixel
            } else {
                brightest = Some(f64::INFINITY);
                without_noise
            };
            // A streak that was found is covered at least as in a frame without noise.
            let most = if request.is_found { without_noise } else { f64::INFINITY };
            width.beyond_pix(level.min(most))
        };
        let cells = request.track.cells(chip, request.rate, profile.pixel_reach_pix(), half_width)?;
        Ok(Found { cells, peak_to_noise: brightest })
    }
}

/// Returns the shift of a direction by the motion of the site during a delay of one second: across the track, radians,
/// and along it as a fraction of the motion of the satellite in that time.
fn drift(sight: &impl Fn(f64, f64) -> (Direction<Gcrs>, f64), time_s: f64) -> (f64, f64) {
    const STEP_S: f64 = 0.5;
    let at = |time_s: f64, late_s: f64| *sight(time_s, late_s).0.vector();
    let moved = (at(time_s + STEP_S, 0.0) - at(time_s - STEP_S, 0.0)) / (2.0 * STEP_S);
    let late = (at(time_s, STEP_S) - at(time_s, -STEP_S)) / (2.0 * STEP_S);
    let speed = moved.norm().max(1e-12);
    let along = late.dot(&moved) / speed;
    ((late.norm_squared() - along * along).max(0.0).sqrt(), (along / speed).abs())
}

/// Returns the time at which a track is nearest to a direction, to about a second.
fn nearest(track: &ErringTrack<'_>, direction: &Direction<Gcrs>) -> f64 {
    let [from_s, to_s] = track.times_s;
    let steps = (to_s - from_s).ceil().clamp(1.0, 10_000.0);
    let times_s = (0..=steps as usize).map(|step| from_s + (to_s - from_s) * step as f64 / steps);
    let away = |time_s: &f64| (track.sight)(*time_s).0.separation_rad(direction);
    times_s.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(from_s)
}

/// Result of one corridor.
struct Found {
    cells: Vec<Cell>,
    peak_to_noise: Option<f64>,
}
