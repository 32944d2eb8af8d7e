//! The limb-darkened solar disk in V, and its fraction above the Earth's limb.
//!
//! Limb darkening is P₅(μ) of Neckel (2005, Solar Physics 229, 13), third range, at 550 nm; μ = √(1 - r²), r in solar
//! radii. The mean of the disk is 0.80 of its centre. Other visible wavelengths change a lit fraction by less than
//! 0.01.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

use crate::math::quadrature::gauss_legendre;

/// Coefficients of μ⁰ to μ⁵, a₀ + a₁/λ (+ a₅/λ⁵) of the cited paper at λ = 0.55 µm. Their sum is 1, the intensity at
/// the centre of the disk.
const DARKENING: [f64; 6] = [0.269_80, 1.340_25, -1.642_88, 2.082_24, -1.473_53, 0.424_12];

/// Integrals ∫ (1 - v²)^(n/2) dv over [-1, 1] for n = 0 to 5.
const CHORD: [f64; 6] = [2.0, FRAC_PI_2, 4.0 / 3.0, 3.0 * PI / 8.0, 16.0 / 15.0, 5.0 * PI / 16.0];

/// Light of the whole disk, 2π Σ aₙ/(n + 2).
const DISK_LIGHT: f64 = {
    let (mut sum, mut n) = (0.0, 0);
    while n < 6 {
        sum += DARKENING[n] / (n as f64 + 2.0);
        n += 1;
    }
    2.0 * PI * sum
};

/// Coefficients aₙ kₙ of a strip, as fractions of the disk's light.
const STRIP: [f64; 6] = {
    let (mut coefficients, mut n) = (DARKENING, 0);
    while n < 6 {
        coefficients[n] *= CHORD[n] / DISK_LIGHT;
        n += 1;
    }
    coefficients
};

/// Quadrature rule, accurate to 10⁻⁵ of the disk's light.
static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(24));

/// Returns the intensity at `r` solar radii from the centre of the disk, relative to the centre.
fn intensity(r: f64) -> f64 {
    let mu = (1.0 - r * r).max(0.0).sqrt();
    DARKENING.iter().rev().fold(0.0, |sum, coefficient| sum * mu + coefficient)
}

/// Returns the light within `r` solar radii of the centre: ∫ 2π r I dr = 2π Σ aₙ (1 - μⁿ⁺²)/(n + 2).
fn light_within(r: f64) -> f64 {
    let mu = (1.0 - r * r).max(0.0).sqrt();
    let mut power = mu;
    let mut sum = 0.0;
    for (n, coefficient) in DARKENING.iter().enumerate() {
        power *= mu;
        sum += coefficient * (1.0 - power) / (n as f64 + 2.0);
    }
    2.0 * PI * sum
}

/// Returns the light of the straight strip at `u` solar radii from the centre, as a fraction of the disk's light per
/// solar radius.
///
/// w(u) = Σ aₙ ∫ (1 - u² - v²)^(n/2) dv = Σ aₙ kₙ c^(n+1), c = √(1 - u²).
pub(super) fn strip(u: f64) -> f64 {
    let c = (1.0 - u * u).max(0.0).sqrt();
    STRIP.iter().rev().fold(0.0, |sum, coefficient| sum * c + coefficient) * c
}

