//! Fraction of the Sun's light that reaches a satellite past the Earth.
//!
//! ```text
//!                       penumbra
//!   Sun         _____.------------------
//!  (disk)  ___/ Earth    umbra      ....      at the satellite: disk of the Sun of radius α, its centre x above the
//!             \_(oblate)________....          Earth's limb; x ≥ α sunlit, x ≤ -α umbra, else a lit fraction
//!                    `------------------
//! ```
//!
//! The Earth is the WGS84 ellipsoid. Stretching z by 1/(1 - f) makes it a sphere and keeps lines straight, so that the
//! limb is exact for each point of the Sun. The Sun's disk becomes an ellipse, whose radius perpendicular to the limb
//! is used. The lit fraction is the fraction of the Sun's light in V, with limb darkening; it is within 10⁻⁴ of a sum
//! over rays to all points of the disk.
//!
//! [`ShadowModel::Atmosphere`], the default, includes refraction and extinction. A satellite at 550 km receives 99 % of
//! the light where the line to the Sun's centre passes 56 km above the ground, 90 % at 41 km, 50 % at 27 km, 10 % at 12
//! km and 1 % at -9 km. Below 1 % a satellite counts as dark, above 99 % as sunlit.
//!
//! [`ShadowModel::Geometric`] has no atmosphere. A satellite at 550 km is in the penumbra while the line to the Sun's
//! centre passes between 13 km above and 13 km below the ground. It crosses this range at up to 3 km/s, in 8 s or more.
//! With the atmosphere half of the light is lost 9 s earlier at this speed. Both models neglect the tilt of the Earth's
//! axis against z of GCRS (0.15° in 2026, which moves boundaries by up to 60 m or 0.02 s).
//!
//! Heavens-Above gives the time of the first geometric dimming as the time of shadow entry: for 15 passes these times
//! agree with the geometric model within 0.8 s, rounding included.

use nalgebra::Vector3;

use super::{atmosphere, penumbra};
use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, EARTH_FLATTENING, SUN_RADIUS_KM};
use crate::frames::{Gcrs, Position};

/// Illumination of a satellite: sunlit, penumbra or umbra.
///
/// A satellite is lit unless it is in the umbra ([`Illumination::is_lit`]). Crossings, streak lengths, lost pixels, the
/// truth of injected streaks and statistics use this rule, and the selection of visible passes. The visible part of a
/// pass ends at the edge of the geometric shadow, if a part of the pass is outside of it.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Illumination {
    /// The whole disk of the Sun is visible; with [`ShadowModel::Atmosphere`], at least 99 % of its light arrives, and
    /// the rest (0.01 mag) is neglected.
    Sunlit,
    /// A part of the Sun's light is missing.
    Penumbra {
        /// Fraction of the Sun's light in V that arrives, (0, 1).
        lit_fraction: f64,
    },
    /// No part of the Sun is visible; with [`ShadowModel::Atmosphere`], less than 1 % of its light arrives (5 mag
    /// fainter than in full sunlight).
    Umbra,
}

impl Illumination {
    /// Returns the fraction of the Sun's light in V that arrives, [0, 1].
    pub fn lit_fraction(&self) -> f64 {
        match *self {
            Self::Sunlit => 1.0,
            Self::Penumbra { lit_fraction } => lit_fraction,
            Self::Umbra => 0.0,
        }
    }

    /// Returns true unless the satellite is in the umbra.
    pub fn is_lit(&self) -> bool {
        *self != Self::Umbra
    }

    /// Returns `sunlit`, `penumbra` or `umbra`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sunlit => "sunlit",
            Self::Penumbra { .. } => "penumbra",
            Self::Umbra => "umbra",
        }
    }
}

/// Model of the Earth's shadow.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ShadowModel {
    /// The solid Earth without atmosphere.
    Geometric,
    /// The Earth and its atmosphere: rays near the limb are bent, spread, scattered and absorbed.
    ///
    /// The model is valid for satellites from 100 km up to the Moon's distance; the geometric shadow is returned for
    /// all others.
    #[default]
    Atmosphere,
}

