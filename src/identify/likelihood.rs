//! Candidates, their χ² and their probabilities.
//!
//! The likelihood of a candidate is the product of the normal densities of its offsets (delay, cross-track, angle,
//! length). At equal offsets in sigmas the density is larger for smaller sigmas, so that a candidate with newer
//! elements is more probable. If the satellite may be anywhere along the streak during the exposure, the density of
//! delay and distance is integrated over the exposure.
//!
//! The streak may also be caused by a satellite without an element set. One such satellite is assumed for every ten in
//! the catalogue, with uniform density over all low orbits.

use std::f64::consts::{PI, TAU};

use super::streak::Timing;
use crate::elements::NoradId;
use crate::passes::TrackPoint;

/// Difference between measurement and prediction, with its standard deviation.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Offset {
    /// Measured value minus predicted value.
    pub value: f64,
    /// Standard deviation of prediction and measurement combined, above 0.
    pub sigma: f64,
}

impl Offset {
    /// Returns (value / sigma)².
    fn square(self) -> f64 {
        (self.value / self.sigma).powi(2)
    }
}

/// Satellite that may have caused the streak.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Index of its element set in the catalogue.
    pub element_index: usize,
    /// Point of the track, delayed by `along_track_s`, at the middle of the streak.
    pub passage: TrackPoint,
    /// Delay of the satellite relative to its prediction, seconds; negative if it is early.
    pub along_track_s: Offset,
    /// Distance of the streak from the predicted track, radians; positive towards the position angle of motion + 90°.
    pub cross_track_rad: Offset,
    /// Position angle of the streak minus that of the motion, (-π/2, π/2], radians; (-π, π] if the direction of motion
    /// along the streak was measured.
    pub angle_rad: Offset,
    /// Measured minus predicted length, radians; at least 0 if the streak may end at the edges of the frame. `None` for
    /// an unknown length.
    pub length_rad: Option<Offset>,
    /// Predicted length of the satellite's track during the exposure, radians.
    pub predicted_length_rad: f64,
    /// Position angle of the satellite's motion, from north through east, [0, 2π), radians.
    pub position_angle_rad: f64,
    /// Angular rate of the satellite relative to the stars, rad/s.
    pub angular_rate_rad_s: f64,
    /// Time of the passage minus epoch of the elements, days.
    pub element_age_days: f64,
    /// Sum of the squares of all offsets, each divided by its sigma.
    pub chi_square: f64,
    /// Number of terms of `chi_square`.
    pub terms: u32,
    /// Probability that χ² is at least as large if this satellite caused the streak.
    pub p_value: f64,
    /// Probability that this satellite caused the streak, relative to all candidates and satellites without element
    /// sets.
    pub probability: f64,
    pub(super) log_weight: f64,
}

/// Assumed number of satellites without an element set (classified, new or missing in a file) per satellite with one.
const UNKNOWN_SHARE: f64 = 0.1;
/// Period of a low orbit, s.
const PERIOD_S: f64 = 5_700.0;
/// Factor from radians on the sky to radians of the orbit, across the track: the satellite is 1,000 km from the
/// observer and 7,000 km from the Earth's centre.
const FORESHORTENING: f64 = 1_000.0 / 7_000.0;

/// Integral of exp(-½ χ²) over an exposure.
pub(super) struct ExposureIntegral {
    /// Time of the smallest sum of squares, within the allowed range; -1 is shutter opening and 1 is closing.
    pub at: f64,
    /// ln ∫₋₁¹ du exp(-½ f(u)), with f the sum of squares at the time u.
    pub log_integral: f64,
}

