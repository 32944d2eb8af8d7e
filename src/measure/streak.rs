//! Measurement of one streak in one image.

use super::band::Band;
use super::corridor::Corridor;
use super::fit::{Amplitude, AssumedForm, BlockFit, Blocks, combined, fit_blocks};
use super::hidden_light::{edge_and_hidden_shares, least_usable_beside};
use super::measurement::{Estimate, Flag, MeasureOptions, PredictedStreak, StreakImage, StreakMeasurement};
use super::noise::{
    CONTROLS_A_SIDE, LEAST_CONTROLS, REFINED_FROM, background_sigma, controls, offset_sigma, without_fit_bias,
};
use super::search::{Extent, Found, PredictionErrors, Search, least_usable_share, search};
use super::stars::{mask_stars, without_streak};
use crate::error::Error;
use crate::images::PixelPosition;
use crate::math::quantile::median;
use crate::streaks::{Optics, PathNode, RadialProfile, StreakPath, draw};

/// Half width of the fit across the streak in FWHM, and its smallest value in pixels.
const FIT_WIDTHS: f64 = 6.0;
const LEAST_FIT_PIX: f64 = 10.0;
/// Its smallest value beside another streak, FWHM.
const LEAST_FIT_WIDTHS: f64 = 1.5;
/// Length of a block along the track in FWHM, and its smallest value in pixels.
const BLOCK_WIDTHS: f64 = 8.0;
const LEAST_BLOCK_PIX: f64 = 32.0;
/// Distance of the first control fits from the streak, and distance between neighbouring control fits, FWHM.
const FIRST_CONTROL_WIDTHS: f64 = 4.0;
const CONTROL_STEP_WIDTHS: f64 = 0.75;
/// Distance from another streak of a table, FWHM, from which it has no light in a control fit.
const NEIGHBOUR_WIDTHS: f64 = 2.0;
/// Distance within which a bright streak makes the sky beside it look dark in the search, FWHM.
const CONTRAST_WIDTHS: f64 = 12.0;
/// Number of iterations of mask, offset and angle.
const ITERATIONS: usize = 6;
/// Smallest signal to noise at which the width is measured.
const WIDTH_FROM: f64 = 10.0;
/// Smallest signal to noise at which given ends are fitted along the streak.
const ENDS_FROM: f64 = 10.0;
/// Smallest number of pixels along the track.
pub(super) const LEAST_LENGTH_PIX: usize = 12;
/// The same for a streak whose ends are given, and which has this length in any direction.
const LEAST_GIVEN_PIX: usize = 8;
/// Share of a streak's length with saturated pixels from which the flux is a lower limit.
const SATURATED_SHARE: f64 = 0.05;
/// Share of the length that may be near the edge of the frame, or masked, without a flag.
const EDGE_SHARE: f64 = 0.1;
const MASKED_SHARE: f64 = 0.5;
/// Light within this distance (FWHM) of a position at which less than this share of a streak's light would be on usable
/// pixels may be the wings of a hidden streak.
const WINGS_WIDTHS: f64 = 3.0;
const SEEN_SHARE: f64 = 0.1;
/// Share of a streak's light that must be usable where a part of it is: from the wings alone its light is unknown.
const CORE_SHARE: f64 = 0.5;
/// Relative difference of measured and assumed width above which the width is flagged.
const WIDTH_TOLERANCE: f64 = 0.2;
/// Number of sigmas by which another width must fit better than the assumed one to be flagged.
const SHAPE_SIGMAS: f64 = 3.0;
/// Accuracy of the fitted light of a bright, narrow streak, relative: those that are drawn with exactly the assumed
/// point spread function are off by up to this.
const FIT_ACCURACY: f64 = 0.002;
/// Half of the blocks of a streak must have light: the median of all blocks must exceed this fraction of the threshold
/// of detection.
const MEDIAN_SHARE: f64 = 0.4;
/// Smallest number of blocks of which the median is tested.
const LEAST_BLOCKS: usize = 4;

/// Parameters of a streak relative to its prediction.
#[derive(Copy, Clone, Debug, Default)]
pub(super) struct Shift {
    pub offset_pix: f64,
    pub tilt_rad: f64,
    pub late_s: f64,
    /// Changes of the times at the ends of a streak whose ends are given, seconds.
    pub ends_s: [f64; 2],
}

