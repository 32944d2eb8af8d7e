//! The lit Earth as a set of small sources, and what panels make of its light.

use nalgebra::Vector3;

use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::photometry::brdf::{Brdf, Lambert, Phong};
use crate::photometry::panel::{Incidence, Panel};

use super::albedo::Albedo;
use super::arithmetic::{greater, lobe_powers};
use super::cap::{CHUNK, Chunk, LitCap, Resolution};

/// What a panel receives of the Earth's light, and what of it a glossy lobe about one observer gathers.
///
/// Both are relative to the Sun's irradiance on a plate square to it.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Shine {
    /// Irradiance on the panel: Σ dE cos φ_i, dimensionless.
    pub irradiance: f64,
    /// Σ dE cos φ_i cosⁿθ, θ between the mirror direction of each source and the observer.
    pub lobe: f64,
}

/// Earthshine that a panel sends to an observer, the two laws apart; m² sr⁻¹, cosines and area included.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct EarthTerms {
    /// By its glossy lobe.
    pub glossy_m2_sr: f64,
    /// By its diffuse law.
    pub diffuse_m2_sr: f64,
}

impl Shine {
    /// On a panel with this unit normal (body frame) under an Earth of uniform albedo, for one observer and one
    /// exponent (0 to 10,000). Nothing is allocated; 1 to 5 µs at n = 22.
    ///
    /// Zero where no ground in view is lit, or the satellite does not stand above the ground.
    pub fn on_panel(
        sun_latitude_rad: f64,
        height_km: f64,
        albedo: f64,
        normal: &Vector3<f64>,
        to_observer: &Vector3<f64>,
        exponent: f64,
    ) -> Self {
        let mut shine = Self::default();
        let Some(cap) = LitCap::new(sun_latitude_rad, height_km) else { return shine };
        let mirror = mirrored(normal, to_observer);
        cap.nodes(&Resolution::for_exponent(exponent), |chunk| {
            let n = chunk.len;
            let columns = Columns {
                x: &chunk.x[..n],
                y: &chunk.y[..n],
                z: &chunk.z[..n],
                left: &chunk.irradiance[..n],
                right: &chunk.irradiance[..n],
            };
            columns.add(normal, &mirror, exponent, &mut shine);
        });
        Self { irradiance: shine.irradiance * albedo, lobe: shine.lobe * albedo }
    }

    /// Sent on by a panel of two laws, with cos φ_r of the observer (0 or less: it stands behind).
    pub fn reflected(&self, area_m2: f64, cos_out: f64, diffuse: &Lambert, glossy: &Phong) -> EarthTerms {
        let seen_m2 = area_m2 * cos_out.max(0.0);
        EarthTerms {
            // The laws of the paper's section 2.1, light from each part of the Earth in place of the Sun's.
            glossy_m2_sr: glossy.peak_per_sr() * self.lobe * seen_m2,
            diffuse_m2_sr: diffuse.per_sr() * self.irradiance * seen_m2,
        }
    }
}

/// Direction that the panel mirrors onto the observer: cos θ of a source is its cosine with this.
fn mirrored(normal: &Vector3<f64>, to_observer: &Vector3<f64>) -> Vector3<f64> {
    // m = 2 (n · o) n - o
    normal * (2.0 * normal.dot(to_observer)) - to_observer
}

/// Nodes and their mirror images, each with its own irradiance.
struct Columns<'a> {
    x: &'a [f64],
    y: &'a [f64],
    z: &'a [f64],
    left: &'a [f64],
    right: &'a [f64],
}

impl Columns<'_> {
    /// At most [`CHUNK`] of them.
    fn add(&self, normal: &Vector3<f64>, mirror: &Vector3<f64>, exponent: f64, shine: &mut Shine) {
        let n = self.x.len();
        let (mut cosines, mut lit) = ([0.0; 2 * CHUNK], [0.0; 2 * CHUNK]);
        let (left, right) = cosines[..2 * n].split_at_mut(n);
        let (lit_left, lit_right) = lit[..2 * n].split_at_mut(n);
        for i in 0..n {
            // cos θ and dE cos φ_i of the node and of its image
            let (even, odd) = (self.x[i] * mirror.x + self.z[i] * mirror.z, self.y[i] * mirror.y);
            left[i] = even + odd;
            right[i] = even - odd;
            let (even, odd) = (self.x[i] * normal.x + self.z[i] * normal.z, self.y[i] * normal.y);
            lit_left[i] = self.left[i] * greater(even + odd, 0.0);
            lit_right[i] = self.right[i] * greater(even - odd, 0.0);
        }
        lobe_powers(&mut cosines[..2 * n], exponent);
        let (irradiance, lobe) = sums(&lit[..2 * n], &cosines[..2 * n]);
        shine.irradiance += irradiance;
        shine.lobe += lobe;
    }
}

/// Σ a and Σ a b of two columns of one length, four by four: no sum waits for the one before.
fn sums(a: &[f64], b: &[f64]) -> (f64, f64) {
    let (mut sum, mut product) = ([0.0; 4], [0.0; 4]);
    let (a_fours, b_fours) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = a_fours.remainder().iter().zip(b_fours.remainder());
    let (rest_sum, rest_product) = rest.fold((0.0, 0.0), |(sum, product), (a, b)| (sum + a, product + a * b));
    for (a, b) in a_fours.zip(b_fours) {
        for i in 0..4 {
            sum[i] += a[i];
            product[i] += a[i] * b[i];
        }
    }
    let total = |lanes: [f64; 4]| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    (total(sum) + rest_sum, total(product) + rest_product)
}

