//! Clear air above a site: extinction, and the loss of faint objects in twilight.
//!
//! The values are those of average clear nights. Haze, the Moon and artificial light are not included.

use super::band::Band;

/// Surface brightness of the zenith by day, mag/arcsec² in V. A typical value without a source, about 4000 cd/m²; it
/// matters only if the Sun is above -1 deg.
const DAY_SKY_MAG_ARCSEC2: f64 = 3.6;

/// Returns the extinction of clear air, mag per airmass.
///
/// Rayleigh scattering, aerosols and ozone for visual observers: Green (1992, International Comet Quarterly 14, 55), as
/// later programs quote it. The extension to other bands is ours: λ⁻⁴ for air, λ^-1.3 for aerosols, which gives Green's
/// 0.120 mag at 0.51 µm, and ozone between 0.45 and 0.75 µm only. Water vapour, which absorbs in the infrared, is not
/// included.
pub fn clear_sky_extinction_mag(band: Band, height_m: f64) -> f64 {
    // Effective wavelengths, micrometres: Bessell (2005, ARA&A 43, 293); LSST 2023 passbands; Gaia DR3; 2MASS (Cohen et
    // al. 2003, AJ 126, 1090) and WISE (Jarrett et al. 2011, ApJ 735, 112), isophotal.
    let wavelength_um: f64 = match band {
        Band::B => 0.436,
        Band::V => 0.545,
        Band::R => 0.641,
        Band::I => 0.798,
        Band::LsstU => 0.367,
        Band::LsstG => 0.483,
        Band::LsstR => 0.622,
        Band::LsstI => 0.755,
        Band::LsstZ => 0.869,
        Band::LsstY => 0.971,
        Band::GaiaG => 0.622,
        Band::J => 1.235,
        Band::H => 1.662,
        Band::K => 2.159,
        Band::W1 => 3.353,
        Band::W2 => 4.603,
        Band::Response(band) => band.wavelength_um(),
    };
    // Green's coefficients are those at this wavelength, the scale heights are in km.
    let (ratio, height_km) = (wavelength_um / 0.51, height_m / 1000.0);
    let rayleigh = 0.1451 * ratio.powi(-4) * (-height_km / 7.996).exp();
    let aerosols = 0.120 * ratio.powf(-1.3) * (-height_km / 1.5).exp();
    // The Chappuis bands absorb between 0.45 and 0.75 micrometres.
    let ozone = if (0.45..0.75).contains(&wavelength_um) { 0.016 } else { 0.0 };
    rayleigh + aerosols + ozone
}

/// Returns the magnitude limit of an observer in twilight, given that of the dark night and the altitude of the Sun.
///
/// A limit that the naked eye reaches in the dark is unchanged until the sky hides such objects from the eye. A fainter
/// limit, which requires an instrument, is brighter in twilight by as much as that of the eye.
///
/// ```
/// use streakcast::photometry::twilight_limit_mag;
///
/// let at_deg = |limit_mag: f64, sun_deg: f64| twilight_limit_mag(limit_mag, sun_deg.to_radians());
/// assert_eq!((at_deg(3.0, -20.0), at_deg(3.0, -8.0)), (3.0, 3.0));
/// assert!(at_deg(3.0, -4.0) < 2.9 && at_deg(5.0, -8.0) < 4.6);
/// ```
pub fn twilight_limit_mag(limit_mag: f64, sun_altitude_rad: f64) -> f64 {
    let of_eye = naked_eye_limit_mag(zenith_sky_mag_arcsec2(sun_altitude_rad));
    let of_dark_eye = naked_eye_limit_mag(DARK_SKY_MAG_ARCSEC2);
    limit_mag.min(of_eye + (limit_mag - of_dark_eye).max(0.0))
}

/// Coefficients of the sky's brightness in V, mag/arcsec², as a polynomial in the Sun's depression minus 5 deg: Patat,
/// Ugolnikov and Postylyakov (2006, A&A 455, 385), table 1, at the zenith of Paranal, fitted from 5 to 15 deg with an
/// error of 0.18 mag. Outside this range it is extrapolated, to its maximum by night and to the sky of the day.
const TWILIGHT: [f64; 3] = [11.84, 1.518, -0.057];
/// Depression minus 5 deg at which the polynomial is faintest. There the night is dark.
const DARKEST_DEG: f64 = -TWILIGHT[1] / (2.0 * TWILIGHT[2]);
const DARK_SKY_MAG_ARCSEC2: f64 = TWILIGHT[0] + DARKEST_DEG * (TWILIGHT[1] + DARKEST_DEG * TWILIGHT[2]);

