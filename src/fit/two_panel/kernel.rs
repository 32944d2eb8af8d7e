//! Coefficients put to columns: magnitudes and derivatives, in loops that the widest vectors of the machine run.

use std::borrow::Cow;
use std::f64::consts::{FRAC_1_PI, LN_10, TAU};

use pulp::{Arch, NullaryFnOnce};

use crate::fit::form::{BLOCK, Evaluated, LEAST_M2_SR};
use crate::math::elementary::{exp, fused, ln};

use super::columns::Block;
use super::earth::{EarthBlock, NODES};

/// Parameters whose derivatives are known: all but the panel offset.
const SLOPES: usize = 7;

/// Coefficients as the loops use them.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Numbers {
    c: [f64; 5],
    n_sail: f64,
    n_base: f64,
    /// Magnitude at 1000 km of 1 m² sr⁻¹.
    zero_mag: f64,
}

impl Numbers {
    pub fn new(x: &[f64], zero_mag: f64) -> Self {
        Self { c: std::array::from_fn(|i| x[i]), n_sail: x[5], n_base: x[6], zero_mag }
    }
}

/// Columns with coefficients put to them.
pub(super) struct At<'a> {
    pub numbers: Numbers,
    pub blocks: Cow<'a, [Block]>,
    /// As many as blocks, or none.
    pub earth: &'a [EarthBlock],
    pub weights: [f64; NODES],
}

impl Evaluated for At<'_> {
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]) {
        let earth = self.earth.get(block).map(|earth| (earth, &self.weights));
        dispatch(Magnitudes { numbers: &self.numbers, block: &self.blocks[block], earth, out });
    }
}

impl At<'_> {
    /// Derivatives by c1 to c5, n_sail and n_base; `slopes` are those of the weights of the Earth's nodes.
    pub fn magnitudes_and_slopes(
        &self,
        block: usize,
        slopes: &[f64],
        out: &mut [f64; BLOCK],
    ) -> Box<[[f64; BLOCK]; SLOPES]> {
        let mut columns = Box::new([[0.0; BLOCK]; SLOPES]);
        let mut weight_slopes = [0.0; NODES];
        weight_slopes.copy_from_slice(slopes);
        let earth = self.earth.get(block).map(|earth| (earth, &self.weights, &weight_slopes));
        dispatch(WithSlopes { numbers: &self.numbers, block: &self.blocks[block], earth, out, columns: &mut columns });
        columns
    }
}

/// One of the loops below, with and without fused multiply-add.
trait Loop {
    fn run<const F: bool>(self);
}

/// A loop as an object that is certain to be inlined where wide instructions are allowed.
struct Wide<L>(L);

impl<L: Loop> NullaryFnOnce for Wide<L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.0.run::<true>();
    }
}

fn dispatch(job: impl Loop) {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(Wide(job)),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(Wide(job)),
        _ => job.run::<false>(),
    }
}

struct Magnitudes<'a> {
    numbers: &'a Numbers,
    block: &'a Block,
    earth: Option<(&'a EarthBlock, &'a [f64; NODES])>,
    out: &'a mut [f64; BLOCK],
}

impl Loop for Magnitudes<'_> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        // Copied, as the loops of `photometry::batch` are: else the compiler makes no vectors of them.
        let n = *self.numbers;
        let c = n.c;
        let block = self.block;
        let (glossy_sail, diffuse_sail) = (c[0] * (n.n_sail + 2.0) / TAU, c[1] * FRAC_1_PI);
        let (glossy_base, diffuse_base) = (c[3] * (n.n_base + 2.0) / TAU, c[4] * FRAC_1_PI);
        let through = c[2] * FRAC_1_PI;
        let mut light = [0.0; BLOCK];
        // B_total                                                         Lu (2024), eqs. 1-6
        for (lane, light) in light.iter_mut().enumerate() {
            let sail = fused::<F>(glossy_sail, exp::<F>(n.n_sail * block.ln_sail[lane]), diffuse_sail);
            let base = fused::<F>(glossy_base, exp::<F>(n.n_base * block.ln_base[lane]), diffuse_base);
            *light = fused::<F>(
                sail,
                block.front_m2[lane],
                fused::<F>(base, block.base_m2[lane], through * block.through_m2[lane]),
            );
        }
        if let Some((earth, weights)) = self.earth {
            let weights = *weights;
            let gloss = earth_gloss::<F>(earth, &weights);
            for lane in 0..BLOCK {
                light[lane] += fused::<F>(c[3], gloss[lane], c[4] * earth.diffuse[lane]);
            }
        }
        let mut out = [0.0; BLOCK];
        for lane in 0..BLOCK {
            // m = -2.5 log₁₀ B + zero                                     Lu (2024), eq. 19
            out[lane] = fused::<F>(-2.5 / LN_10, ln::<F>(greater(light[lane], LEAST_M2_SR)), n.zero_mag);
        }
        *self.out = out;
    }
}

