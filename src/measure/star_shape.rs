//! Width and form of the stars of an image.

use super::measurement::StreakImage;
use super::stamp::Stamp;
use crate::error::Error;
use crate::math::minimum::minimum;
use crate::math::quantile::median;
use crate::streaks::{Optics, RadialProfile, SeeingForm};

/// Smallest number of stars.
pub const LEAST_STARS: usize = 3;
/// Range (relative to the assumed width) and number of the widths for which stars are drawn and compared with their
/// images, and largest number of compared stars.
const WIDTH_RANGE: [f64; 2] = [0.4, 2.5];
const WIDTHS: usize = 25;
/// Largest number of ranges of widths: if the stars are at the end of a range, the next one begins there.
const MOST_WIDTH_RANGES: usize = 5;
const MOST_WIDTH_STARS: usize = 50;
/// Smallest signal to noise of these stars.
const WIDTH_SIGNAL_TO_NOISE: f64 = 50.0;

/// Largest 1/β of the Moffat profiles that stars may have (a Gaussian has 0), and accuracy of a fitted 1/β.
const LARGEST_INVERSE_BETA: f64 = 0.5;
const INVERSE_BETA_TOLERANCE: f64 = 0.005;
/// The form is measured if the Gaussian or the profile with the largest 1/β is excluded by this number of sigmas.
const FORM_SIGMAS: f64 = 10.0;
/// A profile with a smaller 1/β is drawn as a Gaussian.
const LEAST_INVERSE_BETA: f64 = 0.01;

/// Width and form of the stars.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StarShape {
    /// FWHM, arcsec.
    pub seeing_arcsec: f64,
    /// Form of the point spread function.
    pub form: SeeingForm,
    /// False if the form is the assumed one.
    pub is_form_measured: bool,
}

impl StarShape {
    /// Returns the image of a star of this shape in focus.
    pub fn profile(&self, image: &StreakImage<'_>) -> Result<RadialProfile, Error> {
        let Self { seeing_arcsec, form, .. } = *self;
        let stars = Optics { seeing_arcsec, outer_radius_m: 0.0, inner_radius_m: 0.0, form };
        stars.profile(1.0, 0.0, image.pixel_scale_arcsec, image.pixel_aspect)
    }
}

/// Returns the measured shape of the stars: the width with the assumed form, or unless `is_form_assumed` width and form,
/// of the Gaussian and all Moffat profiles, that fit best, if the stars show their form. `None` with fewer than three
/// bright stars.
///
/// `stamps` returns the pixels of the stars for an assumed profile.
pub fn star_shape(
    image: &StreakImage<'_>,
    assumed: StarShape,
    is_form_assumed: bool,
    stamps: impl Fn(&RadialProfile) -> Result<Vec<Stamp>, Error>,
) -> Result<Option<StarShape>, Error> {
    let mut start = assumed;
    for _ in 0..MOST_WIDTH_RANGES {
        // A width that cannot be drawn is not measured.
        let Ok(profile) = start.profile(image) else { break };
        let all = stamps(&profile)?;
        let bright = bright(image, &all, &profile);
        let with = |form: SeeingForm, ratio: f64| StarShape {
            seeing_arcsec: ratio * start.seeing_arcsec,
            form,
            is_form_measured: false,
        };
        let width = |form: SeeingForm| width_ratio(&bright, |ratio| with(form, ratio).profile(image).ok());
        match width(start.form) {
            Some(Width::Inside(ratio)) => {
                let assumed = with(start.form, ratio);
                let form = |inverse_beta| match width(form_of(inverse_beta)) {
                    Some(Width::Inside(ratio)) => Some(with(form_of(inverse_beta), ratio)),
                    _ => None,
                };
                let measured = if is_form_assumed { None } else { measured_form(image, &bright, &assumed, form) };
                return Ok(Some(measured.unwrap_or(assumed)));
            }
            Some(Width::AtEnd(ratio)) => start = with(start.form, ratio),
            None => break,
        }
    }
    Ok(None)
}