/// Returns the surface brightness of the zenith without Moon, mag/arcsec² in V.
fn zenith_sky_mag_arcsec2(sun_altitude_rad: f64) -> f64 {
    let x_deg = (-sun_altitude_rad.to_degrees() - 5.0).min(DARKEST_DEG);
    (TWILIGHT[0] + x_deg * (TWILIGHT[1] + x_deg * TWILIGHT[2])).max(DAY_SKY_MAG_ARCSEC2)
}

/// Returns the magnitude of the faintest star that a practised eye sees against a sky.
///
/// Schaefer (1998, Sky & Telescope 95(5), 57), after Hecht (1947): the threshold of the eye is C (1 + √(K b))² foot
/// candles for a sky of b nanolamberts, with one pair of constants for rods and one for cones. The constants are those
/// of later programs that quote him, and b is from Krisciunas & Schaefer (1991, PASP 103, 1033).
fn naked_eye_limit_mag(sky_mag_arcsec2: f64) -> f64 {
    // b = 34.08 exp(20.7233 - 0.92104 μ)
    let sky_nl = 34.08 * (20.7233 - 0.92104 * sky_mag_arcsec2).exp();
    let threshold = |log_c: f64, log_k: f64| {
        // m = -16.57 - 2.5 log10 threshold
        -16.57 - 2.5 * (log_c + 2.0 * (1.0 + (10.0_f64.powf(log_k) * sky_nl).sqrt()).log10())
    };
    // Rods see fainter stars against skies below about 1500 nL, cones against brighter ones.
    threshold(-9.80, -1.90).max(threshold(-8.35, -5.90))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Green (1992): 0.28 mag at sea level and 0.18 mag at 2 km for visual observers. Stubbs et al. (2007), Rubin: u
    /// 0.4 to 0.5, g 0.16 to 0.2, r 0.09 to 0.13, y below 0.1 at 2.7 km.
    #[test]
    fn valid_extinction_against_published_values() {
        let within = |band: Band, height_m: f64, range: [f64; 2]| {
            let mag = clear_sky_extinction_mag(band, height_m);
            assert!((range[0]..range[1]).contains(&mag), "{band} {height_m}: {mag}");
        };
        within(Band::V, 0.0, [0.22, 0.29]);
        within(Band::V, 2000.0, [0.12, 0.19]);
        within(Band::B, 0.0, [0.33, 0.45]);
        within(Band::LsstU, 2663.0, [0.38, 0.52]);
        within(Band::LsstG, 2663.0, [0.14, 0.2]);
        within(Band::LsstR, 2663.0, [0.07, 0.13]);
        within(Band::LsstY, 2663.0, [0.01, 0.05]);
    }

    /// The dark sky of Paranal in V is 21.6 +- 0.2 mag/arcsec²; stars of magnitude 6 to 6.5 are visible in the dark,
    /// those of magnitude 3 to 4 at the end of civil twilight with practice, and Venus by day.
    #[test]
    fn valid_sky_and_eye_against_common_values() {
        assert!((DARK_SKY_MAG_ARCSEC2 - 21.8).abs() < 0.3, "{DARK_SKY_MAG_ARCSEC2}");
        let eye = |sun_deg: f64| naked_eye_limit_mag(zenith_sky_mag_arcsec2(sun_deg.to_radians()));
        assert!((eye(-30.0) - 6.5).abs() < 0.2, "{}", eye(-30.0));
        assert!((3.0..4.0).contains(&eye(-6.0)), "{}", eye(-6.0));
        assert!((-4.5..-2.5).contains(&eye(10.0)), "{}", eye(10.0));
        // The limit becomes brighter without a step from night to day.
        let altitudes_deg = || (-250..250).map(|tenth| f64::from(tenth) * 0.1);
        for (before, after) in altitudes_deg().zip(altitudes_deg().skip(1)) {
            assert!((0.0..0.2).contains(&(eye(before) - eye(after))), "{before} {}", eye(after));
        }
    }

    #[test]
    fn verif_instruments_lose_as_much_as_the_eye() {
        let lost = |limit_mag: f64, sun_deg: f64| limit_mag - twilight_limit_mag(limit_mag, f64::to_radians(sun_deg));
        assert_eq!(lost(12.0, -25.0), 0.0);
        assert!((lost(12.0, -8.0) - lost(7.0, -8.0)).abs() < 1e-9 && lost(7.0, -8.0) > 1.0);
        assert!(lost(2.0, -8.0) == 0.0 && lost(2.0, -3.0) > 0.2);
    }
}
