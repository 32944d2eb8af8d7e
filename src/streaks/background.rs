//! Background of a frame: light of the sky and of stars.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Poisson};
use serde::Deserialize;

use super::psf::{RadialProfile, draw_point};
use crate::error::Error;
use crate::images::{PixelPosition, Plane};

/// Largest accepted flux of a star, electrons.
pub(crate) const BRIGHTEST_E: f64 = 1e12;

/// Star on a frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Star {
    /// Position in the frame, pixels; it may lie outside the frame.
    pub at: PixelPosition,
    /// Light collected during the exposure, electrons.
    pub flux_e: f64,
}

/// Returns the electrons of a star of this magnitude: 10^(0.4 (zero point - m)). The zero point is the magnitude of a
/// star that gives one electron in the exposure.
pub fn flux_e(magnitude: f64, zero_point_mag: f64) -> f64 {
    10_f64.powf(0.4 * (zero_point_mag - magnitude))
}

impl Star {
    /// Creates a star from a magnitude, by [`flux_e`].
    pub fn of_magnitude(at: PixelPosition, magnitude: f64, zero_point_mag: f64) -> Self {
        Self { at, flux_e: flux_e(magnitude, zero_point_mag) }
    }
}

/// Random stars of a given density, at random positions, with magnitudes distributed as N(< m) ∝ 10^(slope m).
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomStars {
    /// Mean number of stars brighter than the faintest magnitude in a million pixels, \[0, 1e5\].
    pub per_megapixel: f64,
    /// Logarithmic slope of the counts, \[0.05, 2\]: 0.6 for a uniform distribution in space, about 0.3 at faint
    /// magnitudes.
    pub slope: f64,
    /// Brightest magnitude, \[-30, 60\] mag.
    pub brightest_mag: f64,
    /// Faintest magnitude, from the brightest to 60 mag.
    pub faintest_mag: f64,
    /// Magnitude of a star that gives one electron in the exposure, \[-30, 60\] mag.
    pub zero_point_mag: f64,
}

impl RandomStars {
    /// Draws stars for a frame of `rows` by `columns` pixels and a margin of `margin_pix` around it; the same seed
    /// gives the same stars.
    ///
    /// # Errors
    /// A field of this struct is out of range.
    pub fn draw(&self, rows: usize, columns: usize, margin_pix: f64, seed: u64) -> Result<Vec<Star>, Error> {
        Error::check_range("background: per_megapixel", self.per_megapixel, 0.0, 1e5)?;
        Error::check_range("background: slope", self.slope, 0.05, 2.0)?;
        Error::check_range("background: brightest_mag", self.brightest_mag, -30.0, 60.0)?;
        Error::check_range("background: faintest_mag", self.faintest_mag, self.brightest_mag, 60.0)?;
        Error::check_range("background: zero_point_mag", self.zero_point_mag, -30.0, 60.0)?;
        Error::check_range("background: margin_pix", margin_pix, 0.0, 1e5)?;
        let (width, height) = (columns as f64 + 2.0 * margin_pix, rows as f64 + 2.0 * margin_pix);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mean = self.per_megapixel * width * height * 1e-6;
        let count = Poisson::new(mean).map_or(0.0, |poisson: Poisson<f64>| poisson.sample(&mut random));
        let least = 10_f64.powf(self.slope * (self.brightest_mag - self.faintest_mag));
        let star = |_| {
            let position = |length: f64, share: f64| share * length - margin_pix - 0.5;
            let at = PixelPosition { x: position(width, random.random()), y: position(height, random.random()) };
            // The fraction of stars brighter than m is 10^(slope (m - faintest)).
            let share = least + (1.0 - least) * (1.0 - random.random::<f64>());
            Star::of_magnitude(at, self.faintest_mag + share.log10() / self.slope, self.zero_point_mag)
        };
        Ok((0..count as usize).map(star).collect())
    }
}

/// Returns the light of sky and stars in a frame of `rows` by `columns` pixels, as expected electrons. Streaks can be
/// added to it before the detector is applied.
///
/// `sky_e` is the light of the sky in one pixel, electrons, \[0, 1e9\]. All stars have the same profile. If the whole
/// image of a star lies in the frame, its pixels sum to the flux within 10⁻⁵.
///
/// # Errors
/// `sky_e` is out of range, or the flux of a star is negative, too large or not finite.
pub fn background(
    rows: usize,
    columns: usize,
    sky_e: f64,
    stars: &[Star],
    profile: &RadialProfile,
) -> Result<Plane, Error> {
    Error::check_range("background: sky_e", sky_e, 0.0, 1e9)?;
    let mut plane = Plane::zeros(rows, columns);
    plane.values_mut().fill(sky_e as f32);
    for star in stars {
        Error::check_range("background: flux_e", star.flux_e, 0.0, BRIGHTEST_E)?;
        draw_point(profile, star.at, star.flux_e, rows, columns).add_to(&mut plane);
    }
    Ok(plane)
}
