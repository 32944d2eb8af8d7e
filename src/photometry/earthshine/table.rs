//! Earthshine on a chassis that looks straight down, tabulated for one exponent: for maps and fits.
//!
//! What is tabulated is smooth: the irradiance on the chassis divided by τ^3.5, and the lobe's sum divided by the irradiance.
//! τ = δ + acos(R/(R+h)) is how far the Sun stands above the last light; the lit lens is τ wide, √τ long, and both
//! cosines in it are of order τ at its middle, hence the power. The Sun's axis is that of the satellite's zenith angle at
//! the terminator, sin η = R/(R+h) sin e, δ = e - η (negative where the terminator stands towards the Sun): it stretches
//! the few degrees in which the terminator runs through what a low satellite has right below. The lobe depends on the mirror direction of the observer,
//! laid on a plane by Lambert's equal-area projection about the nadir (no pole, and symmetric in the zx plane).
//! Between the nodes: cubics through four of them on each axis.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::albedo::{Albedo, PAPER_ALBEDO};
use super::cap::dip_rad;
use super::nodes::{EarthshineNodes, Shine};

/// The irradiance goes as τ to this power near the last light.
const FADING: f64 = 3.5;
/// Step of the Sun's axis times the lobe's narrowness, radians.
const SUN_STEP: f64 = 0.22;
/// Stands for τ = 0, radians.
const LEAST_TAU: f64 = 1e-4;

/// Equal steps on one axis.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Axis {
    from: f64,
    step: f64,
    n: usize,
}

/// Four neighbouring nodes and their weights; on an axis of one node that node four times.
struct Stencil {
    first: isize,
    weight: [f64; 4],
}

impl Axis {
    /// Steps of at most `step` between the ends; one node where the ends are one.
    fn new(from: f64, to: f64, step: f64) -> Self {
        if to <= from {
            return Self { from, step: 1.0, n: 1 };
        }
        let n = ((to - from) / step).ceil().max(3.0) as usize + 1;
        Self { from, step: (to - from) / (n - 1) as f64, n }
    }

    fn node(&self, i: usize) -> f64 {
        self.from + self.step * i as f64
    }

    /// `mirrored`: the function is even about the first node, so nodes before it are those after it.
    fn stencil(&self, value: f64, mirrored: bool) -> Stencil {
        if self.n == 1 {
            return Stencil { first: 0, weight: [1.0, 0.0, 0.0, 0.0] };
        }
        let at = (value - self.from) / self.step;
        let least = if mirrored { -1 } else { 0 };
        let first = (at.floor() as isize - 1).clamp(least, self.n as isize - 4);
        // Lagrange's cubic through nodes 0, 1, 2, 3.
        let t = at - first as f64;
        let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
        Stencil { first, weight: [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0] }
    }
}

impl Stencil {
    fn index(&self, i: usize, axis: &Axis) -> usize {
        // An axis of one node has weights for it alone.
        (self.first + i as isize).unsigned_abs().min(axis.n - 1)
    }
}

/// Zenith angle of the satellite at the terminator, e of the module's docs, radians; beyond π/2 on the far side of the limb.
fn terminator(sun_latitude_rad: f64, ratio: f64) -> f64 {
    let (sin, cos) = sun_latitude_rad.sin_cos();
    sin.atan2(cos - ratio)
}

/// The same for the lowest Sun that lights anything, or that is asked for, and for the highest.
fn terminators([lowest, highest]: [f64; 2], dip: f64) -> [f64; 2] {
    [lowest, highest].map(|sun| terminator(sun.max(-dip), dip.cos()))
}

/// Irradiance and lobe of the paper's earthshine (albedo 0.3) on a chassis that looks straight down.
#[derive(Clone, Debug, PartialEq)]
pub struct EarthshineTable {
    exponent: f64,
    sun_latitude_rad: [f64; 2],
    /// In the dip of the horizon, radians.
    height: Axis,
    /// From the last light (or the lowest Sun asked for) to the highest, as shares.
    sun: Axis,
    /// Of the irradiance on `sun`'s range, finer.
    sun_fine: Axis,
    x: Axis,
    y: Axis,
    /// (height, sun_fine): irradiance / τ^3.5.
    irradiance: Vec<f64>,
    /// (height, sun, y, x): lobe / irradiance.
    lobe: Vec<f32>,
}

