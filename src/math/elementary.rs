//! Sine, logarithm and exponential without branches, so that loops over them can be vectorised.
//!
//! The error is at most 1e-13 in the stated ranges, while magnitudes need only 1e-10. The parameter `F` is true on
//! machines with fused multiply-add; on other machines `mul_add` would call a slow library function.

use std::f64::consts::{FRAC_2_PI, LN_2, LOG2_E};

/// 1.5 · 2⁵²: the sum of this and a smaller number is rounded to an integer, which is found in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Returns a b + c.
#[inline(always)]
pub fn fused<const F: bool>(a: f64, b: f64, c: f64) -> f64 {
    if F { a.mul_add(b, c) } else { a * b + c }
}

/// Returns the greater of two numbers, without the NaN check of `f64::max`. NaN in `a` gives `b`.
#[inline(always)]
pub fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Returns the lesser of two numbers. NaN in `a` gives `b`.
#[inline(always)]
pub fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Evaluates a polynomial by Horner's rule, the highest power first.
#[inline(always)]
fn polynomial<const F: bool, const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = coefficients[0];
    for coefficient in &coefficients[1..] {
        sum = fused::<F>(sum, x, *coefficient);
    }
    sum
}

/// Returns sine and cosine of an angle in radians, of at most some hundred turns. The error is 5e-14 plus 1e-16 times
/// the angle.
#[inline(always)]
pub fn sin_cos<const F: bool>(x: f64) -> (f64, f64) {
    // π/2 as a sum of three parts, the first two short enough that their multiples are exact.
    const PARTS: [f64; 3] = [1.570_796_251_296_997, 7.549_789_415_861_596e-8, 5.390_302_858_158_119e-15];
    let shifted = fused::<F>(x, FRAC_2_PI, ROUND);
    let quarters = shifted - ROUND;
    let quadrant = shifted.to_bits();
    let r = fused::<F>(-quarters, PARTS[2], fused::<F>(-quarters, PARTS[1], fused::<F>(-quarters, PARTS[0], x)));
    let s = r * r;
    // Taylor series on |r| ≤ π/4: the remainder is below 2.1e-14.
    let sin = polynomial::<F, 6>(
        s,
        [1.0 / 6_227_020_800.0, -1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5_040.0, 1.0 / 120.0, -1.0 / 6.0],
    );
    let sin = fused::<F>(sin * s, r, r);
    let cos = polynomial::<F, 7>(
        s,
        [
            -1.0 / 87_178_291_200.0,
            1.0 / 479_001_600.0,
            -1.0 / 3_628_800.0,
            1.0 / 40_320.0,
            -1.0 / 720.0,
            1.0 / 24.0,
            -0.5,
        ],
    );
    let cos = fused::<F>(cos, s, 1.0);
    // In odd quarters sine and cosine are exchanged; the signs are the second bit of the quarter and of the next one.
    let odd = quadrant & 1 == 1;
    let (sine, cosine) = (if odd { cos } else { sin }, if odd { sin } else { cos });
    let sign_of = |quadrant: u64| (quadrant & 2) << 62;
    (
        f64::from_bits(sine.to_bits() ^ sign_of(quadrant)),
        f64::from_bits(cosine.to_bits() ^ sign_of(quadrant.wrapping_add(1))),
    )
}

/// Returns the natural logarithm of a positive normal number. The error is 1.2e-14 plus 2e-16 times the result.
#[inline(always)]
pub fn ln<const F: bool>(x: f64) -> f64 {
    let (exponent, m) = exponent_and_mantissa(x);
    ln_of_parts::<F>(exponent, (m - 1.0) / (m + 1.0))
}