/// Returns the shape with the form that fits best, of those that `shape_of` returns for a value of 1/β; `None` if the
/// stars are too few or too faint to show their form.
fn measured_form(
    image: &StreakImage<'_>,
    stars: &[&Stamp],
    assumed: &StarShape,
    shape_of: impl Fn(f64) -> Option<StarShape>,
) -> Option<StarShape> {
    let misfit_with = |inverse_beta: f64| -> Option<f64> { misfit(image, stars, &shape_of(inverse_beta)?) };
    let start = match assumed.form {
        SeeingForm::Moffat { beta } => beta.recip().min(LARGEST_INVERSE_BETA),
        _ => 0.0,
    };
    let of = |inverse_beta: f64| misfit_with(inverse_beta).unwrap_or(f64::NAN);
    let range = [0.0, LARGEST_INVERSE_BETA];
    let (inverse_beta, least) = minimum(of, range, (start, misfit_with(start)?), INVERSE_BETA_TOLERANCE);
    let extreme = range.into_iter().filter_map(misfit_with).fold(f64::NEG_INFINITY, f64::max);
    let shape = shape_of(inverse_beta)?;
    (extreme - least >= FORM_SIGMAS * FORM_SIGMAS).then_some(StarShape { is_form_measured: true, ..shape })
}

fn form_of(inverse_beta: f64) -> SeeingForm {
    if inverse_beta < LEAST_INVERSE_BETA {
        SeeingForm::Gaussian
    } else {
        SeeingForm::Moffat { beta: inverse_beta.recip() }
    }
}

/// Returns Σ n ln S over the stars, with the sum S of the squares of n pixels that the fit of a drawn star leaves: χ² but
/// for a constant.
fn misfit(image: &StreakImage<'_>, stars: &[&Stamp], shape: &StarShape) -> Option<f64> {
    let profile = shape.profile(image).ok()?;
    let of = |stamp: &&Stamp| {
        let (squares, count) = stamp.squares(&profile);
        count * squares.max(f64::MIN_POSITIVE).ln()
    };
    Some(stars.iter().map(of).sum())
}

/// Returns the brightest stars with a sufficient signal to noise.
fn bright<'a>(image: &StreakImage<'_>, stamps: &'a [Stamp], assumed: &RadialProfile) -> Vec<&'a Stamp> {
    let mut bright: Vec<(&Stamp, f64)> = stamps
        .iter()
        .filter(|stamp| stamp.is_found)
        .filter_map(|stamp| Some((stamp, stamp.light(image, assumed)?)))
        .filter(|(_, light)| light.flux >= WIDTH_SIGNAL_TO_NOISE * light.sigma)
        .map(|(stamp, light)| (stamp, light.flux))
        .collect();
    bright.sort_by(|a, b| b.1.total_cmp(&a.1));
    bright.truncate(MOST_WIDTH_STARS);
    bright.into_iter().map(|(stamp, _)| stamp).collect()
}

/// Width of the stars relative to the assumed one.
enum Width {
    /// It is in the range of the compared widths.
    Inside(f64),
    /// It is at this end of the range, or beyond.
    AtEnd(f64),
}

/// Returns the ratio of the measured width of the stars to the assumed one. The width of a star is the one for which
/// the drawn star leaves the smallest sum of squares; the result is the median. `None` with fewer
/// than three stars.
fn width_ratio(bright: &[&Stamp], profile_of: impl Fn(f64) -> Option<RadialProfile>) -> Option<Width> {
    let [low, high] = WIDTH_RANGE.map(f64::ln);
    let step = (high - low) / (WIDTHS - 1) as f64;
    let profiles: Vec<(f64, Option<RadialProfile>)> =
        (0..WIDTHS).map(|index| low + step * index as f64).map(|ln| (ln, profile_of(ln.exp()))).collect();
    let ratio_of = |stamp: &Stamp| -> Option<f64> {
        let squares: Vec<f64> = profiles
            .iter()
            .map(|(_, profile)| profile.as_ref().map_or(f64::INFINITY, |profile| stamp.squares(profile).0))
            .collect();
        let least = (0..WIDTHS).min_by(|a, b| squares[*a].total_cmp(&squares[*b]))?;
        let ln = profiles[least].0;
        if least == 0 || least == WIDTHS - 1 {
            return squares[least].is_finite().then_some(ln);
        }
        let [before, here, after] = [squares[least - 1], squares[least], squares[least + 1]];
        let is_minimum = before > here && after > here && before.is_finite() && after.is_finite();
        // Vertex of the parabola through the three points.
        is_minimum.then(|| ln + 0.5 * step * (before - after) / (before - 2.0 * here + after))
    };
    let ratios: Vec<f64> = bright.iter().filter_map(|stamp| ratio_of(stamp)).collect();
    let ln = (ratios.len() >= LEAST_STARS).then(|| median(ratios))?;
    let is_inside = (low + 0.5 * step..=high - 0.5 * step).contains(&ln);
    Some(if is_inside { Width::Inside(ln.exp()) } else { Width::AtEnd(ln.exp()) })
}
