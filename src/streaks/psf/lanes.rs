//! Tables of a profile as loops read them: many values at a time, without branches.

use super::curve::Curve;

/// Parts of an interval between nodes: linear in between, good to 10⁻⁵ of the peak at worst.
const PER_INTERVAL: usize = 16;

/// `K` functions of a radius in single precision: values and their steps, on the compressed scale of the curves they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Lanes<const K: usize = 1> {
    core_pix: f32,
    scale: f32,
    /// Number of the last node.
    last: u32,
    /// Of each node and function: the value, and the step to that of the next node.
    nodes: Vec<[[f32; 2]; K]>,
}

impl<const K: usize> Lanes<K> {
    /// From curves over the same radii.
    pub(super) fn of(curves: [&Curve; K]) -> Self {
        let mut nodes = Vec::new();
        for (k, curve) in curves.iter().enumerate() {
            let mut values = curve.finer::<PER_INTERVAL>();
            // Beyond the end there is nothing.
            values.last_mut().into_iter().for_each(|last| *last = 0.0);
            nodes.resize(values.len(), [[0.0; 2]; K]);
            for (node, pair) in nodes.iter_mut().zip(values.windows(2)) {
                node[k] = [pair[0], pair[1] - pair[0]];
            }
        }
        let last = nodes.len().saturating_sub(1);
        let radii = curves[0].radii();
        let scale = radii.scale() * PER_INTERVAL as f64;
        Self { core_pix: radii.core_pix() as f32, scale: scale as f32, last: last as u32, nodes }
    }

    /// Values of all functions at `N` radii of at least 0, pixels.
    #[inline(always)]
    pub fn all_at<const N: usize>(&self, r_pix: &[f32; N]) -> [[f32; N]; K] {
        /// 2²³: a number added to it loses its fraction, and the rest stands in the lowest bits.
        const WHOLE: f32 = 8_388_608.0;
        let mut out = [[0.0; N]; K];
        // Said for the compiler: with it no read below needs a check of its own.
        let Some(nodes) = self.nodes.get(..=self.last as usize) else { return out };
        for (lane, r) in r_pix.iter().enumerate() {
            let place = r / (r + self.core_pix) * self.scale;
            let shifted = (place - 0.5).max(0.0) + WHOLE;
            let fraction = place - (shifted - WHOLE);
            let node = &nodes[(shifted.to_bits() & 0x007F_FFFF).min(self.last) as usize];
            for (out, [value, step]) in out.iter_mut().zip(node) {
                out[lane] = value + fraction * step;
            }
        }
        out
    }
}

impl Lanes {
    /// Values at `N` radii of at least 0, pixels.
    #[inline(always)]
    pub fn at<const N: usize>(&self, r_pix: &[f32; N]) -> [f32; N] {
        let [values] = self.all_at(r_pix);
        values
    }
}
