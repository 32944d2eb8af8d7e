//! The sunlit part of the Earth that a satellite sees, as nodes of a product rule.
//!
//! Seen from the height h, a spherical Earth fills a cap about the nadir. A point of it at the nadir angle η (at the
//! satellite), the angle γ (at the Earth's centre) and the longitude φ about the nadir from the Sun's sends an
//! irradiance, relative to the Sun's own on a plate square to it, of
//!
//! ```text
//! dE = (albedo/π) cos(Sun) cos(view) dA / d² = (albedo/π) cos(Sun) sin η dη dφ
//! cos(Sun) = cos γ sin δ + sin γ cos δ cos φ                     δ the Sun's latitude above the chassis plane
//! ```
//!
//! Neither γ nor η is a good variable: η runs off with a square root at the limb, and γ is crowded below a low satellite.
//! The zenith angle e of the satellite at the ground, 0 to π/2, is regular at both ends:
//!
//! ```text
//! sin η = R/(R+h) sin e        γ = e - η
//! ```
//!
//! Where the Sun stands below the height at which the whole cap is lit, φ is cut at the terminator, cos φ = -tan δ / tan γ.
//! The cut opens with a square root at γ = |δ|; the substitution e = e₀ + (π/2 - e₀) s² (2 - s) takes it away, and hardly stretches the rest. A Sun above the
//! chassis plane, lower than that, lights full circles up to γ = δ and cut ones beyond, as two pieces. Gauss-Legendre
//! rules in e (or s) and φ; equal steps on full circles.
//!
//! Nothing is lit below δ = -acos(R/(R+h)): -23.0° at 550 km.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;

use super::arithmetic::{greater, half_turn_sin_cos};
use super::rule;

/// Nodes that are handed over together.
pub(super) const CHUNK: usize = 64;

/// How many nodes are laid: by the width of the lobe that they are to resolve.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Resolution {
    /// Rings at least, and by radian of nadir angle.
    pub rings: [f64; 2],
    /// Nodes on half a ring at least, and by radian of arc on the sky.
    pub arc: [f64; 2],
}

impl Resolution {
    /// For a lobe cosⁿθ (n = 0: diffuse light alone); errors in the docs of [`super`].
    pub fn for_exponent(exponent: f64) -> Self {
        // The lobe is exp(-n θ²/2) near its middle: 1/√n is its scale in radians.
        let narrowness = exponent.max(0.0).sqrt();
        // A broad lobe ends with a kink 90° off; rules of this kind see it only by their number.
        let kink = 1.0 / exponent.max(1.0).powi(2);
        Self {
            rings: [4.3 + 0.4 * narrowness + 16.0 * kink, 0.65 * narrowness + 0.014 * narrowness * narrowness],
            arc: [1.6 + 0.15 * narrowness + 11.0 * kink, 0.62 * narrowness + 0.02 * narrowness * narrowness],
        }
    }

    /// `times` as many nodes in either direction.
    pub fn finer(self, times: f64) -> Self {
        Self { rings: self.rings.map(|n| n * times), arc: self.arc.map(|n| n * times) }
    }
}

/// Nodes with their mirror images in the zx plane: each stands for two.
pub(super) struct Chunk {
    /// Unit vectors from the satellite; y is at least 0, and -y is meant too.
    pub x: [f64; CHUNK],
    pub y: [f64; CHUNK],
    pub z: [f64; CHUNK],
    /// Irradiance for an albedo of 1, relative to the Sun's on a plate square to it, of each of the two.
    pub irradiance: [f64; CHUNK],
    /// How many there are.
    pub len: usize,
}

impl Chunk {
    pub fn empty() -> Self {
        Self { x: [0.0; CHUNK], y: [0.0; CHUNK], z: [0.0; CHUNK], irradiance: [0.0; CHUNK], len: 0 }
    }
}

/// What all nodes of one ring share.
struct Ring {
    sin_nadir: f64,
    cos_nadir: f64,
    level: f64,
    swing: f64,
    weight: f64,
}

impl Chunk {
    fn make_room(&mut self, n: usize, take: &mut impl FnMut(&Chunk)) {
        if self.len + n > CHUNK {
            take(self);
            self.len = 0;
        }
    }

    /// Nodes at φ = start + length · at with the weights scale · weight.
    fn lay(&mut self, ring: &Ring, (start, length): (f64, f64), scale: f64, (at, weight): (&[f64], &[f64])) {
        let span = self.len..self.len + at.len();
        let weight_of_ring = ring.weight * scale;
        let (x, y) = (&mut self.x[span.clone()], &mut self.y[span.clone()]);
        let (z, irradiance) = (&mut self.z[span.clone()], &mut self.irradiance[span]);
        for (((((x, y), z), irradiance), at), weight) in x.iter_mut().zip(y).zip(z).zip(irradiance).zip(at).zip(weight)
        {
            let (sin, cos) = half_turn_sin_cos(start + length * at);
            let cos_sun = ring.level + ring.swing * cos;
            *x = ring.sin_nadir * cos;
            *y = ring.sin_nadir * sin;
            *z = -ring.cos_nadir;
            *irradiance = weight_of_ring * weight * greater(cos_sun, 0.0);
        }
        self.len += at.len();
    }
}

