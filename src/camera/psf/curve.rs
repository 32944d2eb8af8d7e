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
        let near = &self.values[first..first + 4];
        weights[0] * near[0] + weights[1] * near[1] + weights[2] * near[2] + weights[3] * near[3]
    }

    /// Values at `per_interval` times as many nodes, single precision, `(intervals * per_interval + 1)`.
    pub fn finer(&self, per_interval: usize) -> Vec<f32> {
        let mut fine = Vec::with_capacity(self.radii.intervals() * per_interval + 1);
        for interval in 0..self.radii.intervals() {
            let first = interval.clamp(1, self.radii.intervals() - 2) - 1;
            let near = &self.values[first..first + 4];
            for part in 0..per_interval {
                let weights = cubic((interval - first) as f64 + part as f64 / per_interval as f64);
                let value = weights[0] * near[0] + weights[1] * near[1] + weights[2] * near[2] + weights[3] * near[3];
                fine.push(value as f32);
            }
        }
        fine.push(self.values[self.radii.intervals()] as f32);
        fine
    }
}

/// Lagrange's weights of the nodes 0, 1, 2, 3.
#[inline]
pub(super) fn cubic(x: f64) -> [f64; 4] {
    let (a, b, c, d) = (x, x - 1.0, x - 2.0, x - 3.0);
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}
