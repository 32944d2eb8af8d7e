//! Seeing: a Gaussian, a Moffat profile, or the sum of two Gaussians.

use std::f64::consts::{LN_2, PI};

use serde::Deserialize;

use crate::error::Error;

/// Smallest FWHM, pixels. The drawing time grows with the inverse square of the FWHM. Narrower profiles would differ
/// from this one only for points within a tenth of a pixel of a pixel border.
const LEAST_FWHM_PIX: f64 = 0.1;
const GREATEST_FWHM_PIX: f64 = 100.0;
/// Smallest exponent β. Below 2, a Moffat profile has a hundredth of its light beyond 50 FWHM, far outside the range in
/// which seeing is measured.
const LEAST_BETA: f64 = 2.0;
const GREATEST_BETA: f64 = 100.0;

/// Surface brightness of a star's image, normalised to unit flux over the whole plane. Widths are full widths at half
/// maximum, pixels.
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Seeing {
    /// exp(-r²/2σ²), FWHM = 2.3548 σ.
    Gaussian {
        /// Width, \[0.1, 100\] pixels.
        fwhm_pix: f64,
    },
    /// (1 + r²/α²)^-β, FWHM = 2 α √(2^(1/β) - 1) (Moffat 1969, A&A 3, 455).
    Moffat {
        /// Width, \[0.1, 100\] pixels.
        fwhm_pix: f64,
        /// Exponent of the wings, \[2, 100\]; 4.765 for turbulence (Trujillo et al. 2001), 2.5 to 4 at telescopes.
        beta: f64,
    },
    /// A narrow and a wide Gaussian about the same centre.
    DoubleGaussian {
        /// FWHM of the narrow Gaussian, \[0.1, 100\] pixels.
        fwhm_pix: f64,
        /// FWHM of the wide Gaussian, from that of the narrow one to 100 pixels.
        wide_fwhm_pix: f64,
        /// Fraction of the flux in the wide Gaussian, \[0, 1\].
        wide_share: f64,
    },
}

impl Seeing {
    /// Returns the FWHM of the narrowest part, pixels.
    pub fn narrowest_fwhm_pix(&self) -> f64 {
        match *self {
            Self::Gaussian { fwhm_pix } | Self::Moffat { fwhm_pix, .. } | Self::DoubleGaussian { fwhm_pix, .. } => {
                fwhm_pix
            }
        }
    }

    /// Checks that widths, exponent and fraction are in range.
    ///
    /// # Errors
    /// A number outside its range or not finite.
    pub(super) fn validate(&self) -> Result<(), Error> {
        Error::check_range("fwhm_pix", self.narrowest_fwhm_pix(), LEAST_FWHM_PIX, GREATEST_FWHM_PIX)?;
        match *self {
            Self::Gaussian { .. } => Ok(()),
            Self::Moffat { beta, .. } => Error::check_range("beta", beta, LEAST_BETA, GREATEST_BETA),
            Self::DoubleGaussian { fwhm_pix, wide_fwhm_pix, wide_share } => {
                Error::check_range("wide_fwhm_pix", wide_fwhm_pix, fwhm_pix, GREATEST_FWHM_PIX)?;
                Error::check_range("wide_share", wide_share, 0.0, 1.0)
            }
        }
    }

    /// Returns the surface brightness at a radius (pixels), per square pixel.
    pub(super) fn at(&self, r_pix: f64) -> f64 {
        let gaussian = |sigma: f64| (-0.5 * (r_pix / sigma).powi(2)).exp() / (2.0 * PI * sigma * sigma);
        match *self {
            Self::Gaussian { fwhm_pix } => gaussian(sigma_of(fwhm_pix)),
            Self::Moffat { fwhm_pix, beta } => {
                let alpha = alpha_of(fwhm_pix, beta);
                (beta - 1.0) / (PI * alpha * alpha) * (1.0 + (r_pix / alpha).powi(2)).powf(-beta)
            }
            Self::DoubleGaussian { fwhm_pix, wide_fwhm_pix, wide_share } => {
                (1.0 - wide_share) * gaussian(sigma_of(fwhm_pix)) + wide_share * gaussian(sigma_of(wide_fwhm_pix))
            }
        }
    }

    /// Returns the fraction of the flux beyond a radius, pixels.
    pub(super) fn beyond(&self, r_pix: f64) -> f64 {
        let gaussian = |sigma: f64| (-0.5 * (r_pix / sigma).powi(2)).exp();
        match *self {
            Self::Gaussian { fwhm_pix } => gaussian(sigma_of(fwhm_pix)),
            Self::Moffat { fwhm_pix, beta } => (1.0 + (r_pix / alpha_of(fwhm_pix, beta)).powi(2)).powf(1.0 - beta),
            Self::DoubleGaussian { fwhm_pix, wide_fwhm_pix, wide_share } => {
                (1.0 - wide_share) * gaussian(sigma_of(fwhm_pix)) + wide_share * gaussian(sigma_of(wide_fwhm_pix))
            }
        }
    }

    /// Returns the brightness of a long line at a distance (pixels) from the line, in an arbitrary unit.
    pub(super) fn line(&self, v_pix: f64) -> f64 {
        let gaussian = |sigma: f64| (-0.5 * (v_pix / sigma).powi(2)).exp() / sigma;
        match *self {
            Self::Gaussian { fwhm_pix } => gaussian(sigma_of(fwhm_pix)),
            Self::Moffat { fwhm_pix, beta } => (1.0 + (v_pix / alpha_of(fwhm_pix, beta)).powi(2)).powf(0.5 - beta),
            Self::DoubleGaussian { fwhm_pix, wide_fwhm_pix, wide_share } => {
                (1.0 - wide_share) * gaussian(sigma_of(fwhm_pix)) + wide_share * gaussian(sigma_of(wide_fwhm_pix))
            }
        }
    }

    /// Returns the radius beyond which a condition is true, pixels.
    pub(super) fn radius_where(&self, is_true: impl Fn(f64) -> bool) -> f64 {
        let mut bounds = [0.0, self.narrowest_fwhm_pix()];
        while !is_true(bounds[1]) {
            bounds = [bounds[1], 2.0 * bounds[1]];
        }
        for _ in 0..60 {
            let middle = 0.5 * (bounds[0] + bounds[1]);
            bounds[usize::from(is_true(middle))] = middle;
        }
        bounds[1]
    }
}

/// σ = FWHM / √(8 ln 2).
fn sigma_of(fwhm_pix: f64) -> f64 {
    fwhm_pix / (8.0 * LN_2).sqrt()
}

/// α = FWHM / (2 √(2^(1/β) - 1)).
fn alpha_of(fwhm_pix: f64, beta: f64) -> f64 {
    0.5 * fwhm_pix / ((LN_2 / beta).exp_m1()).sqrt()
}