impl EarthshineTable {
    /// For one exponent of the chassis' lobe (1 to 200), heights [least, greatest] in km and Sun latitudes in radians.
    ///
    /// Uses rayon's current pool. `None` where a range is reversed, no number, beyond ±π/2 or not above the ground, or
    /// the exponent beyond its own.
    pub fn new(exponent: f64, height_km: [f64; 2], sun_latitude_rad: [f64; 2]) -> Option<Self> {
        let within = |[from, to]: [f64; 2], least: f64, greatest: f64| least <= from && from <= to && to <= greatest;
        let half_turn = std::f64::consts::FRAC_PI_2;
        if !(within(height_km, 1.0, 1e6)
            && within(sun_latitude_rad, -half_turn, half_turn)
            && (1.0..=200.0).contains(&exponent))
        {
            return None;
        }
        let dips = height_km.map(dip_rad);
        // The scale of what is tabulated is the lobe's width, smoothed by the Earth's; found by trial, held by tests.
        let narrowness = exponent.max(20.0).sqrt();
        let disc = std::f64::consts::SQRT_2;
        let height = Axis::new(dips[0], dips[1], 0.16 / narrowness);
        let longest = dips.map(|dip| {
            let [least, greatest] = terminators(sun_latitude_rad, dip);
            greatest - least
        });
        let shares = |step: f64| Axis::new(0.0, 1.0, (step / longest[0].max(longest[1]).max(1e-3)).min(0.25));
        let mut table = Self {
            exponent,
            sun_latitude_rad,
            height,
            sun: shares(SUN_STEP / narrowness),
            sun_fine: shares(0.025),
            x: Axis::new(-disc, disc, 0.26 / narrowness),
            y: Axis::new(0.0, disc, 0.26 / narrowness),
            irradiance: Vec::new(),
            lobe: Vec::new(),
        };
        table.irradiance = (0..height.n * table.sun_fine.n)
            .into_par_iter()
            .map(|i| {
                table.irradiance_node(height.node(i / table.sun_fine.n), table.sun_fine.node(i % table.sun_fine.n))
            })
            .collect();
        table.lobe = (0..height.n * table.sun.n)
            .into_par_iter()
            .flat_map_iter(|i| table.lobe_nodes(height.node(i / table.sun.n), table.sun.node(i % table.sun.n)))
            .collect();
        Some(table)
    }

    /// The exponent it was made for.
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Memory of its numbers, bytes.
    pub fn size_bytes(&self) -> usize {
        size_of_val(self.irradiance.as_slice()) + size_of_val(self.lobe.as_slice())
    }

    /// On the chassis, for an observer in this direction (unit vector in the body frame).
    ///
    /// `None` outside the heights and Sun latitudes that it was made for; zero where no ground in view is lit or the
    /// observer stands above the chassis plane.
    pub fn shine(&self, sun_latitude_rad: f64, height_km: f64, to_observer: &Vector3<f64>) -> Option<Shine> {
        let dip = dip_rad(height_km);
        let slack = 1e-9;
        let span = [self.height.node(0), self.height.node(self.height.n - 1)];
        let covered = span[0] - slack <= dip
            && dip <= span[1] + slack
            && self.sun_latitude_rad[0] - slack <= sun_latitude_rad
            && sun_latitude_rad <= self.sun_latitude_rad[1] + slack;
        if !covered {
            return None;
        }
        let tau = sun_latitude_rad + dip;
        if tau <= 0.0 || to_observer.z >= 0.0 {
            return Some(Shine::default());
        }
        let [least, greatest] = terminators(self.sun_latitude_rad, dip);
        let at = terminator(sun_latitude_rad, dip.cos());
        let share = if greatest > least { (at - least) / (greatest - least) } else { 0.0 };
        let height = self.height.stencil(dip, false);
        let fine = self.sun_fine.stencil(share, false);
        let mut scaled = 0.0;
        for (i, height_weight) in height.weight.iter().enumerate() {
            let row = &self.irradiance[height.index(i, &self.height) * self.sun_fine.n..][..self.sun_fine.n];
            for (j, sun_weight) in fine.weight.iter().enumerate() {
                scaled += height_weight * sun_weight * row[fine.index(j, &self.sun_fine)];
            }
        }
        let irradiance = (scaled * tau.powf(FADING)).max(0.0);
        Some(Shine { irradiance, lobe: irradiance * self.lobe_share(&height, share, to_observer) })
    }

