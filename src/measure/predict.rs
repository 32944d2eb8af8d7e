//! Predicted streaks of the satellites that may cross a frame.

use std::sync::Arc;

use super::measurement::PredictedStreak;
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::ViewingGeometry;
use crate::orbit::{LeftOut, PositionSource};
use crate::passes::{Exposure, ExposureInterval, Field, Pass, PassOptions, Sky};
use crate::photometry::{Brightness, PhotometryOptions, SIZE_SIGMA};
use crate::streaks::{PathNode, SkyPoint, SkyTrack, StreakPath, TargetChip, TargetFrame, Tracking};

/// Number of points of a track in the field.
const SAMPLES: usize = 257;
/// Margin around the frame on the sky, radians (0.1°), in which tracks are predicted.
const MARGIN_RAD: f64 = 1.7e-3;

/// Limits of the errors for which tracks are predicted.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PredictOptions {
    /// Largest delay, seconds, at most 50.
    pub most_late_s: f64,
    /// Largest delay and largest distance across the track, in sigmas.
    pub sigmas: f64,
    /// Diameter of all satellites, m; `None` for those of the models.
    pub size_m: Option<f64>,
}

impl Default for PredictOptions {
    fn default() -> Self {
        Self { most_late_s: 5.0, sigmas: 3.0, size_m: None }
    }
}

/// What is known about the satellite of a streak. All fields may be missing for a streak of a table.
#[derive(Clone, Debug, Default)]
pub struct KnownSatellite {
    /// NORAD catalogue number.
    pub norad_id: Option<NoradId>,
    /// Name in the element set; empty if it is unknown.
    pub name: Arc<str>,
    /// Age of the elements, days.
    pub element_age_days: Option<f64>,
    /// Predicted brightness at the middle of the track.
    pub brightness: Option<Brightness>,
    /// Geometry of Sun, satellite and observer at the middle of the track.
    pub geometry: Option<ViewingGeometry>,
    /// Distance at the middle of the track, km.
    pub range_km: Option<f64>,
    /// Diameter in the brightness model, m.
    pub model_size_m: Option<f64>,
    /// Error (one sigma) of the predicted time, seconds.
    pub time_sigma_s: Option<f64>,
}

/// Predicted streak of one satellite on one chip, or a streak of a table.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Name of the streak in its table; empty for the prediction of a satellite.
    pub id: Arc<str>,
    /// The satellite.
    pub satellite: KnownSatellite,
    /// False if the elements are too old to predict positions.
    pub is_position_known: bool,
    /// False for a streak of a table without times at its ends: they are those of the shutter if the streak ends in the
    /// frame.
    pub has_times: bool,
    /// Full width at half maximum of the image of the light, arcsec; `None` for that of the seeing, the distance and
    /// the size, or a fitted one if the distance is unknown.
    pub image_fwhm_arcsec: Option<f64>,
    /// Diameter with which the image is drawn, m; `None` if it is unknown, or if the width of the image is given or
    /// fitted.
    pub size_m: Option<f64>,
    /// Mean distance to the nearest other streak beside this one in a table, pixels; `None` for a predicted track.
    pub neighbour_pix: Option<f64>,
    /// Index of the chip in [`TargetFrame::chips`].
    pub chip: usize,
    /// Track in pixels with its errors.
    pub streak: PredictedStreak,
}

/// Returns the predicted streaks of lit satellites whose tracks, with their errors, may cross a chip of the frame, and
/// the satellites whose positions cannot be computed.
///
/// # Errors
/// Passes cannot be computed, or the world coordinates do not cover the frame.
pub fn predictions(
    sky: &Sky,
    frame: &TargetFrame,
    photometry: &PhotometryOptions,
    options: &PredictOptions,
) -> Result<(Vec<Prediction>, Vec<LeftOut>), Error> {
    let (exposure, radius_rad) = frame.exposure()?;
    let exposure = Exposure {
        start: seconds_after(exposure.start, -options.most_late_s),
        duration_s: exposure.duration_s + 2.0 * options.most_late_s,
        ..exposure
    };
    // Positions along the orbit need not be known: streaks are searched for about the predictions.
    let of_known_age = sky;
    let sky = &sky.clone().with_elements_of_any_age();
    let field = Field::circle(2.0 * (radius_rad + MARGIN_RAD))?;
    let query = PassOptions { samples: SAMPLES, photometry: *photometry, ..PassOptions::default() };
    let mut crossings = sky.field_passes(std::slice::from_ref(&exposure), &field, &query)?;
    let passes = crossings.by_exposure.pop().unwrap_or_default();
    let interval = sky.exposure_interval(&exposure)?;
    let mut found = Vec::new();
    for pass in &passes {
        for (index, chip) in frame.chips.iter().enumerate() {
            if let Some(streak) = predicted_streak(pass, frame, chip, &interval, options)? {
                found.push(Prediction {
                    id: "".into(),
                    satellite: KnownSatellite {
                        norad_id: Some(pass.norad_id),
                        name: sky.elements()[pass.element_index].name.clone(),
                        element_age_days: Some(pass.element_age_days),
                        brightness: pass.mid.brightness.clone(),
                        geometry: Some(pass.mid.geometry),
                        range_km: Some(pass.mid.range_km),
                        model_size_m: Some(interval.sky().model(pass.element_index).size_m()),
                        time_sigma_s: Some(pass.along_track_sigma_s.hypot(frame.start_sigma_s)),
                    },
                    image_fwhm_arcsec: None,
                    size_m: Some(2.0 * streak.radius_m),
                    neighbour_pix: None,
                    has_times: true,
                    is_position_known: pass.position_source != PositionSource::ElementSet
                        || of_known_age.is_known(pass.element_index, pass.element_age_days),
                    chip: index,
                    streak,
                });
            }
        }
    }
    Ok((found, crossings.left_out))
}