impl ShadowModel {
    /// Parses a name: `geometric` or `atmosphere`.
    pub fn by_name(name: &str) -> Option<Self> {
        [Self::Geometric, Self::Atmosphere].into_iter().find(|model| model.name() == name)
    }

    /// Returns `geometric` or `atmosphere`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Geometric => "geometric",
            Self::Atmosphere => "atmosphere",
        }
    }

    /// Returns a cone about the anti-solar direction inside which every position is in [`Illumination::Umbra`], with
    /// either model: its radius at the Earth's centre, km, and the decrease of the radius per km of distance behind the
    /// Earth. Valid for satellites from 100 km up to the Moon's distance.
    pub fn dark_core() -> (f64, f64) {
        // The limb is nearest to the Earth's centre at the poles. At perihelion the sine of the half angle of the
        // umbral cone is (R_sun - R) / d = 0.00469.
        (EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING), 0.0048)
    }

    /// Returns the illumination of a satellite; both positions are geocentric, km. A position below the Earth's surface
    /// is treated as the surface point above it.
    ///
    /// The result is quick to compute far from the shadow's boundary. Near the boundary the sum covers two dozen rings
    /// of the Sun's disk, or 20 rays through the atmosphere.
    pub fn illumination(self, satellite: &Position<Gcrs>, sun: &Position<Gcrs>) -> Illumination {
        let radius = EARTH_EQUATORIAL_RADIUS_KM;
        let position = stretch(satellite.vector());
        let to_sun = stretch(sun.vector()) - position;
        let height_km = position.norm() - radius;
        let airy = self == Self::Atmosphere
            && height_km > atmosphere::TOP_KM
            && position.norm_squared() < atmosphere::FARTHEST_KM * atmosphere::FARTHEST_KM;
        let edge_km = if airy { radius + atmosphere::CLEAR_KM } else { radius };

        // Only positions behind the terminator plane and inside the cone of the penumbra (radius `edge_km` at this
        // plane, half angle at most 0.0048 rad), or on its sunward side and within `edge_km` of the Earth's centre, can
        // be in shadow.
        let behind_km = -position.dot(&to_sun) / to_sun.norm();
        let across_km2 = position.norm_squared() - behind_km * behind_km;
        let cone_km = edge_km * 1.0002 + 0.005 * behind_km;
        if behind_km < 0.0 && position.norm_squared() > (edge_km * 1.0002).powi(2)
            || behind_km >= 0.0 && across_km2 > cone_km * cone_km
        {
            return Illumination::Sunlit;
        }

        let limb = Limb::new(&position, &to_sun);
        // x = angle (Earth's centre, Sun) - angular radius of the Earth
        let above = (limb.separation_rad - limb.earth_rad) / limb.sun_across_rad;
        if airy {
            // Less than 1 % of the light is bent into the geometric umbra.
            if above <= -1.0 {
                return Illumination::Umbra;
            }
            let lit_fraction = atmosphere::lit_fraction(position.norm(), limb.separation_rad, limb.sun_across_rad);
            return match lit_fraction {
                lit if lit < LEAST_LIT => Illumination::Umbra,
                lit if lit > 1.0 - LEAST_LIT => Illumination::Sunlit,
                lit_fraction => Illumination::Penumbra { lit_fraction },
            };
        }
        if above >= 1.0 {
            return Illumination::Sunlit;
        }
        match penumbra::lit_fraction(above, limb.limb_radius_in_suns()) {
            lit if lit <= 0.0 => Illumination::Umbra,
            lit if lit >= 1.0 => Illumination::Sunlit,
            lit_fraction => Illumination::Penumbra { lit_fraction },
        }
    }
}

/// Returns the illumination of a satellite by the default [`ShadowModel`], with the atmosphere.
pub fn illumination(satellite: &Position<Gcrs>, sun: &Position<Gcrs>) -> Illumination {
    ShadowModel::default().illumination(satellite, sun)
}

