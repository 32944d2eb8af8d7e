//! Thermal emission of satellites in the infrared: a grey body with the area of the satellite, and its reflection of
//! the Earth's infrared light.
//!
//! Borlaff, Marcum and Howell (2025, Nature, s41586-025-09759-5, "SPARKLES"), equations 4 to 6, with a temperature of
//! 280 K and an emissivity of 0.9 (Horiuchi et al. 2020, ApJ 905, 3). Unlike there, a surface reflects what it does not
//! absorb, 10 %.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::brightness::{Brightness, Earthshine, MagnitudeSource, PhotometryOptions};
use super::error_distribution::ErrorDistribution;
use super::magnitude::{Magnitude, StandardMagnitude};
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::geometry::ViewingGeometry;

/// Emissivity of satellites and of the Earth, which is at 290 K.
const EMISSIVITY: f64 = 0.9;

/// Error (one sigma) of the size in a brightness model, relative to the size. The sizes are those of the largest bright
/// part; which part is bright depends on the geometry.
pub const SIZE_SIGMA: f64 = 0.5;

/// Size of a satellite of unknown size, m.
pub(super) const UNKNOWN_SIZE_M: f64 = 3.0;

/// Thermal emission of a satellite.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Emission {
    /// Magnitude above the atmosphere.
    pub magnitude: Magnitude,
    /// One sigma, mag: that of the area, and 10 K in the temperature.
    pub sigma_mag: f64,
}

impl Emission {
    /// Returns the emission of a satellite with the area of a disk of diameter `size_m`; `None` in bands without. The
    /// sigma is at least that of the area of single satellites, `objects_sigma_mag`.
    pub fn new(
        size_m: f64,
        objects_sigma_mag: f64,
        geometry: &ViewingGeometry,
        options: &PhotometryOptions,
    ) -> Option<Self> {
        let [at_280_k, at_290_k] = options.band.black_body_mag(options.system)?;
        let size_m = if size_m > 0.0 { size_m } else { UNKNOWN_SIZE_M };
        let area_m2 = FRAC_PI_4 * size_m * size_m;
        let temperature_mag = at_280_k - at_290_k;
        let of_earth = match options.earthshine {
            Earthshine::Computed => of_earth(geometry) * 10_f64.powf(0.4 * temperature_mag),
            Earthshine::Off => 0.0,
        };
        // F = ε A B(280 K) / d² + (1 - ε) ε γ A (R / (R + h))² B(290 K) / d²
        let standard = StandardMagnitude(at_280_k - 2.5 * (area_m2 * (EMISSIVITY + of_earth)).log10());
        // A = π D² / 4: σ(m) = 2 (2.5 / ln 10) σ(D) / D
        let area_sigma_mag = (5.0 / std::f64::consts::LN_10 * SIZE_SIGMA).max(objects_sigma_mag);
        let magnitude = standard.at_range(geometry.range_km);
        magnitude.0.is_finite().then_some(Self { magnitude, sigma_mag: area_sigma_mag.hypot(temperature_mag) })
    }

    /// Returns the light of the satellite with its reflected light; `None` for the latter in the Earth's shadow.
    /// `air_mag` is the extinction, which the reflected light includes.
    pub fn with_reflection(self, reflected: Option<Brightness>, air_mag: f64) -> Brightness {
        let emitted = self.magnitude.dimmed_by(air_mag);
        let Some(light) = reflected else { return self.alone(emitted, false) };
        // m = -2.5 log10(10^(-0.4 m_r) + 10^(-0.4 m_t)), with the share w of the emission
        let excess = 10_f64.powf(0.4 * (light.magnitude.0 - emitted.0));
        let share = excess / (1.0 + excess);
        let magnitude = light.magnitude.dimmed_by(-2.5 * excess.ln_1p() / std::f64::consts::LN_10);
        let scatter_mag = (1.0 - share) * light.scatter_mag;
        let sigma_mag = ((1.0 - share) * light.sigma_mag).hypot(share * self.sigma_mag);
        if share > 0.5 {
            return Brightness { sigma_mag, scatter_mag: sigma_mag, ..self.alone(magnitude, light.grey_reflectance) };
        }
        Brightness { magnitude, sigma_mag, scatter_mag, ..light }
    }

    /// Returns light that is mostly emission. Its errors are normal: there are no flares.
    fn alone(self, magnitude: Magnitude, grey_reflectance: bool) -> Brightness {
        Brightness {
            magnitude,
            sigma_mag: self.sigma_mag,
            scatter_mag: self.sigma_mag,
            error_distribution: ErrorDistribution::NORMAL,
            source: MagnitudeSource::Thermal,
            in_fitted_range: false,
            grey_reflectance,
        }
    }
}

/// Returns the infrared light of the Earth that a satellite reflects, as the emissivity of a satellite at 290 K.
fn of_earth(geometry: &ViewingGeometry) -> f64 {
    // Angle between the directions to the Earth's centre and to the observer.
    let phase_rad = geometry.observer_latitude_rad + FRAC_PI_2;
    // γ = 2 / (3π) (sin φ + (π - φ) cos φ)
    let gamma = 2.0 / (3.0 * PI) * (phase_rad.sin() + (PI - phase_rad) * phase_rad.cos());
    let dilution = EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + geometry.height_km.max(0.0));
    (1.0 - EMISSIVITY) * EMISSIVITY * gamma * dilution * dilution
}

