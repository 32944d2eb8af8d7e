//! Corridors of the satellites in a frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use hifitime::Epoch;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::super::chip::Chip;
use super::super::frame::{TargetFrame, noise_of_chip};
use super::super::optics::Optics;
use super::super::truth::{NoiseMap, SHARE_WITHOUT_NOISE};
use super::area::{Area, polygons};
use super::corridor::{Cell, LocalLight, UncertainTrack};
use super::light_width::LightWidth;
use super::measured::{MeasuredStreak, UnusedReason};
use crate::elements::NoradId;
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, Gcrs, seconds_after};
use crate::images::PixelPosition;
use crate::orbit::Lateness;
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
    /// Probability that the streak of a satellite is in its corridor, (0, 1), and the probability that it is not
    /// brighter than the magnitude for which the corridor is computed.
    pub coverage: f64,
    /// Light is covered down to this multiple of the local noise of a pixel.
    pub threshold: f64,
    /// Smallest probability with which a satellite whose nominal track misses the frame is considered.
    pub min_probability: f64,
    /// Full width of the light of a streak, arcsec; `None` to compute it from brightness and noise.
    pub width_arcsec: Option<f64>,
    /// True if the zero point of the frame is known. Without it and `width_arcsec`, only measured streaks can be
    /// masked.
    pub is_calibrated: bool,
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
    /// Time at which the satellite is nearest to the middle of the chip: the predicted time, with the measured delay if
    /// there is one.
    pub epoch: Epoch,
    /// Age of the elements, days.
    pub element_age_days: f64,
    /// Probability that the satellite is in the frame during the exposure; 1 if it was measured on a chip.
    pub probability: f64,
    /// Probability that the streak is in the corridor.
    pub coverage: f64,
    /// Smallest and largest delay, seconds.
    pub late_s: [f64; 2],
    /// Largest distance across the track, radians.
    pub across_rad: f64,
    /// Predicted magnitude at that time, and the magnitude for which the corridor is computed; `None` if the width of
    /// the light is given.
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