/// Measures the streak of one satellite in one image; `None` if fewer than 12 pixels of its track are in the image.
///
/// # Errors
/// The image of a star is too narrow or too wide to be drawn.
pub fn measure_streak(
    image: &StreakImage<'_>,
    predicted: &PredictedStreak,
    optics: &Optics,
    options: &MeasureOptions,
) -> Result<Option<StreakMeasurement>, Error> {
    let (rows, columns) = (image.plane.rows(), image.plane.columns());
    // A given streak of this length has at least 1 / √2 as many pixels along the nearer axis.
    let least = if predicted.ends_s.is_some() { LEAST_GIVEN_PIX } else { LEAST_LENGTH_PIX };
    let Some(corridor) = Corridor::new(&predicted.path, rows, columns, least) else { return Ok(None) };
    let mut measuring =
        Measuring { image, predicted, corridor, optics: *optics, profile: profile_of(image, predicted, optics)? };
    let extent = measuring.extent(options);
    let Some(found) = search(image, &measuring.corridor, &measuring.profile, &extent, options.false_alarm) else {
        return Ok(None);
    };
    measuring.measure(&found, &extent, options)
}

/// Returns the image of the satellite, with which the streak is drawn.
pub(super) fn profile_of(
    image: &StreakImage<'_>,
    predicted: &PredictedStreak,
    optics: &Optics,
) -> Result<RadialProfile, Error> {
    let PredictedStreak { range_km, radius_m, .. } = *predicted;
    optics.profile(range_km, radius_m, image.pixel_scale_arcsec, image.pixel_aspect)
}

/// State of the measurement of one streak.
pub(super) struct Measuring<'a> {
    pub image: &'a StreakImage<'a>,
    pub predicted: &'a PredictedStreak,
    pub corridor: Corridor,
    pub optics: Optics,
    pub profile: RadialProfile,
}

/// Drawn streak in the pixels of a band.
pub(super) struct Drawn {
    pub path: StreakPath,
    pub template: Vec<f32>,
}

