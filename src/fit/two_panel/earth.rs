//! The Earth's light on the chassis at each point, ready for any exponent.
//!
//! The diffuse part needs no exponent. The glossy one, (n+2)/2π Σ dE cos φ_i cosⁿθ, is smooth in ln n: its values at Chebyshev's
//! nodes are kept for each point, and interpolated by weights that all points share (Berrut and Trefethen 2004, SIAM
//! Review 46, 501, eq. 4.2).

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use nalgebra::Vector3;

use crate::fit::form::BLOCK;
use crate::fit::point::FitPoint;
use crate::photometry::earthshine::{PAPER_ALBEDO, Shine};

use super::shape::{EXPONENTS, TwoPanelForm};

/// How many nodes: the interpolation is good to 1e-5 of the diffuse light.
pub(super) const NODES: usize = 16;

/// One block of points, m² sr⁻¹ of coefficients of 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EarthBlock {
    /// Of c5.
    pub diffuse: [f64; BLOCK],
    /// Of c4, at each node; in single precision (6e-8), which halves what the loops have to read.
    pub glossy: Box<[[f32; BLOCK]; NODES]>,
}

impl EarthBlock {
    pub fn new(form: &TwoPanelForm, points: &[FitPoint], exponents: &Exponents) -> Self {
        let base_m2 = form.shape.base_length_m * form.shape.base_width_m;
        let down = -Vector3::z();
        let mut block = Self { diffuse: [0.0; BLOCK], glossy: Box::new([[0.0; BLOCK]; NODES]) };
        for (lane, point) in points.iter().enumerate() {
            let g = &point.geometry;
            let to_observer = g.to_observer();
            let seen_m2 = base_m2 * to_observer.vector().dot(&down).max(0.0);
            if seen_m2 == 0.0 {
                continue;
            }
            for (exponent, row) in exponents.nodes.iter().zip(block.glossy.iter_mut()) {
                let shine = Shine::on_panel(
                    g.sun_latitude_rad,
                    g.height_km,
                    PAPER_ALBEDO,
                    &down,
                    to_observer.vector(),
                    *exponent,
                );
                row[lane] = ((exponent + 2.0) / TAU * shine.lobe * seen_m2) as f32;
                block.diffuse[lane] = FRAC_1_PI * shine.irradiance * seen_m2;
                if shine.irradiance == 0.0 {
                    break;
                }
            }
        }
        block
    }
}

/// Exponents at which the glossy part is known.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Exponents {
    pub nodes: [f64; NODES],
    /// ln n of the nodes.
    logarithms: [f64; NODES],
    barycentric: [f64; NODES],
}

impl Exponents {
    pub fn new() -> Self {
        let [least, greatest] = EXPONENTS.map(f64::ln);
        let angle = |k: usize| PI * (k as f64 + 0.5) / NODES as f64;
        let logarithms: [f64; NODES] =
            std::array::from_fn(|k| 0.5 * (least + greatest) - 0.5 * (greatest - least) * angle(k).cos());
        // Chebyshev points of the first kind: w_k = (-1)^k sin((2k + 1) π / 2K)
        let barycentric = std::array::from_fn(|k| if k % 2 == 0 { angle(k).sin() } else { -angle(k).sin() });
        Self { nodes: logarithms.map(f64::exp), logarithms, barycentric }
    }

    /// What each node counts for at an exponent.
    pub fn weights(&self, exponent: f64) -> [f64; NODES] {
        let x = exponent.ln();
        if let Some(at) = self.logarithms.iter().position(|node| *node == x) {
            return std::array::from_fn(|k| f64::from(u8::from(k == at)));
        }
        let parts: [f64; NODES] = std::array::from_fn(|k| self.barycentric[k] / (x - self.logarithms[k]));
        let sum: f64 = parts.iter().sum();
        parts.map(|part| part / sum)
    }

    /// Their derivatives by the exponent.
    pub fn slopes(&self, exponent: f64) -> Vec<f64> {
        // The weights are polynomials of degree 15 in ln n; differences lose 1e-9 of them.
        let h = 1e-4;
        let (up, down) = (self.weights(exponent * f64::exp(h)), self.weights(exponent * f64::exp(-h)));
        up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * h * exponent)).collect()
    }
}
