//! Earthshine: the sunlit part of the Earth that a satellite sees, and the quadrature rule that integrates its light.
//!
//! Every part of the Earth that is lit by the Sun and visible from the satellite is a Lambertian source of albedo 0.3.
//! Lu (2024) sums over HEALPix pixels, as the tests do. Here a product rule with fewer and better placed nodes covers
//! the lit ground in view. In Lu (2024) and in two-panel models, earthshine falls on the chassis only; in lists of
//! panels it may fall on any panel, with any reflection law. Light reflected between parts of the satellite,
//! refraction, twilight airglow and the size of the Sun's disk are neglected.
//!
//! The tables show the convergence: the largest relative error of the diffuse light, and the largest error of the
//! magnitude of a chassis lit by the Earth only (c4 0.19, c5 0.09; printed by
//! `cargo test --test library earthshine -- --nocapture`). First, HEALPix sums with the pole at the nadir compared with
//! the rule, for a lobe with the exponent 22, a height of 550 km and the Sun at -12° to 40°:
//!
//! | nside | lit pixels | diffuse | total, mag |
//! |---|---|---|---|
//! | 32 | 480 | 2.1e-2 | 0.15 |
//! | 64 | 1,984 | 4.4e-3 | 0.032 |
//! | 128 | 7,812 | 1.1e-3 | 0.0078 |
//! | 256 | 31,000 | 2.7e-4 | 0.0019 |
//! | 512 | 124,500 | 6.8e-5 | 0.0005 |
//!
//! Second, the rule compared with a much finer one, for 200 km to 36,000 km and all positions of the Sun:
//!
//! | exponent | nodes at 550 km, at most | total, mag |
//! |---|---|---|
//! | 1 | 1,260 | 0.0003 |
//! | 2 | 270 | 0.0002 |
//! | 5 | 170 | 0.0001 |
//! | 22 | 358 | 0.0004 |
//! | 60 | 724 | 0.0006 |
//! | 200 | 2,056 | 0.0007 |
//!
//! Below an exponent of 1 the lobe ends with a step at 90°, and the error is some hundredths of a magnitude. Exponents
//! above 200 are not tested.
//!
//! Seen from the height h, a spherical Earth fills a cap around the nadir. A point of the Earth is given by its nadir
//! angle η (at the satellite), its angle γ from the nadir point (at the Earth's centre) and its longitude φ about the
//! nadir from the Sun. It contributes the following irradiance, relative to that of the Sun, on a plate that is
//! perpendicular to the direction of the point:
//!
//! ```text
//! dE = (albedo/π) cos(Sun) cos(view) dA / d² = (albedo/π) cos(Sun) sin η dη dφ
//! cos(Sun) = cos γ sin δ + sin γ cos δ cos φ                     δ the Sun's latitude above the chassis plane
//! ```
//!
//! Neither γ nor η is a suitable variable of integration: η has a square root at the limb, and below a low satellite
//! the points crowd in γ. The zenith angle e of the satellite as seen from the ground, 0 to π/2, is regular at both
//! ends:
//!
//! ```text
//! sin η = R/(R+h) sin e        γ = e - η
//! ```
//!
//! If the Sun is below the height at which the whole cap is lit, φ is limited by the terminator, cos φ = -tan δ / tan
//! γ. This limit begins with a square root at γ = |δ|, which the substitution e = e₀ + (π/2 - e₀) s² (2 - s) removes.
//! If the Sun is above the chassis plane but below that height, full circles are lit up to γ = δ and partial circles
//! beyond; the two are integrated separately. The rules are Gauss-Legendre in e (or s) and φ, with equal steps in φ on
//! full circles.
//!
//! No ground in view is lit if δ is below -acos(R/(R+h)), which is -23.0° at 550 km.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use std::sync::LazyLock;

use nalgebra::Vector3;

use super::brdf::Facets;
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::math::elementary::{exp, fused, greater, ln, sin_cos};
use crate::math::quadrature::gauss_legendre;
use crate::math::vectors::{Kernel, widest_fused};

/// Albedo of the Earth, taken as the same everywhere (Lu 2024, section 2.4).
pub const EARTH_ALBEDO: f64 = 0.3;

/// Number of nodes evaluated together.
const LANES: usize = 8;

