//! How much of the Sun's disk a satellite sees past the Earth.
//!
//! ```text
//!                       penumbra
//!   Sun         _____.------------------
//!  (disk)  ___/ Earth    umbra      ....      at the satellite: disk of the Sun, radius α, its centre x above the limb of the
//!             \_(oblate)________....          Earth;  x ≥ α sunlit,  x ≤ -α umbra,  between them the lit fraction of the disk
//!                    `------------------
//! ```
//!
//! The Earth is the WGS84 ellipsoid without air. Stretching z by 1/(1 - f) makes it a sphere and keeps straight lines straight, so that the limb
//! is found exactly for each point of the Sun. What is left out, for a satellite at 550 km that sinks through the penumbra (25 km deep there) at up to
//! 3 km/s, in 8 s and more:
//!
//! | what | effect |
//! |---|---|
//! | the Earth's axis taken as z of GCRS (0.15° off in 2026) | borders within 60 m, 0.02 s |
//! | the Sun's disk left round by the stretching (0.34 % of its diameter) | borders within 50 m, 0.02 s; lit fraction within 0.004 |
//! | the air, which absorbs and bends the light that grazes it | each kilometre of dark air brings the shadow forward by 0.35 s and more |
//! | the disk evenly bright | lit fraction within 0.03 |
//!
//! Heavens-Above's moments of entry are those of the first dimming here: 15 passes agree within 0.8 s, their rounding included.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING, SUN_RADIUS_KM};
use crate::frames::{Gcrs, Position};

/// Sunlit, in the half shadow, or dark.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Illumination {
    /// The whole disk of the Sun is seen.
    Sunlit,
    /// The Earth covers a part of the Sun's disk.
    Penumbra {
        /// The part of the disk's area that is seen, (0, 1).
        lit_fraction: f64,
    },
    /// Nothing of the Sun is seen.
    Umbra,
}

impl Illumination {
    /// The part of the Sun's disk that is seen, [0, 1].
    pub fn lit_fraction(&self) -> f64 {
        match *self {
            Self::Sunlit => 1.0,
            Self::Penumbra { lit_fraction } => lit_fraction,
            Self::Umbra => 0.0,
        }
    }

    /// `sunlit`, `penumbra` or `umbra`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sunlit => "sunlit",
            Self::Penumbra { .. } => "penumbra",
            Self::Umbra => "umbra",
        }
    }
}

/// How a satellite is lit, both places geocentric, km. A place below the Earth's surface is lit as one on the surface above it would be.
///
/// Far from the shadow's border a few products decide; near it three inverse trigonometric functions.
pub fn illumination(satellite: &Position<Gcrs>, sun: &Position<Gcrs>) -> Illumination {
    let radius = EARTH_EQUATORIAL_RADIUS_KM;
    let stretch = |v: &Vector3<f64>| Vector3::new(v.x, v.y, v.z / (1.0 - EARTH_FLATTENING));
    let place = stretch(satellite.vector());
    let to_sun = stretch(sun.vector()) - place;

    // Behind the terminator plane, and within the cone of the penumbra (half angle at most 0.0048 rad; the Earth's radius at the terminator)?
    let behind_km = -place.dot(&to_sun) / to_sun.norm();
    let across_km2 = place.norm_squared() - behind_km * behind_km;
    let cone_km = radius * 1.0002 + 0.005 * behind_km;
    if behind_km < 0.0 && place.norm_squared() > (radius * 1.0002).powi(2)
        || behind_km >= 0.0 && across_km2 > cone_km * cone_km
    {
        return Illumination::Sunlit;
    }

    // x = angle (Earth's centre, Sun) - angular radius of the Earth
    let to_earth = -place;
    let separation_rad = to_earth.cross(&to_sun).norm().atan2(to_earth.dot(&to_sun));
    let earth_rad = (radius / place.norm()).min(1.0).asin();
    let sun_rad = (SUN_RADIUS_KM / (sun.vector() - satellite.vector()).norm()).min(1.0).asin();
    let above_limb_rad = separation_rad - earth_rad;
    if above_limb_rad >= sun_rad {
        return Illumination::Sunlit;
    }
    let covered = covered_fraction(above_limb_rad, sun_rad, earth_rad);
    if covered >= 1.0 { Illumination::Umbra } else { Illumination::Penumbra { lit_fraction: 1.0 - covered } }
}

