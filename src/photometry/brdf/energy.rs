//! How much of the light that falls on a surface leaves it again.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::law::Brdf;
use crate::photometry::panel::Incidence;

/// Nodes in azimuth and in the distance from the lobe's middle; enough for lobes down to a degree wide, to 1e-3.
const AZIMUTHS: usize = 64;
const RINGS: usize = 512;

/// Share of the incident power that a law sends back into the hemisphere, for light at this cosine from the normal:
/// ∫ f cos φ_r dω.
///
/// The rule is centred on the mirror direction, with rings that crowd around it, since that is where the lobes are.
/// Its error is below 1e-3 of the share for lobes wider than a degree.
pub fn reflected_share(law: &(impl Brdf + ?Sized), cos_in: f64) -> f64 {
    let cos_in = cos_in.clamp(0.0, 1.0);
    let sin_in = (1.0 - cos_in * cos_in).sqrt();
    let normal = Vector3::z();
    let to_source = Vector3::new(sin_in, 0.0, cos_in);
    let mirror = Vector3::new(-sin_in, 0.0, cos_in);
    let (east, north) = (Vector3::y(), mirror.cross(&Vector3::y()));
    let mut share = 0.0;
    for ring in 0..RINGS {
        // θ = π t³: rings of equal t, dω = sin θ dθ dψ
        let t = (ring as f64 + 0.5) / RINGS as f64;
        let theta = PI * t.powi(3);
        let weight = theta.sin() * 3.0 * PI * t * t / RINGS as f64 * TAU / AZIMUTHS as f64;
        for azimuth in 0..AZIMUTHS {
            let psi = (azimuth as f64 + 0.5) * TAU / AZIMUTHS as f64;
            let to_eye = mirror * theta.cos() + (east * psi.cos() + north * psi.sin()) * theta.sin();
            let incidence = Incidence::new(&normal, &to_source, &to_eye);
            if incidence.cos_out > 0.0 {
                share += law.value_per_sr(&incidence) * incidence.cos_out * weight;
            }
        }
    }
    share
}

/// What every law promises: reciprocity, no negative light, an answer for every incidence.
#[cfg(test)]
pub(super) fn hold_law_to_the_rules(law: &impl Brdf) {
    let normal = Vector3::z();
    let mut state = 7_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut up = || {
        let (longitude, cos) = (TAU * uniform(), uniform());
        let sin = (1.0 - cos * cos).sqrt();
        Vector3::new(sin * longitude.cos(), sin * longitude.sin(), cos)
    };
    for _ in 0..2000 {
        let (light, eye) = (up(), up());
        let there = law.value_per_sr(&Incidence::new(&normal, &light, &eye));
        let back = law.value_per_sr(&Incidence::new(&normal, &eye, &light));
        assert!(there >= 0.0 && there.is_finite(), "{there} for {light:?} {eye:?}");
        assert!((there - back).abs() <= 1e-9 * there.max(1.0), "{there} {back} for {light:?} {eye:?}");
        // In the mirror itself, and along the normal, no root of a negative number.
        let mirror = Vector3::new(-light.x, -light.y, light.z);
        assert!(law.value_per_sr(&Incidence::new(&normal, &light, &mirror)).is_finite());
        assert!(law.value_per_sr(&Incidence::new(&normal, &normal, &normal)).is_finite());
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Lambert, Phong};
    use super::*;

    #[test]
    fn verif_shares_of_known_laws() {
        // A Lambertian surface reflects its albedo at any incidence.
        for cos_in in [1.0, 0.7, 0.2, 0.02] {
            let share = reflected_share(&Lambert { albedo: 0.3 }, cos_in);
            assert!((share - 0.3).abs() < 3e-4, "{cos_in}: {share}");
        }
        // Phong's lobe its weight under light along the normal, and less at a slant.
        for exponent in [1.0, 22.0, 300.0, 5000.0] {
            let law = Phong { weight: 0.7, exponent };
            assert!((reflected_share(&law, 1.0) - 0.7).abs() < 7e-4, "{exponent}");
            assert!(reflected_share(&law, 0.3) < 0.7);
        }
    }
}