fn predicted_streak(
    pass: &Pass,
    frame: &TargetFrame,
    target: &TargetChip,
    interval: &ExposureInterval<'_>,
    options: &PredictOptions,
) -> Result<Option<PredictedStreak>, Error> {
    let chip = &target.chip;
    let Some((centre, _)) = chip.circle() else { return Ok(None) };
    // A satellite of this magnitude has a rate of 1 in the unit of the frame per second.
    let unit = chip.scale.magnitude(1.0);
    let points = pass.samples.iter().map(|sample| SkyPoint {
        time_s: seconds_between(frame.opened, sample.epoch),
        direction: sample.direction,
        range_km: sample.range_km,
        magnitude: sample.brightness.as_ref().and(unit),
    });
    let track = SkyTrack { points: points.collect() };
    let radian_pix = (1.0f64).to_degrees() * 3600.0 / chip.pixel_scale_arcsec();
    let cross_sigma_pix = pass.cross_track_sigma_rad * radian_pix;
    let margin_pix = (MARGIN_RAD * radian_pix).min(options.sigmas * cross_sigma_pix + 100.0);
    let paths = chip.paths(&track, &Tracking::Sidereal, &centre, margin_pix)?;
    let Some(longest) = paths.into_iter().max_by(|a, b| a.path.length_pix().total_cmp(&b.path.length_pix())) else {
        return Ok(None);
    };
    // An error of the clock has the same effect as a delay of the satellite.
    let lateness_sigma_s = pass.along_track_sigma_s.hypot(frame.start_sigma_s);
    let late_s = (options.sigmas * lateness_sigma_s).min(options.most_late_s);
    let Some(path) = cut(&longest.path, [-late_s, frame.exposure_s + late_s])? else { return Ok(None) };
    if path.total() <= 0.0 {
        return Ok(None);
    }
    let nodes = path.nodes();
    let middle_s = 0.5 * (nodes[0].time_s + nodes[nodes.len() - 1].time_s);
    let model_size_m = interval.sky().model(pass.element_index).size_m();
    Ok(Some(PredictedStreak {
        drift_pix_s: drift(pass, target, interval, middle_s + options.most_late_s).unwrap_or_default(),
        path,
        lateness_sigma_s,
        largest_delay_s: options.most_late_s,
        ends_s: None,
        cross_sigma_pix,
        range_km: pass.mid.range_km,
        radius_m: 0.5 * options.size_m.unwrap_or(model_size_m),
        radius_sigma_m: if options.size_m.is_some() { 0.0 } else { 0.5 * SIZE_SIGMA * model_size_m },
    }))
}

/// Returns the displacement per second of delay that the motion of the observer causes, pixels. `time_s` is relative to
/// the start of the interval.
fn drift(pass: &Pass, target: &TargetChip, interval: &ExposureInterval<'_>, time_s: f64) -> Option<[f64; 2]> {
    const DELAY_S: f64 = 1.0;
    let nominal = interval.track(pass.element_index, 0.0).ok()?;
    let late = interval.track(pass.element_index, DELAY_S).ok()?;
    let wcs = &target.chip.wcs;
    let from = wcs.to_pixel(nominal.direction(time_s - DELAY_S).0)?;
    let to = wcs.to_pixel(late.direction(time_s).0)?;
    Some([(to.x - from.x) / DELAY_S, (to.y - from.y) / DELAY_S])
}

/// Returns the part of a path between two times; `None` if it is empty.
fn cut(path: &StreakPath, [from_s, to_s]: [f64; 2]) -> Result<Option<StreakPath>, Error> {
    let nodes = path.nodes();
    let (from_s, to_s) = (from_s.max(nodes[0].time_s), to_s.min(nodes[nodes.len() - 1].time_s));
    /// Smallest time between two nodes, seconds.
    const LEAST_S: f64 = 1e-6;
    if to_s - from_s < 2.0 * LEAST_S {
        return Ok(None);
    }
    let end = |time_s: f64| PathNode::new(time_s, path.point_at(time_s), path.rate_at(time_s));
    let inner = nodes.iter().filter(|node| node.time_s > from_s + LEAST_S && node.time_s < to_s - LEAST_S);
    let nodes = std::iter::once(end(from_s)).chain(inner.copied()).chain([end(to_s)]).collect();
    Ok(Some(StreakPath::new(nodes)?))
}