/// Reason why a satellite is left out of a mask.
#[derive(Clone, Debug, PartialEq)]
pub enum LeftOutReason {
    /// Its brightest pixel is fainter than the threshold, at its bright magnitude.
    Faint {
        /// Light of the brightest pixel of all chips, in multiples of the local noise.
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

/// Satellite that is left out of a mask.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutSatellite {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Name in the element set; empty if it has none.
    pub name: Arc<str>,
    /// Reason.
    pub reason: LeftOutReason,
}

/// Mask of a frame.
#[derive(Clone, Debug, Default)]
pub struct FrameMask {
    /// Corridors, in the order of chips and times.
    pub streaks: Vec<MaskedStreak>,
    /// Satellites that may be in the frame and are left out, and those of unknown position.
    pub left_out: Vec<LeftOutSatellite>,
    /// Measured streaks that are not used.
    pub unused: Vec<(MeasuredStreak, UnusedReason)>,
}

impl FrameMask {
    /// Returns the masked pixels of a chip.
    pub fn area(&self, chip: usize) -> Area {
        Area::union(self.streaks.iter().filter(|streak| streak.chip == chip).map(|streak| &streak.area))
    }
}

/// Computes the corridors of the satellites in a frame, on all threads of the current pool.
///
/// Streaks in `measured` replace the predictions of their satellites on their chips, if their times are in the exposure
/// and their tracks reach the chips.
///
/// # Errors
/// Passes cannot be computed, pixels cannot be read, the image of a star cannot be drawn, or the zero point of a frame
/// with a predicted streak is missing.
pub fn mask_frame(
    sky: &Sky,
    frame: &TargetFrame,
    measured: &[MeasuredStreak],
    options: &MaskOptions,
) -> Result<FrameMask, Error> {
    let (exposure, radius_rad) = frame.exposure()?;
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
        if let Some(reason) = streak.unused_in(frame) {
            mask.unused.push((streak.clone(), reason));
        } else if let Some(index) = elements.iter().position(|set| set.norad_id == streak.norad_id) {
            of_satellite.entry(index).or_default().push(streak);
            // A satellite that is found only by its measured streak is not masked as predicted alone.
            probabilities.entry(index).or_insert(0.0);
        } else {
            let (norad_id, name) = (streak.norad_id, streak.name.as_str().into());
            mask.left_out.push(LeftOutSatellite { norad_id, name, reason: LeftOutReason::NoElements });
        }
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
    let share = options.coverage.sqrt();
    let sigmas = Lateness::gaussian(1.0).half_width_s(share);
    let (exposure, interval, noise) = (&exposure, &interval, &noise[..]);
    let masking = Masking { frame, exposure, radius_rad, interval, noise, options, share, sigmas };
    let parts = probabilities.into_par_iter().map(|(element_index, probability)| {
        sky.watch().check()?;
        let measured = of_satellite.get(&element_index).map_or(&[][..], Vec::as_slice);
        Ok((element_index, masking.satellite(element_index, probability, measured)?))
    });
    let parts = parts.collect::<Result<BTreeMap<usize, FrameMask>, Error>>()?;
    let is_listed = |part: &FrameMask| !part.streaks.is_empty() || !part.left_out.is_empty();
    let unknown = found.left_out.iter().filter(|satellite| !parts.get(&satellite.element_index).is_some_and(is_listed));
    mask.left_out.extend(unknown.map(|satellite| LeftOutSatellite {
        norad_id: satellite.norad_id,
        name: elements[satellite.element_index].name.clone(),
        reason: LeftOutReason::UnknownPosition(satellite.reason.to_string()),
    }));
    for part in parts.into_values() {
        mask.streaks.extend(part.streaks);
        mask.left_out.extend(part.left_out);
        mask.unused.extend(part.unused);
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
    /// Probability with which the delay and the distance across the track are each covered, and the number of standard
    /// deviations of a normal distribution that contain it.
    share: f64,
    sigmas: f64,
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
    fn new(track: &DelayedTrack<'_>, margin_s: f64, times_s: [f64; 2], options: &MaskOptions) -> Self {
        let point = |index: usize| {
            let time_s = times_s[0] + (times_s[1] - times_s[0]) * index as f64 / (LIGHT_POINTS - 1) as f64;
            let Some(point) = track.point(time_s + margin_s, &options.photometry) else { return LightPoint::default() };
            let bright = |light: Brightness| {
                let magnitude = light.exceeded_with(1.0 - options.coverage);
                (light, magnitude)
            };
            LightPoint {
                is_lit: point.illumination.is_lit() || options.photometry.band.is_thermal(),
                brightness: point.brightness.map(bright),
            }
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

/// Satellite that may be near the frame.
struct Satellite<'a> {
    element_index: usize,
    element_age_days: f64,
    /// Direction and distance, km, at a predicted time, if it is late by a number of seconds.
    sight: &'a Sight<'a>,
    range_km: f64,
    light: &'a TrackLight,
    /// Predicted track, and the probabilities that it is in the frame and that its corridor contains the streak.
    predicted: UncertainTrack<'a>,
    probability: f64,
    coverage: f64,
}

type Sight<'a> = dyn Fn(f64, f64) -> (Direction<Gcrs>, f64) + Sync + 'a;

/// Errors of the predicted position of a satellite.
struct PositionErrors {
    /// Distribution of the delay without satellites that have manoeuvred: these may be anywhere on their orbit, and are
    /// not covered.
    lateness: Lateness,
    /// Share of satellites that have not manoeuvred.
    not_manoeuvred: f64,
    cross_track_km: f64,
    /// Largest delay that is covered.
    delay_s: f64,
}

impl PositionErrors {
    /// Returns the distance across the track, with the shift by the delay, that contains a share of the errors.
    fn across_rad(&self, sight: &Sight<'_>, time_s: f64, share: f64) -> f64 {
        let (drift_rad_s, _) = drift(sight, time_s);
        let sigma_rad = self.cross_track_km / sight(time_s, 0.0).1;
        self.lateness.scaled(drift_rad_s).blurred(sigma_rad).half_width_s(share)
    }
}

/// Corridor to be computed on one chip.
struct CorridorRequest<'a> {
    chip: usize,
    track: UncertainTrack<'a>,
    optics: Optics,
    /// True if the streak was found in the pixels.
    is_found: bool,
    /// Light per second at a predicted time.
    rate: &'a dyn Fn(f64) -> f64,
}

impl Masking<'_> {
    /// Returns the mask of one satellite, without corridors if it is left out or cannot be in the frame.
    fn satellite(
        &self,
        element_index: usize,
        probability: f64,
        measured: &[&MeasuredStreak],
    ) -> Result<FrameMask, Error> {
        let (sky, middle_s) = (self.interval.sky(), 0.5 * self.frame.exposure_s);
        let left_out = |reason: LeftOutReason| {
            let elements = &sky.elements()[element_index];
            let satellite = LeftOutSatellite { norad_id: elements.norad_id, name: elements.name.clone(), reason };
            FrameMask { left_out: vec![satellite], ..FrameMask::default() }
        };
        let Some(propagator) = self.interval.propagator(element_index) else { return Ok(FrameMask::default()) };
        let uncertainty = self.interval.uncertainty(element_index, propagator, middle_s);
        let (lateness, not_manoeuvred) = uncertainty.lateness.without_manoeuvres();
        let lateness = lateness.blurred(self.frame.start_sigma_s);
        let delay_s = lateness.half_width_s(self.share).min(Lateness::LONGEST_S);
        let errors = PositionErrors { lateness, not_manoeuvred, cross_track_km: uncertainty.cross_track_km, delay_s };
        let delays_s = measured.iter().filter_map(|streak| streak.late_s);
        let longest_s = delays_s.map(|(late_s, sigma_s)| late_s.abs() + self.sigmas * sigma_s).fold(delay_s, f64::max);
        // Positions are computed for all times at which a delayed satellite was predicted. The motion of the site moves
        // an end of the streak by at most as much as the delay.
        let margin_s = 2.0 * longest_s + 1.0;
        let wide = Exposure {
            start: seconds_after(self.frame.opened, -margin_s),
            duration_s: self.frame.exposure_s + 2.0 * margin_s,
            ..self.exposure.clone()
        };
        let interval = sky.exposure_interval(&wide)?;
        let track = match interval.track(element_index, 0.0) {
            Ok(track) => track,
            Err(error) => return Ok(left_out(LeftOutReason::UnknownPosition(error.to_string()))),
        };
        let sight = |time_s: f64, late_s: f64| track.delayed(time_s + late_s + margin_s, late_s);
        let on_time = |time_s: f64| sight(time_s, 0.0);
        let Some((predicted, near_s, coverage)) = self.predicted(&errors, &sight, &on_time) else {
            let reason = LeftOutReason::UnknownPosition("measured, but predicted far from the frame".into());
            return Ok(if measured.is_empty() { FrameMask::default() } else { left_out(reason) });
        };
        let satellite = Satellite {
            element_index,
            element_age_days: self.interval.element_age_days(propagator, middle_s),
            sight: &sight,
            range_km: on_time(0.5 * (near_s[0] + near_s[1])).1,
            light: &TrackLight::new(&track, margin_s, near_s, self.options),
            predicted,
            probability,
            coverage,
        };
        let (mask, reason) = self.on_chips(&satellite, measured)?;
        // A satellite that is masked on one chip may be too faint for another.
        Ok(match reason.filter(|_| mask.streaks.is_empty()) {
            Some(reason) => FrameMask { unused: mask.unused, ..left_out(reason) },
            None => mask,
        })
    }

    /// Returns the predicted track with its errors, the times at which it may be near the frame, and the probability
    /// that its corridor contains the streak; `None` if it does not lead near the frame.
    fn predicted<'a>(
        &self,
        errors: &PositionErrors,
        sight: &Sight<'_>,
        on_time: &'a (dyn Fn(f64) -> (Direction<Gcrs>, f64) + Sync),
    ) -> Option<(UncertainTrack<'a>, [f64; 2], f64)> {
        let (exposure_s, share, pointing) = (self.frame.exposure_s, self.share, &self.exposure.pointing);
        let times_s = |reach_s: f64| [-reach_s, exposure_s + reach_s];
        let track = |reach_s, across_rad| UncertainTrack { sight: on_time, times_s: times_s(reach_s), across_rad };
        let nearest_s = nearest(&track(errors.delay_s, 0.0), pointing);
        let widest_rad = errors.across_rad(sight, nearest_s, share);
        let near_s = track(errors.delay_s, widest_rad).near_s(pointing, self.radius_rad + MARGIN_RAD)?;
        // An end of the streak moves by the delay less the motion of the site along the track.
        let reach_s = errors.delay_s * (1.0 + drift(sight, nearest_s).1.min(1.0));
        // If no end of the streak can be in the frame, only the error across the track matters.
        let has_end = near_s[0] <= reach_s || near_s[1] >= exposure_s - reach_s;
        let (across_rad, covered) = if has_end {
            (widest_rad, share * share.min(errors.lateness.share(-errors.delay_s, errors.delay_s)))
        } else {
            (errors.across_rad(sight, nearest_s, self.options.coverage), self.options.coverage)
        };
        Some((track(reach_s, across_rad), near_s, errors.not_manoeuvred * covered))
    }

    /// Returns the corridors of a satellite on all chips, measured or else predicted, and the reason why the prediction
    /// is not masked on a chip.
    fn on_chips(
        &self,
        satellite: &Satellite<'_>,
        measured: &[&MeasuredStreak],
    ) -> Result<(FrameMask, Option<LeftOutReason>), Error> {
        let (light, chips) = (satellite.light, 0..self.frame.chips.len());
        let mut mask = FrameMask::default();
        for &streak in measured {
            let found = match chips.clone().find(|chip| self.frame.chips[*chip].chip.hdu == streak.hdu) {
                Some(chip) if mask.streaks.iter().all(|other| other.chip != chip) => {
                    self.measured_on(satellite, chip, streak)?.ok_or(UnusedReason::OffChip)
                }
                _ => Err(UnusedReason::Repeated),
            };
            match found {
                Ok(added) => mask.streaks.push(added),
                Err(reason) => mask.unused.push((streak.clone(), reason)),
            }
        }
        let masked: Vec<usize> = mask.streaks.iter().map(|streak| streak.chip).collect();
        if satellite.probability == 0.0 && masked.is_empty() || !light.points.iter().any(|point| point.is_lit) {
            return Ok((mask, None));
        }
        let (is_given, is_calibrated) = (self.options.width_arcsec.is_some(), self.options.is_calibrated);
        if !is_given && light.points.iter().all(|point| point.brightness.is_none()) {
            return Ok((mask, Some(LeftOutReason::UnknownMagnitude)));
        }
        let mut brightest: Option<f64> = None;
        for chip in chips.filter(|chip| !masked.contains(chip)) {
            let rate = |time_s: f64| match light.is_lit(time_s) {
                false => 0.0,
                true if is_given || !is_calibrated => 1.0,
                true => self.frame.chips[chip].chip.scale.rate(light.bright_mag(time_s)),
            };
            let (track, optics) = (satellite.predicted, self.options.optics);
            let request = CorridorRequest { chip, track, optics, is_found: false, rate: &rate };
            let corridor = self.corridor(satellite, &request)?;
            brightest = brightest.into_iter().chain(corridor.peak_to_noise).max_by(f64::total_cmp);
            let streak = self.masked(satellite, &request, corridor);
            if !is_given && !is_calibrated && streak.is_some() {
                let name = self.name_of(satellite);
                let of_all = if masked.is_empty() { "" } else { " on all chips" };
                return Err(missing_zero_point(self.frame, &format!(" ({name} is not measured{of_all})")));
            }
            // A satellite that was measured on another chip is in the frame.
            let probability = if masked.is_empty() { satellite.probability } else { 1.0 };
            mask.streaks.extend(streak.map(|streak| MaskedStreak { probability, ..streak }));
        }
        let magnitude = light.points.iter().filter_map(|point| Some(point.brightness.as_ref()?.1));
        let magnitude = magnitude.fold(f64::INFINITY, f64::min);
        let faint = brightest.filter(|peak_to_noise| *peak_to_noise < self.options.threshold);
        Ok((mask, faint.map(|peak_to_noise| LeftOutReason::Faint { peak_to_noise, magnitude })))
    }

    fn name_of(&self, satellite: &Satellite<'_>) -> String {
        let elements = &self.interval.sky().elements()[satellite.element_index];
        elements.norad_id.or_name(&elements.name)
    }

    /// Returns the corridor of a measured streak on a chip; `None` if it does not reach the chip.
    fn measured_on(
        &self,
        satellite: &Satellite<'_>,
        index: usize,
        streak: &MeasuredStreak,
    ) -> Result<Option<MaskedStreak>, Error> {
        let (options, chip, exposure_s) = (self.options, &self.frame.chips[index].chip, self.frame.exposure_s);
        // Without a measured delay it is that of the prediction.
        let (late_s, error_s) = streak
            .late_s
            .map_or((0.0, -satellite.predicted.times_s[0]), |(late_s, sigma_s)| (late_s, self.sigmas * sigma_s));
        let Some(fitted) = streak.fitted(chip, self.frame.opened, late_s, satellite.sight) else { return Ok(None) };
        if streak.is_saturated && !options.is_calibrated && options.width_arcsec.is_none() {
            // Its measured light is a lower limit.
            let reason = format!(" ({} is saturated)", self.name_of(satellite));
            return Err(missing_zero_point(self.frame, &reason));
        }
        let pixel_rad = (chip.pixel_scale_arcsec() / 3600.0).to_radians();
        let track = UncertainTrack {
            sight: &fitted,
            times_s: [-late_s - error_s, exposure_s - late_s + error_s],
            across_rad: ERROR_AT_ENDS * self.sigmas * streak.across_sigma_pix * pixel_rad,
        };
        let rate = |time_s: f64| match satellite.light.bright_mag(time_s) {
            _ if options.width_arcsec.is_some() => 1.0,
            // The light of a saturated streak is a lower limit.
            Some(magnitude) if streak.is_saturated => streak.rate.max(chip.scale.rate(Some(magnitude))),
            _ => streak.rate,
        };
        let seeing_arcsec = streak.seeing_arcsec.unwrap_or(options.optics.seeing_arcsec);
        let optics = Optics { seeing_arcsec, ..options.optics };
        let request = CorridorRequest { chip: index, track, optics, is_found: true, rate: &rate };
        Ok(self.masked(satellite, &request, self.corridor(satellite, &request)?))
    }

    /// Returns the masked streak of a corridor; `None` if it contains no pixel of the chip.
    fn masked(
        &self,
        satellite: &Satellite<'_>,
        request: &CorridorRequest<'_>,
        ChipCorridor { cells, peak_to_noise }: ChipCorridor,
    ) -> Option<MaskedStreak> {
        let chip = &self.frame.chips[request.chip].chip;
        let area = Area::of_cells(&cells, &chip.light_area);
        let away = |cell: &Cell| chip.middle().distance(cell.middle());
        let nearest = cells.iter().min_by(|a, b| away(a).total_cmp(&away(b))).filter(|_| area.pixels() > 0)?;
        let widest_pix = cells.iter().map(|cell| cell.light_pix).fold(0.0, f64::max);
        let elements = &self.interval.sky().elements()[satellite.element_index];
        let [from_s, to_s] = request.track.times_s;
        let late_s = [self.frame.exposure_s - to_s, -from_s];
        let (origin, probability, coverage) = if request.is_found {
            (StreakOrigin::Measured, 1.0, self.options.coverage)
        } else {
            (StreakOrigin::Predicted, satellite.probability, satellite.coverage)
        };
        let brightness = satellite.light.around(nearest.time_s())[0].brightness.clone();
        Some(MaskedStreak {
            chip: request.chip,
            norad_id: elements.norad_id,
            name: elements.name.clone(),
            origin,
            epoch: seconds_after(self.frame.opened, nearest.time_s() + 0.5 * (late_s[0] + late_s[1])),
            element_age_days: satellite.element_age_days,
            probability,
            coverage,
            late_s,
            across_rad: request.track.across_rad,
            brightness: brightness.filter(|_| self.options.width_arcsec.is_none()),
            peak_to_noise,
            width_arcsec: 2.0 * widest_pix * chip.pixel_scale_arcsec(),
            polygons: polygons(&cells, &chip.light_area).into_iter().map(|polygon| on_sky(chip, polygon)).collect(),
            area,
        })
    }

    /// Returns the cells of a corridor on a chip, and the light of the brightest pixel of the chip.
    fn corridor(&self, satellite: &Satellite<'_>, request: &CorridorRequest<'_>) -> Result<ChipCorridor, Error> {
        let chip: &Chip = &self.frame.chips[request.chip].chip;
        let scale_arcsec = chip.pixel_scale_arcsec();
        // Without a zero point only the pixels that a satellite may cross are computed, not the width of its light.
        let of_seeing = (!self.options.is_calibrated && !request.is_found).then_some(request.optics.seeing_arcsec);
        if let Some(width_arcsec) = self.options.width_arcsec.or(of_seeing) {
            let half_pix = 0.5 * width_arcsec / scale_arcsec;
            let cells = request.track.cells(chip, request.rate, half_pix, |_| Some(half_pix))?;
            return Ok(ChipCorridor { cells, peak_to_noise: None });
        }
        let radius_m = 0.5 * self.interval.sky().model(satellite.element_index).size_m();
        let profile = request.optics.profile(satellite.range_km, radius_m, scale_arcsec, chip.pixel_aspect())?;
        let noise = &self.noise[request.chip];
        let (mut width, mut brightest) = (None, None);
        let half_width = |light: &LocalLight| {
            let [x, y] = light.motion_pix_s;
            // The width depends little on the direction, so that that of the first cell suffices.
            let width: &LightWidth = width.get_or_insert_with(|| LightWidth::new(&profile, y.atan2(x)));
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
        Ok(ChipCorridor { cells, peak_to_noise: brightest })
    }
}

/// Returns the error of a frame without a zero point; `why` states why it is needed, in parentheses, or is empty.
pub fn missing_zero_point(frame: &TargetFrame, why: &str) -> Error {
    let shown = frame.file.path().display();
    Error::new(
        ErrorKind::Invalid,
        format!(
            "{shown}: missing zero point, which relates magnitudes to counts{why}; specify --zero-point, \
             --zero-point-1s, or --width to mask all streaks with one width"
        ),
    )
}

/// Returns the corners of a polygon on the sky, anticlockwise as seen by the observer (IVOA DALI 1.1, section 3.3.7).
/// In mirrored images they are clockwise in pixels.
fn on_sky(chip: &Chip, polygon: Vec<PixelPosition>) -> Vec<Direction<Gcrs>> {
    let mut corners: Vec<_> = polygon.into_iter().filter_map(|corner| chip.wcs.to_sky(corner)).collect();
    let next = corners.iter().cycle().skip(1);
    let turn: Vector3<f64> = corners.iter().zip(next).map(|(a, b)| a.vector().cross(b.vector())).sum();
    if corners.first().is_some_and(|first| turn.dot(first.vector()) > 0.0) {
        corners.reverse();
    }
    corners
}

/// Returns the shift of a direction by the motion of the site during a delay of one second: across the track, radians,
/// and along it as a fraction of the motion of the satellite in that time.
fn drift(sight: &Sight<'_>, time_s: f64) -> (f64, f64) {
    const STEP_S: f64 = 0.5;
    let at = |time_s: f64, late_s: f64| *sight(time_s, late_s).0.vector();
    let moved = (at(time_s + STEP_S, 0.0) - at(time_s - STEP_S, 0.0)) / (2.0 * STEP_S);
    let late = (at(time_s, STEP_S) - at(time_s, -STEP_S)) / (2.0 * STEP_S);
    let speed = moved.norm().max(1e-12);
    let along = late.dot(&moved) / speed;
    ((late.norm_squared() - along * along).max(0.0).sqrt(), (along / speed).abs())
}

/// Returns the time at which a track is nearest to a direction, to about a second.
fn nearest(track: &UncertainTrack<'_>, direction: &Direction<Gcrs>) -> f64 {
    let [from_s, to_s] = track.times_s;
    let steps = (to_s - from_s).ceil().clamp(1.0, 10_000.0);
    let times_s = (0..=steps as usize).map(|step| from_s + (to_s - from_s) * step as f64 / steps);
    let away = |time_s: &f64| (track.sight)(*time_s).0.separation_rad(direction);
    times_s.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(from_s)
}

/// Corridor on one chip.
struct ChipCorridor {
    cells: Vec<Cell>,
    peak_to_noise: Option<f64>,
}
