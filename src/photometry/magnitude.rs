//! Apparent magnitudes, and magnitudes at a range of 1000 km, as separate types.

use std::fmt;

/// Range to which standard magnitudes refer, km (d in Lu 2024).
pub const STANDARD_RANGE_KM: f64 = 1000.0;

/// Largest reflection, m² sr⁻¹, that can be caused by the rounding of a cosine of 0 (1e-16 times a square metre, with a
/// margin).
const LEAST_REFLECTION_M2_SR: f64 = 1e-12;

/// Apparent magnitude at the observer; smaller is brighter.
#[derive(Copy, Clone, Debug, PartialEq, PartialOrd)]
pub struct Magnitude(pub f64);

/// Magnitude that the same satellite would have at a range of 1000 km; smaller is brighter.
#[derive(Copy, Clone, Debug, PartialEq, PartialOrd)]
pub struct StandardMagnitude(pub f64);

impl Magnitude {
    /// Converts a magnitude at `range_km` (positive) to one at 1000 km.
    pub fn to_standard(self, range_km: f64) -> StandardMagnitude {
        StandardMagnitude(self.0 - range_modulus_mag(range_km))
    }

    /// Returns the magnitude dimmed by `mag`; a negative value brightens it.
    pub fn dimmed_by(self, mag: f64) -> Self {
        Self(self.0 + mag)
    }
}

impl StandardMagnitude {
    /// Returns the apparent magnitude at `range_km` (positive).
    pub fn at_range(self, range_km: f64) -> Magnitude {
        Magnitude(self.0 + range_modulus_mag(range_km))
    }

    /// Returns the magnitude of a reflection B (m² sr⁻¹, cosines and areas included), given the apparent magnitude of
    /// the Sun.
    ///
    /// `None` if B is not above 1e-12 m² sr⁻¹ (33 mag at 1000 km). No lit surface is then visible, and B is a rounding
    /// error of a cosine that should be 0.
    pub fn from_reflection(b_total_m2_sr: f64, sun_magnitude: f64) -> Option<Self> {
        // m(1000 km) = -2.5 log10(B_total / d²) + m_sun, d = 10⁶ m       Lu (2024), eqs. 19-21
        let range_m = STANDARD_RANGE_KM * 1000.0;
        (b_total_m2_sr > LEAST_REFLECTION_M2_SR && b_total_m2_sr.is_finite())
            .then(|| Self(-2.5 * (b_total_m2_sr / (range_m * range_m)).log10() + sun_magnitude))
    }
}

impl fmt::Display for Magnitude {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

impl fmt::Display for StandardMagnitude {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

/// Returns the magnitude at a range minus the magnitude at 1000 km.
fn range_modulus_mag(range_km: f64) -> f64 {
    // m = m(1000 km) + 5 log10(r / 1000 km)                              Lu (2024), eq. 14
    5.0 * (range_km / STANDARD_RANGE_KM).log10()
}

/// Returns the relative airmass at a true (unrefracted) altitude, 1 at the zenith; `None` on and below the horizon.
///
/// Young (1994, Applied Optics 33, 1108). It agrees with the standard atmosphere within 0.0037 airmasses down to the
/// horizon.
pub fn airmass(altitude_rad: f64) -> Option<f64> {
    let c = altitude_rad.sin();
    // X = (1.002432 cos²z + 0.148386 cos z + 0.0096467) / (cos³z + 0.149864 cos²z + 0.0102963 cos z + 0.000303978)
    (c > 0.0)
        .then(|| ((1.002432 * c + 0.148386) * c + 0.0096467) / (((c + 0.149864) * c + 0.0102963) * c + 0.000303978))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance, mag: rounding of a few operations on numbers near 10.
    const ROUNDING_MAG: f64 = 1e-12;

    #[test]
    fn verif_standard_magnitude_round_trip() {
        for range_km in [300.0, 550.0, 1000.0, 1999.0, 36_000.0] {
            let there = StandardMagnitude(6.34).at_range(range_km);
            assert!((there.to_standard(range_km).0 - 6.34).abs() < ROUNDING_MAG);
        }
        // 550 km is 1.298 mag nearer than 1000 km.
        assert!((StandardMagnitude(6.0).at_range(550.0).0 - 4.701_813_4).abs() < 1e-7);
    }

    #[test]
    fn verif_reflection_of_one_square_metre_per_steradian() {
        // B = 1 m²/sr at 10⁶ m: -2.5 log10(10⁻¹²) = 30 mag fainter than the Sun.
        let magnitude = StandardMagnitude::from_reflection(1.0, -26.76).unwrap();
        assert!((magnitude.0 - 3.24).abs() < ROUNDING_MAG);
        for nothing in [0.0, 1e-15, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(StandardMagnitude::from_reflection(nothing, -26.76), None);
        }
    }

    #[test]
    fn valid_airmass_against_the_plane_parallel_law_and_the_horizon_value() {
        assert!((airmass(std::f64::consts::FRAC_PI_2).unwrap() - 1.0).abs() < 1e-4);
        assert!((airmass(30_f64.to_radians()).unwrap() - 2.0).abs() < 0.01);
        // Young (1994) gives 31.7 at the true horizon.
        assert!((airmass(1e-9).unwrap() - 31.7).abs() < 0.05);
        assert_eq!(airmass(0.0), None);
        assert_eq!(airmass(-0.1), None);
    }
}
