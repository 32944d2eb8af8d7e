//! Measurement of all predicted streaks in a frame.

use hifitime::Epoch;
use rayon::prelude::*;

use super::background::Background;
use super::bad_pixels::{compare_noise, remove_bad_pixels};
use super::cut::{StreakCut, streak_cut};
use super::levels::PixelLevels;
use super::measurement::{Estimate, Flag, MeasureOptions, StreakImage, StreakMeasurement};
use super::predict::{PredictOptions, Prediction, predictions};
use super::star_table::CatalogueStar;
use super::streak::{measure_streak, profile_of};
use super::zero_point::{StarZeroPoint, star_zero_point};
use crate::error::Error;
use crate::frames::{Direction, Gcrs, seconds_after};
use crate::orbit::LeftOut;
use crate::passes::Sky;
use crate::photometry::PhotometryOptions;
use crate::streaks::{CountScale, Optics, TargetFrame};
use crate::watch::Watch;

/// Source of the zero points of a frame.
#[derive(Copy, Clone, Debug)]
pub enum ZeroPoints<'a> {
    /// The count scales of the chips, from the header or given.
    Frame,
    /// None: magnitudes are instrumental, -2.5 log10 of the counts.
    Missing,
    /// Stars in the band of the frame. A chip with fewer than three usable stars has instrumental magnitudes.
    Stars(&'a [CatalogueStar]),
}

/// Options for the measurement of a frame.
#[derive(Copy, Clone, Debug)]
pub struct FrameOptions<'a> {
    /// Source of the zero points.
    pub zero_points: ZeroPoints<'a>,
    /// Photometry of the predictions.
    pub photometry: PhotometryOptions,
    /// Seeing and telescope.
    pub optics: Optics,
    /// False if the seeing in `optics` is only a first estimate. The seeing is then measured from the stars, or,
    /// without stars, fitted to each streak.
    pub is_seeing_known: bool,
    /// Diameter of the satellites, m; `None` for those of the models, whose errors are part of those of the magnitudes.
    pub satellite_size_m: Option<f64>,
    /// Options for each streak.
    pub measure: MeasureOptions,
    /// If true, the pixels along each track are returned, for pictures.
    pub cuts: bool,
}

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
    /// Exposure time of the frame, seconds.
    pub exposure_s: f64,
    /// Direction of the satellite at that time: measured if the streak was found, otherwise predicted.
    pub direction: Direction<Gcrs>,
    /// Directions of both ends of the measured streak on the chip; `None` if they are not on the sky of the frame.
    pub ends: [Option<Direction<Gcrs>>; 2],
    /// Side of a pixel, arcsec.
    pub pixel_scale_arcsec: f64,
    /// Speed along the track, pixels per second.
    pub speed_pix_s: f64,
    /// Magnitude, with the error of the zero point if it is known; `None` if the streak was not found.
    pub magnitude: Option<Estimate>,
    /// Magnitude of the upper limit of the rate; for a saturated streak it has no meaning. `None` if the position is
    /// unknown: the satellite may be elsewhere; or if the sky is cut off.
    pub limit_mag: Option<f64>,
    /// Magnitude of a streak at the threshold of detection; `None` if the sky is cut off.
    pub faintest_mag: Option<f64>,
    /// False if the chip has no zero point: magnitudes are instrumental, -2.5 log10 of the counts.
    pub is_calibrated: bool,
    /// Magnitude of a star whose pixels sum to 1 in the unit of the frame.
    pub zero_point_mag: f64,
    /// Error (one sigma) of a zero point from stars, mag; `None` if it is from the header or given.
    pub zero_point_sigma_mag: Option<f64>,
    /// Filter as written in the header.
    pub filter: Option<String>,
    /// Predicted magnitude that is corrected by earlier streaks of the same pass; `None` without such streaks.
    pub of_pass: Option<Estimate>,
    /// Pixels along the track, if they are requested.
    pub cut: Option<StreakCut>,
}

/// Measurements of a frame.
#[derive(Clone, Debug, Default)]
pub struct FrameMeasurements {
    /// Measured streaks and upper limits, in order of HDU and time.
    pub passes: Vec<MeasuredPass>,
    /// Satellites whose positions cannot be computed.
    pub left_out: Vec<LeftOut>,
    /// Zero points from stars, with the HDUs of their chips. Only chips with a predicted track are measured.
    pub star_zero_points: Vec<(usize, StarZeroPoint)>,
    /// What was used of companion planes: bad pixels and noise, or the reason why a plane was not used.
    pub planes_used: Vec<String>,
    /// Values at which pixels of a chip are cut off although the header does not say so, as sentences.
    pub remarks: Vec<String>,
}