/// Returns the fraction of the Sun's light above the limb of the Earth, seen as a disk of radius `limb`, when the Sun's
/// centre is `above` outside that limb (both in solar radii). It is within 5·10⁻⁵ of a direct sum over the disk.
///
/// The Earth covers a circle of radius r around the Sun's centre over the half angle β(r). With R for `limb`, x for
/// `above`, and d = R + x, the distance of the centres:
///
/// cos β = (x (2R + x) + r²) / (2 d r),  covered = ∫ 2 r β(r) I(r) dr
///
/// β is 0 or π below r = |x|; from there to the rim (or the far side of a small limb) the substitution r = a + (b - a)
/// sin²(πs/2) removes the roots at both ends.
pub(super) fn lit_fraction(above: f64, limb: f64) -> f64 {
    if above >= 1.0 {
        return 1.0;
    }
    // The distance between the two centres cannot be negative.
    let x = above.max(-limb);
    let d = limb + x;
    if d + 1.0 <= limb {
        return 0.0;
    }
    let (inner, outer) = (x.abs(), (limb + d).min(1.0));
    let mut covered = if x < 0.0 { light_within(inner) } else { 0.0 };
    let width = outer - inner;
    if width > 0.0 && d > 0.0 {
        for &(s, weight) in RULE.iter() {
            let (sin, cos) = (FRAC_PI_2 * s).sin_cos();
            let r = inner + width * sin * sin;
            let beta = ((x * (2.0 * limb + x) + r * r) / (2.0 * d * r)).clamp(-1.0, 1.0).acos();
            covered += weight * PI * width * sin * cos * 2.0 * r * beta * intensity(r);
        }
    }
    (1.0 - covered / DISK_LIGHT).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance for the direct sum over the disk. The difference is mainly due to the finite cells of the sum.
    const TOLERANCE: f64 = 5e-5;

    #[test]
    fn the_law_is_that_of_the_source() {
        assert!((DARKENING.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        // Pierce & Slaughter (1977), Neckel & Labs (1994) near 550 nm: 0.96-0.97 at r = 0.3, about 0.80 at 0.75,
        // 0.45-0.5 at 0.98.
        for (r, low, high) in [(0.3, 0.96, 0.98), (0.75, 0.78, 0.83), (0.98, 0.42, 0.52)] {
            assert!((low..high).contains(&intensity(r)), "{r}: {}", intensity(r));
        }
        assert!((DISK_LIGHT / PI - 0.80).abs() < 0.01, "{DISK_LIGHT}");
        assert!((light_within(1.0) / DISK_LIGHT - 1.0).abs() < 1e-15);
    }

    #[test]
    fn verif_strips_add_up_to_the_disk() {
        let steps = 20_000;
        let sum: f64 = (0..steps)
            .map(|step| {
                let phi = PI * (f64::from(step) + 0.5) / f64::from(steps);
                strip(phi.cos()) * phi.sin() * PI / f64::from(steps)
            })
            .sum();
        assert!((sum - 1.0).abs() < 1e-7, "{sum}");
        // A straight limb leaves the sum of the strips above it.
        let above = 0.37_f64;
        let part: f64 = (0..steps)
            .map(|step| {
                let phi = (-above).acos() * (f64::from(step) + 0.5) / f64::from(steps);
                strip(phi.cos()) * phi.sin() * (-above).acos() / f64::from(steps)
            })
            .sum();
        assert!((lit_fraction(above, 1e7) - part).abs() < 1e-6, "{part}");
    }

    /// Sums a million cells of the disk, each visible or hidden.
    #[test]
    fn verif_against_the_plain_sum() {
        for (above, limb) in
            [(0.9, 500.0), (0.3, 500.0), (0.0, 33.0), (-0.5, 33.0), (-0.97, 3.6), (0.2, 3.6), (-0.4, 0.8), (-0.3, 0.25)]
        {
            let (mut seen, mut all) = (0.0, 0.0);
            let cells = 20_000;
            for row in 0..cells {
                let x = (f64::from(row) + 0.5) / f64::from(cells) * 2.0 - 1.0;
                // Along a row the boundary is exact: the covered part of the row.
                let (half, reach) = ((1.0 - x * x).sqrt(), limb * limb - (x + limb + above).powi(2));
                let edge = reach.max(0.0).sqrt().min(half);
                for cell in 0..64 {
                    let phi = PI * (f64::from(cell) + 0.5) / 64.0;
                    let (y, dy) = (half * phi.cos(), half * phi.sin() * PI / 64.0);
                    all += dy * intensity(x.hypot(y));
                    let y = edge * phi.cos();
                    seen -= edge * phi.sin() * PI / 64.0 * intensity(x.hypot(y));
                }
            }
            let expected = 1.0 + seen / all;
            let found = lit_fraction(above, limb);
            assert!((found - expected).abs() < TOLERANCE, "{above} {limb}: {found} {expected}");
        }
    }
}