/// Fraction of the Sun's light below which a satellite behind the atmosphere is in the umbra, and missing fraction
/// below which it is sunlit.
///
/// For a satellite at 550 km 1 % remains 3 km above the edge of the geometric umbra. Less light is uncertain, because
/// clouds block the lowest rays.
const LEAST_LIT: f64 = 0.01;

/// Two perpendicular directions: any third direction is far from parallel to at least one of them.
const AXES: [Vector3<f64>; 2] = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 0.0)];

fn stretch(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z / (1.0 - EARTH_FLATTENING))
}

/// Earth and Sun seen from a satellite, in the stretched space where the Earth is a sphere.
struct Limb {
    /// Angle between the Earth's centre and the Sun's, radians.
    separation_rad: f64,
    /// The Earth's angular radius, radians.
    earth_rad: f64,
    /// The Sun's angular radii perpendicular to the limb and along it, radians.
    sun_across_rad: f64,
    sun_along_rad: f64,
}

impl Limb {
    fn new(position: &Vector3<f64>, to_sun: &Vector3<f64>) -> Self {
        let to_earth = -position;
        let normal = to_earth.cross(to_sun);
        let separation_rad = normal.norm().atan2(to_earth.dot(to_sun));
        let earth_rad = (EARTH_EQUATORIAL_RADIUS_KM / position.norm()).min(1.0).asin();
        // A plane with unit normal n' in the stretched space has the normal S n' in the true space (S is the
        // stretching), and the Sun's sphere extends |S n'| R to either side of it.
        let centre = to_earth.normalize();
        let perpendicular = centre.cross(if centre.z.abs() < 0.9 { &AXES[0] } else { &AXES[1] });
        // If the Sun is exactly behind the Earth's centre, any side may be chosen.
        let towards =
            (to_sun - centre * centre.dot(to_sun)).try_normalize(1e-9).unwrap_or_else(|| perpendicular.normalize());
        let (sin, cos) = earth_rad.sin_cos();
        let across = towards * cos - centre * sin;
        let along = centre.cross(&towards);
        let reach_rad = |n: Vector3<f64>| (SUN_RADIUS_KM * stretch(&n).norm() / to_sun.norm()).min(1.0).asin();
        Self { separation_rad, earth_rad, sun_across_rad: reach_rad(across), sun_along_rad: reach_rad(along) }
    }

