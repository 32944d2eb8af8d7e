//! The pixels around a star: its centre, its light in an aperture and the misfit of a drawn star.

use super::background::SIGMA_OF_MAD;
use super::measurement::StreakImage;
use crate::images::PixelPosition;
use crate::math::quantile::median;
use crate::streaks::{RadialProfile, draw_point};

/// Radius of the aperture in FWHM, and its smallest value in pixels. The sky is measured from two to three times this
/// radius.
pub const APERTURE_WIDTHS: f64 = 2.0;
pub const LEAST_APERTURE_PIX: f64 = 3.0;
pub const SKY_RADII: [f64; 2] = [2.0, 3.0];
/// Smallest width of the weights of a centroid, pixels. The centroids of narrower stars with weights as wide as the
/// star are up to 0.4 pixels from the star, so that it looks wider.
const LEAST_WEIGHT_PIX: f64 = 3.0;
/// Light of a star in an aperture.
#[derive(Copy, Clone, Debug)]
pub struct Aperture {
    /// Light, corrected for that outside the aperture.
    pub flux: f64,
    /// Error (one sigma).
    pub sigma: f64,
}

/// Pixels around a star.
pub struct Stamp {
    /// Column and row of the first pixel.
    first: [usize; 2],
    side: usize,
    values: Vec<f32>,
    /// Centre of the star, pixels of the image.
    at: PixelPosition,
    /// Radius of the aperture, pixels.
    radius_pix: f64,
    /// True if the centre is that of light near the expected position, false if it is the expected position.
    pub is_found: bool,
}

impl Stamp {
    /// Reads the pixels around a star and measures its centre, starting at the expected position. `None` if the pixels
    /// extend beyond the illuminated area, or a pixel in the aperture has no value.
    pub fn centred(image: &StreakImage<'_>, expected: PixelPosition, radius_pix: f64, fwhm_pix: f64) -> Option<Self> {
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
    pub fn pixels(&self, radius_pix: f64) -> impl Iterator<Item = (PixelPosition, f64)> + '_ {
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

    /// Returns the share of the light of a drawn star that is measured in the aperture: q = Σ m - n s, with the n pixels m
    /// of the aperture and the mean s of the pixels of the sky, in which the star has wings.
    pub fn share(&self, profile: &RadialProfile) -> f64 {
        let [inner, outer] = SKY_RADII.map(|radii| radii * self.radius_pix);
        let [mut light, mut count, mut wings, mut sky_count] = [0.0f64; 4];
        for (index, star) in self.template(profile).into_iter().enumerate() {
            let distance = self.position(index).distance(self.at);
            if distance <= self.radius_pix {
                light += f64::from(star);
                count += 1.0;
            } else if distance > inner && distance <= outer {
                wings += f64::from(star);
                sky_count += 1.0;
            }
        }
        light - count * wings / sky_count.max(1.0)
    }

    /// Measures the light in the aperture. `None` if the sky cannot be measured.
    ///
    /// F = (Σ d - n s) / q with the n pixels d of the aperture, the sky s and the share q of a star's light in these
    /// pixels. σ² = (n σ_s² (1 + n/n_s) + F q / g) / q² with the n_s pixels of the sky, their scatter σ_s and the
    /// gain g.
    pub fn light(&self, image: &StreakImage<'_>, profile: &RadialProfile) -> Option<Aperture> {
        let (sky, sky_sigma, sky_count) = self.sky()?;
        let share = self.share(profile);
        let (mut sum, mut count) = (0.0, 0.0);
        for (_, value) in self.pixels(self.radius_pix) {
            sum += value - sky;
            count += 1.0;
        }
        let photons = image.electrons_per_unit.map_or(0.0, |gain| sum.max(0.0) / gain);
        let variance = count * sky_sigma * sky_sigma * (1.0 + count / sky_count as f64) + photons;
        (share > 0.0 && variance > 0.0).then(|| Aperture { flux: sum / share, sigma: variance.sqrt() / share })
    }

    /// Returns the sum of the squares that a fit of a drawn star and a constant leaves within twice the radius of the
    /// aperture, and the number of pixels.
    pub fn squares(&self, profile: &RadialProfile) -> (f64, f64) {
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
        (squares - if weight > 0.0 { signal * signal / weight } else { 0.0 }, n)
    }
}