/// Conversion of the rates of a chip to magnitudes.
#[derive(Copy, Clone, Debug)]
struct ChipScale {
    scale: CountScale,
    is_calibrated: bool,
    /// Error of the zero point, mag.
    sigma_mag: Option<f64>,
    /// True if the sky is cut off, so that the light of streaks is incomplete.
    is_clipped: bool,
}

/// Predicts and measures all streaks in a frame, on all threads of the current pool.
///
/// # Errors
/// Pixels cannot be read, passes cannot be computed, or the image of a star cannot be drawn.
pub fn measure_frame(sky: &Sky, frame: &TargetFrame, options: &FrameOptions<'_>) -> Result<FrameMeasurements, Error> {
    let expected = PredictOptions {
        sigmas: options.measure.corridor_sigmas,
        size_m: options.satellite_size_m,
        ..PredictOptions::default()
    };
    let (predicted, left_out) = predictions(sky, frame, &options.photometry, &expected)?;
    let (measured, done) = measure_predictions(frame, &predicted, options, sky.watch())?;
    Ok(FrameMeasurements { passes: measured.into_iter().map(|(_, pass)| pass).collect(), left_out, ..done })
}

/// Measures predicted streaks in a frame. Returns the measurements, each with the index of its prediction, and the zero
/// points and planes.
///
/// # Errors
/// Pixels cannot be read, or the image of a star cannot be drawn.
pub fn measure_predictions(
    frame: &TargetFrame,
    predicted: &[Prediction],
    options: &FrameOptions<'_>,
    watch: &Watch,
) -> Result<(Vec<(usize, MeasuredPass)>, FrameMeasurements), Error> {
    let mut done = FrameMeasurements::default();
    let mut passes = Vec::new();
    for (index, target) in frame.chips.iter().enumerate() {
        let of_chip: Vec<(usize, &Prediction)> =
            predicted.iter().enumerate().filter(|(_, prediction)| prediction.chip == index).collect();
        if of_chip.is_empty() {
            continue;
        }
        watch.check()?;
        let chip = &target.chip;
        let mut plane = frame.file.read_plane(chip.hdu)?;
        let mut planes = remove_bad_pixels(&frame.file, chip.hdu, &frame.images.companions, &mut plane)?;
        // Infinite pixels, such as those of a division by a flat field of 0, have no value.
        plane.values_mut().iter_mut().filter(|value| value.is_infinite()).for_each(|value| *value = f32::NAN);
        let levels = PixelLevels::new(&plane, &chip.light_area, target.whole_range.map(|(_, greatest)| greatest));
        done.remarks.extend(levels.iter().flat_map(|levels| levels.remarks(target)));
        let electrons_per_unit =
            target.electrons_per_unit.filter(|gain| !levels.is_some_and(|levels| levels.contradict_gain(*gain)));
        let full = levels.and_then(|levels| levels.full);
        let mut background = Background::new(&plane, &chip.light_area);
        if let Some(noise) = &planes.noise
            && let Some(words) = compare_noise(noise, &mut background)
        {
            planes.used[noise.plane] += &format!("; {words}");
        }
        done.planes_used.extend(planes.used);
        let image = StreakImage {
            plane: &plane,
            background: &background,
            light_area: &chip.light_area,
            exposure_s: frame.exposure_s,
            electrons_per_unit,
            saturation: target.saturation.or(full.map(|(level, _)| level)),
            pixel_scale_arcsec: chip.pixel_scale_arcsec(),
            pixel_aspect: chip.pixel_aspect(),
        };
        let (mut optics, mut measure) = (options.optics, options.measure);
        measure.is_seeing_known = options.is_seeing_known;
        measure.fit_width |= !options.is_seeing_known;
        let is_calibrated = !matches!(options.zero_points, ZeroPoints::Missing);
        let is_clipped = levels.is_some_and(|levels| levels.empty.is_some());
        let mut scale = ChipScale { scale: chip.scale, is_calibrated, sigma_mag: None, is_clipped };
        if let ZeroPoints::Stars(stars) = options.zero_points {
            let from_stars = star_zero_point(
                &image,
                &chip.wcs,
                stars,
                &optics,
                options.is_seeing_known,
                measure.is_form_known,
                watch,
            )?;
            let zero_point_mag = from_stars.zero_point_mag.map_or(0.0, |zero_point| zero_point.value);
            scale = ChipScale {
                scale: CountScale::of_frame(zero_point_mag, frame.exposure_s)?,
                is_calibrated: from_stars.zero_point_mag.is_some(),
                sigma_mag: from_stars.zero_point_mag.map(|zero_point| zero_point.sigma),
                is_clipped,
            };
            if let Some(shape) = from_stars.shape.filter(|_| !options.is_seeing_known) {
                (optics.seeing_arcsec, optics.form) = (shape.seeing_arcsec, shape.form);
                measure.fit_width = options.measure.fit_width;
                measure.is_seeing_known = true;
                measure.is_form_known |= shape.is_form_measured;
            }
            done.star_zero_points.push((chip.hdu, from_stars));
        }
        let measured = of_chip.par_iter().map(|(number, prediction)| -> Result<Option<(usize, MeasuredPass)>, _> {
            watch.check()?;
            let measure = MeasureOptions { neighbour_pix: prediction.neighbour_pix, ..measure };
            let (optics, measure) = width_of(prediction, optics, measure, options.measure.fit_width);
            let Some(measured) = measure_streak(&image, &prediction.streak, &optics, &measure)? else {
                return Ok(None);
            };
            let cut = options.cuts.then(|| -> Result<StreakCut, Error> {
                // The seeing by which the streak was drawn.
                let fitted = measured.seeing_arcsec.filter(|_| measure.fit_width);
                let drawn = Optics { seeing_arcsec: fitted.unwrap_or(optics.seeing_arcsec), ..optics };
                Ok(streak_cut(&image, &measured, &profile_of(&image, &prediction.streak, &drawn)?))
            });
            let cut = cut.transpose()?;
            Ok(on_sky(frame, prediction, measured, &scale).map(|pass| (*number, MeasuredPass { cut, ..pass })))
        });
        passes.extend(measured.collect::<Result<Vec<_>, Error>>()?.into_iter().flatten());
    }
    Ok((passes, done))
}

