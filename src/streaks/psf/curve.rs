//! A function of a radius, by its values at nodes.

use super::radii::Radii;

/// Values at the nodes of [`Radii`], cubic in between, 0 beyond the last.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    radii: Radii,
    values: Vec<f64>,
}

impl Curve {
    /// From a function of the radius in pixels.
    pub fn of(radii: Radii, function: impl FnMut(f64) -> f64) -> Self {
        Self { radii, values: (0..=radii.intervals()).map(|node| radii.radius(node)).map(function).collect() }
    }

    /// From one value a node.
    pub fn from_values(radii: Radii, values: Vec<f64>) -> Self {
        Self { radii, values }
    }

    pub fn radii(&self) -> Radii {
        self.radii
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Weighted sum of curves over the same radii.
    pub fn sum(parts: &[(f64, &Self)]) -> Self {
        let radii = parts[0].1.radii;
        let value = |node: usize| parts.iter().map(|(weight, curve)| weight * curve.values[node]).sum();
        Self { radii, values: (0..=radii.intervals()).map(value).collect() }
    }

    pub fn scale(&mut self, factor: f64) {
        self.values.iter_mut().for_each(|value| *value *= factor);
    }

    /// Value at a radius of at least 0, pixels.
    #[inline]
    pub fn at(&self, r_pix: f64) -> f64 {
        if r_pix > self.radii.end_pix() {
            return 0.0;
        }
        let place = self.radii.place(r_pix);
        let first = (place as usize).clamp(1, self.radii.intervals() - 2) - 1;
        let weights = cubic(place - first as f64);
        let [a, b, c, d] = self.values[first..first + 4] else { return 0.0 };
        weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d
    }

    /// Values at `PER` times as many nodes, single precision, `(intervals * PER + 1)`.
    pub fn finer<const PER: usize>(&self) -> Vec<f32> {
        let intervals = self.radii.intervals();
        // Of each of four nodes at all parts of the interval before the second of them, between this and the third, and after that.
        let weights: [[[f64; PER]; 4]; 3] = std::array::from_fn(|before| {
            let at: [[f64; 4]; PER] = std::array::from_fn(|part| cubic(before as f64 + part as f64 / PER as f64));
            std::array::from_fn(|node| at.map(|weights| weights[node]))
        });
        let mut fine = Vec::with_capacity(intervals * PER + 1);
        for interval in 0..intervals {
            let first = interval.clamp(1, intervals - 2) - 1;
            let near = &self.values[first..first + 4];
            let [a, b, c, d] = &weights[interval - first];
            let value = |part: usize| a[part] * near[0] + b[part] * near[1] + c[part] * near[2] + d[part] * near[3];
            let values: [f32; PER] = std::array::from_fn(|part| value(part) as f32);
            fine.extend_from_slice(&values);
        }
        fine.push(self.values[intervals] as f32);
        fine
    }
}

/// Lagrange's weights of the nodes 0, 1, 2, 3.
#[inline]
pub(super) fn cubic(x: f64) -> [f64; 4] {
    const SIXTH: f64 = 1.0 / 6.0;
    let (a, b, c, d) = (x, x - 1.0, x - 2.0, x - 3.0);
    [-SIXTH * b * c * d, 0.5 * a * c * d, -0.5 * a * b * d, SIXTH * a * b * c]
}
