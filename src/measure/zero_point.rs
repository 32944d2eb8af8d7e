//! Zero point and seeing of an image from stars of known magnitude.

use super::background::SIGMA_OF_MAD;
use super::measurement::{Estimate, StreakImage};
use super::star_table::CatalogueStar;
use crate::error::Error;
use crate::images::{PixelPosition, Wcs};
use crate::math::quantile::median;
use crate::streaks::{Optics, RadialProfile, draw_point};
use crate::watch::Watch;

/// Radius of the aperture in FWHM, and its smallest value in pixels. The sky is measured from two to three times this
/// radius.
const APERTURE_WIDTHS: f64 = 2.0;
const LEAST_APERTURE_PIX: f64 = 3.0;
const SKY_RADII: [f64; 2] = [2.0, 3.0];
/// Smallest width of the weights of a centroid, pixels. The centroids of narrower stars with weights as wide as the
/// star are up to 0.4 pixels from the star, so that it looks wider.
const LEAST_WEIGHT_PIX: f64 = 3.0;
/// Smallest signal to noise of a star, expected from its magnitude.
const LEAST_SIGNAL_TO_NOISE: f64 = 20.0;
/// Smallest number of stars.
const LEAST_STARS: usize = 3;
/// Pixels above this fraction of the saturation are treated as saturated: detectors are not linear there.
const SATURATED_SHARE: f64 = 0.95;
/// Another star of the table is a neighbour if it is nearer than the inner radius of the sky and at most this much
/// fainter, mag.
const NEIGHBOUR_MAG: f64 = 5.0;
/// Least error of a zero point, mag. It is due to the errors of the drawn stars, and of the sky between the wings of
/// other stars.
const LEAST_ERROR_MAG: f64 = 0.002;
/// Stars beyond this number of sigmas of the median zero point are outliers.
const OUTLIER_SIGMAS: f64 = 4.0;
/// There is no zero point unless this share of the stars has light at their positions, and this share are no outliers.
const LEAST_SHARE: f64 = 0.5;
/// Largest scatter of the zero points from single stars, mag, also of magnitudes of a neighbouring band.
const MOST_SCATTER_MAG: f64 = 0.5;
/// Cause of stars without light at their positions.
const MISPLACED: &str = "the world coordinates of the frame or the positions of the stars (epoch) are wrong";
/// Range (relative to the assumed width) and number of the widths for which stars are drawn and compared with their
/// images, and largest number of compared stars.
const WIDTH_RANGE: [f64; 2] = [0.4, 2.5];
const WIDTHS: usize = 25;
/// Largest number of ranges of widths: if the stars are at the end of a range, the next one begins there.
const MOST_WIDTH_RANGES: usize = 5;
const MOST_WIDTH_STARS: usize = 50;
/// Smallest signal to noise of these stars.
const WIDTH_SIGNAL_TO_NOISE: f64 = 50.0;

/// Zero point of an image from stars, and the number of stars that were used and omitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StarZeroPoint {
    /// Magnitude of a star whose pixels sum to 1; `None` if fewer than three stars are usable.
    pub zero_point_mag: Option<Estimate>,
    /// FWHM of the stars, arcsec; `None` if fewer than three are bright enough.
    pub seeing_arcsec: Option<f64>,
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

/// Light of a star in an aperture.
#[derive(Copy, Clone, Debug)]
struct Aperture {
    /// Light, corrected for that outside the aperture.
    flux: f64,
    /// Error (one sigma).
    sigma: f64,
}