/// Returns the optics and the options of a streak. A given width of its image replaces seeing and defocus, and is
/// fitted only if this is requested by `fit_given`. Without a width and a distance, the width is fitted, and the seeing
/// is its first estimate.
fn width_of(
    prediction: &Prediction,
    optics: Optics,
    measure: MeasureOptions,
    fit_given: bool,
) -> (Optics, MeasureOptions) {
    match (prediction.image_fwhm_arcsec, prediction.satellite.range_km) {
        (Some(seeing_arcsec), _) => (
            Optics { seeing_arcsec, outer_radius_m: 0.0, inner_radius_m: 0.0, ..optics },
            MeasureOptions { fit_width: fit_given, is_seeing_known: true, ..measure },
        ),
        (None, Some(_)) => (optics, measure),
        (None, None) => (optics, MeasureOptions { fit_width: true, ..measure }),
    }
}

fn on_sky(
    frame: &TargetFrame,
    prediction: &Prediction,
    mut measured: StreakMeasurement,
    of_chip: &ChipScale,
) -> Option<MeasuredPass> {
    if !prediction.is_position_known {
        measured.flags.push(Flag::Position);
    }
    let ChipScale { scale, is_calibrated, sigma_mag, is_clipped } = *of_chip;
    if is_clipped {
        measured.flags.push(Flag::Clipped);
        measured.flags.sort_unstable();
    }
    let without = [Flag::Position, Flag::Clipped, Flag::Masked, Flag::Dark];
    let has_limit = measured.flags.iter().all(|flag| !without.contains(flag));
    let chip = &frame.chips[prediction.chip].chip;
    let [from_s, to_s] = measured.inside_s;
    let middle_s = 0.5 * (from_s + to_s);
    let at =
        if measured.is_detected { measured.path.point_at(middle_s) } else { prediction.streak.path.point_at(middle_s) };
    let magnitude = measured.is_detected.then_some(()).and_then(|()| {
        let value = scale.magnitude(measured.rate.value)?;
        // σ_m² = (2.5 / ln 10 σ_F / F)² + σ_ZP²
        let sigma = 2.5 / std::f64::consts::LN_10 * measured.rate.sigma / measured.rate.value;
        Some(Estimate { value, sigma: sigma.hypot(sigma_mag.unwrap_or(0.0)) })
    });
    Some(MeasuredPass {
        image: frame.file.path().display().to_string(),
        hdu: chip.hdu,
        epoch: seconds_after(frame.opened, middle_s),
        duration_s: to_s - from_s,
        exposure_s: frame.exposure_s,
        direction: chip.wcs.to_sky(at)?,
        ends: measured.ends_in_frame().map(|end| chip.wcs.to_sky(end)),
        pixel_scale_arcsec: chip.pixel_scale_arcsec(),
        speed_pix_s: if to_s > from_s { measured.length_pix / (to_s - from_s) } else { f64::NAN },
        magnitude,
        limit_mag: scale.magnitude(measured.rate_limit).filter(|_| has_limit),
        faintest_mag: scale.magnitude(measured.threshold * measured.noise_sigma()).filter(|_| !is_clipped),
        is_calibrated,
        zero_point_mag: scale.zero_point_mag(),
        zero_point_sigma_mag: sigma_mag,
        filter: frame.filter.clone(),
        prediction: prediction.clone(),
        measured,
        of_pass: None,
        cut: None,
    })
}
