//! Tabulated functions of a radius, with close nodes in the core of a profile and distant nodes in its wings.

/// Number of nodes per σ of the seeing (the σ of a Gaussian of the same FWHM) at the centre.
const NODES_PER_SIGMA: f64 = 48.0;
/// Fraction by which the radius grows from one node to the next at the end.
const END_STEP: f64 = 0.1;

/// Values at equal steps of t = r / (r + core), interpolated by cubics; the value is 0 beyond the end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    core_pix: f64,
    end_pix: f64,
    /// Number of steps from t = 0 to t = 1, which is an infinite radius.
    scale: f64,
    values: Vec<f64>,
}

impl Curve {
    /// Tabulates a function of the radius (pixels) up to `end_pix`. Up to about `core_pix` the function may change as
    /// fast as seeing of width `fwhm_pix`; beyond `core_pix` it must be smooth.
    pub fn new(core_pix: f64, end_pix: f64, fwhm_pix: f64, function: impl FnMut(f64) -> f64) -> Self {
        let intervals = (NODES_PER_SIGMA * core_pix / (0.425 * fwhm_pix)).max(end_pix / (END_STEP * core_pix));
        let intervals = intervals.ceil().clamp(256.0, 8192.0) as usize;
        let scale = intervals as f64 * (end_pix + core_pix) / end_pix;
        let radius = |node: usize| core_pix * node as f64 / (scale - node as f64);
        Self { core_pix, end_pix, scale, values: (0..=intervals).map(radius).map(function).collect() }
    }

    /// Returns the radius of the last node, pixels.
    pub fn end_pix(&self) -> f64 {
        self.end_pix
    }

    /// Returns the greatest value at a node.
    pub fn greatest(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// Multiplies all values by a factor.
    pub fn scale(&mut self, factor: f64) {
        self.values.iter_mut().for_each(|value| *value *= factor);
    }

    /// Returns the value at a radius of at least 0, pixels.
    #[inline]
    pub fn at(&self, r_pix: f64) -> f64 {
        const SIXTH: f64 = 1.0 / 6.0;
        if r_pix > self.end_pix {
            return 0.0;
        }
        let position = r_pix / (r_pix + self.core_pix) * self.scale;
        let first = (position as usize).clamp(1, self.values.len() - 3) - 1;
        let [p, q, r, s] = self.values[first..first + 4] else { return 0.0 };
        // Lagrange weights of the nodes 0, 1, 2, 3.
        let a = position - first as f64;
        let (b, c, d) = (a - 1.0, a - 2.0, a - 3.0);
        -SIXTH * b * c * d * p + 0.5 * a * c * d * q - 0.5 * a * b * d * r + SIXTH * a * b * c * s
    }
}
