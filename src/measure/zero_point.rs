//! Zero point and seeing of an image from stars of known magnitude.

use super::background::SIGMA_OF_MAD;
use super::measurement::{Estimate, StreakImage};
use super::stamp::{APERTURE_WIDTHS, Aperture, LEAST_APERTURE_PIX, SKY_RADII, Stamp};
use super::star_shape::{LEAST_STARS, StarShape, star_shape};
use super::star_table::CatalogueStar;
use crate::error::Error;
use crate::images::{PixelPosition, Wcs};
use crate::math::quantile::median;
use crate::streaks::{Optics, RadialProfile, SeeingForm};
use crate::watch::Watch;

/// Smallest signal to noise of a star, expected from its magnitude.
const LEAST_SIGNAL_TO_NOISE: f64 = 20.0;
/// Pixels above this fraction of the saturation are treated as saturated: detectors are not linear there.
const SATURATED_SHARE: f64 = 0.95;
/// Another star of the table is a neighbour if it is nearer than the inner radius of the sky and at most this much
/// fainter, mag.
const NEIGHBOUR_MAG: f64 = 5.0;
/// Least error of a zero point, mag. It is due to the errors of the drawn stars, and of the sky between the wings of
/// other stars.
const LEAST_ERROR_MAG: f64 = 0.002;
/// Forms between which that of the stars is, if it is neither given nor measured.
const EXTREME_FORMS: [SeeingForm; 2] = [SeeingForm::Gaussian, SeeingForm::Moffat { beta: 2.5 }];
/// Stars beyond this number of sigmas of the median zero point are outliers.
const OUTLIER_SIGMAS: f64 = 4.0;
/// There is no zero point unless this share of the stars has light at their positions, and this share are no outliers.
const LEAST_SHARE: f64 = 0.5;
/// Largest scatter of the zero points from single stars, mag, also of magnitudes of a neighbouring band.
const MOST_SCATTER_MAG: f64 = 0.5;
/// Cause of stars without light at their positions.
const MISPLACED: &str = "the world coordinates of the frame or the positions of the stars (epoch) are wrong";
/// Zero point of an image from stars, and the number of stars that were used and omitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StarZeroPoint {
    /// Magnitude of a star whose pixels sum to 1; `None` if fewer than three stars are usable.
    pub zero_point_mag: Option<Estimate>,
    /// FWHM and form of the stars; `None` if fewer than three are bright enough. The form is the given one if it is
    /// known.
    pub shape: Option<StarShape>,
    /// Number of stars that determine the zero point.
    pub used: usize,
    /// Number of stars with saturated pixels.
    pub saturated: usize,
    /// Number of stars whose aperture or sky extends beyond the illuminated pixels, or whose aperture has missing
    /// pixels.
    pub edge: usize,
    /// Number of stars with another star of the table beside them.
    pub blended: usize,
    /// Number of stars whose expected signal to noise is below 20.
    pub faint: usize,
    /// Number of stars that differ from the median by more than four sigmas.
    pub outliers: usize,
    /// Number of stars without light at their positions, if most stars have none.
    pub misplaced: usize,
    /// Number of stars outside of the illuminated pixels.
    pub outside: usize,
    /// Reason why there is no zero point although there are enough stars.
    pub doubt: Option<String>,
}

impl StarZeroPoint {
    /// Returns the numbers of stars as text.
    pub fn counts(&self) -> String {
        let omitted = [
            (self.saturated, "saturated"),
            (self.edge, "at the edge"),
            (self.blended, "blended"),
            (self.faint, "faint"),
            (self.outliers, "outliers"),
            (self.misplaced, "without light at their positions"),
            // A table may cover a larger area than a chip.
            (if self.used == 0 { self.outside } else { 0 }, "outside of the frame"),
        ];
        let omitted: Vec<String> =
            omitted.iter().filter(|(count, _)| *count > 0).map(|(count, reason)| format!("{count} {reason}")).collect();
        let omitted = if omitted.is_empty() { "none".to_owned() } else { omitted.join(", ") };
        let doubt = self.doubt.iter().map(|doubt| format!("; {doubt}")).collect::<String>();
        format!("stars used: {}; omitted: {omitted}{doubt}", self.used)
    }
}

/// Star that can be measured: its pixels, and its magnitude.
struct StarCandidate {
    star: CatalogueStar,
    stamp: Stamp,
}

