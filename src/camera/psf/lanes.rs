//! Tables of a profile as loops read them: many values at a time, without branches.

use super::curve::Curve;

/// Parts of an interval between nodes: linear in between, good to 10⁻⁵ of the peak at worst.
const PER_INTERVAL: usize = 16;

/// A function of a radius in single precision: values and their steps, on the compressed scale of the curve they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Lanes {
    core_pix: f32,
    scale: f32,
    values: Vec<f32>,
    steps: Vec<f32>,
}

impl Lanes {
    pub(super) fn of(curve: &Curve) -> Self {
        let mut values = curve.finer(PER_INTERVAL);
        // Beyond the end there is nothing.
        if let Some(last) = values.last_mut() {
            *last = 0.0;
        }
        let mut steps: Vec<f32> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.push(0.0);
        let scale = curve.radii().scale() * PER_INTERVAL as f64;
        Self { core_pix: curve.radii().core_pix() as f32, scale: scale as f32, values, steps }
    }

    /// Values at `N` radii of at least 0, pixels.
    #[inline(always)]
    pub fn at<const N: usize>(&self, r_pix: &[f32; N]) -> [f32; N] {
        /// 2²³: a number added to it loses its fraction, and the rest stands in the lowest bits.
        const WHOLE: f32 = 8_388_608.0;
        let count = self.values.len().min(self.steps.len());
        let (values, steps) = (&self.values[..count], &self.steps[..count]);
        // Said for the compiler: with it no read below needs a check of its own.
        if count == 0 {
            return [0.0; N];
        }
        let mut out = [0.0; N];
        for (out, r) in out.iter_mut().zip(r_pix) {
            let place = r / (r + self.core_pix) * self.scale;
            let shifted = (place - 0.5).max(0.0) + WHOLE;
            let fraction = place - (shifted - WHOLE);
            let node = ((shifted.to_bits() & 0x007F_FFFF) as usize).min(count - 1);
            *out = values[node] + fraction * steps[node];
        }
        out
    }
}