struct Basis<'a> {
    numbers: &'a Numbers,
    block: &'a Block,
    earth: Option<(&'a EarthBlock, &'a [f64; NODES])>,
    columns: &'a mut [[f64; BLOCK]; 5],
}

impl Loop for Basis<'_> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        let n = *self.numbers;
        let block = self.block;
        let (glossy_sail, glossy_base) = ((n.n_sail + 2.0) / TAU, (n.n_base + 2.0) / TAU);
        let [mut sail_gloss, mut sail, mut through, mut base_gloss, mut base] = [[0.0; BLOCK]; 5];
        for lane in 0..BLOCK {
            sail_gloss[lane] = glossy_sail * exp::<F>(n.n_sail * block.ln_sail[lane]) * block.front_m2[lane];
            sail[lane] = FRAC_1_PI * block.front_m2[lane];
            through[lane] = FRAC_1_PI * block.through_m2[lane];
            base_gloss[lane] = glossy_base * exp::<F>(n.n_base * block.ln_base[lane]) * block.base_m2[lane];
            base[lane] = FRAC_1_PI * block.base_m2[lane];
        }
        if let Some((earth, weights)) = self.earth {
            let weights = *weights;
            let gloss = earth_gloss::<F>(earth, &weights);
            for lane in 0..BLOCK {
                base_gloss[lane] += gloss[lane];
                base[lane] += earth.diffuse[lane];
            }
        }
        *self.columns = [sail_gloss, sail, through, base_gloss, base];
    }
}

struct WithSlopes<'a> {
    numbers: &'a Numbers,
    block: &'a Block,
    earth: Option<(&'a EarthBlock, &'a [f64; NODES], &'a [f64; NODES])>,
    out: &'a mut [f64; BLOCK],
    columns: &'a mut [[f64; BLOCK]; SLOPES],
}

impl Loop for WithSlopes<'_> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        let n = *self.numbers;
        let c = n.c;
        let mut basis = [[0.0; BLOCK]; 5];
        let earth = self.earth.map(|(earth, weights, _)| (earth, weights));
        Basis { numbers: &n, block: self.block, earth, columns: &mut basis }.run::<F>();
        let block = self.block;
        let [mut light, mut by_sail, mut by_base] = [[0.0; BLOCK]; 3];
        for lane in 0..BLOCK {
            light[lane] = fused::<F>(
                c[0],
                basis[0][lane],
                fused::<F>(
                    c[1],
                    basis[1][lane],
                    fused::<F>(c[2], basis[2][lane], fused::<F>(c[3], basis[3][lane], c[4] * basis[4][lane])),
                ),
            );
            // ∂/∂n of (n+2)/2π cosⁿθ: itself times 1/(n+2) + ln cos θ
            by_sail[lane] = c[0] * basis[0][lane] * (1.0 / (n.n_sail + 2.0) + block.ln_sail[lane]);
            by_base[lane] = c[3] * basis[3][lane] * (1.0 / (n.n_base + 2.0) + block.ln_base[lane]);
        }
        if let Some((earth, weights, slopes)) = self.earth {
            let (weights, slopes) = (*weights, *slopes);
            let (gloss, steeper) = (earth_gloss::<F>(earth, &weights), earth_gloss::<F>(earth, &slopes));
            for lane in 0..BLOCK {
                // The Earth's share of the lobe has its own derivative.
                let own = steeper[lane] - gloss[lane] * (1.0 / (n.n_base + 2.0) + block.ln_base[lane]);
                by_base[lane] = fused::<F>(c[3], own, by_base[lane]);
            }
        }
        let mut out = [0.0; BLOCK];
        for lane in 0..BLOCK {
            out[lane] = fused::<F>(-2.5 / LN_10, ln::<F>(greater(light[lane], LEAST_M2_SR)), n.zero_mag);
        }
        let mut scale = [0.0; BLOCK];
        for lane in 0..BLOCK {
            // dm/dp = -(2.5 / ln 10) (dB/dp) / B
            scale[lane] = if light[lane] > LEAST_M2_SR { -2.5 / LN_10 / light[lane] } else { 0.0 };
        }
        let mut columns = [basis[0], basis[1], basis[2], basis[3], basis[4], by_sail, by_base];
        for column in &mut columns {
            for lane in 0..BLOCK {
                column[lane] *= scale[lane];
            }
        }
        *self.out = out;
        *self.columns = columns;
    }
}

/// Σ_k w_k of the values at the nodes.
#[inline(always)]
fn earth_gloss<const F: bool>(earth: &EarthBlock, weights: &[f64; NODES]) -> [f64; BLOCK] {
    let rows = &*earth.glossy;
    let mut gloss = [0.0; BLOCK];
    for lane in 0..BLOCK {
        // The inner loop is unrolled, the outer one made of vectors: each sum stays in its register.
        let mut sum = 0.0;
        for node in 0..NODES {
            sum = fused::<F>(weights[node], f64::from(rows[node][lane]), sum);
        }
        gloss[lane] = sum;
    }
    gloss
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
