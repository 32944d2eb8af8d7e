//! Optics: the image of a light at a finite distance, seen through the atmosphere and a telescope.

use std::fmt;

use crate::error::Error;
use crate::streaks::{Blur, RadialProfile, Seeing};

/// Shape of a star's image.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SeeingForm {
    /// A Gaussian.
    Gaussian,
    /// A Moffat profile of exponent β.
    Moffat {
        /// Exponent β of the wings, 2 to 100.
        beta: f64,
    },
    /// The sum of a narrow and a wide Gaussian.
    DoubleGaussian {
        /// Ratio of the widths of the wide and the narrow Gaussian, 1 or more.
        widening: f64,
        /// Fraction of the flux in the wide Gaussian, 0 to 1.
        wide_share: f64,
    },
}

impl fmt::Display for SeeingForm {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gaussian => formatter.write_str("Gaussian"),
            Self::Moffat { beta } => write!(formatter, "Moffat with beta {beta}"),
            Self::DoubleGaussian { widening, wide_share } => {
                write!(formatter, "double Gaussian, the second {widening} times as wide with {wide_share} of the flux")
            }
        }
    }
}

/// Seeing and telescope.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Optics {
    /// Shape of a star's image.
    pub form: SeeingForm,
    /// Full width at half maximum of a star's image, arcsec.
    pub seeing_arcsec: f64,
    /// Outer radius of the aperture, m; 0 if defocus is to be ignored.
    pub outer_radius_m: f64,
    /// Radius of the central obstruction, m.
    pub inner_radius_m: f64,
}

impl Optics {
    /// Computes the image of a disk of `radius_m` at `range_km`, through a telescope that is focused on the stars.
    /// Pixels are `aspect` times as wide as high; `pixel_scale_arcsec` is the side of a square with the same area.
    ///
    /// # Errors
    /// The width of the image is outside the range that can be drawn.
    #[doc(hidden)]
    pub fn profile(
        &self,
        range_km: f64,
        radius_m: f64,
        pixel_scale_arcsec: f64,
        aspect: f64,
    ) -> Result<RadialProfile, Error> {
        if !(pixel_scale_arcsec > 0.0 && pixel_scale_arcsec.is_finite()) {
            return Err(Error::invalid("pixel scale", format!("{pixel_scale_arcsec} arcsec"), "above 0 arcsec"));
        }
        // A length r at distance d has the angle r / d. This holds for the size of the body and for the defocused image
        // of the pupil (Ragazzoni 2020).
        let pixels_a_metre = (1.0 / (range_km * 1000.0)).to_degrees() * 3600.0 / pixel_scale_arcsec;
        let blur = Blur {
            seeing: self.seeing(pixel_scale_arcsec),
            outer_radius_pix: self.outer_radius_m * pixels_a_metre,
            inner_radius_pix: self.inner_radius_m * pixels_a_metre,
            body_radius_pix: radius_m * pixels_a_metre,
        };
        RadialProfile::on_oblong(&blur, aspect).map_err(|error| {
            let pixels = format_args!("pixels of {pixel_scale_arcsec:.3} arcsec").to_string();
            // Defocus and size have no effect on a light whose width is given.
            if self.outer_radius_m == 0.0 && radius_m == 0.0 {
                error.at(format_args!("image of {:.3} arcsec on {pixels}", self.seeing_arcsec))
            } else {
                error.at(format_args!("light at {range_km:.0} km on {pixels}"))
            }
        })
    }

    /// Returns the greatest distance of drawn light from the centre of an image, radians. It covers the widest wings,
    /// and the rings of defocused satellites at any height.
    pub fn farthest_rad(&self) -> f64 {
        const SEEINGS: f64 = 200.0;
        const RINGS_RAD: f64 = 1e-3;
        (SEEINGS * self.seeing_arcsec / 3600.0).to_radians().max(RINGS_RAD)
    }

    /// Returns the profile of a star's image on pixels of this size.
    pub fn seeing(&self, pixel_scale_arcsec: f64) -> Seeing {
        let fwhm_pix = self.seeing_arcsec / pixel_scale_arcsec;
        match self.form {
            SeeingForm::Gaussian => Seeing::Gaussian { fwhm_pix },
            SeeingForm::Moffat { beta } => Seeing::Moffat { fwhm_pix, beta },
            SeeingForm::DoubleGaussian { widening, wide_share } => {
                Seeing::DoubleGaussian { fwhm_pix, wide_fwhm_pix: widening * fwhm_pix, wide_share }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_image_has_the_width_of_seeing_ring_and_body() {
        let optics =
            Optics { form: SeeingForm::Gaussian, seeing_arcsec: 0.7, outer_radius_m: 4.18, inner_radius_m: 2.558 };
        let blur = *optics.profile(550.0, 2.0, 0.2, 1.0).unwrap().blur();
        assert_eq!(blur.seeing, Seeing::Gaussian { fwhm_pix: 0.7 / 0.2 });
        // Rubin's ring is 3.14" across at 550 km: the aperture of 8.36 m divided by the distance.
        assert!((2.0 * blur.outer_radius_pix * 0.2 - 3.135).abs() < 1e-3);
        assert!((blur.inner_radius_pix / blur.outer_radius_pix - 2.558 / 4.18).abs() < 1e-12);
        assert!((blur.body_radius_pix / blur.outer_radius_pix - 2.0 / 4.18).abs() < 1e-12);
        let message = optics.profile(550.0, 2.0, 20.0, 1.0).unwrap_err().to_string();
        assert!(message.contains("550 km") && message.contains("fwhm_pix is 0.03"), "{message}");
        assert!(optics.profile(550.0, 2.0, f64::NAN, 1.0).is_err());
        assert!(optics.profile(550.0, 2.0, 0.2, 3.0).unwrap_err().to_string().contains("aspect is 3"));
    }
}