#[cfg(test)]
mod tests {
    use super::super::band::{Band, MagSystem};
    use super::*;

    fn geometry(observer_deg: f64) -> ViewingGeometry {
        ViewingGeometry {
            sun_latitude_rad: -0.3,
            observer_latitude_rad: observer_deg.to_radians(),
            observer_longitude_rad: 1.0,
            range_km: 1000.0,
            height_km: 550.0,
            sun_distance_au: 1.0,
        }
    }

    fn options(band: Band, earthshine: Earthshine) -> PhotometryOptions {
        PhotometryOptions { earthshine, ..PhotometryOptions::in_band(band, MagSystem::Ab) }
    }

    /// Planck's law at the isophotal wavelengths of the bands, times the colour corrections of WISE for 280 K
    /// (interpolated in table 1 of Wright et al. 2010: 1.41 in W1, 1.12 in W2), for 0.9 * 10 m² at 1000 km.
    #[test]
    fn valid_emission_is_that_of_plancks_law_with_the_colour_corrections_of_wise() {
        /// Tolerance, mag: the colour corrections are relative to a spectrum ν⁻² (2 %) and interpolated (1 %), and the
        /// Sun's magnitudes are rounded to 0.01 mag.
        const COLOUR_MAG: f64 = 0.05;
        let size_m = (40.0 / PI).sqrt();
        for (band, wavelength_um, colour, zero_jy) in
            [(Band::W1, 3.3526, 1.41, 309.54), (Band::W2, 4.6028, 1.12, 171.787)]
        {
            // B = 2 h c / λ³ / (exp(h c / λ k T) - 1)
            let metres: f64 = wavelength_um * 1e-6;
            let planck = 2.0 * 6.626_070_15e-34 * 299_792_458.0
                / metres.powi(3)
                / (14_387.768_775 / (wavelength_um * 280.0)).exp_m1();
            let flux_jy = 0.9 * 10.0 * planck * colour / 1e12 * 1e26;
            let of_wise = -2.5 * (flux_jy / zero_jy).log10();
            let options = PhotometryOptions { system: MagSystem::Vega, ..options(band, Earthshine::Off) };
            let found = Emission::new(size_m, 0.0, &geometry(-90.0), &options).unwrap();
            // The zero points of Willmer differ from those of WISE.
            let zero = -2.5
                * (zero_jy
                    / (3631.0
                        * 10_f64
                            .powf(-0.4 * (band.sun_magnitude(MagSystem::Ab) - band.sun_magnitude(MagSystem::Vega)))))
                .log10();
            assert!((found.magnitude.0 - (of_wise - zero)).abs() < COLOUR_MAG, "{band}: {found:?} {}", of_wise - zero);
        }
        assert_eq!(Emission::new(4.0, 0.0, &geometry(-90.0), &options(Band::V, Earthshine::Computed)), None);
        assert_eq!(Emission::new(4.0, 0.0, &geometry(-90.0), &options(Band::H, Earthshine::Computed)), None);
    }

    #[test]
    fn the_earth_adds_most_light_below_the_satellite() {
        let magnitude = |observer_deg, earthshine| {
            Emission::new(4.0, 0.0, &geometry(observer_deg), &options(Band::W2, earthshine)).unwrap().magnitude.0
        };
        let gain =
            |observer_deg| magnitude(observer_deg, Earthshine::Off) - magnitude(observer_deg, Earthshine::Computed);
        // Full phase: 0.09 (2/3) (6378.137 / 6928.137)² 10^(0.4 * 0.404) / 0.9 = 0.0820, or 0.0856 mag
        assert!((gain(-90.0) - 0.0856).abs() < 1e-3, "{}", gain(-90.0));
        assert!(gain(90.0).abs() < 1e-12 && gain(0.0) > 0.02 && gain(0.0) < gain(-45.0));
    }

    #[test]
    fn light_and_sigma_of_both_are_between_those_of_each() {
        let emission = Emission { magnitude: Magnitude(5.0), sigma_mag: 1.2 };
        let reflected = |magnitude| Brightness {
            magnitude: Magnitude(magnitude),
            sigma_mag: 0.4,
            scatter_mag: 0.3,
            error_distribution: ErrorDistribution::SATELLITES,
            source: MagnitudeSource::Prior,
            in_fitted_range: true,
            grey_reflectance: true,
        };
        let equal = emission.with_reflection(Some(reflected(5.0)), 0.0);
        assert!(
            (equal.magnitude.0 - (5.0 - 0.752_575)).abs() < 1e-6
                && (equal.sigma_mag - 0.6_f64.hypot(0.2)).abs() < 1e-12
        );
        let faint = emission.with_reflection(Some(reflected(0.0)), 0.0);
        assert!(
            faint.source == MagnitudeSource::Prior && faint.in_fitted_range && (faint.sigma_mag - 0.4).abs() < 0.01
        );
        let bright = emission.with_reflection(Some(reflected(9.0)), 0.0);
        assert!(bright.source == MagnitudeSource::Thermal && bright.magnitude.0 < 5.0 && bright.sigma_mag > 1.1);
        let dark = emission.with_reflection(None, 0.2);
        assert!((dark.probability_brighter_than(5.2) - 0.5).abs() < 1e-9);
        assert_eq!((dark.magnitude.0, dark.sigma_mag, dark.source), (5.2, 1.2, MagnitudeSource::Thermal));
    }
}