impl Measuring<'_> {
    /// Returns true for a streak whose ends are given.
    pub(super) fn is_given(&self) -> bool {
        self.predicted.ends_s.is_some()
    }

    /// Returns the corridor that contains the errors of the prediction.
    fn extent(&self, options: &MeasureOptions) -> Extent {
        let [nx, ny] = self.corridor.normal();
        let [dx, dy] = self.predicted.drift_pix_s;
        let late_s = (options.corridor_sigmas * self.predicted.lateness_sigma_s).min(self.predicted.largest_delay_s);
        // During the delay the observer moves across the track.
        let across_pix = (options.corridor_sigmas * self.predicted.cross_sigma_pix).hypot(late_s * (dx * nx + dy * ny));
        let drift_rad_s = (dx.hypot(dy) * self.image.pixel_scale_arcsec / 3600.0).to_radians();
        /// Error of the angle of a track and of the world coordinates, radians.
        const ANGLE_ERROR_RAD: f64 = 1e-3;
        /// Largest difference in angle that is searched, for a predicted track and for a streak whose ends are given.
        const LARGEST_TILT_RAD: [f64; 2] = [0.05, 0.2];
        let cross_sigma_pix = self.predicted.cross_sigma_pix;
        let (tilt_rad, errors) = if self.is_given() {
            // The middle and the angle of two ends with independent errors.
            let sigma_rad = 2f64.sqrt() * cross_sigma_pix / (self.corridor.len() as f64);
            let tilt_rad = (ANGLE_ERROR_RAD + options.corridor_sigmas * sigma_rad).min(LARGEST_TILT_RAD[1]);
            let (across_pix, sigma_rad) = (cross_sigma_pix / 2f64.sqrt(), sigma_rad.hypot(ANGLE_ERROR_RAD));
            (tilt_rad, PredictionErrors { across_pix, drift_pix_s: 0.0, tilt_rad: sigma_rad, late_s: 0.0 })
        } else {
            let tilt_rad = (ANGLE_ERROR_RAD + late_s * drift_rad_s).min(LARGEST_TILT_RAD[0]);
            let errors = PredictionErrors {
                across_pix: cross_sigma_pix,
                drift_pix_s: dx * nx + dy * ny,
                tilt_rad: f64::INFINITY,
                late_s: self.predicted.lateness_sigma_s.min(self.predicted.largest_delay_s),
            };
            (tilt_rad, errors)
        };
        let fwhm_pix = self.profile.fwhm_pix();
        // Two streaks nearer than their width are not resolved.
        let to_neighbour_pix =
            options.neighbour_pix.filter(|pix| *pix >= fwhm_pix).map_or(f64::INFINITY, |pix| 0.5 * pix);
        let across_pix = (across_pix + fwhm_pix).min(options.most_corridor_pix).min(to_neighbour_pix);
        Extent { across_pix, tilt_rad, late_s, to_neighbour_pix, errors }
    }

    /// Returns the path of a shifted streak while the shutter is open; `None` if it is too short.
    ///
    /// p(t) = P(t - δ) + n (v + τ u) + e (e · d) δ with the predicted path P, delay δ, offset v, tilt τ, distance u
    /// along the track from the middle, drift d, and unit vectors n across and e along the track.
    pub(super) fn path(&self, shift: &Shift) -> Result<Option<StreakPath>, Error> {
        let Corridor { motion: [ex, ey], middle, .. } = self.corridor;
        let [nx, ny] = self.corridor.normal();
        let [dx, dy] = self.predicted.drift_pix_s;
        let along = (dx * ex + dy * ey) * shift.late_s;
        let predicted = &self.predicted.path;
        let exposure_s = self.image.exposure_s;
        let node = |time_s: f64, rate: f64| {
            let at = predicted.point_at(time_s - shift.late_s);
            let across = shift.offset_pix + shift.tilt_rad * ((at.x - middle.x) * ex + (at.y - middle.y) * ey);
            let at = PixelPosition { x: at.x + nx * across + ex * along, y: at.y + ny * across + ey * along };
            PathNode::new(time_s, at, rate)
        };
        let nodes = predicted.nodes();
        let [first_s, last_s] = [nodes[0].time_s, nodes[nodes.len() - 1].time_s].map(|time_s| time_s + shift.late_s);
        let [from_s, to_s] = match self.predicted.ends_s {
            Some([from_s, to_s]) => [(from_s + shift.ends_s[0]).max(first_s), (to_s + shift.ends_s[1]).min(last_s)],
            None => [first_s.max(0.0), last_s.min(exposure_s)],
        };
        /// Smallest time between two nodes, seconds.
        const LEAST_STEP_S: f64 = 1e-7;
        if to_s - from_s < 2.0 * LEAST_STEP_S {
            return Ok(None);
        }
        let mut path = vec![node(from_s, predicted.rate_at(from_s - shift.late_s))];
        for inner in nodes {
            let time_s = inner.time_s + shift.late_s;
            if time_s > from_s + LEAST_STEP_S && time_s < to_s - LEAST_STEP_S {
                path.push(node(time_s, inner.rate));
            }
        }
        path.push(node(to_s, predicted.rate_at(to_s - shift.late_s)));
        Ok(Some(StreakPath::new(path)?))
    }

    /// Draws the shifted streak in the pixels of a band; `None` if its path is too short.
    pub fn drawn(&self, band: &Band, shift: &Shift) -> Result<Option<Drawn>, Error> {
        self.drawn_with(&self.profile, band, shift)
    }

    /// Same as `drawn` with another image of the satellite.
    pub(super) fn drawn_with(
        &self,
        profile: &RadialProfile,
        band: &Band,
        shift: &Shift,
    ) -> Result<Option<Drawn>, Error> {
        let Some(path) = self.path(shift)? else { return Ok(None) };
        let patch = draw(&path, profile, self.image.plane.rows(), self.image.plane.columns());
        let template = band.template(&patch);
        Ok(Some(Drawn { path, template }))
    }

    /// Returns the shift of a position of the search, and the number of ends in the image.
    fn shift(&self, found: &Found) -> Result<(Shift, usize), Error> {
        let corridor = &self.corridor;
        let cos = corridor.cos();
        let [ex, ey] = corridor.motion;
        let sense = if corridor.is_along_rows { ex.signum() } else { ey.signum() };
        let mut shift = Shift {
            offset_pix: found.minor_pix * cos,
            tilt_rad: found.slope * cos * cos * sense,
            late_s: corridor.delay_s(found.late_s, found.minor_pix),
            ends_s: [0.0; 2],
        };
        // Without an end in the image the delay is not measurable, and the predicted time is used.
        let ends = self.ends(&shift)?;
        if ends == 0 || self.is_given() {
            shift.late_s = 0.0;
        }
        Ok((shift, ends))
    }

    /// Returns the half width of the fit across the track and the length of a block along it, pixels of the two axes.
    fn block_size(&self, extent: &Extent) -> [usize; 2] {
        let (fwhm, cos) = (self.profile.fwhm_pix().max(1.0), self.corridor.cos());
        // The fit ends between the streak and its neighbour.
        let to_neighbour_pix = extent.to_neighbour_pix.max(LEAST_FIT_WIDTHS * fwhm);
        let half_width = (FIT_WIDTHS * fwhm).max(LEAST_FIT_PIX).min(to_neighbour_pix) / cos;
        [half_width.ceil() as usize, ((BLOCK_WIDTHS * fwhm).max(LEAST_BLOCK_PIX) * cos) as usize]
    }

    /// Returns the number of control fits on each side of the streak, of the given first distance, steps and half width
    /// of a fit, pixels of the minor axis. They do not reach the nearest other streak of a table, unless too few remain.
    fn controls_a_side(&self, first: isize, step: isize, half_width: usize, options: &MeasureOptions) -> usize {
        let Some(neighbour_pix) = options.neighbour_pix else { return CONTROLS_A_SIDE };
        let free_pix = neighbour_pix - NEIGHBOUR_WIDTHS * self.profile.fwhm_pix();
        let last = (free_pix / self.corridor.cos()) as isize - half_width as isize;
        let free = ((last - first).max(0) / step) as usize;
        if 2 * (free + 1) >= LEAST_CONTROLS { free.min(CONTROLS_A_SIDE) } else { CONTROLS_A_SIDE }
    }

    /// Returns true if a dark streak is significant, and the median of its blocks is larger than that of the brightest
    /// one, which is then only the contrast beside the dark streak. Beside another streak of a table this is unknown,
    /// because a bright one makes the sky beside it look dark.
    fn is_dark(&self, search: &Search, extent: &Extent, options: &MeasureOptions) -> Result<bool, Error> {
        let Search { best, darkest } = search;
        let contrast_pix = CONTRAST_WIDTHS * self.profile.fwhm_pix();
        let is_contrast = options.neighbour_pix.is_some_and(|pix| pix < contrast_pix);
        if darkest.significance >= -darkest.threshold || is_contrast {
            return Ok(false);
        }
        let [half_width, block] = self.block_size(extent);
        // Median light of the blocks, and signal to noise of all.
        let light = |found: &Found| -> Result<Option<(f64, f64)>, Error> {
            let line = [found.minor_pix, found.slope];
            let band = Band::read(self.image.plane, self.image.light_area, &self.corridor, line, half_width);
            let Some(drawn) = self.drawn(&band, &self.shift(found)?.0)? else { return Ok(None) };
            let blocks = Blocks::new(band.len(), block, half_width);
            let fits = fit_blocks(&band, &band.values, &vec![false; band.values.len()], &drawn.template, 0, &blocks);
            let amplitudes: Vec<f64> = fits.iter().filter_map(BlockFit::amplitude).collect();
            let Some(all) = combined(&fits) else { return Ok(None) };
            let sigma = (all.squares / all.freedom / all.weight).sqrt();
            Ok((!amplitudes.is_empty()).then(|| (median(amplitudes), all.value / sigma)))
        };
        Ok(match (light(best)?, light(darkest)?) {
            (Some((bright, _)), Some((dark, signal))) => -dark > bright && signal < -darkest.threshold,
            _ => false,
        })
    }

    fn measure(
        &mut self,
        search: &Search,
        extent: &Extent,
        options: &MeasureOptions,
    ) -> Result<Option<StreakMeasurement>, Error> {
        let found = &self.aligned(&search.best, extent);
        let (mut shift, ends) = self.shift(found)?;
        if options.fit_width {
            self.start_width(found, shift.late_s);
        }
        let is_dark = self.is_dark(&Search { best: *found, ..*search }, extent, options)?;
        let corridor = &self.corridor;
        let cos = corridor.cos();
        let fwhm = self.profile.fwhm_pix().max(1.0);
        let [half_width, block] = self.block_size(extent);
        let step = (CONTROL_STEP_WIDTHS * fwhm / cos).ceil().max(1.0) as isize;
        let first = (FIRST_CONTROL_WIDTHS * fwhm / cos).ceil() as isize;
        let last = first + step * self.controls_a_side(first, step, half_width, options) as isize;
        let half = half_width + last as usize;
        let band = Band::read(self.image.plane, self.image.light_area, corridor, [found.minor_pix, found.slope], half);
        let mut blocks = Blocks::new(band.len(), block, half_width);

        shift = self.best_if_narrow(&band, &blocks, extent, &shift)?;
        let Some(mut drawn) = self.drawn(&band, &shift)? else { return Ok(None) };
        let mut stars = mask_stars(&band, &drawn.template, &blocks, fwhm, true);
        blocks.weigh(&band, &stars.mask, &drawn.template);
        let is_saturated = self.is_saturated(&band, &drawn.template);
        let mut seeing_arcsec = None;
        let mut fitted_ends = Vec::new();
        for iteration in 0..ITERATIONS {
            let fits = fit_blocks(&band, &band.values, &stars.mask, &drawn.template, 0, &blocks);
            let Some(amplitude) = combined(&fits) else { return Ok(None) };
            let sigma = (amplitude.squares / amplitude.freedom / amplitude.weight).sqrt();
            if amplitude.value < REFINED_FROM * sigma {
                stars = mask_stars(&band, &drawn.template, &blocks, fwhm, false);
                blocks.weigh(&band, &stars.mask, &drawn.template);
                break;
            }
            let before = shift;
            let moved = self.refined(&band, &stars.mask, &drawn.template, &blocks, &fits, &mut shift);
            // A step out of the corridor, towards the light of a neighbour or a star, is not made.
            if shift.offset_pix.abs() > extent.across_pix {
                shift = before;
            }
            if matches!(iteration, 1 | 3) && ends > 0 && !self.is_given() {
                self.fit_lateness(&band, &stars.mask, &blocks, extent, iteration == 3, &mut shift)?;
            }
            if matches!(iteration, 1 | 3) && amplitude.value > ENDS_FROM * sigma {
                fitted_ends = self.ends_inside();
                let variance = amplitude.squares / amplitude.freedom;
                for end in &fitted_ends {
                    self.fit_end(&band, &stars.mask, &blocks, variance, *end, &mut shift)?;
                }
            }
            if iteration == 2 && options.fit_width && amplitude.value > WIDTH_FROM * sigma {
                seeing_arcsec = Some(self.fit_width(&band, &stars.mask, &blocks, &shift)?.0);
            }
            let Some(next) = self.drawn(&band, &shift)? else { return Ok(None) };
            drawn = next;
            // Stars are masked again after the first steps, which align the template with the streak.
            if iteration == 1 || iteration == 3 {
                stars = mask_stars(&band, &drawn.template, &blocks, fwhm, false);
                blocks.weigh(&band, &stars.mask, &drawn.template);
            }
            if iteration > 2 && moved < 0.02 {
                break;
            }
        }

        let fits = fit_blocks(&band, &band.values, &stars.mask, &drawn.template, 0, &blocks);
        let Some(amplitude) = combined(&fits) else { return Ok(None) };
        let rest = without_streak(&band, &stars.mask, &drawn.template, &blocks);
        let pixel_sigma = (amplitude.squares / amplitude.freedom / amplitude.weight).sqrt();
        // The values of a constant frame differ only by rounding: its noise is unknown.
        let finite = band.values.iter().filter(|value| value.is_finite());
        let rounding = f64::from(f32::EPSILON) * median(finite.map(|value| f64::from(value.abs())).collect());
        let pixel_sigma =
            if (amplitude.squares / amplitude.freedom).sqrt() > rounding { pixel_sigma } else { f64::NAN };
        let controls = controls(
            &band,
            &rest,
            &stars,
            &drawn.template,
            &blocks,
            amplitude.weight,
            (first..=last).step_by(step as usize),
        );
        let controls = controls.filter(|_| pixel_sigma.is_finite());
        let mut flags = Vec::new();
        if controls.is_none() {
            flags.push(Flag::PixelNoise);
        }
        let background_sigma = background_sigma(controls, pixel_sigma, self.stated_noise(), (&fits, &blocks));
        let photon = self.photon_variance(&band, &stars.mask, &drawn.template, &blocks, amplitude.value);
        if photon.is_none() {
            flags.push(Flag::NoGain);
        }
        let inflation =
            if seeing_arcsec.is_some() { self.width_inflation(&band, &stars.mask, &blocks, &shift)? } else { 1.0 };
        let inflation = inflation * self.ends_inflation(&band, &stars.mask, &blocks, &shift, &fitted_ends)?;
        let sigma = (background_sigma * background_sigma * inflation + photon.unwrap_or(0.0) * inflation).sqrt();
        let noise_ratio = background_sigma / pixel_sigma.max(1e-300);

        let is_spread = is_spread(&fits, &amplitude, sigma, found.threshold);
        let signal_to_noise = amplitude.value / sigma;
        let wings = (WINGS_WIDTHS * fwhm / cos).ceil() as isize;
        let seen = |reach, in_lit_columns| {
            least_usable_beside(&band, &drawn.template, self.image.light_area, reach, in_lit_columns)
        };
        let is_detected = found.significance >= found.threshold
            && signal_to_noise >= found.threshold
            && is_spread
            && !is_dark
            && seen(wings, false) >= SEEN_SHARE
            && seen(0, true) >= CORE_SHARE;

        let margin = (fwhm / cos).ceil() as usize;
        let (edge, masked) = edge_and_hidden_shares(&band, &stars.mask, &drawn.template, self.image.light_area, margin);
        let given_width = seeing_arcsec.is_none();
        // Increase of the sum of the squared residuals at one sigma from the best fit.
        let squares_of_sigma = noise_ratio * noise_ratio * amplitude.squares / amplitude.freedom;
        let (mut value, mut form_sigma, mut brighter) = (amplitude.value, 0.0, 1.0);
        if is_detected && signal_to_noise > WIDTH_FROM {
            let optics = self.optics;
            let (measured_arcsec, decrease) = match seeing_arcsec {
                Some(fitted) => (fitted, 0.0),
                None => self.fit_width(&band, &stars.mask, &blocks, &shift)?,
            };
            (self.optics, self.profile) = (optics, profile_of(self.image, self.predicted, &optics)?);
            let is_other = (measured_arcsec / optics.seeing_arcsec).ln().abs() > (1.0 + WIDTH_TOLERANCE).ln();
            if given_width && is_other && decrease > SHAPE_SIGMAS * SHAPE_SIGMAS * squares_of_sigma {
                flags.push(Flag::Width);
            }
            seeing_arcsec = Some(measured_arcsec);
            let assumed = AssumedForm { amplitude: &amplitude, seeing_arcsec: measured_arcsec, squares_of_sigma };
            let forms = self.amplitude_of_forms(&band, &stars.mask, &blocks, &shift, &assumed, options.is_form_known);
            value = forms.value;
            let accuracy = if self.is_narrow() { FIT_ACCURACY } else { 0.0 };
            form_sigma = forms.sigma.hypot(accuracy * value);
        } else if !options.is_form_known {
            let (share, factor) = self.unknown_form_share(&band, &stars.mask, &blocks, &shift)?;
            (form_sigma, brighter) = (share * value.abs(), factor);
        }
        if is_saturated {
            flags.push(Flag::Saturated);
        }
        if options.neighbour_pix.is_some_and(|pix| pix < FIT_WIDTHS * self.profile.fwhm_pix()) {
            flags.push(Flag::Blended);
        }
        if edge > EDGE_SHARE {
            flags.push(Flag::Edge);
        }
        let is_hidden = || least_usable_share(self.image, &self.corridor, &self.profile, extent) < 1.0 - MASKED_SHARE;
        if masked > MASKED_SHARE || !is_detected && is_hidden() {
            flags.push(Flag::Masked);
        }
        if is_dark {
            flags.push(Flag::Dark);
        }
        flags.sort_unstable();

        let inside = self.inside(&drawn.path);
        let ends = self.ends(&shift)?;
        let late_s = if is_detected && ends > 0 && !self.is_given() {
            let sigma_s = self.lateness_sigma(&band, &stars.mask, &blocks, &shift, &amplitude, noise_ratio)?;
            sigma_s.map(|sigma| Estimate { value: shift.late_s, sigma })
        } else {
            None
        };
        let offset_sigma = offset_sigma(&band, &stars.mask, &drawn.template, &blocks, &amplitude) * noise_ratio;
        // The track of a streak that is not found is the predicted one.
        let predicted = if is_detected { None } else { self.path(&Shift::default())? };
        let missed = predicted.as_ref().and_then(|path| Some((path, self.times_inside(path)?)));
        let (of_length, inside) = missed.unwrap_or((&drawn.path, inside));
        let length_pix = of_length.point_at(inside[0]).distance(of_length.point_at(inside[1]));
        let size_share = if is_detected { self.size_share(&band, &stars.mask, &blocks, &shift, options)? } else { 0.0 };
        let mut width_share = 0.0;
        if options.fit_width && given_width {
            let (share, factor) = self.unknown_width_share(&band, &stars.mask, &blocks, &shift, options)?;
            (width_share, brighter) = (share, brighter * factor);
        }
        let along = if self.is_given() { fitted_ends.len() } else { ends.min(1) };
        let rate = value * without_fit_bias(signal_to_noise, along);
        let [size_sigma, width_sigma] = [size_share, width_share].map(|share| share * value.abs());
        let sigma = sigma.hypot(size_sigma).hypot(form_sigma).hypot(width_sigma);
        // The light of fitted ends is that of the time between the given ends.
        let (path, longer) = self.within_given_times(&drawn.path)?;
        let inside = missed.map_or_else(|| self.inside(&path), |(_, inside)| inside);
        let [rate, sigma, size_sigma, form_sigma, width_sigma] =
            [rate, sigma, size_sigma, form_sigma, width_sigma].map(|light| light * longer);
        Ok(Some(StreakMeasurement {
            is_detected,
            rate: Estimate { value: rate, sigma },
            size_sigma,
            form_sigma,
            width_sigma,
            rate_limit: brighter * (rate.max(0.0) + options.limit_sigmas * sigma),
            signal_to_noise,
            significance: found.significance,
            threshold: found.threshold,
            offset_pix: Estimate { value: shift.offset_pix, sigma: offset_sigma },
            tilt_rad: shift.tilt_rad,
            late_s,
            ends,
            seeing_arcsec,
            width_pix: self.profile.fwhm_pix(),
            length_pix,
            inside_s: inside,
            path,
            flags,
            corridor_pix: extent.across_pix,
        }))
    }

    /// Improves offset and tilt by one Gauss-Newton step. Returns the change of the offset or the shift of the ends by
    /// the change of the tilt, whichever is larger, pixels.
    fn refined(
        &self,
        band: &Band,
        mask: &[bool],
        template: &[f32],
        blocks: &Blocks,
        fits: &[BlockFit],
        shift: &mut Shift,
    ) -> f64 {
        let (height, half) = (band.height, band.half());
        let width = blocks.half_width;
        let middle = 0.5 * band.len() as f64;
        let sense = if self.corridor.is_along_rows {
            self.corridor.motion[0].signum()
        } else {
            self.corridor.motion[1].signum()
        };
        // Weighted sums of J², J² u, J² u², J r, J r u, with J = ∂m/∂v.
        let mut sums = [0.0f64; 5];
        for ((columns, weight), fit) in blocks.weighted().zip(fits) {
            let Some(amplitude) = fit.amplitude() else { continue };
            let amplitude = amplitude.max(0.0);
            let background = [0, 1].map(|term| fit.background[term] - amplitude * fit.response[term]);
            for column in columns {
                let u = (column as f64 - middle) / band.cos * sense;
                for offset in half - width..=half + width {
                    let at = column * height + offset;
                    if mask[at] || band.values[at].is_nan() {
                        continue;
                    }
                    let x = offset as f64 - half as f64;
                    let rest = f64::from(band.values[at])
                        - background[0]
                        - background[1] * x
                        - amplitude * f64::from(template[at]);
                    let slope = amplitude * f64::from(template[at - 1] - template[at + 1]) / (2.0 * band.cos);
                    let terms = [slope, slope * u, slope * u * u, rest, rest * u];
                    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * slope * term);
                }
            }
        }
        let [jj, ju, juu, jr, jru] = sums;
        let determinant = jj * juu - ju * ju;
        if !(jj > 0.0 && determinant > 1e-9 * jj * juu) {
            return 0.0;
        }
        let fwhm = self.profile.fwhm_pix().max(1.0);
        let reach = 0.5 * band.len() as f64 / band.cos;
        let offset = ((juu * jr - ju * jru) / determinant).clamp(-fwhm, fwhm);
        let tilt = ((jj * jru - ju * jr) / determinant).clamp(-fwhm / reach, fwhm / reach);
        shift.offset_pix += offset;
        shift.tilt_rad += tilt;
        offset.abs().max(tilt.abs() * reach)
    }

    /// Returns the sum of the squared residuals for a shift, with one amplitude for all blocks.
    pub(super) fn squares(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
    ) -> Result<Option<f64>, Error> {
        let Some(drawn) = self.drawn(band, shift)? else { return Ok(None) };
        let fits = fit_blocks(band, &band.values, mask, &drawn.template, 0, blocks);
        Ok(combined(&fits).map(|amplitude| amplitude.squares))
    }

    /// Returns the noise of a pixel of the sky along the track that a companion plane states, and its ratio to the
    /// scatter of the sky.
    fn stated_noise(&self) -> Option<(f64, f64)> {
        let ratio = self.image.background.stated_ratio?;
        Some((ratio * self.sky_noise()?, ratio))
    }

    /// Returns the scatter of a pixel of the sky along the track.
    fn sky_noise(&self) -> Option<f64> {
        let along = self.corridor.pixels().filter_map(|[row, column]| self.image.background.noise(row, column));
        let scatter: Vec<f64> = along.collect();
        (!scatter.is_empty()).then(|| median(scatter))
    }

    /// Returns the noise of the median of a number of pixels of the sky: σ √(π / 2n). The scatter of medians is no
    /// measure of it in frames with whole numbers, where most medians may be equal.
    pub(super) fn median_noise(&self, pixels: usize) -> f64 {
        self.sky_noise().map_or(0.0, |sigma| sigma * (std::f64::consts::FRAC_PI_2 / pixels as f64).sqrt())
    }

    /// Returns true if more than the fraction `SATURATED_SHARE` of the streak's length has saturated pixels.
    fn is_saturated(&self, band: &Band, template: &[f32]) -> bool {
        let Some(level) = self.image.saturation else { return false };
        let (mut lit, mut saturated) = (0, 0);
        for (light, values) in template.chunks_exact(band.height).zip(band.values.chunks_exact(band.height)) {
            let peak = light.iter().copied().fold(0.0, f32::max);
            if peak <= 0.0 {
                continue;
            }
            lit += 1;
            let is_full = |(light, value): (&f32, &f32)| *light > 0.5 * peak && f64::from(*value) >= level;
            saturated += usize::from(light.iter().zip(values).any(is_full));
        }
        saturated as f64 > SATURATED_SHARE * f64::from(lit)
    }
}

/// Returns true if the light is spread along the track: the median of the blocks is significant, too. A star lights
/// only one or two blocks. Streaks of few blocks are not tested.
fn is_spread(fits: &[BlockFit], amplitude: &Amplitude, sigma: f64, threshold: f64) -> bool {
    let mean_weight = amplitude.weight / fits.len() as f64;
    let blocks: Vec<f64> =
        fits.iter().filter(|fit| fit.weight > 0.3 * mean_weight).filter_map(BlockFit::amplitude).collect();
    blocks.len() < LEAST_BLOCKS || median(blocks) > MEDIAN_SHARE * threshold * sigma
}