/// Earthshine on a panel, relative to the Sun's irradiance on a plate perpendicular to the direction of the Sun.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct PanelEarthshine {
    /// Irradiance on the panel: Σ dE cos φ_i, dimensionless.
    pub irradiance: f64,
    /// Sum Σ dE cos φ_i cosⁿθ, where θ is the angle between the mirror direction of each source and the observer.
    pub lobe: f64,
}

/// The lit ground that is visible from a satellite, for one position of the Sun and one height.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LitEarth {
    sin_sun: f64,
    cos_sun: f64,
    sun_latitude_rad: f64,
    /// Ratio R/(R+h) of the Earth's radius to that of the orbit.
    ratio: f64,
}

/// Numbers of nodes, which depend on the width of the lobe that they must resolve.
#[derive(Copy, Clone)]
struct Resolution {
    /// Smallest number of rings, and number of rings per radian of nadir angle.
    rings: [f64; 2],
    /// Smallest number of nodes on half a ring, and number of nodes per radian of arc on the sky.
    arc: [f64; 2],
}

impl Resolution {
    /// Returns the resolution for a lobe cosⁿθ; the documentation of this module states the errors.
    fn for_exponent(exponent: f64) -> Self {
        // The lobe is exp(-n θ²/2) near its axis: 1/√n is its scale in radians.
        let narrowness = exponent.max(0.0).sqrt();
        // A broad lobe ends with a kink at 90°. Gauss rules resolve a kink only by a large number of nodes.
        let kink = 1.0 / exponent.max(1.0).powi(2);
        Self {
            rings: [4.3 + 0.4 * narrowness + 16.0 * kink, 0.65 * narrowness + 0.014 * narrowness * narrowness],
            arc: [1.6 + 0.15 * narrowness + 11.0 * kink, 0.62 * narrowness + 0.02 * narrowness * narrowness],
        }
    }

    fn count([least, by_radian]: [f64; 2], length_rad: f64) -> usize {
        (least + by_radian * length_rad).ceil() as usize
    }
}

impl LitEarth {
    /// Returns `None` if no visible ground is lit, the satellite is not above the ground, or a number is not finite.
    pub fn new(sun_latitude_rad: f64, height_km: f64) -> Option<Self> {
        let is_sound = height_km > 0.0 && height_km.is_finite() && sun_latitude_rad.abs() <= FRAC_PI_2;
        let ratio = EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + height_km);
        if !is_sound || sun_latitude_rad <= -ratio.acos() {
            return None;
        }
        let (sin_sun, cos_sun) = sun_latitude_rad.sin_cos();
        Some(Self { sin_sun, cos_sun, sun_latitude_rad, ratio })
    }

    /// Returns the light on a panel with this unit normal in the body frame, for one observer and an exponent from 0 to
    /// 10,000.
    ///
    /// Takes 1 to 5 µs for an exponent of 22, and allocates nothing.
    pub fn shine(&self, normal: &Vector3<f64>, to_observer: &Vector3<f64>, exponent: f64) -> PanelEarthshine {
        // The lobe cosine of a source is the cosine between the source and the mirror image of the observer, 2 (n · o)
        // n - o.
        let mirror = normal * (2.0 * normal.dot(to_observer)) - to_observer;
        let shine = PanelEarthshineSums {
            normal: (*normal).into(),
            mirror: mirror.into(),
            exponent,
            irradiance: [0.0; LANES],
            lobe: [0.0; LANES],
        };
        let shine = widest_fused(Sum { earth: *self, resolution: Resolution::for_exponent(exponent), sink: shine });
        PanelEarthshine { irradiance: shine.irradiance.iter().sum(), lobe: shine.lobe.iter().sum() }
    }

    /// Returns the irradiance on a panel that faces down, as in [`Self::shine`], and the sum Σ dE f cos φ_i over its
    /// facets of reflectance 1, sr⁻¹, for an observer below the panel; `exponent` is that of the lobe
    /// ([`crate::photometry::brdf::Law::equivalent_exponent`]).
    ///
    /// Allocates nothing. The masking of the facets is the same along each ring, because their panel is level.
    pub(super) fn shine_on_facets(&self, facets: &Facets, to_observer: &Vector3<f64>, exponent: f64) -> [f64; 2] {
        let cos_out = -to_observer.z;
        let sums = FacetSums {
            facets: *facets,
            to_observer: (*to_observer).into(),
            cos_out,
            ring: (f64::NAN, 0.0),
            irradiance: [0.0; LANES],
            reflected: [0.0; LANES],
        };
        let sums = widest_fused(Sum { earth: *self, resolution: Resolution::for_exponent(exponent), sink: sums });
        let reflected = facets.seen_per_cosine(cos_out) * sums.reflected.iter().sum::<f64>();
        [sums.irradiance.iter().sum(), reflected]
    }

    /// Returns point sources that are equivalent to the lit ground: unit vectors from the satellite in the body frame,
    /// each with its irradiance on a plate perpendicular to it, relative to that of the Sun.
    ///
    /// There are enough sources for lobes up to `exponent` (see [`crate::photometry::brdf::Law::equivalent_exponent`]).
    pub fn sources(&self, exponent: f64) -> Vec<(Vector3<f64>, f64)> {
        widest_fused(Sum { earth: *self, resolution: Resolution::for_exponent(exponent), sink: Sources(Vec::new()) }).0
    }

    /// Returns the zenith angle e at the ground point with the angle γ, which must be within the cap.
    fn ground_zenith_rad(&self, gamma_rad: f64) -> f64 {
        let (sin, cos) = gamma_rad.sin_cos();
        // tan e = r sin γ / (r cos γ - R)
        sin.atan2(cos - self.ratio)
    }

    fn ring(&self, e_rad: f64) -> Ring {
        let (sin_e, cos_e) = e_rad.sin_cos();
        let sin_nadir = self.ratio * sin_e;
        let cos_nadir = (1.0 - sin_nadir * sin_nadir).sqrt();
        // γ = e - η
        let sin_gamma = sin_e * cos_nadir - cos_e * sin_nadir;
        let cos_gamma = cos_e * cos_nadir + sin_e * sin_nadir;
        Ring {
            sin_nadir,
            cos_nadir,
            // cos(Sun) = level + swing cos φ
            level: cos_gamma * self.sin_sun,
            swing: sin_gamma * self.cos_sun,
            // sin η dη = sin η (R/r) cos e / cos η de
            weight: EARTH_ALBEDO * FRAC_1_PI * sin_nadir * self.ratio * cos_e / cos_nadir,
        }
    }
}

