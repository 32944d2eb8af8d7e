//! Bands that are given by a response curve: the Sun's magnitude and that of a black body, by integration over the
//! curve.

use std::hash::{Hash, Hasher};

/// Planck's constant, J s; speed of light, m/s; Boltzmann's constant, J/K (CODATA 2018).
const PLANCK_J_S: f64 = 6.626_070_15e-34;
const LIGHT_M_S: f64 = 299_792_458.0;
const BOLTZMANN_J_K: f64 = 1.380_649e-23;

/// Flux density of magnitude 0 in the AB system, W m⁻² Hz⁻¹.
const AB_ZERO: f64 = 3631e-26;

/// Temperatures of the black bodies in a band, K.
const TEMPERATURES_K: [f64; 2] = [280.0, 290.0];

/// Magnitude of 1 m² of a diffuse sphere at 1000 km, less that of the Sun: p A γ / (π d²) with the albedo p = 0.25, and
/// γ = 2 / (3π) at a phase angle of 90°.
pub(super) const DIFFUSE_LESS_SUN_MAG: f64 = 34.43;

/// Magnitude of the full Moon less that of the Sun: -12.7 and -26.8 in V.
const FULL_MOON_LESS_SUN_MAG: f64 = 14.0;

/// Largest relative step of the wavelength in the integrals.
const STEP: f64 = 0.002;

/// Spectral irradiance of the Sun at 1 au: wavelength, µm, and W m⁻² µm⁻¹. ASTM E490-00a (2014), at low resolution;
/// beyond 20 µm as λ⁻⁴, because its next value, at 50 µm, is four times as large.
const SUN: [(f64, f64); 70] = [
    (0.25, 59.81),
    (0.26, 129.1),
    (0.27, 222.1),
    (0.28, 212.9),
    (0.29, 441.0),
    (0.3, 526.0),
    (0.31, 634.5),
    (0.32, 746.5),
    (0.33, 948.7),
    (0.34, 947.3),
    (0.35, 969.5),
    (0.36, 985.2),
    (0.37, 1129.0),
    (0.38, 1091.0),
    (0.39, 1093.0),
    (0.4, 1518.0),
    (0.41, 1712.0),
    (0.42, 1740.0),
    (0.43, 1625.0),
    (0.44, 1826.0),
    (0.45, 2030.0),
    (0.46, 2077.0),
    (0.47, 2049.0),
    (0.48, 2057.0),
    (0.49, 1955.0),
    (0.5, 1948.0),
    (0.51, 1911.0),
    (0.52, 1806.0),
    (0.53, 1861.0),
    (0.54, 1861.0),
    (0.55, 1867.0),
    (0.56, 1808.0),
    (0.57, 1797.0),
    (0.58, 1801.0),
    (0.59, 1758.0),
    (0.6, 1745.0),
    (0.62, 1663.0),
    (0.64, 1610.0),
    (0.66, 1527.0),
    (0.68, 1485.0),
    (0.7, 1438.0),
    (0.72, 1360.0),
    (0.75, 1272.0),
    (0.8, 1132.0),
    (0.9, 882.6),
    (1.0, 719.7),
    (1.2, 487.1),
    (1.4, 342.5),
    (1.6, 243.5),
    (1.8, 167.1),
    (2.0, 115.0),
    (2.2, 81.73),
    (2.4, 58.78),
    (2.6, 43.86),
    (2.8, 33.43),
    (3.0, 25.93),
    (3.2, 20.45),
    (3.4, 16.36),
    (3.6, 13.26),
    (3.8, 10.87),
    (4.0, 8.977),
    (4.5, 5.674),
    (5.0, 3.691),
    (6.0, 1.879),
    (7.0, 1.022),
    (8.0, 0.6041),
    (10.0, 0.2663),
    (15.0, 0.06106),
    (20.0, 0.01755),
    (50.0, 0.000449),
];

/// Band with a response curve. Its magnitudes are AB. Two bands are equal if their numbers are the same.
#[derive(Copy, Clone, Debug)]
pub struct ResponseBand {
    sun_mag: f64,
    black_body_mag: [f64; 2],
    wavelength_um: f64,
}

