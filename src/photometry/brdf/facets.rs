//! A rough mirror: small facets with a Gaussian distribution of slopes, which hide and shade each other.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `weight` | 1 | 0 and up | reflectance of a facet, the same at every angle; 1 is lossless |
//! | `slope` | 1 | 0.001 to 1 | rms slope of the facets along one axis: 0.1 tilts them by 5.7° |
//!
//! Each facet is a small mirror. Light reaches the observer from the facets whose normal is half way between the
//! directions of source and observer. Unlike Phong's lobe, this lobe becomes elongated towards grazing incidence, and
//! its peak moves beyond the mirror direction (to 65° for a mirror direction of 60° and a slope of 0.1). Only the light
//! that would meet a second facet is lost. The reflected fraction is at most `weight` at any incidence, and nearly
//! `weight` for slopes below 0.1 except near grazing incidence. The law is reciprocal, and 0 if source or observer is
//! behind the surface.
//!
//! Neglected are Fresnel's increase towards grazing incidence (`weight` is the reflectance of a metal, which changes
//! little with angle), light reflected by a second facet, and diffraction.
//!
//! Reference: Torrance and Sparrow (1967), J. Opt. Soc. Am. 57, 1105; slopes of Beckmann and Spizzichino (1963), *The
//! scattering of electromagnetic waves from rough surfaces*; masking of Smith (1967), IEEE Trans. Antennas Propag. 15,
//! 668, as in Walter et al. (2007), *Microfacet models for refraction through rough surfaces*, eqs. 20, 23, 25 and 26,
//! whose width α is √2 times our slope.

use std::f64::consts::{FRAC_2_PI, SQRT_2, TAU};

use super::law::{Brdf, Incidence};

/// Square of the cosine below which no facet with an allowed slope exists: the density e^(-tan²β/2w²) is 0 in double
/// precision, and the half-way direction is undefined if source and observer are in opposite directions.
const LEAST_COS_SQUARED: f64 = 1e-6;

/// Rough mirror of small facets.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Facets {
    /// Reflectance of a facet.
    pub weight: f64,
    /// Root mean square slope along one axis.
    pub slope: f64,
}

impl Facets {
    /// Returns the density of facets per solid angle of their normals, sr⁻¹. `cos_squared` is the square of the cosine
    /// of the angle β between the normals of facet and panel.
    fn density_per_sr(&self, cos_squared: f64) -> f64 {
        if cos_squared < LEAST_COS_SQUARED {
            return 0.0;
        }
        // D = exp(-tan²β / 2w²) / (2π w² cos⁴β)                          Walter et al. (2007), eq. 25
        let (tan_squared, variance) = (1.0 / cos_squared - 1.0, self.slope * self.slope);
        (-0.5 * tan_squared / variance).exp() / (TAU * variance * cos_squared * cos_squared)
    }

    /// Returns the fraction of facets that are visible (or lit) from a direction, divided by the cosine between this
    /// direction and the normal. It is finite at grazing incidence, where both are 0.
    pub(in crate::photometry) fn seen_per_cosine(&self, cosine: f64) -> f64 {
        // G₁ = 2 / (1 + erf a + e^(-a²) / (a √π)), a = cot θ / (√2 w)    Walter et al. (2007), eq. 26
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let a = cosine / (SQRT_2 * self.slope * sine);
        // cos θ / (a √π) = w sin θ √(2/π)
        2.0 / (cosine * (1.0 + libm::erf(a)) + self.slope * sine * FRAC_2_PI.sqrt() * (-a * a).exp())
    }
}

impl Brdf for Facets {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        let Incidence { cos_in, cos_out, .. } = *incidence;
        if self.weight == 0.0 || cos_in < 0.0 || cos_out < 0.0 {
            return 0.0;
        }
        // h = (s + o) / |s + o|, cos β = n · h = (cos φ_i + cos φ_r) / √(2 + 2 s · o)
        let square = 2.0 + 2.0 * incidence.cos_phase();
        let cos_squared = if square > 0.0 { ((cos_in + cos_out).powi(2) / square).min(1.0) } else { 0.0 };
        // f = c D G₁(s) G₁(o) / (4 cos φ_i cos φ_r)                      Walter et al. (2007), eqs. 20 and 23
        let seen = self.seen_per_cosine(cos_in) * self.seen_per_cosine(cos_out);
        0.25 * self.weight * self.density_per_sr(cos_squared) * seen
    }
}

#[cfg(test)]
mod tests {
    use super::super::energy::{check_law, reflected_share};
    use super::*;
    use nalgebra::Vector3;

    const SLOPES: [f64; 4] = [0.02, 0.1, 0.4, 1.0];

    fn at_degrees(longitude: f64, zenith: f64) -> Vector3<f64> {
        let (sin, cos) = zenith.to_radians().sin_cos();
        Vector3::new(sin * longitude.cos(), sin * longitude.sin(), cos)
    }