/// Integrates over two offsets (in sigmas) that change linearly from `before` at u = -1 to `after` at u = 1. The
/// minimum of the sum of squares is searched from -`free` to `free`.
pub(super) fn integrate_exposure(before: [f64; 2], after: [f64; 2], free: f64) -> ExposureIntegral {
    // f(u) = Σ (p + q u)² = A u² + 2 B u + C
    let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
    for (before, after) in before.into_iter().zip(after) {
        let (p, q) = (0.5 * (after + before), 0.5 * (after - before));
        (a, b, c) = (a + q * q, b + p * q, c + p * p);
    }
    let square = |u: f64| a * u * u + 2.0 * b * u + c;
    if a <= 0.0 {
        return ExposureIntegral { at: 0.0, log_integral: std::f64::consts::LN_2 - 0.5 * c };
    }
    let at = (-b / a).clamp(-free, free);
    // ∫ exp(-f/2) = exp(-½ (C - B²/A)) √(2π/A) [Φ((1 + B/A) √A) - Φ((-1 + B/A) √A)]
    let root = a.sqrt();
    let share = normal_between((b / a - 1.0) * root, (b / a + 1.0) * root);
    let log_integral = if share > 1e-280 {
        -0.5 * (c - b * b / a) + 0.5 * (TAU / a).ln() + share.ln()
    } else {
        // Far outside the minimum, the end nearer to it dominates. There exp(-½ f) falls exponentially with the rate ½
        // f'.
        let end = (-b / a).clamp(-1.0, 1.0);
        -0.5 * square(end) - (a * end + b).abs().ln()
    };
    ExposureIntegral { at, log_integral }
}

/// Returns Φ(high) - Φ(low) without loss of digits in the tails.
fn normal_between(low: f64, high: f64) -> f64 {
    let upper = |x: f64| 0.5 * libm::erfc(x / std::f64::consts::SQRT_2);
    if low > 0.0 { upper(low) - upper(high) } else { upper(-high) - upper(-low) }
}

/// Returns the logarithm of the normal density of an offset.
pub(super) fn log_normal(offset: Offset) -> f64 {
    -0.5 * offset.square() - (TAU.sqrt() * offset.sigma).ln()
}

/// Goodness of fit and weight of one candidate.
pub(super) struct CandidateWeight {
    chi_square: f64,
    terms: u32,
    log_weight: f64,
}

impl CandidateWeight {
    /// Computes the weight. `delay_square` is the squared delay in sigmas. `log_density` is the logarithm of the
    /// density of delay and cross-track offset, integrated over the exposure if the exact time is unknown.
    pub fn new(candidate: &Candidate, timing: Timing, delay_square: f64, log_density: f64) -> Self {
        let length = candidate.length_rad;
        let mut squares = vec![candidate.cross_track_rad.square(), candidate.angle_rad.square()];
        let mut log_weight = log_normal(candidate.angle_rad) + log_density;
        if timing == Timing::Within {
            // Delay and length are lower limits here; only a positive excess counts as an offset.
            squares.extend([delay_square].into_iter().filter(|square| *square > 1e-6));
            squares.extend(length.map(Offset::square).filter(|square| *square > 0.0));
            log_weight -= 0.5 * length.map_or(0.0, Offset::square);
        } else {
            squares.push(delay_square);
            squares.extend(length.map(Offset::square));
            log_weight += length.map_or(0.0, log_normal);
        }
        Self { chi_square: squares.iter().sum(), terms: squares.len() as u32, log_weight }
    }

    /// Sets χ², its probability and the weight of a candidate.
    pub fn apply_to(self, candidate: &mut Candidate) {
        candidate.chi_square = self.chi_square;
        candidate.terms = self.terms;
        candidate.p_value = chi_square_survival(self.chi_square, self.terms);
        candidate.log_weight = self.log_weight;
    }
}

/// Returns the logarithm of the total weight of satellites without element sets.
pub(super) fn log_weight_of_unknown(
    satellites: usize,
    timing: Timing,
    duration_s: f64,
    length_rad: Option<f64>,
) -> f64 {
    let number = (UNKNOWN_SHARE * satellites as f64).max(0.1);
    // Uniform density over low orbits: 1/P in time, half the foreshortening across the track, any angle.
    let anywhere = number / PERIOD_S * 0.5 * FORESHORTENING;
    match timing {
        Timing::Within => (anywhere * duration_s.max(1.0) / PI).ln(),
        Timing::Whole => (anywhere / PI / length_rad.unwrap_or(1.0)).ln(),
        Timing::FirstToSecond => (anywhere / TAU / length_rad.unwrap_or(1.0)).ln(),
    }
}