/// Measures the zero point of an image, by photometry of stars in apertures, and the width of the stars.
///
/// If `is_width_known` is false, `optics` has only a first estimate of the seeing, and the apertures have the measured
/// width.
///
/// # Errors
/// The image of a star is too narrow or too wide to be drawn, or `watch` is stopped.
pub fn star_zero_point(
    image: &StreakImage<'_>,
    wcs: &Wcs,
    stars: &[CatalogueStar],
    optics: &Optics,
    is_width_known: bool,
    watch: &Watch,
) -> Result<StarZeroPoint, Error> {
    let mut found = StarZeroPoint::default();
    let placed = placed(image, wcs, stars);
    found.outside = stars.len() - placed.len();
    let star_profile = |seeing_arcsec: f64| -> Result<RadialProfile, Error> {
        // Stars are in focus.
        let stars = Optics { seeing_arcsec, outer_radius_m: 0.0, inner_radius_m: 0.0, form: optics.form };
        stars.profile(1.0, 0.0, image.pixel_scale_arcsec, image.pixel_aspect)
    };
    let assumed = star_profile(optics.seeing_arcsec)?;
    // The width of misplaced stars is not measured.
    let mut start_arcsec = optics.seeing_arcsec;
    for _ in 0..MOST_WIDTH_RANGES {
        // A width that cannot be drawn is not measured.
        let Ok(profile) = star_profile(start_arcsec) else { break };
        let first = candidates(image, &placed, &profile, &mut StarZeroPoint::default(), watch)?;
        match width_ratio(image, &first, &profile, |ratio| star_profile(ratio * start_arcsec).ok()) {
            Some(Width::Inside(ratio)) => {
                found.seeing_arcsec = Some(ratio * start_arcsec);
                break;
            }
            Some(Width::AtEnd(ratio)) => start_arcsec *= ratio,
            None => break,
        }
    }
    let profile = match found.seeing_arcsec {
        Some(seeing_arcsec) if !is_width_known => star_profile(seeing_arcsec)?,
        _ => assumed,
    };
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
        found.zero_point_mag = Some(Estimate { value: statistics.0, sigma: error.hypot(LEAST_ERROR_MAG) });
    }
    Ok(found)
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

/// Width of the stars relative to the assumed one.
enum Width {
    /// It is in the range of the compared widths.
    Inside(f64),
    /// It is at this end of the range, or beyond.
    AtEnd(f64),
}