    /// The facets visible from a direction cover the projected panel: ∫ D G₁ (o · m)⁺ dω_m = cos φ_r.
    #[test]
    fn verif_facets_seen_cover_the_panel() {
        for slope in SLOPES {
            let law = Facets { weight: 1.0, slope };
            for zenith in [0.0_f64, 30.0, 60.0, 80.0, 88.0] {
                let eye = at_degrees(0.0, zenith);
                let (n_tan, n_azimuth) = (4000, 720);
                let mut sum = 0.0;
                for i in 0..n_tan {
                    // tan β = t to 8 slopes, dω = cos³β t dt dψ
                    let step = 8.0 * slope / f64::from(n_tan);
                    let t = (f64::from(i) + 0.5) * step;
                    let cos = 1.0 / (1.0 + t * t).sqrt();
                    let ring: f64 = (0..n_azimuth)
                        .map(|j| {
                            let psi = (f64::from(j) + 0.5) * TAU / f64::from(n_azimuth);
                            (eye.z * cos + eye.x * t * cos * psi.cos()).max(0.0)
                        })
                        .sum();
                    sum += law.density_per_sr(cos * cos) * ring * cos.powi(3) * t * step * TAU / f64::from(n_azimuth);
                }
                // Midpoint rule in 4000 rings, with a kink where facets turn away.
                let covered = sum * law.seen_per_cosine(eye.z);
                assert!((covered - 1.0).abs() < 1e-4, "slope {slope}, {zenith}°: {covered}");
            }
        }
    }

    #[test]
    fn verif_energy_is_at_most_the_weight() {
        for slope in SLOPES {
            let law = Facets { weight: 0.8, slope };
            for cos_in in [1.0, 0.8, 0.5, 0.2, 0.05, 0.01] {
                let share = reflected_share(&law, cos_in);
                assert!(share < 0.8 * 1.001 && share > 0.0, "slope {slope}, cosine {cos_in}: {share}");
            }
        }
        for cos_in in [1.0, 0.7] {
            let share = reflected_share(&Facets { weight: 0.8, slope: 0.02 }, cos_in);
            assert!((share - 0.8).abs() < 8e-4, "{cos_in}: {share}");
        }
    }

    #[test]
    fn verif_peak_and_half_width_under_light_along_the_normal() {
        let law = Facets { weight: 0.5, slope: 0.01 };
        let normal = Vector3::z();
        let at = |zenith: f64| law.value_per_sr(&Incidence::new(&normal, &normal, &at_degrees(0.3, zenith)));
        // c / (8π w²)
        let peak = 0.5 / (4.0 * TAU * 1e-4);
        assert!((at(0.0) / peak - 1.0).abs() < 1e-12);
        // At half maximum the facet is tilted by √(2 ln 2) w, and the light is deflected by twice this angle.
        let half = (2.0 * 0.01 * (2.0 * std::f64::consts::LN_2).sqrt()).to_degrees();
        assert!((at(half) / peak - 0.5).abs() < 1e-3, "{}", at(half) / peak);
    }

    /// The off-specular peak explained by Torrance and Sparrow: 65.1° for a mirror direction of 60°.
    #[test]
    fn verif_peak_lies_beyond_the_mirror_direction_at_slant_incidence() {
        let law = Facets { weight: 1.0, slope: 0.1 };
        let (normal, light) = (Vector3::z(), at_degrees(0.0, 60.0));
        let at =
            |zenith: f64| law.value_per_sr(&Incidence::new(&normal, &light, &at_degrees(std::f64::consts::PI, zenith)));
        let brightest = (0..900).map(|i| f64::from(i) * 0.1).max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap();
        assert!(brightest > 63.0 && brightest < 68.0, "{brightest}");
    }

    #[test]
    fn verif_dark_from_behind_and_finite_at_grazing() {
        let normal = Vector3::z();
        for slope in [1e-3, 0.1, 1.0] {
            let law = Facets { weight: 1.0, slope };
            let at = |light: f64, eye: f64| {
                let (light, eye) = (at_degrees(0.0, light), at_degrees(std::f64::consts::PI, eye));
                law.value_per_sr(&Incidence::new(&normal, &light, &eye))
            };
            for (light, eye) in [(100.0, 30.0), (30.0, 100.0), (150.0, 120.0)] {
                assert_eq!(at(light, eye), 0.0);
            }
            // The value in the mirror direction increases without bound towards grazing incidence, but stays finite.
            let mirror: Vec<f64> = [0.0, 45.0, 80.0, 89.0, 89.9].map(|zenith| at(zenith, zenith)).to_vec();
            assert!(mirror.windows(2).all(|pair| pair[1] >= pair[0] * 0.999 && pair[1].is_finite()), "{mirror:?}");
        }
    }

    #[test]
    fn verif_facets_are_reciprocal_and_finite() {
        for slope in [1e-3, 0.05, 0.4, 1.0] {
            check_law(&Facets { weight: 0.6, slope });
        }
    }
}
