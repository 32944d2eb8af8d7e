//! Measurement of all predicted streaks in a frame.

use hifitime::Epoch;
use rayon::prelude::*;

use super::background::Background;
use super::error::MeasureError;
use super::measurement::{Estimate, MeasureOptions, StreakImage, StreakMeasurement};
use super::predict::{PredictOptions, Prediction, predictions};
use super::streak::measure_streak;
use crate::frames::{Direction, Gcrs, seconds_after};
use crate::orbit::LeftOut;
use crate::passes::Sky;
use crate::photometry::PhotometryOptions;
use crate::streaks::{Optics, TargetFrame};

/// Measured streak of one satellite on one chip, in units of the sky.
#[derive(Clone, Debug)]
pub struct MeasuredPass {
    /// File of the frame.
    pub image: String,
    /// HDU of the chip.
    pub hdu: usize,
    /// Prediction.
    pub prediction: Prediction,
    /// Measurement in pixels.
    pub measured: StreakMeasurement,
    /// Middle of the time in which the satellite is on the chip.
    pub epoch: Epoch,
    /// Duration of that time, seconds.
    pub duration_s: f64,
    /// Direction of the satellite at that time: measured if the streak was found, otherwise predicted.
    pub direction: Direction<Gcrs>,
    /// Side of a pixel, arcsec.
    pub pixel_scale_arcsec: f64,
    /// Speed along the track, pixels per second.
    pub speed_pix_s: f64,
    /// Magnitude; `None` if the streak was not found.
    pub magnitude: Option<Estimate>,
    /// Magnitude of the upper limit of the rate; for a saturated streak it has no meaning.
    pub limit_mag: Option<f64>,
    /// Magnitude of a streak at the threshold of detection.
    pub faintest_mag: Option<f64>,
    /// False if the frame has no zero point: magnitudes are instrumental, -2.5 log10 of the counts.
    pub is_calibrated: bool,
    /// Filter as written in the header.
    pub filter: Option<String>,
}

/// Measurements of a frame.
#[derive(Clone, Debug, Default)]
pub struct FrameMeasurements {
    /// Measured streaks and upper limits, in order of HDU and time.
    pub passes: Vec<MeasuredPass>,
    /// Satellites whose positions cannot be computed.
    pub left_out: Vec<LeftOut>,
}

/// Predicts and measures all streaks in a frame, on all threads of the current pool.
///
/// # Errors
/// Pixels cannot be read, passes cannot be computed, or the image of a star cannot be drawn.
pub fn measure_frame(
    sky: &Sky,
    frame: &TargetFrame,
    is_calibrated: bool,
    photometry: &PhotometryOptions,
    optics: &Optics,
    options: &MeasureOptions,
) -> Result<FrameMeasurements, MeasureError> {
    let expected = PredictOptions { sigmas: options.corridor_sigmas, ..PredictOptions::default() };
    let (predicted, left_out) = predictions(sky, frame, photometry, &expected)?;
    let mut passes = Vec::new();
    for (index, target) in frame.chips.iter().enumerate() {
        let of_chip: Vec<&Prediction> = predicted.iter().filter(|prediction| prediction.chip == index).collect();
        if of_chip.is_empty() {
            continue;
        }
        let chip = &target.chip;
        let plane = frame.file.read_plane(chip.hdu)?;
        let background = Background::of(&plane, &chip.light_area);
        let image = StreakImage {
            plane: &plane,
            background: &background,
            light_area: &chip.light_area,
            exposure_s: frame.exposure_s,
            electrons_per_unit: target.electrons_per_unit,
            saturation: target.saturation,
            pixel_scale_arcsec: chip.pixel_scale_arcsec(),
            pixel_aspect: chip.pixel_aspect(),
        };
        let measured = of_chip.par_iter().map(|prediction| -> Result<Option<MeasuredPass>, MeasureError> {
            let measured = measure_streak(&image, &prediction.streak, optics, options)?;
            Ok(measured.and_then(|measured| on_sky(frame, prediction, measured, is_calibrated)))
        });
        passes.extend(measured.collect::<Result<Vec<_>, _>>()?.into_iter().flatten());
    }
    Ok(FrameMeasurements { passes, left_out })
}

fn on_sky(
    frame: &TargetFrame,
    prediction: &Prediction,
    measured: StreakMeasurement,
    is_calibrated: bool,
) -> Option<MeasuredPass> {
    let chip = &frame.chips[prediction.chip].chip;
    let [from_s, to_s] = measured.inside_s;
    let middle_s = 0.5 * (from_s + to_s);
    let at =
        if measured.is_detected { measured.path.point_at(middle_s) } else { prediction.streak.path.point_at(middle_s) };
    let magnitude = measured.is_detected.then_some(()).and_then(|()| {
        let value = chip.scale.magnitude(measured.rate.value)?;
        // σ_m = 2.5 / ln 10 σ_F / F
        Some(Estimate { value, sigma: 2.5 / std::f64::consts::LN_10 * measured.rate.sigma / measured.rate.value })
    });
    Some(MeasuredPass {
        image: frame.file.path().display().to_string(),
        hdu: chip.hdu,
        epoch: seconds_after(frame.opened, middle_s),
        duration_s: to_s - from_s,
        direction: chip.wcs.to_sky(at)?,
        pixel_scale_arcsec: chip.pixel_scale_arcsec(),
        speed_pix_s: if to_s > from_s { measured.length_pix / (to_s - from_s) } else { f64::NAN },
        magnitude,
        limit_mag: chip.scale.magnitude(measured.rate_limit),
        faintest_mag: chip.scale.magnitude(measured.threshold * measured.rate.sigma),
        is_calibrated,
        filter: frame.filter.clone(),
        prediction: prediction.clone(),
        measured,
    })
}
