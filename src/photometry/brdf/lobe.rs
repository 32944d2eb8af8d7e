//! The power of a cosine that Phong's law, `straight` and `retro` share; they differ in the direction it stands about.

use std::f64::consts::TAU;

/// Height of the lobe, sr⁻¹.
pub(super) fn peak_per_sr(weight: f64, exponent: f64) -> f64 {
    // c (n + 2) / 2π                                                     Lu (2024), eq. 2
    weight * (exponent + 2.0) / TAU
}

/// Its value where the cosine with its middle is this, sr⁻¹; 0 beyond 90°.
pub(super) fn value_per_sr(weight: f64, exponent: f64, cosine: f64) -> f64 {
    // A lobe of no weight costs nothing; and 0 · 0⁰ has no say.
    if weight == 0.0 || cosine <= 0.0 {
        return 0.0;
    }
    // f = c (n + 2) / 2π · cosⁿθ                                         Lu (2024), eq. 2
    peak_per_sr(weight, exponent) * cosine.powf(exponent)
}
