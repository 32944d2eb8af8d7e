//! A flat panel: light in, light out, and the cosines between.

use nalgebra::Vector3;

use super::brdf::Brdf;

/// The cosines that laws of reflection and projection depend on.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Incidence {
    /// Between the normal and the source; negative where the source stands behind.
    pub cos_in: f64,
    /// Between the normal and the observer; negative where it stands behind.
    pub cos_out: f64,
    /// Between the observer and the mirror direction of the source, cos θ of the paper.
    pub cos_mirror: f64,
}

impl Incidence {
    /// From unit vectors in one frame, both pointing away from the panel.
    pub fn new(normal: &Vector3<f64>, to_source: &Vector3<f64>, to_observer: &Vector3<f64>) -> Self {
        let cos_in = normal.dot(to_source);
        let cos_out = normal.dot(to_observer);
        // m = 2 (n · s) n - s, cos θ = m · o
        Self { cos_in, cos_out, cos_mirror: 2.0 * cos_in * cos_out - to_source.dot(to_observer) }
    }

    /// Between the source and the observer: the cosine of the phase angle, s · o.
    pub fn cos_phase(&self) -> f64 {
        // cos θ = 2 cos φ_i cos φ_r - s · o
        2.0 * self.cos_in * self.cos_out - self.cos_mirror
    }

    /// ρ·ρ₀ of observer and mirror direction laid on the surface, in [-1, 1]: with s and o the sources' and observer's
    /// unit vectors and t their parts along the surface, ρ₀ = -s_t and ρ = o_t.
    pub fn sine_product(&self) -> f64 {
        // s · o = s_t · o_t + cos φ_i cos φ_r and cos θ = 2 cos φ_i cos φ_r - s · o
        self.cos_mirror - self.cos_in * self.cos_out
    }

    /// |ρ - ρ₀|² of observer and mirror direction laid on the surface, in [0, 4]: 0 in the mirror direction.
    pub fn sine_distance_squared(&self) -> f64 {
        // |ρ|² + |ρ₀|² - 2 ρ·ρ₀; rounding must not make it negative
        (2.0 - self.cos_in.powi(2) - self.cos_out.powi(2) - 2.0 * self.sine_product()).max(0.0)
    }

    /// The same panel seen as if its back were its front.
    pub fn from_behind(&self) -> Self {
        Self { cos_in: -self.cos_in, cos_out: -self.cos_out, cos_mirror: self.cos_mirror }
    }

    /// cos φ_i cos φ_r of a face that is lit and seen from the front; 0 where either stands behind.
    pub fn front(&self) -> f64 {
        self.cos_in.max(0.0) * self.cos_out.max(0.0)
    }

    /// cos φ_i cos(π - φ_r) of a panel lit from the front and seen from behind; 0 elsewhere.
    pub fn through(&self) -> f64 {
        self.cos_in.max(0.0) * (-self.cos_out).max(0.0)
    }
}

/// A flat panel of one area and one normal.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Panel {
    /// Area of one side, m².
    pub area_m2: f64,
    /// Unit normal of the front, in the body frame.
    pub normal: Vector3<f64>,
}

impl Panel {
    /// How this panel stands to a source and an observer.
    pub fn incidence(&self, to_source: &Vector3<f64>, to_observer: &Vector3<f64>) -> Incidence {
        Incidence::new(&self.normal, to_source, to_observer)
    }

    /// Light that the front sends to an observer in front, m² sr⁻¹: f cos φ_i cos φ_r A.
    pub fn front_m2_sr(&self, law: &impl Brdf, incidence: &Incidence) -> f64 {
        let projection = incidence.front();
        // The powers of a dark panel need not be raised.
        if projection > 0.0 { law.value_per_sr(incidence) * projection * self.area_m2 } else { 0.0 }
    }

    /// Light that comes through to an observer behind, m² sr⁻¹: f cos φ_i cos(π - φ_r) A.
    pub fn through_m2_sr(&self, law: &impl Brdf, incidence: &Incidence) -> f64 {
        let projection = incidence.through();
        if projection > 0.0 { law.value_per_sr(incidence) * projection * self.area_m2 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::brdf::{Lambert, Phong};

    #[test]
    fn verif_front_is_black_from_behind_and_unlit_from_behind() {
        let panel = Panel { area_m2: 2.0, normal: Vector3::z() };
        let (above, below) = (Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.6, 0.0, -0.8));
        let glossy = Phong { weight: 0.5, exponent: 3.0 };
        let diffuse = Lambert { albedo: 0.5 };
        for (to_sun, to_observer) in [(below, above), (above, below), (below, below)] {
            let incidence = panel.incidence(&to_sun, &to_observer);
            assert_eq!(panel.front_m2_sr(&glossy, &incidence), 0.0);
            assert_eq!(panel.front_m2_sr(&diffuse, &incidence), 0.0);
        }
        let lit = panel.incidence(&above, &above);
        assert!(panel.front_m2_sr(&glossy, &lit) > 0.0 && panel.front_m2_sr(&diffuse, &lit) > 0.0);
        // Through: lit from the front, seen from behind, and no other way.
        assert!(panel.through_m2_sr(&diffuse, &panel.incidence(&above, &below)) > 0.0);
        for (to_sun, to_observer) in [(below, above), (above, above), (below, below)] {
            assert_eq!(panel.through_m2_sr(&diffuse, &panel.incidence(&to_sun, &to_observer)), 0.0);
        }
    }

    #[test]
    fn verif_mirror_direction() {
        let panel = Panel { area_m2: 1.0, normal: Vector3::new(0.6, 0.0, 0.8) };
        let to_sun = Vector3::new(0.0, 0.28, 0.96);
        let mirror = panel.normal * (2.0 * panel.normal.dot(&to_sun)) - to_sun;
        assert!((panel.incidence(&to_sun, &mirror).cos_mirror - 1.0).abs() < 1e-15);
    }
}
