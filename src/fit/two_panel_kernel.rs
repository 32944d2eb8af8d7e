//! Magnitudes and derivatives of blocks of points, computed with the widest vector instructions of the machine.

use std::borrow::Cow;
use std::f64::consts::LN_10;

use super::form::{BLOCK, Evaluated, LEAST_M2_SR};
use crate::math::elementary::fused;
use crate::math::vectors::{Kernel, widest_fused};
use crate::photometry::ChassisAndSail;
use crate::photometry::two_panel::{Directions, LitPanels, magnitudes, slope_of_lobe, weighted_sum};

/// Number of parameters with analytic derivatives: c1 to c5, n_sail, n_base.
pub(super) const SLOPES: usize = 7;

/// Number of exponents for which earthshine is tabulated. The interpolation is accurate to 1e-5 of the diffuse light.
pub(super) const NODES: usize = 16;

/// Earthshine on the chassis for one block of points and c4 = c5 = 1, m² sr⁻¹.
///
/// The glossy part is a smooth function of ln n. Values at Chebyshev nodes are interpolated with weights that all
/// points share.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EarthBlock {
    pub diffuse: [f64; BLOCK],
    /// Glossy part at each node. Single precision (6e-8) halves the memory traffic of the loops.
    pub glossy: Box<[[f32; BLOCK]; NODES]>,
}

/// All points with given values of the parameters.
pub(super) struct Evaluation<'a> {
    /// Coefficients c1 to c5.
    pub c: [f64; 5],
    /// Exponents n_sail and n_base.
    pub exponents: [f64; 2],
    /// Magnitude at 1000 km of a light of 1 m² sr⁻¹.
    pub zero_mag: f64,
    pub lit: Cow<'a, [LitPanels<BLOCK>]>,
    /// Earthshine of each block of `lit`; empty without earthshine.
    pub earth: &'a [EarthBlock],
    /// Weights of the nodes for the exponent n_base.
    pub earth_weights: [f64; NODES],
}

impl Evaluated for Evaluation<'_> {
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]) {
        widest_fused(Magnitudes { evaluation: self, block, out, slopes: None });
    }
}

impl Evaluation<'_> {
    /// Computes magnitudes and derivatives. `earth_slopes` are the derivatives of the weights of the nodes with respect
    /// to n_base.
    pub fn magnitudes_and_slopes(
        &self,
        block: usize,
        earth_slopes: &[f64; NODES],
        out: &mut [f64; BLOCK],
        slopes: &mut [[f64; BLOCK]; SLOPES],
    ) {
        widest_fused(Magnitudes { evaluation: self, block, out, slopes: Some((earth_slopes, slopes)) });
    }
}

struct Magnitudes<'a> {
    evaluation: &'a Evaluation<'a>,
    block: usize,
    out: &'a mut [f64; BLOCK],
    slopes: Option<(&'a [f64; NODES], &'a mut [[f64; BLOCK]; SLOPES])>,
}

impl Kernel for Magnitudes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const F: bool>(self) {
        let Evaluation { c, exponents: [n_sail, n_base], zero_mag, .. } = *self.evaluation;
        let lit = &self.evaluation.lit[self.block];
        let earth = self.evaluation.earth.get(self.block);
        let exponents = [Some(n_sail), Some(n_base)];
        if self.slopes.is_none() {
            let mut light = lit.light::<F>(&c, exponents);
            if let Some(earth) = earth {
                let gloss = interpolated::<F>(earth, &self.evaluation.earth_weights);
                for lane in 0..BLOCK {
                    light[lane] += fused::<F>(c[3], gloss[lane], c[4] * earth.diffuse[lane]);
                }
            }
            *self.out = magnitudes::<F, BLOCK>(&light, LEAST_M2_SR, zero_mag);
            return;
        }
        let mut basis = lit.basis::<F>(exponents);
        let sun_lobe = basis[3];
        if let Some(earth) = earth {
            let gloss = interpolated::<F>(earth, &self.evaluation.earth_weights);
            for lane in 0..BLOCK {
                basis[3][lane] += gloss[lane];
                basis[4][lane] += earth.diffuse[lane];
            }
        }
        let light = weighted_sum::<F, BLOCK>(&c, &basis);
        *self.out = magnitudes::<F, BLOCK>(&light, LEAST_M2_SR, zero_mag);
        let Some((earth_slopes, slopes)) = self.slopes else { return };
        let mut columns = [basis[0], basis[1], basis[2], basis[3], basis[4], [0.0; BLOCK], [0.0; BLOCK]];
        if let Some(earth) = earth {
            columns[6] = interpolated::<F>(earth, earth_slopes);
        }
        let mut scale = [0.0; BLOCK];
        for lane in 0..BLOCK {
            columns[5][lane] = c[0] * slope_of_lobe(basis[0][lane], n_sail, lit.ln_sail[lane]);
            columns[6][lane] = c[3] * (columns[6][lane] + slope_of_lobe(sun_lobe[lane], n_base, lit.ln_base[lane]));
            // dm/dp = -(2.5 / ln 10) (dB/dp) / B
            scale[lane] = if light[lane] > LEAST_M2_SR { -2.5 / LN_10 / light[lane] } else { 0.0 };
        }
        for column in &mut columns {
            for lane in 0..BLOCK {
                column[lane] *= scale[lane];
            }
        }
        *slopes = columns;
    }
}

/// Returns the weighted sum of the values at the nodes, Σ_k w_k v_k.
#[inline(always)]
fn interpolated<const F: bool>(earth: &EarthBlock, weights: &[f64; NODES]) -> [f64; BLOCK] {
    let (rows, weights) = (&*earth.glossy, *weights);
    let mut values = [0.0; BLOCK];
    for lane in 0..BLOCK {
        // The inner loop is unrolled and the outer one vectorised, so that each sum stays in a register.
        let mut sum = 0.0;
        for node in 0..NODES {
            sum = fused::<F>(weights[node], f64::from(rows[node][lane]), sum);
        }
        values[lane] = sum;
    }
    values
}

/// Returns the projected areas for one block of points.
pub(super) fn lit_panels(panels: &ChassisAndSail, directions: &Directions<BLOCK>, blocking: bool) -> LitPanels<BLOCK> {
    widest_fused(Lit { panels: *panels, directions, blocking })
}

struct Lit<'a> {
    panels: ChassisAndSail,
    directions: &'a Directions<BLOCK>,
    blocking: bool,
}

impl Kernel for Lit<'_> {
    type Output = LitPanels<BLOCK>;

    #[inline(always)]
    fn run<const F: bool>(self) -> LitPanels<BLOCK> {
        let open =
            if self.blocking { self.panels.open_sail::<F, BLOCK>(self.directions) } else { self.panels.whole_sail() };
        self.panels.lit::<F, BLOCK>(self.directions, &open, [true, true])
    }
}
