//! Powers, sines and cosines without branches, so that the compiler can take several at once.

use std::f64::consts::{FRAC_PI_2, LN_2};

use crate::math::elementary::polynomial;

/// Adding it rounds a number of magnitude below 2⁵¹ to an integer, kept in the lowest bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// Bits of √½.
const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
/// Bits of 1.
const ONE: u64 = 0x3ff0_0000_0000_0000;
/// Bits of 2⁵²: its mantissa counts integers.
const COUNTER: u64 = 0x4330_0000_0000_0000;
/// Taylor's series of sin u / u and cos u in u², the highest power first.
const SINE: [f64; 9] = [
    1.0 / 355_687_428_096_000.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
    1.0,
];
const COSINE: [f64; 10] = [
    -1.0 / 6_402_373_705_728_000.0,
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
    -1.0 / 2.0,
    1.0,
];
const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;

/// xⁿ for x up to 1 and n from 0 to 10,000; less than 1e-300 where x < 0 (a lobe seen from more than 90° off).
///
/// Relative error below 1e-11 + 5e-13 n; what would be less than 1e-300 stays there.
#[inline(always)]
pub(super) fn lobe_power(x: f64, n: f64) -> f64 {
    // x = 2ᵉ m, √½ ≤ m < √2
    let bits = greater(x, 1e-300).to_bits().wrapping_add(ONE - ROOT_HALF);
    let e = f64::from_bits(COUNTER | (bits >> 52)) - (4_503_599_627_370_496.0 + 1023.0);
    let m = f64::from_bits((bits & MANTISSA).wrapping_add(ROOT_HALF));
    // ln m = 2 (z + z³/3 + z⁵/5 + …), z = (m - 1)/(m + 1), |z| < 0.1716
    let z = (m - 1.0) / (m + 1.0);
    let (s, s2) = (z * z, z * z * (z * z));
    // Pairs of terms first: the processor need not wait for one to begin the next.
    let series = (1.0 + s * (1.0 / 3.0))
        + s2 * ((1.0 / 5.0 + s * (1.0 / 7.0)) + s2 * ((1.0 / 9.0 + s * (1.0 / 11.0)) + s2 * (1.0 / 13.0)));
    let log2 = e + (2.0 / LN_2) * z * series;
    // From x = 0 down, straight to the floor.
    let drop = x * 1e18;
    let y = greater(n * log2 + if drop < 0.0 { drop } else { 0.0 }, -1000.0);
    // 2^y = 2^k e^f, k the nearest integer, |f| ≤ ln 2 / 2
    let shifted = y + ROUNDER;
    let f = (y - (shifted - ROUNDER)) * LN_2;
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let (f2, f4) = (f * f, f * f * (f * f));
    let exp = ((1.0 + f) + f2 * (1.0 / 2.0 + f * (1.0 / 6.0)))
        + f4 * (((1.0 / 24.0 + f * (1.0 / 120.0)) + f2 * (1.0 / 720.0 + f * (1.0 / 5040.0)))
            + f4 * (1.0 / 40_320.0 + f * (1.0 / 362_880.0)));
    scale * exp
}

/// The greater of two numbers; `f64::max` would also ask whether either is one.
#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// [`lobe_power`] of each; kept apart from its callers, where the compiler finds nothing but one loop.
#[inline(never)]
pub(super) fn lobe_powers(x: &mut [f64], n: f64) {
    for x in x {
        *x = lobe_power(*x, n);
    }
}

/// Sine and cosine of an angle in [0, π], to 1e-13.
#[inline(always)]
pub(super) fn half_turn_sin_cos(angle: f64) -> (f64, f64) {
    // sin φ = cos u, cos φ = -sin u, u = φ - π/2
    let u = angle - FRAC_PI_2;
    let s = u * u;
    let (sin, cos) = (u * polynomial::<false, 9>(s, SINE), polynomial::<false, 10>(s, COSINE));
    (cos, -sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the series for exp, relative, and of that for log (times the exponent).
    const EXP_SERIES: f64 = 1e-11;
    const LOG_SERIES: f64 = 5e-13;

    #[test]
    fn verif_powers_against_std() {
        for n in [0.0, 0.5, 1.0, 2.0, 5.3, 22.0, 200.0, 10_000.0] {
            for i in 1..=40_000 {
                let x = f64::from(i) / 40_000.0;
                let (ours, exact) = (lobe_power(x, n), x.powf(n));
                let allowed = (EXP_SERIES + LOG_SERIES * n) * exact + 1e-300;
                assert!((ours - exact).abs() <= allowed, "{x}^{n}: {ours} {exact}");
            }
            assert!(lobe_power(-1e-3, n) < 1e-300 && lobe_power(-1.0, n) < 1e-300);
        }
        // A cosine that rounding lifts above 1 is none the worse.
        assert!((lobe_power(1.0 + 1e-15, 200.0) - 1.0).abs() < 1e-10);
    }

    #[test]
    fn verif_sines_and_cosines_against_std() {
        for i in 0..=10_000 {
            let angle = std::f64::consts::PI * f64::from(i) / 10_000.0;
            let (sin, cos) = half_turn_sin_cos(angle);
            assert!((sin - angle.sin()).abs() < 1e-13 && (cos - angle.cos()).abs() < 1e-13, "{angle}");
        }
    }
}