/// Ground points that have the same nadir angle.
struct Ring {
    sin_nadir: f64,
    cos_nadir: f64,
    level: f64,
    swing: f64,
    weight: f64,
}

/// Sources at y ≥ 0. Each of them stands for a second source of the same irradiance at -y.
struct Group {
    x: [f64; LANES],
    y: [f64; LANES],
    z: f64,
    irradiance: [f64; LANES],
}

/// Receiver of sources, which sums their light.
trait Sink {
    fn take<const F: bool>(&mut self, group: &Group);
}

/// The product rule, which passes its sources in groups to a receiver.
struct Sum<S> {
    earth: LitEarth,
    resolution: Resolution,
    sink: S,
}

impl<S: Sink> Kernel for Sum<S> {
    type Output = S;

    #[inline(always)]
    fn run<const F: bool>(mut self) -> S {
        let earth = &self.earth;
        // The whole cap is lit if the Sun is above the horizon at the limb.
        let sun_rad = earth.sun_latitude_rad;
        let cut_from_rad =
            if sun_rad.abs() < earth.ratio.acos() { earth.ground_zenith_rad(sun_rad.abs()) } else { FRAC_PI_2 };
        let nadir_angle = |e_rad: f64| (earth.ratio * e_rad.sin()).asin();
        for (from, to, is_cut) in [(0.0, cut_from_rad, false), (cut_from_rad, FRAC_PI_2, true)] {
            if to <= from || (sun_rad <= 0.0 && !is_cut) {
                continue;
            }
            let rings = Resolution::count(self.resolution.rings, nadir_angle(to) - nadir_angle(from));
            for (s, ds) in Rule::gauss(rings).points() {
                let (share, slope) = if is_cut { (s * s * (2.0 - s), s * (4.0 - 3.0 * s)) } else { (s, 1.0) };
                let ring = earth.ring(from + (to - from) * share);
                let reach = if is_cut { (-ring.level / ring.swing).clamp(-1.0, 1.0).acos() } else { PI };
                let nodes = Resolution::count(self.resolution.arc, ring.sin_nadir * reach);
                let rule = if is_cut { Rule::half_gauss(nodes) } else { Rule::midpoints(nodes) };
                each_group::<F, S>(&ring, reach, (to - from) * slope * ds, rule, &mut self.sink);
            }
        }
        self.sink
    }
}