/// Measures the zero point of an image, by photometry of stars in apertures, and the width of the stars.
///
/// If `is_width_known` is false, `optics` has only a first estimate of the seeing, and the apertures have the measured
/// width. If `is_form_known` is false, the form of the stars is measured, too; without bright stars, the error of the zero
/// point contains that of the form.
///
/// # Errors
/// The image of a star is too narrow or too wide to be drawn, or `watch` is stopped.
pub fn star_zero_point(
    image: &StreakImage<'_>,
    wcs: &Wcs,
    stars: &[CatalogueStar],
    optics: &Optics,
    is_width_known: bool,
    is_form_known: bool,
    watch: &Watch,
) -> Result<StarZeroPoint, Error> {
    let mut found = StarZeroPoint::default();
    let placed = placed(image, wcs, stars);
    found.outside = stars.len() - placed.len();
    let assumed = StarShape { seeing_arcsec: optics.seeing_arcsec, form: optics.form, is_form_measured: false };
    // The shape of misplaced stars is not measured.
    found.shape = star_shape(image, assumed, is_form_known || is_width_known, |profile| {
        let all = candidates(image, &placed, profile, &mut StarZeroPoint::default(), watch)?;
        Ok(all.into_iter().map(|candidate| candidate.stamp).collect())
    })?;
    let shape = found.shape.filter(|_| !is_width_known).unwrap_or(assumed);
    let profile = shape.profile(image)?;
    let candidates = candidates(image, &placed, &profile, &mut found, watch)?;
    let measured: Vec<(&StarCandidate, Aperture)> =
        candidates.iter().filter_map(|candidate| Some((candidate, candidate.stamp.light(image, &profile)?))).collect();
    found.faint += candidates.len() - measured.len();

    let zero_point =
        |(candidate, light): &(&StarCandidate, Aperture)| candidate.star.magnitude + 2.5 * light.flux.log10();
    let bright = measured.iter().filter(|(_, light)| light.flux >= LEAST_SIGNAL_TO_NOISE * light.sigma);
    let first: Vec<f64> = bright.map(zero_point).collect();
    if first.is_empty() {
        found.faint += measured.len();
        return Ok(found);
    }
    let first = median(first);
    // Stars are selected by their expected light, because a selection by measured light would prefer stars that noise
    // makes brighter.
    let (usable, faint): (Vec<_>, Vec<_>) = measured.into_iter().partition(|(candidate, light)| {
        let expected = 10f64.powf(0.4 * (first - candidate.star.magnitude));
        expected >= LEAST_SIGNAL_TO_NOISE * light.sigma
    });
    found.faint += faint.len();
    let all = usable.len();
    let without_light = usable.iter().filter(|(candidate, _)| !candidate.stamp.is_found).count();
    if without_light as f64 > LEAST_SHARE * all as f64 {
        (found.misplaced, found.outliers) = (without_light, all - without_light);
        found.doubt = Some(MISPLACED.to_owned());
        return Ok(found);
    }
    // Zero point from each star, with its error.
    let mut values: Vec<(f64, f64)> = usable
        .iter()
        .map(|measurement| {
            let (candidate, light) = measurement;
            let sigma = 2.5 / std::f64::consts::LN_10 * light.sigma / light.flux;
            let value = if light.flux > 0.0 { zero_point(measurement) } else { f64::NEG_INFINITY };
            (value, sigma.hypot(candidate.star.sigma_mag))
        })
        .collect();
    let mut statistics = robust(&values);
    for _ in 0..5 {
        let (middle, scatter) = statistics;
        let before = values.len();
        values.retain(|(value, sigma)| (value - middle).abs() <= OUTLIER_SIGMAS * scatter.hypot(*sigma));
        statistics = robust(&values);
        if values.len() == before {
            break;
        }
    }
    found.outliers = all - values.len();
    found.used = values.len();
    if found.used >= LEAST_STARS {
        let scatter_mag = statistics.1;
        if (found.used as f64) < LEAST_SHARE * all as f64 || scatter_mag > MOST_SCATTER_MAG {
            found.doubt = Some(format!(
                "the zero points from single stars scatter by {scatter_mag:.2} mag and {} of {all} are outliers: the \
                 magnitudes are not those of the stars at these positions, or of another band",
                found.outliers
            ));
            return Ok(found);
        }
        let own = median(values.iter().map(|(_, sigma)| *sigma).collect());
        // The median of n values of a normal distribution has the error σ √(π/2n). The scatter of few stars may be
        // small by chance, so the median of their own errors is the smallest accepted scatter.
        let error = (std::f64::consts::FRAC_PI_2 / found.used as f64).sqrt() * statistics.1.max(own);
        let is_form_unknown = !is_form_known && !shape.is_form_measured;
        let form_mag = if is_form_unknown { form_error_mag(image, shape, &candidates[0].stamp) } else { 0.0 };
        let sigma = error.hypot(LEAST_ERROR_MAG).hypot(form_mag);
        found.zero_point_mag = Some(Estimate { value: statistics.0, sigma });
    }
    Ok(found)
}