impl ResponseBand {
    /// Range of the wavelengths of a response curve, µm.
    pub const WAVELENGTHS_UM: [f64; 2] = [SUN[0].0, SUN[SUN.len() - 1].0];

    /// Creates the band of a curve: wavelength, µm, and relative response (detected electrons for each photon above the
    /// atmosphere), which is interpolated linearly. `None` if there are fewer than two points, the wavelengths do not
    /// increase or are not from 0.25 to 50 µm, or a response is negative, not finite, or zero everywhere.
    pub fn from_curve(curve: &[(f64, f64)]) -> Option<Self> {
        let [least, most] = Self::WAVELENGTHS_UM;
        let is_valid = |&(wavelength_um, response): &(f64, f64)| {
            (least..=most).contains(&wavelength_um) && response >= 0.0 && response.is_finite()
        };
        let increases = curve.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if !(increases && curve.iter().all(is_valid)) {
            return None;
        }
        let photons = integral(curve, |wavelength_um| 1.0 / wavelength_um);
        if photons.is_nan() || photons <= 0.0 {
            return None;
        }
        // <F_ν> = ∫ F_ν R dλ/λ / ∫ R dλ/λ
        let ab = |flux: &dyn Fn(f64) -> f64| {
            let mean = integral(curve, |wavelength_um| flux(wavelength_um) / wavelength_um) / photons;
            -2.5 * (mean / AB_ZERO).log10()
        };
        // A black body of 1 m² at 10⁶ m covers 10⁻¹² sr.
        let black_body = |kelvin: f64| ab(&|wavelength_um| 1e-12 * planck(wavelength_um, kelvin));
        Some(Self {
            sun_mag: ab(&sun),
            black_body_mag: TEMPERATURES_K.map(black_body),
            // Pivot wavelength: λ² = ∫ R λ dλ / ∫ R dλ/λ
            wavelength_um: (integral(curve, |wavelength_um| wavelength_um) / photons).sqrt(),
        })
    }

    /// Returns the AB magnitude of the Sun at 1 au.
    pub(super) fn sun_mag(&self) -> f64 {
        self.sun_mag
    }

    /// Returns the AB magnitudes of 1 m² of a black body at 280 K and 290 K, at 1000 km; `None` if the full Moon's
    /// light on a diffuse body outshines them.
    pub(super) fn black_body_mag(&self) -> Option<[f64; 2]> {
        let faintest = self.sun_mag + DIFFUSE_LESS_SUN_MAG + FULL_MOON_LESS_SUN_MAG;
        (self.black_body_mag[0] < faintest).then_some(self.black_body_mag)
    }

    /// Returns the pivot wavelength, µm.
    pub(super) fn wavelength_um(&self) -> f64 {
        self.wavelength_um
    }

    fn bits(&self) -> [u64; 4] {
        let [cold, warm] = self.black_body_mag;
        [self.sun_mag, cold, warm, self.wavelength_um].map(f64::to_bits)
    }
}

impl PartialEq for ResponseBand {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl Eq for ResponseBand {}

impl Hash for ResponseBand {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.bits().hash(state);
    }
}

/// Returns the integral of the response times a function over the wavelength.
fn integral(curve: &[(f64, f64)], of: impl Fn(f64) -> f64) -> f64 {
    let piece = |pair: &[(f64, f64)]| {
        let ((from, low), (to, high)) = (pair[0], pair[1]);
        let steps = ((to / from).ln() / STEP).ceil().max(1.0);
        let width = (to - from) / steps;
        let middle = |step: u32| {
            let share = (f64::from(step) + 0.5) / steps;
            (low + (high - low) * share) * of(from + (to - from) * share) * width
        };
        (0..steps as u32).map(middle).sum::<f64>()
    };
    curve.windows(2).map(piece).sum()
}

/// Returns the spectral radiance of a black body, W m⁻² Hz⁻¹ sr⁻¹.
fn planck(wavelength_um: f64, kelvin: f64) -> f64 {
    // B_ν = 2 h ν³ / c² / (exp(h ν / k T) - 1)
    let frequency_hz = LIGHT_M_S / (wavelength_um * 1e-6);
    2.0 * PLANCK_J_S * frequency_hz.powi(3)
        / LIGHT_M_S.powi(2)
        / (PLANCK_J_S * frequency_hz / (BOLTZMANN_J_K * kelvin)).exp_m1()
}