    fn lobe_share(&self, height: &Stencil, share: f64, to_observer: &Vector3<f64>) -> f64 {
        // Lambert's projection of the mirror direction (-x, -y, z): ρ = √(2 (1 - c)), c the nadir's cosine.
        let stretch = (2.0 / (1.0 - to_observer.z)).sqrt();
        let x = self.x.stencil(-to_observer.x * stretch, false);
        let y = self.y.stencil(to_observer.y.abs() * stretch, true);
        let sun = self.sun.stencil(share, false);
        let x_first = x.first.unsigned_abs();
        let x_weight = x.weight.map(|weight| weight as f32);
        let columns: [usize; 4] = std::array::from_fn(|k| y.index(k, &self.y) * self.x.n + x_first);
        let (mut sum, plane) = (0.0, self.x.n * self.y.n);
        for (i, height_weight) in height.weight.iter().enumerate() {
            if *height_weight == 0.0 {
                continue;
            }
            for (j, sun_weight) in sun.weight.iter().enumerate() {
                let from = (height.index(i, &self.height) * self.sun.n + sun.index(j, &self.sun)) * plane;
                let mut part = [0.0_f32; 4];
                for (column, y_weight) in columns.iter().zip(&y.weight) {
                    let row = &self.lobe[from + column..][..4];
                    for (part, value) in part.iter_mut().zip(row) {
                        *part += *y_weight as f32 * value;
                    }
                }
                let line: f32 = part.iter().zip(&x_weight).map(|(part, weight)| part * weight).sum();
                sum += height_weight * sun_weight * f64::from(line);
            }
        }
        sum.max(0.0)
    }

    /// Sun latitude, τ and height of a node.
    fn place(&self, dip: f64, share: f64) -> (f64, f64, f64) {
        let [least, greatest] = terminators(self.sun_latitude_rad, dip);
        let e = least + share * (greatest - least);
        let sun = (e - (dip.cos() * e.sin()).asin()).clamp(LEAST_TAU - dip, std::f64::consts::FRAC_PI_2);
        let radius = crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
        (sun, sun + dip, radius / dip.cos() - radius)
    }

    fn irradiance_node(&self, dip: f64, share: f64) -> f64 {
        let (sun, tau, height_km) = self.place(dip, share);
        // Diffuse light asks for few nodes; these are those of a lobe of 60.
        let nodes = EarthshineNodes::new(sun, height_km, &Albedo::Uniform(PAPER_ALBEDO), 60.0);
        nodes.shine(&-Vector3::z(), &-Vector3::z(), 1.0).irradiance / tau.powf(FADING)
    }

    fn lobe_nodes(&self, dip: f64, share: f64) -> Vec<f32> {
        let (sun, _, height_km) = self.place(dip, share);
        // The table's own error stays for the interpolation.
        let nodes = EarthshineNodes::finer(sun, height_km, &Albedo::Uniform(PAPER_ALBEDO), self.exponent, 1.2);
        let down = -Vector3::z();
        let mut plane = Vec::with_capacity(self.x.n * self.y.n);
        for j in 0..self.y.n {
            for i in 0..self.x.n {
                let (x, y) = (self.x.node(i), self.y.node(j));
                let rho2 = x * x + y * y;
                // Corners that no stencil of an observer below the chassis plane reaches.
                let reach = std::f64::consts::SQRT_2 + 3.0 * self.x.step.max(self.y.step);
                if rho2 > reach * reach {
                    plane.push(0.0);
                    continue;
                }
                // c = 1 - ρ²/2, sin = ρ √(1 - ρ²/4); the observer mirrors the node.
                let along = (1.0 - 0.25 * rho2).max(0.0).sqrt();
                let to_observer = Vector3::new(-x * along, -y * along, 0.5 * rho2 - 1.0);
                let shine = nodes.shine(&down, &to_observer, self.exponent);
                plane.push(if shine.irradiance > 0.0 { (shine.lobe / shine.irradiance) as f32 } else { 0.0 });
            }
        }
        plane
    }
}