    /// Returns the radius of curvature of the limb, in units in which the Sun's disk is a circle of radius 1.
    ///
    /// On the sphere the limb is a small circle with the curvature of a plane circle of radius tan(earth_rad). Making
    /// the Sun's ellipse round scales lengths along the limb by the ratio of its axes, and the radius by its square.
    fn limb_radius_in_suns(&self) -> f64 {
        // Beyond 10⁴ (at the surface itself) the limb is straight to one part in 10⁶.
        self.earth_rad.tan().clamp(0.0, 1e4) / self.sun_across_rad * (self.sun_across_rad / self.sun_along_rad).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::constants::AU_KM;

    fn lit_at(angle_from_antisun_rad: f64, radius_km: f64) -> Illumination {
        let sun = Position::<Gcrs>::new(AU_KM, 0.0, 0.0);
        let (sin, cos) = angle_from_antisun_rad.sin_cos();
        ShadowModel::Geometric.illumination(&Position::new(-radius_km * cos, radius_km * sin, 0.0), &sun)
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
        // The umbral cone ends at R D/(Rs - R) = 1.384 million km; beyond it the Earth covers the centre of a ring.
        let tip_km = EARTH_EQUATORIAL_RADIUS_KM * AU_KM / (SUN_RADIUS_KM - EARTH_EQUATORIAL_RADIUS_KM);
        // Over the poles, where the radius is 0.34 % smaller, it ends earlier.
        assert_eq!(lit_at(0.0, tip_km * 0.99), Illumination::Umbra);
        // The remaining light is a ring at the Sun's rim, darker than the mean of the disk (and the Earth's outline is
        // not a circle, which matters here).
        let lit = lit_at(0.0, tip_km * 1.01).lit_fraction();
        let ratio = EARTH_EQUATORIAL_RADIUS_KM / (tip_km * 1.01) / (SUN_RADIUS_KM / (AU_KM + tip_km * 1.01));
        let area = 1.0 - ratio * ratio;
        assert!(lit > 0.3 * area && lit < 0.95 * area, "{lit} of {area}");
    }

    #[test]
    fn entry_is_continuous_and_monotone() {
        for radius_km in [6578.0, 6928.0, 7578.0, 26_560.0, 42_164.0, 384_400.0] {
            // Angle of the limb from the anti-solar direction.
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
            // The steepest slope is in the middle: w(0) = 0.74 per solar radius.
            assert!(
                largest_step < 1.1 * penumbra::strip(0.0) / 0.00465 * 0.012 / f64::from(steps),
                "{radius_km}: {largest_step}"
            );
        }
    }

    /// Sums the light of the Sun's disk by rays from the satellite against the ellipsoid, without stretching: along
    /// each ring the crossings of the limb are interpolated between the rays.
    fn lit_by_rays(satellite: &Vector3<f64>, sun: &Vector3<f64>) -> f64 {
        let axis = (sun - satellite).normalize();
        let side = axis.cross(&Vector3::z()).normalize();
        let up = axis.cross(&side);
        // The visible limb of the Sun's sphere is a circle slightly nearer than its centre.
        let half = (SUN_RADIUS_KM / (sun - satellite).norm()).asin();
        let (rings, spokes) = (1500, 120);
        let (a, b) = (EARTH_EQUATORIAL_RADIUS_KM, EARTH_EQUATORIAL_RADIUS_KM * (1.0 - EARTH_FLATTENING));
        let inverse = Vector3::new(1.0 / (a * a), 1.0 / (a * a), 1.0 / (b * b));
        let qc = satellite.dot(&satellite.component_mul(&inverse)) - 1.0;
        // Positive where the ray misses the Earth.
        let miss = |rho: f64, turn: f64| {
            let ray = axis + (side * turn.cos() + up * turn.sin()) * (half * rho).tan();
            let (qa, qb) = (ray.dot(&ray.component_mul(&inverse)), ray.dot(&satellite.component_mul(&inverse)));
            if qb >= 0.0 { 1.0 } else { qa * qc - qb * qb }
        };
        let (mut lit, mut all) = (0.0, 0.0);
        for ring in 0..rings {
            // Denser towards the rim, where the intensity falls as a square root.
            let t = (f64::from(ring) + 0.5) / f64::from(rings) * PI / 2.0;
            let (rho, weight) = (t.sin(), t.sin() * t.cos());
            let mu = t.cos();
            let light = weight
                * (0.269_80 + mu * (1.340_25 + mu * (-1.642_88 + mu * (2.082_24 + mu * (-1.473_53 + mu * 0.424_12)))));
            let misses: Vec<f64> =
                (0..=spokes).map(|spoke| miss(rho, 2.0 * PI * f64::from(spoke) / f64::from(spokes))).collect();
            let seen: f64 = misses
                .windows(2)
                .map(|pair| match (pair[0] > 0.0, pair[1] > 0.0) {
                    (true, true) => 1.0,
                    (false, false) => 0.0,
                    (true, false) => pair[0] / (pair[0] - pair[1]),
                    (false, true) => pair[1] / (pair[1] - pair[0]),
                })
                .sum();
            lit += light * seen / f64::from(spokes);
            all += light;
        }
        lit / all
    }

    #[test]
    fn verif_against_rays_to_the_ellipsoid() {
        /// Tolerance stated in the docs; half of it is the error of the sum.
        const TOLERANCE: f64 = 1e-4;
        let (mut checked, mut worst) = (0, 0.0_f64);
        for (sun_declination, latitude) in [(0.0, 0.2), (0.4, -0.9), (-0.4, 1.2), (0.3, 0.0), (-0.2, -1.4)] {
            let (sin, cos) = f64::sin_cos(sun_declination);
            let sun = Vector3::new(cos, 0.0, sin) * AU_KM;
            for radius_km in [6900.0, 7600.0, 42_164.0] {
                // A path from midnight to the terminator at this inclination, around the limb.
                let up = Vector3::new(-sin, 0.0, cos) * f64::sin(latitude) + Vector3::y() * f64::cos(latitude);
                let limb = f64::asin(EARTH_EQUATORIAL_RADIUS_KM / radius_km);
                for step in 0..16 {
                    let angle = limb - 0.009 + 0.016 * f64::from(step) / 16.0;
                    let satellite = (-sun.normalize() * angle.cos() + up * angle.sin()) * radius_km;
                    let (position, sun_position) = (Position::from_vector(satellite), Position::from_vector(sun));
                    let illumination = ShadowModel::Geometric.illumination(&position, &sun_position);
                    if let Illumination::Penumbra { lit_fraction } = illumination {
                        let rays = lit_by_rays(&satellite, &sun);
                        worst = worst.max((lit_fraction - rays).abs());
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 80, "{checked}");
        assert!(worst < TOLERANCE, "{worst}");
    }

    /// Where the light of the atmosphere is not computed, it is below 1 % or above 99 %.
    #[test]
    fn verif_the_edges_of_the_computed_light() {
        let mut radius_km = EARTH_EQUATORIAL_RADIUS_KM + atmosphere::TOP_KM + 0.1;
        while radius_km < atmosphere::FARTHEST_KM {
            let arc = |height_km: f64| ((EARTH_EQUATORIAL_RADIUS_KM + height_km) / radius_km).asin();
            // Smallest and largest radius of the Sun, which the flattening of the Earth changes by 0.3 %.
            for sun_rad in [0.004_55, 0.004_65, 0.004_78] {
                let dark = atmosphere::lit_fraction(radius_km, arc(0.0) - sun_rad, sun_rad);
                assert!(dark < LEAST_LIT, "{radius_km} {sun_rad}: {dark}");
                let clear = atmosphere::lit_fraction(radius_km, arc(atmosphere::CLEAR_KM) + sun_rad, sun_rad);
                assert!(clear > 1.0 - LEAST_LIT, "{radius_km} {sun_rad}: {clear}");
            }
            radius_km *= 1.01;
        }
    }

    #[test]
    fn verif_all_of_the_dark_core_is_dark() {
        let (radius_km, narrowing) = ShadowModel::dark_core();
        for model in [ShadowModel::Geometric, ShadowModel::Atmosphere] {
            // The nearest Sun, overhead at both tropics and at the equator.
            for declination_rad in [-0.409_f64, 0.0, 0.409] {
                let toward = Vector3::new(declination_rad.cos(), 0.0, declination_rad.sin());
                let perpendicular = [Vector3::new(-toward.z, 0.0, toward.x), Vector3::y()];
                let sun = Position::from_vector(toward * (0.9832 * AU_KM));
                for depth_km in [1300.0, 2000.0, 3000.0, 7000.0, 20_000.0, 42_000.0, 100_000.0, 200_000.0] {
                    let across_km = radius_km - narrowing * depth_km;
                    for step in 0..12 {
                        let (sin, cos) = (PI * f64::from(step) / 6.0).sin_cos();
                        let position = -toward * depth_km
                            + (perpendicular[0] * cos + perpendicular[1] * sin) * (0.999 * across_km);
                        let found = model.illumination(&Position::from_vector(position), &sun);
                        assert_eq!(found, Illumination::Umbra, "{model:?} {declination_rad} {depth_km} {step}");
                    }
                }
            }
        }
    }
}