/// One Sun and one height.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct LitCap {
    sin_sun: f64,
    cos_sun: f64,
    sun_latitude_rad: f64,
    /// R/(R+h).
    ratio: f64,
}

/// How far below the chassis plane the Sun can stand and still light ground in view: acos(R/(R+h)).
pub(super) fn dip_rad(height_km: f64) -> f64 {
    (EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + height_km)).acos()
}

impl LitCap {
    /// `None` where no ground in view is lit, the satellite does not stand above the ground, or a number is not finite.
    pub fn new(sun_latitude_rad: f64, height_km: f64) -> Option<Self> {
        let sound = height_km > 0.0 && height_km.is_finite() && sun_latitude_rad.abs() <= FRAC_PI_2;
        if !sound || sun_latitude_rad <= -dip_rad(height_km) {
            return None;
        }
        let (sin_sun, cos_sun) = sun_latitude_rad.sin_cos();
        let ratio = EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + height_km);
        Some(Self { sin_sun, cos_sun, sun_latitude_rad, ratio })
    }

    /// Hands over all nodes, some at a time.
    pub fn nodes(&self, resolution: &Resolution, mut take: impl FnMut(&Chunk)) {
        let mut chunk = Chunk::empty();
        // The whole cap is lit where the Sun stands above the ground at the limb.
        let cut_from = if self.sun_latitude_rad.abs() < self.ratio.acos() {
            self.ground_zenith_rad(self.sun_latitude_rad.abs())
        } else {
            FRAC_PI_2
        };
        if self.sun_latitude_rad > 0.0 {
            self.piece(0.0, cut_from, false, resolution, &mut chunk, &mut take);
        }
        if cut_from < FRAC_PI_2 {
            self.piece(cut_from, FRAC_PI_2, true, resolution, &mut chunk, &mut take);
        }
        if chunk.len > 0 {
            take(&chunk);
        }
    }

    /// e of a point at γ, within the cap.
    fn ground_zenith_rad(&self, gamma: f64) -> f64 {
        let (sin, cos) = gamma.sin_cos();
        // tan e = r sin γ / (r cos γ - R)
        sin.atan2(cos - self.ratio)
    }

    fn piece(
        &self,
        from: f64,
        to: f64,
        cut: bool,
        resolution: &Resolution,
        chunk: &mut Chunk,
        take: &mut impl FnMut(&Chunk),
    ) {
        let nadir_angle = |e: f64| (self.ratio * e.sin()).asin();
        let sky = nadir_angle(to) - nadir_angle(from);
        let rings = (resolution.rings[0] + resolution.rings[1] * sky).ceil() as usize;
        rule::whole(rings, |s, weight| {
            let (e, de) = if cut {
                (from + (to - from) * s * s * (2.0 - s), weight * (to - from) * s * (4.0 - 3.0 * s))
            } else {
                (from + (to - from) * s, weight * (to - from))
            };
            self.ring(e, de, cut, resolution, chunk, take);
        });
    }

    fn ring(
        &self,
        e: f64,
        de: f64,
        cut: bool,
        resolution: &Resolution,
        chunk: &mut Chunk,
        take: &mut impl FnMut(&Chunk),
    ) {
        let (sin_e, cos_e) = e.sin_cos();
        let sin_nadir = self.ratio * sin_e;
        let cos_nadir = (1.0 - sin_nadir * sin_nadir).sqrt();
        // γ = e - η
        let sin_gamma = sin_e * cos_nadir - cos_e * sin_nadir;
        let cos_gamma = cos_e * cos_nadir + sin_e * sin_nadir;
        // cos(Sun) = level + swing cos φ
        let (level, swing) = (cos_gamma * self.sin_sun, sin_gamma * self.cos_sun);
        let reach = if cut { (-level / swing).clamp(-1.0, 1.0).acos() } else { PI };
        // sin η dη = sin η (R/r) cos e / cos η de
        let weight = FRAC_1_PI * sin_nadir * self.ratio * cos_e / cos_nadir * de * reach;
        let n = (resolution.arc[0] + resolution.arc[1] * sin_nadir * reach).ceil() as usize;
        let ring = Ring { sin_nadir, cos_nadir, level, swing, weight };
        if cut {
            rule::half(n, |start, length, rule| {
                chunk.make_room(rule.at.len(), take);
                chunk.lay(&ring, (reach * start, reach * length), length, (&rule.at, &rule.weight));
            });
        } else {
            let step = 1.0 / n as f64;
            for first in (0..n).step_by(rule::LONGEST) {
                let more = (n - first).min(rule::LONGEST);
                chunk.make_room(more, take);
                let start = reach * (first as f64 + 0.5) * step;
                chunk.lay(&ring, (start, reach * step), step, (&rule::COUNT[..more], &rule::ONES[..more]));
            }
        }
    }
}