/// The part of a disk of radius `sun_rad`, its centre `above_limb_rad` outside of the limb of a disk of radius `earth_rad`, that is covered.
///
/// On the sphere the limb is a small circle, bent like a plane circle of radius tan(earth_rad); seen on the scale of the Sun's disk that is what counts.
/// With r the Sun, R the limb, d = R + x, the half angles β at the Sun's centre and γ at the other one:
///
/// cos β = (x (2R + x) + r²) / (2 d r),  sin γ = (r/R) sin β,  area = r² (β - sin β cos β) + R² (γ - sin γ cos γ)
fn covered_fraction(above_limb_rad: f64, sun_rad: f64, earth_rad: f64) -> f64 {
    // Beyond 10⁴ (on the very surface) the limb is straight to one part in 10⁶.
    let limb = earth_rad.tan().clamp(0.0, 1e4);
    let (x, r) = (above_limb_rad, sun_rad);
    let d = limb + x;
    if x >= r {
        return 0.0;
    }
    if d + r <= limb {
        return 1.0;
    }
    if d + limb <= r {
        // The Earth is smaller than the Sun and all within its disk, beyond a million kilometres.
        return (limb / r).powi(2);
    }
    let cos_beta = ((x * (2.0 * limb + x) + r * r) / (2.0 * d * r)).clamp(-1.0, 1.0);
    let beta = cos_beta.acos();
    let sin_beta = beta.sin();
    let cos_gamma = (d - r * cos_beta) / limb;
    let gamma = (r * sin_beta).atan2(limb * cos_gamma);
    let area = r * r * (beta - sin_beta * cos_beta) + limb * limb * (gamma - gamma.sin() * gamma.cos());
    (area / (PI * r * r)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::AU_KM;

    fn lit_at(angle_from_antisun_rad: f64, radius_km: f64) -> Illumination {
        let sun = Position::<Gcrs>::new(AU_KM, 0.0, 0.0);
        let (sin, cos) = angle_from_antisun_rad.sin_cos();
        illumination(&Position::new(-radius_km * cos, radius_km * sin, 0.0), &sun)
    }

    #[test]
    fn day_side_and_night_side() {
        assert_eq!(lit_at(PI, 6928.0), Illumination::Sunlit);
        assert_eq!(lit_at(PI / 2.0, 6928.0), Illumination::Sunlit);
        assert_eq!(lit_at(0.0, 6928.0), Illumination::Umbra);
        assert_eq!(lit_at(0.0, 42_164.0), Illumination::Umbra);
        assert_eq!(lit_at(0.0, 42_164.0).name(), "umbra");
    }

    #[test]
    fn umbra_ends_where_the_cone_does() {
        // The umbral cone closes at R D/(Rs - R) = 1.384 million km; beyond it the Earth is a ring's core.
        let tip_km = EARTH_EQUATORIAL_RADIUS_KM * AU_KM / (SUN_RADIUS_KM - EARTH_EQUATORIAL_RADIUS_KM);
        assert_eq!(lit_at(0.0, tip_km * 0.999), Illumination::Umbra);
        let lit = lit_at(0.0, tip_km * 1.01).lit_fraction();
        // The Earth's disk against the Sun's, as radii go with distance.
        let ratio = EARTH_EQUATORIAL_RADIUS_KM / (tip_km * 1.01) / (SUN_RADIUS_KM / (AU_KM + tip_km * 1.01));
        assert!((lit - (1.0 - ratio * ratio)).abs() < 1e-4, "{lit}");
    }

    #[test]
    fn entry_is_continuous_and_monotone() {
        for radius_km in [6578.0, 6928.0, 7578.0, 26_560.0, 42_164.0, 384_400.0] {
            // The limb stands at this angle from the anti-solar direction.
            let limb = (EARTH_EQUATORIAL_RADIUS_KM / radius_km).asin();
            let steps = 20_000;
            let mut previous = 1.0;
            let (mut largest_step, mut kinds) = (0.0_f64, [0; 3]);
            for step in 0..=steps {
                let angle = limb + 0.006 - 0.012 * f64::from(step) / f64::from(steps);
                let lit = lit_at(angle, radius_km);
                let fraction = lit.lit_fraction();
                assert!((0.0..=1.0).contains(&fraction));
                assert!(fraction <= previous + 1e-12, "{radius_km}: {fraction} after {previous}");
                largest_step = largest_step.max(previous - fraction);
                kinds[match lit {
                    Illumination::Sunlit => 0,
                    Illumination::Penumbra { .. } => 1,
                    Illumination::Umbra => 2,
                }] += 1;
                previous = fraction;
            }
            assert!(kinds.iter().all(|&count| count > 100), "{radius_km}: {kinds:?}");
            // The steepest slope is 2/(π r) a radian, at the middle.
            assert!(
                largest_step < 1.3 * 2.0 / (PI * 0.00465) * 0.012 / f64::from(steps),
                "{radius_km}: {largest_step}"
            );
        }
    }

    #[test]
    fn half_the_disk_at_the_limb() {
        // A straight limb through the centre of the disk leaves one half; the Earth's roundness covers a little less.
        let covered = covered_fraction(0.0, 0.004_65, 1.17);
        assert!((covered - 0.5).abs() < 1e-3 && covered < 0.5, "{covered}");
        assert!((covered_fraction(0.0, 0.004_65, PI / 2.0) - 0.5).abs() < 1e-6);
    }

    /// The ray from the satellite to each point of the Sun's disk against the ellipsoid, without any stretching.
    fn lit_by_rays(satellite: &Vector3<f64>, sun: &Vector3<f64>) -> f64 {
        let axis = (sun - satellite).normalize();
        let side = axis.cross(&Vector3::z()).normalize();
        let up = axis.cross(&side);
        // The limb of the Sun's sphere is a circle a little nearer than its centre.
        let distance = (sun - satellite).norm();
        let half = (SUN_RADIUS_KM / distance).asin();
        let (rings, spokes) = (200, 400);
        let (a, b) = (EARTH_EQUATORIAL_RADIUS_KM, EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING));
        let inverse = Vector3::new(1.0 / (a * a), 1.0 / (a * a), 1.0 / (b * b));
        let mut lit = 0;
        for ring in 0..rings {
            // Equal areas.
            let rho = half * ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
            for spoke in 0..spokes {
                let (sin, cos) =
                    (2.0 * PI * (f64::from(spoke) + 0.5 * f64::from(ring % 2)) / f64::from(spokes)).sin_cos();
                let ray = axis + (side * cos + up * sin) * rho.tan();
                let qa = ray.dot(&ray.component_mul(&inverse));
                let qb = ray.dot(&satellite.component_mul(&inverse));
                let qc = satellite.dot(&satellite.component_mul(&inverse)) - 1.0;
                let hit = qb < 0.0 && qb * qb > qa * qc;
                lit += i32::from(!hit);
            }
        }
        f64::from(lit) / f64::from(rings * spokes)
    }

    #[test]
    fn verif_against_rays_to_the_ellipsoid() {
        // The Sun's disk is left round by the stretching: its edge is wrong by 0.34 % of the radius at the poles, the area within by as much.
        const TOLERANCE: f64 = 0.004;
        let mut checked = 0;
        for (sun_declination, latitude) in [(0.0, 0.2), (0.4, -0.9), (-0.4, 1.2), (0.3, 0.0), (-0.2, -1.4)] {
            let (sin, cos) = f64::sin_cos(sun_declination);
            let sun = Vector3::new(cos, 0.0, sin) * AU_KM;
            for radius_km in [6900.0, 7600.0, 42_164.0] {
                // A path from noon to midnight at this slant.
                let up = Vector3::new(-sin, 0.0, cos) * f64::sin(latitude) + Vector3::y() * f64::cos(latitude);
                for step in 0..4000 {
                    let angle = PI * f64::from(step) / 4000.0;
                    let satellite = (-sun.normalize() * angle.cos() + up * angle.sin()) * radius_km;
                    let ours = illumination(&Position::from_vector(satellite), &Position::from_vector(sun));
                    if let Illumination::Penumbra { lit_fraction } = ours {
                        let rays = lit_by_rays(&satellite, &sun);
                        assert!((lit_fraction - rays).abs() < TOLERANCE, "{lit_fraction} against {rays}");
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 100, "{checked}");
    }
}
