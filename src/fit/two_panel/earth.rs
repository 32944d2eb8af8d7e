//! The Earth's light on the chassis at each point, ready for any exponent.
//!
//! The diffuse part needs no exponent. The glossy one, (n+2)/2π Σ dE cos φ_i cosⁿθ, is smooth in ln n: its values at Chebyshev's
//! nodes are kept for each point, and interpolated by weights that all points share.

use std::f64::consts::{FRAC_1_PI, TAU};

use nalgebra::Vector3;

use crate::fit::form::BLOCK;
use crate::fit::log_nodes::LogNodes;
use crate::fit::point::FitPoint;
use crate::photometry::earthshine::{PAPER_ALBEDO, Shine};

use super::shape::TwoPanelForm;

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
    pub fn new(form: &TwoPanelForm, points: &[FitPoint], exponents: &LogNodes<NODES>) -> Self {
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
            for (exponent, row) in exponents.at.iter().zip(block.glossy.iter_mut()) {
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
