//! Cubic interpolation through four evenly spaced nodes.

/// Returns the Lagrange weights of four nodes at 0, 1, 2 and 3 for the interpolated value at `u`.
pub fn cubic_weights(u: f64) -> [f64; 4] {
    let (a, b, c, d) = (u, u - 1.0, u - 2.0, u - 3.0);
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}

/// Returns the derivatives of [`cubic_weights`] with respect to `u`.
pub fn cubic_slopes(u: f64) -> [f64; 4] {
    let (a, b, c, d) = (u, u - 1.0, u - 2.0, u - 3.0);
    [
        -(c * d + b * d + b * c) / 6.0,
        (c * d + a * d + a * c) / 2.0,
        -(b * d + a * d + a * b) / 2.0,
        (b * c + a * c + a * b) / 6.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_cubics_come_back() {
        let value = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.25 * x * x * x;
        let slope = |x: f64| -2.0 + x - 0.75 * x * x;
        let sum = |weights: [f64; 4]| (0..4).map(|k| weights[k] * value(k as f64)).sum::<f64>();
        for u in [-0.5, 0.0, 1.3, 2.0, 3.7] {
            assert!((sum(cubic_weights(u)) - value(u)).abs() < 1e-13, "{u}");
            assert!((sum(cubic_slopes(u)) - slope(u)).abs() < 1e-13, "{u}");
        }
    }
}