/// Sets the probabilities of the candidates, and returns that of a satellite without an element set.
pub(super) fn set_probabilities(candidates: &mut [Candidate], log_unknown: f64) -> f64 {
    let greatest = candidates.iter().map(|candidate| candidate.log_weight).fold(log_unknown, f64::max);
    let unknown = (log_unknown - greatest).exp();
    let total = unknown + candidates.iter().map(|candidate| (candidate.log_weight - greatest).exp()).sum::<f64>();
    for candidate in candidates {
        candidate.probability = (candidate.log_weight - greatest).exp() / total;
    }
    unknown / total
}

/// Returns the probability that a χ² with `terms` degrees of freedom is at least `chi_square` (Abramowitz & Stegun
/// 26.4.4 and 26.4.5); 1 if `terms` is 0.
fn chi_square_survival(chi_square: f64, terms: u32) -> f64 {
    if terms == 0 {
        return 1.0;
    }
    let half = 0.5 * chi_square.max(0.0);
    // Q(χ²|ν+2) = Q(χ²|ν) + (χ²/2)^(ν/2) e^(-χ²/2) / Γ(ν/2 + 1)
    let (mut q, mut degree, mut term) = if terms.is_multiple_of(2) {
        ((-half).exp(), 2, half * (-half).exp())
    } else {
        (libm::erfc(half.sqrt()), 1, 2.0 * (half / PI).sqrt() * (-half).exp())
    };
    while degree < terms {
        q += term;
        degree += 2;
        term *= half / (0.5 * f64::from(degree));
    }
    q.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 26.8 of Abramowitz & Stegun: the χ² that is exceeded with probability 0.05 and 0.001.
    #[test]
    fn valid_chi_square_against_abramowitz_and_stegun() {
        for (terms, at_5_percent, at_01_percent) in [
            (1, 3.84146, 10.828),
            (2, 5.99147, 13.816),
            (3, 7.81473, 16.266),
            (4, 9.48773, 18.467),
            (5, 11.0705, 20.515),
        ] {
            // Five digits of χ² determine the probability to 3e-6.
            assert!((chi_square_survival(at_5_percent, terms) - 0.05).abs() < 3e-6, "{terms}");
            assert!((chi_square_survival(at_01_percent, terms) - 0.001).abs() < 1e-6, "{terms}");
            assert_eq!(chi_square_survival(0.0, terms), 1.0);
        }
    }

    /// The closed form of the integral is compared with a numerical sum, for minima inside and far outside the
    /// exposure.
    #[test]
    fn verif_integral_over_the_exposure() {
        for (before, after) in [
            ([-3.0, 0.5], [5.0, 1.5]),
            ([2.0, -1.0], [9.0, 1.0]),
            ([-0.1, 0.0], [0.1, 0.0]),
            ([30.0, 4.0], [50.0, 4.0]),
        ] {
            let square = |u: f64| {
                (0..2).map(|axis| (0.5 * (before[axis] * (1.0 - u) + after[axis] * (1.0 + u))).powi(2)).sum::<f64>()
            };
            let integral = integrate_exposure(before, after, 1.0);
            let steps = 200_000;
            let step = 2.0 / f64::from(steps);
            let least = square(integral.at);
            let sum: f64 =
                (0..steps).map(|index| (-0.5 * (square(-1.0 + step * (f64::from(index) + 0.5)) - least)).exp()).sum();
            let expected = (sum * step).ln() - 0.5 * least;
            assert!(
                (integral.log_integral - expected).abs() < 1e-6,
                "{before:?}: {} {expected}",
                integral.log_integral
            );
            assert!((-100..=100).all(|u| square(f64::from(u) / 100.0) >= least - 1e-9));
        }
        // Far outside, the result is the integral of an exponential, accurate to second order.
        let far = integrate_exposure([60.0, 0.0], [100.0, 0.0], 1.0);
        assert!((far.log_integral - (-1800.0 - (60.0_f64 * 20.0).ln())).abs() < 0.2, "{}", far.log_integral);
        assert!(integrate_exposure([400.0, 0.0], [410.0, 3.0], 0.2).at == -0.2);
    }
}