#[inline(always)]
fn each_group<const F: bool, S: Sink>(ring: &Ring, reach: f64, de: f64, rule: Rule, sink: &mut S) {
    let mut points = rule.points();
    loop {
        let (mut at, mut weight, mut count) = ([0.0; LANES], [0.0; LANES], 0);
        for (x, w) in points.by_ref().take(LANES) {
            (at[count], weight[count]) = (x, w);
            count += 1;
        }
        if count == 0 {
            return;
        }
        let mut group = Group { x: [0.0; LANES], y: [0.0; LANES], z: -ring.cos_nadir, irradiance: [0.0; LANES] };
        for lane in 0..LANES {
            let (sin, cos) = sin_cos::<F>(reach * at[lane]);
            group.x[lane] = ring.sin_nadir * cos;
            group.y[lane] = ring.sin_nadir * sin;
            // Elements beyond the last point have zero weight.
            let cos_sun = greater(fused::<F>(ring.swing, cos, ring.level), 0.0);
            group.irradiance[lane] = ring.weight * reach * de * weight[lane] * cos_sun;
        }
        sink.take::<F>(&group);
    }
}

/// Sums for [`PanelEarthshine`], kept separately for each element of a group.
struct PanelEarthshineSums {
    normal: [f64; 3],
    mirror: [f64; 3],
    exponent: f64,
    irradiance: [f64; LANES],
    lobe: [f64; LANES],
}

impl Sink for PanelEarthshineSums {
    #[inline(always)]
    fn take<const F: bool>(&mut self, group: &Group) {
        let ([nx, ny, nz], [mx, my, mz], exponent) = (self.normal, self.mirror, self.exponent);
        let (mut irradiance, mut lobe) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            for y in [group.y[lane], -group.y[lane]] {
                let cos_in = fused::<F>(nx, group.x[lane], fused::<F>(ny, y, nz * group.z));
                let cos_mirror = fused::<F>(mx, group.x[lane], fused::<F>(my, y, mz * group.z));
                let lit = group.irradiance[lane] * greater(cos_in, 0.0);
                let power = exp::<F>(exponent * ln::<F>(greater(cos_mirror, f64::MIN_POSITIVE)));
                irradiance[lane] += lit;
                lobe[lane] += if cos_mirror > 0.0 { lit * power } else { 0.0 };
            }
        }
        for lane in 0..LANES {
            self.irradiance[lane] += irradiance[lane];
            self.lobe[lane] += lobe[lane];
        }
    }
}

/// Sums of [`LitEarth::shine_on_facets`], lane by lane, without the masking towards the observer.
struct FacetSums {
    facets: Facets,
    to_observer: [f64; 3],
    cos_out: f64,
    /// Cosine of incidence of the last ring, and the masking of facets at it.
    ring: (f64, f64),
    irradiance: [f64; LANES],
    reflected: [f64; LANES],
}

impl Sink for FacetSums {
    #[inline(always)]
    fn take<const F: bool>(&mut self, group: &Group) {
        let cos_in = -group.z;
        if self.ring.0 != cos_in {
            self.ring = (cos_in, self.facets.seen_per_cosine(cos_in));
        }
        let ([ox, oy, oz], variance) = (self.to_observer, self.facets.slope * self.facets.slope);
        let sum_squared = (cos_in + self.cos_out) * (cos_in + self.cos_out);
        // f = D G₁(s) G₁(o) / (4 cos φ_i cos φ_r), D = exp(-tan²β / 2w²) / (2π w² cos⁴β)    see `brdf::Facets`
        let factor = 0.25 * cos_in * self.ring.1 * 0.5 * FRAC_1_PI / variance;
        let mut reflected = [0.0; LANES];
        for (lane, reflected) in reflected.iter_mut().enumerate() {
            for y in [group.y[lane], -group.y[lane]] {
                let cos_phase = fused::<F>(ox, group.x[lane], fused::<F>(oy, y, oz * group.z));
                // 1/cos²β = (2 + 2 s · o) / (cos φ_i + cos φ_r)²
                let secant_squared = greater((2.0 + 2.0 * cos_phase) / sum_squared, 1.0);
                let density = exp::<F>((0.5 - 0.5 * secant_squared) / variance) * secant_squared * secant_squared;
                *reflected += group.irradiance[lane] * density;
            }
        }
        for (lane, reflected) in reflected.iter().enumerate() {
            self.irradiance[lane] += 2.0 * group.irradiance[lane] * cos_in;
            self.reflected[lane] += factor * reflected;
        }
    }
}