/// Returns the error of a zero point (one sigma, mag) because the form of the stars is unknown: half of the largest
/// difference between the assumed form, a Gaussian and the Moffat profile with the widest wings.
fn form_error_mag(image: &StreakImage<'_>, assumed: StarShape, stamp: &Stamp) -> f64 {
    let share = |form: SeeingForm| Some(stamp.share(&StarShape { form, ..assumed }.profile(image).ok()?));
    let shares = [EXTREME_FORMS[0], EXTREME_FORMS[1], assumed.form].into_iter().filter_map(share);
    // -2.5 log₁₀ q with the shares q of a star's light in the aperture
    let magnitudes: Vec<f64> = shares.filter(|share| *share > 0.0).map(|share| -2.5 * share.log10()).collect();
    let of = |choose: fn(f64, f64) -> f64| magnitudes.iter().copied().reduce(choose).unwrap_or_default();
    0.5 * (of(f64::max) - of(f64::min))
}

/// Returns the median and the scatter of values.
fn robust(values: &[(f64, f64)]) -> (f64, f64) {
    if values.is_empty() {
        return (0.0, 0.0);
    }
    let middle = median(values.iter().map(|(value, _)| *value).collect());
    (middle, SIGMA_OF_MAD * median(values.iter().map(|(value, _)| (value - middle).abs()).collect()))
}

/// Returns the stars on illuminated pixels with their positions, in order of the column.
fn placed(image: &StreakImage<'_>, wcs: &Wcs, stars: &[CatalogueStar]) -> Vec<(PixelPosition, CatalogueStar)> {
    let on_chip = |star: &CatalogueStar| {
        let at = wcs.to_pixel(star.direction).filter(|at| image.light_area.contains(*at))?;
        Some((at, *star))
    };
    let mut placed: Vec<(PixelPosition, CatalogueStar)> = stars.iter().filter_map(on_chip).collect();
    placed.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    placed
}

/// Returns the stars that are not saturated, at the edge or beside another star, and counts the others.
fn candidates(
    image: &StreakImage<'_>,
    placed: &[(PixelPosition, CatalogueStar)],
    profile: &RadialProfile,
    found: &mut StarZeroPoint,
    watch: &Watch,
) -> Result<Vec<StarCandidate>, Error> {
    let radius_pix = (APERTURE_WIDTHS * profile.fwhm_pix()).max(LEAST_APERTURE_PIX);
    let near_pix = SKY_RADII[0] * radius_pix;
    let mut kept = Vec::new();
    for (index, (at, star)) in placed.iter().enumerate() {
        watch.check()?;
        let is_neighbour = |(other, neighbour): &(PixelPosition, CatalogueStar)| {
            neighbour.magnitude < star.magnitude + NEIGHBOUR_MAG && other.distance(*at) < near_pix
        };
        let after = placed[index + 1..].iter().take_while(|(other, _)| other.x - at.x < near_pix);
        let before = placed[..index].iter().rev().take_while(|(other, _)| at.x - other.x < near_pix);
        if after.chain(before).any(is_neighbour) {
            found.blended += 1;
            continue;
        }
        let Some(stamp) = Stamp::centred(image, *at, radius_pix, profile.fwhm_pix()) else {
            found.edge += 1;
            continue;
        };
        let level = image.saturation.map_or(f64::INFINITY, |level| SATURATED_SHARE * level);
        if stamp.pixels(radius_pix).any(|(_, value)| value >= level) {
            found.saturated += 1;
            continue;
        }
        kept.push(StarCandidate { star: *star, stamp });
    }
    Ok(kept)
}