/// Returns k and m such that x = 2ᵏ m and √½ ≤ m < √2.
#[inline(always)]
fn exponent_and_mantissa(x: f64) -> (f64, f64) {
    /// The bits of √½, the lower end of the range of m.
    const ROOT_HALF: u64 = 0x3FE6_A09E_667F_3BCD;
    const MANTISSA: u64 = (1 << 52) - 1;
    let above = x.to_bits().wrapping_sub(ROOT_HALF);
    // The exponent as a float: its bits placed below those of 2⁵².
    let exponent = f64::from_bits((above >> 52) | 0x4330_0000_0000_0000) - 4_503_599_627_370_496.0;
    // Negative exponents wrap at 2¹².
    let exponent = if exponent > 2048.0 { exponent - 4096.0 } else { exponent };
    (exponent, f64::from_bits((above & MANTISSA).wrapping_add(ROOT_HALF)))
}

/// Returns k ln 2 + ln m with ln m = 2 artanh f, f = (m - 1)/(m + 1), |f| ≤ 0.172; the remainder is below 1.2e-14.
#[inline(always)]
fn ln_of_parts<const F: bool>(exponent: f64, f: f64) -> f64 {
    let s = f * f;
    let series = polynomial::<F, 9>(
        s,
        [2.0 / 19.0, 2.0 / 17.0, 2.0 / 15.0, 2.0 / 13.0, 2.0 / 11.0, 2.0 / 9.0, 2.0 / 7.0, 2.0 / 5.0, 2.0 / 3.0],
    );
    fused::<F>(exponent, LN_2, fused::<F>(series * s, f, 2.0 * f))
}

/// Returns eˣ for x ≤ 700, and 0 below -700. The error is 1e-14 times the result plus 1e-16 times x.
#[inline(always)]
pub fn exp<const F: bool>(x: f64) -> f64 {
    // ln 2 as a sum of two parts, the first short enough that its multiples are exact.
    const PARTS: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
    let bounded = if x > -700.0 { x } else { -700.0 };
    let shifted = fused::<F>(bounded, LOG2_E, ROUND);
    let power = shifted - ROUND;
    let r = fused::<F>(-power, PARTS[1], fused::<F>(-power, PARTS[0], bounded));
    // Taylor series on |r| ≤ ½ ln 2: the remainder is below 6.5e-15.
    let value = polynomial::<F, 12>(
        r,
        [
            1.0 / 39_916_800.0,
            1.0 / 3_628_800.0,
            1.0 / 362_880.0,
            1.0 / 40_320.0,
            1.0 / 5_040.0,
            1.0 / 720.0,
            1.0 / 120.0,
            1.0 / 24.0,
            1.0 / 6.0,
            0.5,
            1.0,
            1.0,
        ],
    );
    // The bits of the number 2ᵏ: k, which is in the low bits of `shifted`, is shifted to the exponent field.
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    if x > -700.0 { value * scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn many(least: f64, greatest: f64) -> impl Iterator<Item = f64> {
        (0..=20_000).map(move |i| least + (greatest - least) * f64::from(i) / 20_000.0)
    }

    #[test]
    fn valid_elementary_functions_against_the_standard_library() {
        for x in many(-700.0, 700.0).chain(many(-7.0, 7.0)) {
            for (sin, cos) in [sin_cos::<true>(x), sin_cos::<false>(x)] {
                let (s, c) = x.sin_cos();
                let allowed = 3e-14 + 3e-16 * x.abs();
                assert!((sin - s).abs() < allowed && (cos - c).abs() < allowed, "{x}: {sin} {s}, {cos} {c}");
            }
            for value in [exp::<true>(x.min(690.0)), exp::<false>(x.min(690.0))] {
                let expected = x.min(690.0).exp();
                let allowed = 1e-14 + 4e-16 * x.abs();
                assert!(x <= -699.99 || (value / expected - 1.0).abs() < allowed, "{x}: {value} {expected}");
            }
        }
        assert_eq!(exp::<true>(-800.0), 0.0);
        assert_eq!(exp::<true>(f64::NEG_INFINITY), 0.0);
        for x in many(-690.0, 690.0).map(f64::exp).chain(many(0.5, 2.0)) {
            for value in [ln::<true>(x), ln::<false>(x)] {
                assert!((value - x.ln()).abs() < 2e-14 + 4e-16 * x.ln().abs(), "{x}: {value}");
            }
        }
    }
}