/// Receiver that collects the sources in a list.
struct Sources(Vec<(Vector3<f64>, f64)>);

impl Sink for Sources {
    #[inline(always)]
    fn take<const F: bool>(&mut self, group: &Group) {
        for lane in (0..LANES).filter(|&lane| group.irradiance[lane] > 0.0) {
            for y in [group.y[lane], -group.y[lane]] {
                self.0.push((Vector3::new(group.x[lane], y, group.z), group.irradiance[lane]));
            }
        }
    }
}

/// Number of points of the longest single rule. Longer rules are composed of several panels.
const LONGEST: usize = 32;

/// Gauss-Legendre rules of 0 to [`LONGEST`] points on (0, 1).
static GAUSS: LazyLock<Vec<Vec<(f64, f64)>>> = LazyLock::new(|| (0..=LONGEST).map(gauss_legendre).collect());

/// Positive halves of the Gauss-Legendre rules with 0, 2, 4 ... points on (-1, 1).
static HALF_GAUSS: LazyLock<Vec<Vec<(f64, f64)>>> = LazyLock::new(|| {
    let half = |n: usize| gauss_legendre(2 * n)[n..].iter().map(|(x, weight)| (2.0 * x - 1.0, 2.0 * weight)).collect();
    (0..=LONGEST).map(half).collect()
});

/// Quadrature rule that consists of equal panels with the same short rule.
#[derive(Copy, Clone)]
pub(super) struct Rule {
    panels: usize,
    points: &'static [(f64, f64)],
}

impl Rule {
    /// Returns a Gauss-Legendre rule with about `n` points.
    pub fn gauss(n: usize) -> Self {
        let n = n.max(1);
        let panels = n.div_ceil(LONGEST);
        Self { panels, points: &GAUSS[n.div_ceil(panels)] }
    }

    /// Returns about `n` points in the half (0, 1) of an integral over (-1, 1); each of them also stands for its mirror
    /// image.
    pub fn half_gauss(n: usize) -> Self {
        if n <= LONGEST { Self { panels: 1, points: &HALF_GAUSS[n.max(1)] } } else { Self::gauss(n) }
    }

    /// Returns the midpoints of `n` equal steps, which suit periodic functions.
    pub fn midpoints(n: usize) -> Self {
        Self { panels: n.max(1), points: &GAUSS[1] }
    }

    /// Returns the abscissae and weights; the weights sum to 1.
    #[inline(always)]
    pub fn points(self) -> impl Iterator<Item = (f64, f64)> {
        let length = 1.0 / self.panels as f64;
        let panel =
            move |panel| self.points.iter().map(move |(x, weight)| ((panel as f64 + x) * length, weight * length));
        (0..self.panels).flat_map(panel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_powers_are_integrated_exactly() {
        for n in [1, 2, 5, 16, 32, 33, 70] {
            for power in 0..2 * n.min(LONGEST / 2) as i32 {
                let sum: f64 = Rule::gauss(n).points().map(|(x, weight)| weight * x.powi(power)).sum();
                assert!((sum * f64::from(power + 1) - 1.0).abs() < 1e-12, "{n} {power} {sum}");
                let even: f64 =
                    Rule::half_gauss(n).points().map(|(x, weight)| weight * (x.powi(power) + (-x).powi(power))).sum();
                let exact = if power % 2 == 0 { 2.0 } else { 0.0 };
                assert!((even * f64::from(power + 1) - exact).abs() < 1e-12, "{n} {power} {even}");
            }
            let turn: f64 = Rule::midpoints(n).points().map(|(x, weight)| weight * (6.0 * x - 3.0)).sum();
            assert!(turn.abs() < 1e-13);
        }
    }
}
