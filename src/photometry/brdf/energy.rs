//! Fraction of the incident light that a surface reflects or transmits.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::law::{Brdf, Incidence};

/// Numbers of nodes in azimuth and in the distance from the centre of the lobe. They give an accuracy of 1e-3 for lobes
/// down to a degree wide.
const AZIMUTHS: usize = 64;
const RINGS: usize = 512;

/// Returns the fraction of the incident power that a law reflects into the hemisphere of the source: ∫ f cos φ_r dω.
/// `cos_in` is the cosine of the angle of incidence.
///
/// The integral is the sum of two quadrature rules, one around the mirror direction and one around the source. Their
/// rings are denser near these directions, where the lobes are. The error is below 1e-3 of the fraction for lobes wider
/// than a degree.
pub fn reflected_share(law: &(impl Brdf + ?Sized), cos_in: f64) -> f64 {
    share(law, cos_in, 1.0)
}

/// Returns the fraction of the incident power that a transmission law sends into the hemisphere behind the surface: ∫ f
/// |cos φ_r| dω. The accuracy for lobes about the transmitted direction is that of [`reflected_share`].
pub fn transmitted_share(law: &(impl Brdf + ?Sized), cos_in: f64) -> f64 {
    share(law, cos_in, -1.0)
}

/// Integrates over the hemisphere of the source (`side` 1) or over the other hemisphere (`side` -1).
fn share(law: &(impl Brdf + ?Sized), cos_in: f64, side: f64) -> f64 {
    let mut share = 0.0;
    each_outgoing(law, cos_in, side, |_, part| share += part);
    share
}

/// Calls `take` with the directions into which a law sends light, and the fraction f |cos φ_r| dω of the incident power
/// that leaves in each. `side` is 1 for the hemisphere of the source and -1 for the other one.
///
/// The directions are unit vectors in axes with the normal along z and the source in the half plane y = 0, x ≥ 0. The
/// accuracy of sums over them is that of [`reflected_share`].
pub(in crate::photometry) fn each_outgoing(
    law: &(impl Brdf + ?Sized),
    cos_in: f64,
    side: f64,
    mut take: impl FnMut(&Vector3<f64>, f64),
) {
    let cos_in = cos_in.clamp(0.0, 1.0);
    let sin_in = (1.0 - cos_in * cos_in).sqrt();
    let normal = Vector3::z();
    let to_source = Vector3::new(sin_in, 0.0, cos_in);
    // The two directions are the mirror direction and the source; for transmission, the transmitted direction and the
    // mirror image of the source in the plane.
    let poles = [Vector3::new(-sin_in, 0.0, side * cos_in), Vector3::new(sin_in, 0.0, side * cos_in)];
    for (pole, other) in [(poles[0], poles[1]), (poles[1], poles[0])] {
        let (east, north) = (Vector3::y(), pole.cross(&Vector3::y()));
        for ring in 0..RINGS {
            // θ = π t³: rings of equal t, dω = sin θ dθ dψ
            let t = (ring as f64 + 0.5) / RINGS as f64;
            let theta = PI * t.powi(3);
            let weight = theta.sin() * 3.0 * PI * t * t / RINGS as f64 * TAU / AZIMUTHS as f64;
            for azimuth in 0..AZIMUTHS {
                let psi = (azimuth as f64 + 0.5) * TAU / AZIMUTHS as f64;
                let to_eye = pole * theta.cos() + (east * psi.cos() + north * psi.sin()) * theta.sin();
                let incidence = Incidence::new(&normal, &to_source, &to_eye);
                if incidence.cos_out * side > 0.0 {
                    // Each direction belongs to both rules, with the larger weight for the nearer of the two poles, and
                    // with half the weight for each if the poles coincide.
                    let (near, far) = ((to_eye - pole).norm_squared(), (to_eye - other).norm_squared());
                    let part = if near + far > 0.0 { far / (near + far) } else { 0.5 };
                    take(&to_eye, law.value_per_sr(&incidence) * incidence.cos_out.abs() * weight * part);
                }
            }
        }
    }
}

/// Checks reciprocity and finite, non-negative values for every incidence.
#[cfg(test)]
pub(super) fn check_law(law: &impl Brdf) {
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
        // On the side of the source, behind the surface, and opposite.
        for eye in [eye, -eye, -light] {
            let there = law.value_per_sr(&Incidence::new(&normal, &light, &eye));
            let back = law.value_per_sr(&Incidence::new(&normal, &eye, &light));
            assert!(there >= 0.0 && there.is_finite(), "{there} for {light:?} {eye:?}");
            assert!((there - back).abs() <= 1e-9 * there.max(1.0), "{there} {back} for {light:?} {eye:?}");
        }
        // Along the surface: towards the source, across, and opposite.
        let along = Vector3::new(light.x, light.y, 0.0).normalize();
        for eye in [along, Vector3::new(-along.y, along.x, 0.0), -along, eye] {
            let grazing = law.value_per_sr(&Incidence::new(&normal, &along, &eye));
            assert!(grazing >= 0.0 && grazing.is_finite(), "{grazing} for {along:?} {eye:?}");
        }
        // At the mirror direction and along the normal, rounding must not cause the root of a negative number.
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
            let share = transmitted_share(&Lambert { albedo: 0.3 }, cos_in);
            assert!((share - 0.3).abs() < 3e-4, "{cos_in}: {share} behind");
        }
        // Phong's lobe reflects its weight for light along the normal, and less at oblique incidence.
        for exponent in [1.0, 22.0, 300.0, 5000.0] {
            let law = Phong { weight: 0.7, exponent };
            assert!((reflected_share(&law, 1.0) - 0.7).abs() < 7e-4, "{exponent}");
            assert!(reflected_share(&law, 0.3) < 0.7);
        }
    }
}