/// Returns the flux density of the Sun at 1 au, W m⁻² Hz⁻¹, for a wavelength in the range of the table.
fn sun(wavelength_um: f64) -> f64 {
    let next = SUN.partition_point(|(table_um, _)| *table_um <= wavelength_um).clamp(1, SUN.len() - 1);
    let ((from, low), (to, high)) = (SUN[next - 1], SUN[next]);
    let share = (wavelength_um / from).ln() / (to / from).ln();
    // Between the points the spectrum is a power law. F_ν = F_λ λ² / c, with F_λ per metre
    let per_um = low * (high / low).powf(share);
    per_um * 1e6 * (wavelength_um * 1e-6).powi(2) / LIGHT_M_S
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A narrow band, µm.
    fn narrow(wavelength_um: f64) -> ResponseBand {
        ResponseBand::from_curve(&[(0.999 * wavelength_um, 1.0), (1.001 * wavelength_um, 1.0)]).unwrap()
    }

    #[test]
    fn valid_narrow_bands_against_willmer_and_plancks_law() {
        /// Tolerance, mag: lines and slopes of the Sun's spectrum inside the bands, and its low resolution.
        const SUN_MAG: f64 = 0.08;
        // Pivot wavelengths and AB magnitudes of V, J, H, Ks, W1 and W2.
        for (wavelength_um, expected) in
            [(0.551, -26.77), (1.239, -27.03), (1.650, -26.91), (2.164, -26.49), (3.390, -25.66), (4.641, -25.00)]
        {
            let found = narrow(wavelength_um).sun_mag();
            assert!((found - expected).abs() < SUN_MAG, "{wavelength_um}: {found} {expected}");
        }
        // B_ν(20 µm, 280 K) = 2 h c / λ³ / (exp(14387.77 / 5600) - 1) = 4.117e-12 W m⁻² Hz⁻¹ sr⁻¹
        let found = narrow(20.0).black_body_mag().unwrap()[0];
        assert!((found - -2.5 * (4.117e-12 * 1e-12 / AB_ZERO).log10()).abs() < 1e-3, "{found}");
        assert_eq!(narrow(1.65).black_body_mag(), None);
        assert!(narrow(2.2).black_body_mag().is_some() && (narrow(20.0).wavelength_um() - 20.0).abs() < 1e-4);
    }

    /// The figure `magnitude_vs_size_wave` of SPARKLES (Borlaff et al.), read at 100 m²: surface brightness of trails
    /// in AB, of which the differences between wavelengths do not depend on distance, telescope and exposure.
    #[test]
    fn valid_thermal_colours_are_those_of_sparkles() {
        /// Tolerance, mag: that of the acceptance; the figure is read to 0.2 mag.
        const FIGURE_MAG: f64 = 0.5;
        let emitted = |wavelength_um: f64| narrow(wavelength_um).black_body_mag().unwrap()[0];
        for (wavelength_um, in_figure) in [(5.0, 19.18), (7.0, 17.11), (10.0, 16.02), (49.9, 16.17)] {
            let found = emitted(wavelength_um) - emitted(20.0);
            assert!((found - (in_figure - 15.3)).abs() < FIGURE_MAG, "{wavelength_um}: {found}");
        }
    }

    #[test]
    fn curves_must_increase_and_be_positive() {
        for curve in [
            &[(1.0, 1.0)][..],
            &[(1.0, 1.0), (1.0, 1.0)],
            &[(2.0, 1.0), (1.0, 1.0)],
            &[(0.2, 1.0), (1.0, 1.0)],
            &[(1.0, 1.0), (51.0, 1.0)],
            &[(1.0, 0.0), (2.0, 0.0)],
            &[(1.0, -1.0), (2.0, 2.0)],
            &[(1.0, f64::NAN), (2.0, 2.0)],
            &[(f64::NAN, 1.0), (2.0, 2.0)],
        ] {
            assert_eq!(ResponseBand::from_curve(curve), None, "{curve:?}");
        }
        assert_eq!(narrow(5.0), narrow(5.0));
        assert_ne!(narrow(5.0), narrow(5.1));
    }
}