/// The lit ground in view of a satellite, as directions and irradiances: made once for one Sun and height, asked for
/// many observers and panels.
///
/// Directions are unit vectors in the body frame (z to the zenith, the Sun in the zx half plane), *to* the ground;
/// irradiances are on a plate square to them, relative to the Sun's own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EarthshineNodes {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    left: Vec<f64>,
    right: Vec<f64>,
}

impl EarthshineNodes {
    /// For lobes up to this exponent (0: diffuse light alone). Empty where no ground in view is lit.
    pub fn new(sun_latitude_rad: f64, height_km: f64, albedo: &Albedo, exponent: f64) -> Self {
        let mut nodes = Self::default();
        nodes.lay(sun_latitude_rad, height_km, albedo, exponent);
        nodes
    }

    /// As [`Self::new`], into the memory that is there.
    pub fn lay(&mut self, sun_latitude_rad: f64, height_km: f64, albedo: &Albedo, exponent: f64) {
        self.lay_with(sun_latitude_rad, height_km, albedo, &Resolution::for_exponent(exponent));
    }

    /// As [`Self::new`] with `times` as many nodes in either direction: to see what is left of the rule's error.
    pub fn finer(sun_latitude_rad: f64, height_km: f64, albedo: &Albedo, exponent: f64, times: f64) -> Self {
        let mut nodes = Self::default();
        nodes.lay_with(sun_latitude_rad, height_km, albedo, &Resolution::for_exponent(exponent).finer(times));
        nodes
    }

    fn lay_with(&mut self, sun_latitude_rad: f64, height_km: f64, albedo: &Albedo, resolution: &Resolution) {
        for column in [&mut self.x, &mut self.y, &mut self.z, &mut self.left, &mut self.right] {
            column.clear();
        }
        let Some(cap) = LitCap::new(sun_latitude_rad, height_km) else { return };
        cap.nodes(resolution, |chunk: &Chunk| {
            self.x.extend_from_slice(&chunk.x[..chunk.len]);
            self.y.extend_from_slice(&chunk.y[..chunk.len]);
            self.z.extend_from_slice(&chunk.z[..chunk.len]);
            self.left.extend_from_slice(&chunk.irradiance[..chunk.len]);
        });
        self.right.extend_from_slice(&self.left);
        let ratio = EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + height_km);
        for i in 0..self.x.len() {
            let ground = ground_below(&Vector3::new(self.x[i], self.y[i], self.z[i]), ratio);
            self.left[i] *= albedo.at(&ground);
            self.right[i] *= albedo.at(&Vector3::new(ground.x, -ground.y, ground.z));
        }
    }

    /// How many sources there are.
    pub fn len(&self) -> usize {
        2 * self.x.len()
    }

    /// True where no ground in view is lit.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Direction and irradiance of each.
    pub fn sources(&self) -> impl Iterator<Item = (Vector3<f64>, f64)> {
        (0..self.x.len()).flat_map(|i| {
            let (x, y, z) = (self.x[i], self.y[i], self.z[i]);
            [(Vector3::new(x, y, z), self.left[i]), (Vector3::new(x, -y, z), self.right[i])]
        })
    }

    /// On a panel with this unit normal, for one observer and an exponent not above that of the nodes.
    pub fn shine(&self, normal: &Vector3<f64>, to_observer: &Vector3<f64>, exponent: f64) -> Shine {
        let mirror = mirrored(normal, to_observer);
        let mut shine = Shine::default();
        for from in (0..self.x.len()).step_by(CHUNK) {
            let span = from..(from + CHUNK).min(self.x.len());
            let columns = Columns {
                x: &self.x[span.clone()],
                y: &self.y[span.clone()],
                z: &self.z[span.clone()],
                left: &self.left[span.clone()],
                right: &self.right[span],
            };
            columns.add(normal, &mirror, exponent, &mut shine);
        }
        shine
    }

    /// Sent on by the front of any panel of any law: Σ dE f cos φ_i cos φ_r A, m² sr⁻¹.
    pub fn reflected_m2_sr(&self, panel: &Panel, law: &impl Brdf, to_observer: &Vector3<f64>) -> f64 {
        self.sources()
            .map(|(to_source, irradiance)| {
                irradiance * panel.front_m2_sr(law, &Incidence::new(&panel.normal, &to_source, to_observer))
            })
            .sum()
    }
}

/// Point of the ground (unit vector from the Earth's centre, body axes) in a direction below the horizon; `ratio` is
/// R/(R+h).
fn ground_below(direction: &Vector3<f64>, ratio: f64) -> Vector3<f64> {
    let (sin_nadir, cos_nadir) = (direction.x.hypot(direction.y), -direction.z);
    // R p = (R+h) z + d w, and d from |p| = 1: d/R = cos η / k - sqrt(1 - sin²η/k²), k = R/(R+h)
    let (far, across) = (cos_nadir / ratio, sin_nadir / ratio);
    let distance = far - (1.0 - across * across).max(0.0).sqrt();
    Vector3::new(direction.x * distance, direction.y * distance, 1.0 / ratio - cos_nadir * distance)
}
