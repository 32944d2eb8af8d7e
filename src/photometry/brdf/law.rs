//! Trait of all reflection laws, the cosines on which they depend, and the lobe that three laws share.

use std::f64::consts::TAU;

use nalgebra::Vector3;

/// A bidirectional reflectance distribution function.
///
/// Conventions for all laws: values are in sr⁻¹ and do *not* contain the cosines of projection (a panel multiplies by
/// these cosines and by its area). Light arrives and leaves on the same side of the surface. A law depends on
/// directions only through [`Incidence`]. The value is defined for any incidence, because panels skip faces that are
/// not lit.
pub trait Brdf {
    /// Returns the reflectance for this incidence, sr⁻¹, at least 0.
    fn value_per_sr(&self, incidence: &Incidence) -> f64;
}

/// The cosines on which reflection laws and projection depend.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Incidence {
    /// Cosine between the normal and the source; negative if the source is behind.
    pub cos_in: f64,
    /// Cosine between the normal and the observer; negative if the observer is behind.
    pub cos_out: f64,
    /// Cosine between the observer and the mirror direction of the source, cos θ in Lu (2024).
    pub cos_mirror: f64,
}

impl Incidence {
    /// Computes the cosines from unit vectors in the same frame; the vectors to source and observer point away from the
    /// panel.
    pub fn new(normal: &Vector3<f64>, to_source: &Vector3<f64>, to_observer: &Vector3<f64>) -> Self {
        let cos_in = normal.dot(to_source);
        let cos_out = normal.dot(to_observer);
        // m = 2 (n · s) n - s, cos θ = m · o
        Self { cos_in, cos_out, cos_mirror: 2.0 * cos_in * cos_out - to_source.dot(to_observer) }
    }

    /// Returns the cosine of the phase angle, s · o, between source and observer.
    pub fn cos_phase(&self) -> f64 {
        // cos θ = 2 cos φ_i cos φ_r - s · o
        2.0 * self.cos_in * self.cos_out - self.cos_mirror
    }

    /// Returns ρ·ρ₀ for the observer's direction and the mirror direction projected onto the surface, in [-1, 1]. With
    /// the components s_t and o_t, along the surface, of the unit vectors to source and observer, ρ₀ = -s_t and ρ =
    /// o_t.
    pub fn sine_product(&self) -> f64 {
        // s · o = s_t · o_t + cos φ_i cos φ_r and cos θ = 2 cos φ_i cos φ_r - s · o
        self.cos_mirror - self.cos_in * self.cos_out
    }

    /// Returns |ρ - ρ₀|² for the observer's direction and the mirror direction projected onto the surface, in [0, 4].
    /// It is 0 in the mirror direction.
    pub fn sine_distance_squared(&self) -> f64 {
        // |ρ|² + |ρ₀|² - 2 ρ·ρ₀; rounding must not make it negative
        (2.0 - self.cos_in.powi(2) - self.cos_out.powi(2) - 2.0 * self.sine_product()).max(0.0)
    }

    /// Returns the incidence with front and back of the panel exchanged.
    pub fn from_behind(&self) -> Self {
        Self { cos_in: -self.cos_in, cos_out: -self.cos_out, cos_mirror: self.cos_mirror }
    }

    /// Returns cos φ_i cos φ_r for a face that is lit and seen from the front; 0 if source or observer is behind it.
    pub fn front(&self) -> f64 {
        self.cos_in.max(0.0) * self.cos_out.max(0.0)
    }
}

/// Returns the peak, sr⁻¹, of the lobe that the laws `phong`, `straight` and `retro` share; they differ in the axis of
/// the lobe.
pub(super) fn lobe_peak_per_sr(weight: f64, exponent: f64) -> f64 {
    // c (n + 2) / 2π                                                     Lu (2024), eq. 2
    weight * (exponent + 2.0) / TAU
}

/// Returns the value of the lobe, sr⁻¹, where `cosine` is the cosine of the angle to the axis; 0 beyond 90°.
pub(super) fn lobe_per_sr(weight: f64, exponent: f64, cosine: f64) -> f64 {
    // For a weight of 0, `powf` is not evaluated. At and beyond 90° the lobe is 0 even for an exponent of 0, for which
    // `powf` returns 1.
    if weight == 0.0 || cosine <= 0.0 {
        return 0.0;
    }
    // f = c (n + 2) / 2π · cosⁿθ                                         Lu (2024), eq. 2
    lobe_peak_per_sr(weight, exponent) * cosine.powf(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_mirror_direction() {
        let normal = Vector3::new(0.6, 0.0, 0.8);
        let to_sun = Vector3::new(0.0, 0.28, 0.96);
        let mirror = normal * (2.0 * normal.dot(&to_sun)) - to_sun;
        assert!((Incidence::new(&normal, &to_sun, &mirror).cos_mirror - 1.0).abs() < 1e-15);
    }

    #[test]
    fn verif_front_is_dark_where_source_or_observer_is_behind() {
        let (above, below) = (Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.6, 0.0, -0.8));
        let front = |to_sun, to_observer| Incidence::new(&Vector3::z(), &to_sun, &to_observer).front();
        assert!((front(above, above) - 0.64).abs() < 1e-15);
        assert_eq!([front(below, above), front(above, below), front(below, below)], [0.0; 3]);
    }
}