/// Returns the ratio of the measured width of the stars to the assumed one. The width of a star is the one for which
/// the drawn star leaves the smallest sum of squares; the result is the median over bright stars. `None` with fewer
/// than three such stars.
fn width_ratio(
    image: &StreakImage<'_>,
    candidates: &[StarCandidate],
    assumed: &RadialProfile,
    profile_of: impl Fn(f64) -> Option<RadialProfile>,
) -> Option<Width> {
    let mut bright: Vec<(&StarCandidate, f64)> = candidates
        .iter()
        .filter_map(|candidate| Some((candidate, candidate.stamp.light(image, assumed)?)))
        .filter(|(_, light)| light.flux >= WIDTH_SIGNAL_TO_NOISE * light.sigma)
        .map(|(candidate, light)| (candidate, light.flux))
        .collect();
    bright.sort_by(|a, b| b.1.total_cmp(&a.1));
    bright.truncate(MOST_WIDTH_STARS);
    if bright.len() < LEAST_STARS {
        return None;
    }
    let [low, high] = WIDTH_RANGE.map(f64::ln);
    let step = (high - low) / (WIDTHS - 1) as f64;
    let profiles: Vec<(f64, Option<RadialProfile>)> =
        (0..WIDTHS).map(|index| low + step * index as f64).map(|ln| (ln, profile_of(ln.exp()))).collect();
    let ratio_of = |candidate: &StarCandidate| -> Option<f64> {
        let squares: Vec<f64> = profiles
            .iter()
            .map(|(_, profile)| profile.as_ref().map_or(f64::INFINITY, |profile| candidate.stamp.squares(profile)))
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
    let ratios: Vec<f64> = bright.iter().filter_map(|(candidate, _)| ratio_of(candidate)).collect();
    let ln = (ratios.len() >= LEAST_STARS).then(|| median(ratios))?;
    let is_inside = (low + 0.5 * step..=high - 0.5 * step).contains(&ln);
    Some(if is_inside { Width::Inside(ln.exp()) } else { Width::AtEnd(ln.exp()) })
}

/// Pixels around a star.
struct Stamp {
    /// Column and row of the first pixel.
    first: [usize; 2],
    side: usize,
    values: Vec<f32>,
    /// Centre of the star, pixels of the image.
    at: PixelPosition,
    /// Radius of the aperture, pixels.
    radius_pix: f64,
    /// True if the centre is that of light near the expected position, false if it is the expected position.
    is_found: bool,
}

impl Stamp {
    /// Reads the pixels around a star and measures its centre, starting at the expected position. `None` if the pixels
    /// extend beyond the illuminated area, or a pixel in the aperture has no value.
    fn centred(image: &StreakImage<'_>, expected: PixelPosition, radius_pix: f64, fwhm_pix: f64) -> Option<Self> {
        let mut at = expected;
        let mut stamp = Self::read(image, at, radius_pix)?;
        // Centroid with Gaussian weights as wide as a star. The weights reduce the measured shift by 1 + (s² + p²) / w²
        // with the widths s of the star, p of a pixel (its variance is 1/12) and w of the weights.
        let weight_pix = fwhm_pix.max(LEAST_WEIGHT_PIX);
        let pixel_squared = 8.0 * std::f64::consts::LN_2 / 12.0;
        let shortened = 1.0 + (fwhm_pix * fwhm_pix + pixel_squared) / (weight_pix * weight_pix);
        for _ in 0..10 {
            let sky = stamp.sky()?.0;
            let [mut sum, mut x, mut y] = [0.0; 3];
            for (pixel, value) in stamp.pixels(radius_pix) {
                let weight = (-4.0 * std::f64::consts::LN_2 * (pixel.distance(at) / weight_pix).powi(2)).exp();
                let light = weight * (value - sky);
                sum += light;
                x += light * (pixel.x - at.x);
                y += light * (pixel.y - at.y);
            }
            let moved = PixelPosition { x: at.x + shortened * x / sum, y: at.y + shortened * y / sum };
            // A star that is not found stays at its expected position.
            let is_found = sum > 0.0 && moved.distance(expected) <= fwhm_pix.max(2.0);
            let step_pix = moved.distance(at);
            at = if is_found { moved } else { expected };
            (stamp.at, stamp.is_found) = (at, is_found);
            if !is_found || step_pix < 0.01 {
                break;
            }
        }
        stamp = Self { is_found: stamp.is_found, ..Self::read(image, at, radius_pix)? };
        let is_complete = stamp.pixels(radius_pix).all(|(_, value)| value.is_finite());
        is_complete.then_some(stamp)
    }

    fn read(image: &StreakImage<'_>, at: PixelPosition, radius_pix: f64) -> Option<Self> {
        let reach = (SKY_RADII[1] * radius_pix).ceil() + 1.0;
        let area = image.light_area;
        let first = [at.x, at.y].map(|middle| middle.round() - reach);
        let side = 2.0 * reach + 1.0;
        let is_inside = first[0] >= area.columns.start as f64
            && first[0] + side <= area.columns.end as f64
            && first[1] >= area.rows.start as f64
            && first[1] + side <= area.rows.end as f64;
        if !is_inside {
            return None;
        }
        let (first, side) = (first.map(|first| first as usize), side as usize);
        let rows = first[1]..first[1] + side;
        let values = rows.flat_map(|row| image.plane.row(row)[first[0]..first[0] + side].iter().copied()).collect();
        Some(Self { first, side, values, at, radius_pix, is_found: false })
    }

    fn position(&self, index: usize) -> PixelPosition {
        let (column, row) = (self.first[0] + index % self.side, self.first[1] + index / self.side);
        PixelPosition { x: column as f64, y: row as f64 }
    }

    /// Returns the pixels whose centres are within a radius of the star, with their values.
    fn pixels(&self, radius_pix: f64) -> impl Iterator<Item = (PixelPosition, f64)> + '_ {
        let at = |index: usize| (self.position(index), f64::from(self.values[index]));
        (0..self.values.len()).map(at).filter(move |(pixel, _)| pixel.distance(self.at) <= radius_pix)
    }

    /// Returns the mean of the sky, its scatter, and the number of its pixels. Pixels beyond three sigmas of the median
    /// are omitted.
    fn sky(&self) -> Option<(f64, f64, usize)> {
        let [inner, outer] = SKY_RADII.map(|radii| radii * self.radius_pix);
        let mut values: Vec<f64> = self
            .pixels(outer)
            .filter(|(pixel, value)| pixel.distance(self.at) > inner && value.is_finite())
            .map(|(_, value)| value)
            .collect();
        for _ in 0..5 {
            if values.len() < 10 {
                return None;
            }
            let middle = median(values.clone());
            let sigma = SIGMA_OF_MAD * median(values.iter().map(|value| (value - middle).abs()).collect());
            let before = values.len();
            values.retain(|value| (value - middle).abs() <= 3.0 * sigma);
            if values.len() == before {
                break;
            }
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        (count > 0.0).then(|| (mean, variance.sqrt(), values.len()))
    }

    /// Returns the drawn star of unit flux at each pixel.
    fn template(&self, profile: &RadialProfile) -> Vec<f32> {
        let at = PixelPosition { x: self.at.x - self.first[0] as f64, y: self.at.y - self.first[1] as f64 };
        let patch = draw_point(profile, at, 1.0, self.side, self.side);
        let mut template = vec![0.0; self.values.len()];
        for span in patch.iter() {
            template[span.row * self.side + span.first_column..][..span.values.len()].copy_from_slice(span.values);
        }
        template
    }

    /// Measures the light in the aperture. `None` if the sky cannot be measured.
    ///
    /// F = (Σ d - n s) / q with the n pixels d of the aperture, the sky s and the share q of a star's light in these
    /// pixels. σ² = (n σ_s² (1 + n/n_s) + F q / g) / q² with the n_s pixels of the sky, their scatter σ_s and the
    /// gain g.
    fn light(&self, image: &StreakImage<'_>, profile: &RadialProfile) -> Option<Aperture> {
        let (sky, sky_sigma, sky_count) = self.sky()?;
        let template = self.template(profile);
        let (mut sum, mut count, mut share) = (0.0, 0.0, 0.0);
        for (index, (value, light)) in self.values.iter().zip(&template).enumerate() {
            if self.position(index).distance(self.at) <= self.radius_pix {
                sum += f64::from(*value) - sky;
                count += 1.0;
                share += f64::from(*light);
            }
        }
        let photons = image.electrons_per_unit.map_or(0.0, |gain| sum.max(0.0) / gain);
        let variance = count * sky_sigma * sky_sigma * (1.0 + count / sky_count as f64) + photons;
        (share > 0.0 && variance > 0.0).then(|| Aperture { flux: sum / share, sigma: variance.sqrt() / share })
    }

    /// Returns the sum of the squares that a fit of a drawn star and a constant leaves within twice the radius of the
    /// aperture.
    fn squares(&self, profile: &RadialProfile) -> f64 {
        let template = self.template(profile);
        // Sums of 1, m, m², d, d m, d².
        let mut sums = [0.0f64; 6];
        for (index, (value, light)) in self.values.iter().zip(&template).enumerate() {
            if self.position(index).distance(self.at) <= SKY_RADII[0] * self.radius_pix && value.is_finite() {
                let (d, m) = (f64::from(*value), f64::from(*light));
                sums.iter_mut().zip([1.0, m, m * m, d, d * m, d * d]).for_each(|(sum, term)| *sum += term);
            }
        }
        let [n, m, mm, d, dm, dd] = sums;
        let (weight, signal, squares) = (mm - m * m / n, dm - d * m / n, dd - d * d / n);
        squares - if weight > 0.0 { signal * signal / weight } else { 0.0 }
    }
}
