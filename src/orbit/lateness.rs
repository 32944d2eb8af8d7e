//! Distribution of the lateness of a satellite against its prediction.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Delays up to this many sigmas of the widest Gaussian, without that of manoeuvres, are searched.
const REACH_SIGMAS: f64 = 3.5;
/// Steps of one sigma on both sides of the mean that represent a Gaussian.
const REACH_STEPS: i32 = 4;
/// Probabilities are lower limits where a larger share of delays than this is not searched.
const LARGEST_SHARE_LEFT_OUT: f64 = 0.1;
/// Probability within one sigma of a normal distribution.
const ONE_SIGMA: f64 = 0.682_689_492_137;

/// Distribution of the delay δ along the track, seconds, positive where the satellite is late: a mixture of Gaussians
/// about 0.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Lateness {
    /// Weights, which add up to 1, and sigmas in seconds, in increasing order; unused ones have weight 0.
    parts: [(f64, f64); 3],
    /// Number of parts whose delays are searched; the part of manoeuvres, the last one, is not searched.
    searched: usize,
}

impl Lateness {
    /// Largest delay that is searched, seconds.
    pub const LONGEST_S: f64 = 300.0;

    /// A Gaussian; a sigma of 0 means that δ is exactly 0.
    pub fn gaussian(sigma_s: f64) -> Self {
        Self { parts: [(1.0, sigma_s), (0.0, sigma_s), (0.0, sigma_s)], searched: 1 }
    }

    /// A core of two Gaussians, and a third Gaussian for satellites that manoeuvred since the epoch. Each is given by
    /// its weight and its sigma in seconds; the weights of the core add up to 1.
    pub fn core_and_manoeuvres(core: [(f64, f64); 2], manoeuvres: (f64, f64)) -> Self {
        let rest = 1.0 - manoeuvres.0;
        let [inner, outer] = core.map(|(weight, sigma_s)| (rest * weight, sigma_s));
        Self { parts: [inner, outer, manoeuvres], searched: 2 }
    }

    /// As [`core_and_manoeuvres`](Self::core_and_manoeuvres), where the third Gaussian is an ordinary part of the
    /// distribution, whose delays are searched.
    pub fn core_and_wings(core: [(f64, f64); 2], wings: (f64, f64)) -> Self {
        Self { searched: 3, ..Self::core_and_manoeuvres(core, wings) }
    }

    /// The distribution with an independent Gaussian error added, such as that of a clock.
    pub fn blurred(&self, sigma_s: f64) -> Self {
        Self { parts: self.parts.map(|(weight, part_s)| (weight, part_s.hypot(sigma_s))), ..*self }
    }

    /// The distribution with all delays multiplied by a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { parts: self.parts.map(|(weight, sigma_s)| (weight, factor * sigma_s)), ..*self }
    }

    /// The distribution of satellites that have not manoeuvred since the epoch, and their share, (0, 1].
    pub fn without_manoeuvres(&self) -> (Self, f64) {
        let kept: f64 = self.parts[..self.searched].iter().map(|(weight, _)| weight).sum();
        let mut parts = self.parts.map(|(weight, sigma_s)| (weight / kept, sigma_s));
        parts[self.searched..].iter_mut().for_each(|(weight, _)| *weight = 0.0);
        (Self { parts, ..*self }, kept)
    }

    fn is_gaussian(&self) -> bool {
        self.parts().count() == 1
    }

    /// Number of sigmas of a normal distribution that is exceeded as rarely as this delay: |δ|/σ for a Gaussian.
    pub fn equivalent_sigmas(&self, delay_s: f64) -> f64 {
        if self.is_gaussian() {
            return delay_s.abs() / self.parts[0].1;
        }
        let exceeded: f64 =
            self.parts().map(|(weight, sigma_s)| weight * libm::erfc(delay_s.abs() / sigma_s * FRAC_1_SQRT_2)).sum();
        // P(|x| > z) = erfc(z/√2) is solved for z by bisection; at z = 38 it underflows.
        let (mut low, mut high) = (0.0, 38.0);
        for _ in 0..50 {
            let middle: f64 = 0.5 * (low + high);
            if libm::erfc(middle * FRAC_1_SQRT_2) > exceeded { low = middle } else { high = middle }
        }
        low
    }

    /// Weights and sigmas (seconds) of the Gaussians.
    pub fn parts(&self) -> impl Iterator<Item = (f64, f64)> + Clone + use<> {
        self.parts.into_iter().filter(|(weight, _)| *weight > 0.0)
    }

    /// Natural logarithm of the density at δ, 1/s. The sigmas must not be 0.
    pub fn log_density(&self, delay_s: f64) -> f64 {
        let logarithms = self.parts().map(|(weight, sigma_s)| {
            // ln w N(δ; σ)
            weight.ln() - 0.5 * (delay_s / sigma_s).powi(2) - (TAU.sqrt() * sigma_s).ln()
        });
        let greatest = logarithms.clone().fold(f64::NEG_INFINITY, f64::max);
        greatest + logarithms.map(|x| (x - greatest).exp()).sum::<f64>().ln()
    }

    /// Half width that holds 68.27 % of the delays, seconds.
    pub fn one_sigma_s(&self) -> f64 {
        let inner_s = self.parts[0].1;
        if self.is_gaussian() {
            return inner_s;
        }
        // Newton's method on P(|δ| ≤ x) = 0.6827, which is concave in x, started below the solution, at the innermost
        // sigma.
        let mut half_s = inner_s;
        for _ in 0..100 {
            // P(|δ| ≤ x) = Σ w (1 - erfc(x / σ√2)), and its derivative 2 Σ w N(x; σ).
            let (mut within, mut slope) = (0.0, 0.0);
            for (weight, sigma_s) in self.parts() {
                let z = half_s / sigma_s;
                within += weight * (1.0 - libm::erfc(z * FRAC_1_SQRT_2));
                slope += 2.0 * weight * (-0.5 * z * z).exp() / (TAU.sqrt() * sigma_s);
            }
            let step_s = (ONE_SIGMA - within) / slope;
            half_s += step_s;
            // The error of the result is of the order of the square of the last step.
            if step_s < 1e-5 * half_s {
                break;
            }
        }
        half_s
    }

    /// Half width about 0 that holds a share of the delays, in (0, 1), seconds.
    pub fn half_width_s(&self, share: f64) -> f64 {
        // Beyond nine sigmas of the widest Gaussian, the share is 1 in double precision.
        let (mut low_s, mut high_s) = (0.0, 9.0 * self.parts().map(|(_, sigma_s)| sigma_s).fold(0.0, f64::max));
        for _ in 0..60 {
            let middle_s = 0.5 * (low_s + high_s);
            if self.share(-middle_s, middle_s) < share { low_s = middle_s } else { high_s = middle_s }
        }
        high_s
    }

    /// Largest delay, of either sign, that is searched, seconds.
    pub fn reach_s(&self) -> f64 {
        (REACH_SIGMAS * self.parts[self.searched - 1].1).min(Self::LONGEST_S)
    }

    /// True if delays longer than those that are searched are so probable that probabilities are lower limits.
    pub fn is_cut(&self) -> bool {
        self.searched_share() < 1.0 - LARGEST_SHARE_LEFT_OUT
    }

    /// Share of the delays that are searched: the share of the crossings of a satellite that the search finds, (0, 1].
    pub fn searched_share(&self) -> f64 {
        if self.parts[0].1 > 0.0 { self.share(-self.reach_s(), self.reach_s()) } else { 1.0 }
    }

    /// Share of the crossings of an exposure that its nominal tracks predict, [0, 1]: the time at which a satellite
    /// crosses is uniform in the exposure of `duration_s`, and its nominal track crosses in the exposure or within
    /// `margin_s` before or after it (seconds, not negative).
    pub fn predicted_share(&self, duration_s: f64, margin_s: f64) -> f64 {
        if duration_s <= 0.0 {
            return self.share(-margin_s, margin_s);
        }
        // 1/T ∫₀ᵀ du [F(u + m) - F(u - T - m)], with the integral I of F
        let integral_s = |x_s: f64| self.cumulative_integral_s(x_s);
        let before_s = integral_s(duration_s + margin_s) - integral_s(margin_s);
        let after_s = integral_s(-margin_s) - integral_s(-duration_s - margin_s);
        ((before_s - after_s) / duration_s).clamp(0.0, 1.0)
    }

    /// P(δ ≤ x). If the delay is certain (sigma 0), it is 1 for x ≥ 0 and 0 for x < 0.
    pub fn cumulative(&self, x_s: f64) -> f64 {
        let part = |(weight, sigma_s): (f64, f64)| {
            if sigma_s > 0.0 {
                // Φ(x/σ)
                weight * 0.5 * libm::erfc(-x_s / sigma_s * FRAC_1_SQRT_2)
            } else {
                weight * f64::from(u8::from(x_s >= 0.0))
            }
        };
        self.parts().map(part).sum()
    }

    /// P(low < δ ≤ high).
    pub fn share(&self, low_s: f64, high_s: f64) -> f64 {
        self.cumulative(high_s) - self.cumulative(low_s)
    }

    /// Delays (seconds) with their probabilities that represent the searched part of the distribution. A Gaussian of at
    /// least `step_s` is represented by delays one sigma apart, of which the first is shifted by `offset` sigmas, [0,
    /// 1); a narrower one by its mean.
    pub fn delays(&self, step_s: f64, offset: f64) -> impl Iterator<Item = (f64, f64)> + use<> {
        let reach_s = self.reach_s();
        let of_part = move |(weight, sigma_s): (f64, f64)| {
            let is_wide = sigma_s >= step_s;
            // Σ φ(z) over points one sigma apart is 1 within 10⁻⁸, wherever the first point is.
            let wide = (-REACH_STEPS..REACH_STEPS).map(move |step| {
                let z = f64::from(step) + offset;
                (z * sigma_s, weight * (-0.5 * z * z).exp() / TAU.sqrt())
            });
            let narrow = std::iter::once((0.0, weight)).filter(move |_| !is_wide);
            narrow.chain(wide.filter(move |_| is_wide))
        };
        self.parts().flat_map(of_part).filter(move |(delay_s, _)| delay_s.abs() <= reach_s)
    }

    /// Expected value of max(x - δ, 0), the integral of [`Lateness::cumulative`] up to x, seconds.
    pub fn cumulative_integral_s(&self, x_s: f64) -> f64 {
        let part = |(weight, sigma_s): (f64, f64)| {
            if sigma_s > 0.0 {
                // ∫ Φ(x/σ) dx = x Φ(x/σ) + σ φ(x/σ)
                let z = x_s / sigma_s;
                let cumulative = 0.5 * libm::erfc(-z * FRAC_1_SQRT_2);
                weight * (x_s * cumulative + sigma_s * (-0.5 * z * z).exp() / TAU.sqrt())
            } else {
                weight * x_s.max(0.0)
            }
        };
        self.parts().map(part).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_shares_and_integrals_of_a_gaussian() {
        let lateness = Lateness::gaussian(20.0);
        // Φ(1) - Φ(-1)
        assert!((lateness.share(-20.0, 20.0) - ONE_SIGMA).abs() < 1e-12);
        assert_eq!(lateness.one_sigma_s(), 20.0);
        // The mean of |δ| = 2 E max(-δ, 0) is σ √(2/π).
        assert!((2.0 * lateness.cumulative_integral_s(0.0) - 20.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-12);
        assert_eq!((lateness.reach_s(), lateness.is_cut()), (70.0, false));
        // 300 s are 1.5 sigmas: 13 % of the delays are longer.
        let old = Lateness::gaussian(200.0);
        assert_eq!((old.reach_s(), old.is_cut()), (300.0, true));
        let certain = Lateness::gaussian(0.0);
        assert_eq!(
            (certain.share(-1.0, 0.0), certain.share(0.1, 5.0), certain.cumulative_integral_s(-1.0), certain.is_cut()),
            (1.0, 0.0, 0.0, false)
        );
    }

    #[test]
    fn verif_shares_of_crossings_that_are_predicted() {
        let lateness = Lateness::core_and_manoeuvres([(0.7, 4.0), (0.3, 13.0)], (0.1, 500.0));
        // The mean over the times of crossing, in steps of 0.01 s.
        for (duration_s, margin_s) in [(10.0, 2.0), (300.0, 0.0), (30.0, 60.0)] {
            let steps = (duration_s * 100.0) as u32;
            let of_time = |step: u32| {
                let time_s = (f64::from(step) + 0.5) / 100.0;
                lateness.share(time_s - duration_s - margin_s, time_s + margin_s)
            };
            let mean = (0..steps).map(of_time).sum::<f64>() / f64::from(steps);
            assert!((lateness.predicted_share(duration_s, margin_s) - mean).abs() < 1e-4, "{duration_s} {margin_s}");
        }
        assert_eq!(lateness.predicted_share(0.0, 5.0), lateness.share(-5.0, 5.0));
        assert_eq!(Lateness::gaussian(0.0).predicted_share(10.0, 0.0), 1.0);
        // A delay with a sigma of 37 s makes the prediction useless for 10 s, and hardly matters for 5 min.
        let late = Lateness::gaussian(37.0);
        assert!(late.predicted_share(10.0, 2.0) < 0.15 && late.predicted_share(300.0, 2.0) > 0.9);
        assert_eq!(late.searched_share(), late.share(-129.5, 129.5));
        assert_eq!(Lateness::gaussian(0.0).searched_share(), 1.0);
    }

    #[test]
    fn verif_delays_represent_the_searched_distribution() {
        let lateness = Lateness::core_and_wings([(0.6, 0.4), (0.4, 4.0)], (0.2, 10.0));
        for offset in [0.0, 0.3, 0.9] {
            let delays: Vec<(f64, f64)> = lateness.delays(1.0, offset).collect();
            let moment = |power: i32| delays.iter().map(|(late_s, share)| share * late_s.powi(power)).sum::<f64>();
            let parts: Vec<(f64, f64)> = lateness.parts().collect();
            // The narrow part is at 0, and delays beyond 3.5 sigmas, 2 % of the variance, are left out.
            let variance = parts[1].0 * parts[1].1.powi(2) + parts[2].0 * parts[2].1.powi(2);
            assert!((moment(0) - 1.0).abs() < 1e-3 && moment(1).abs() < 0.03, "{offset}: {delays:?}");
            assert!((moment(2) / variance - 1.0).abs() < 0.03, "{offset}: {} {variance}", moment(2));
            assert!(delays.iter().all(|(late_s, _)| late_s.abs() <= lateness.reach_s()));
        }
        assert_eq!(Lateness::gaussian(0.9).delays(1.0, 0.5).collect::<Vec<_>>(), [(0.0, 1.0)]);
    }

    #[test]
    fn verif_shares_and_integrals_of_a_mixture() {
        let lateness = Lateness::core_and_manoeuvres([(0.7, 2.0), (0.3, 7.0)], (0.2, 500.0));
        let weights: f64 = lateness.parts().map(|(weight, _)| weight).sum();
        assert!((weights - 1.0).abs() < 1e-12);
        let one_sigma_s = lateness.one_sigma_s();
        assert!((lateness.share(-one_sigma_s, one_sigma_s) - ONE_SIGMA).abs() < 1e-9);
        // The integral against a sum of the cumulative distribution in steps of 1/8 s.
        let sum: f64 = (-24_000..80).map(|step| lateness.cumulative((f64::from(step) + 0.5) / 8.0) / 8.0).sum();
        assert!((lateness.cumulative_integral_s(10.0) - sum).abs() < 1e-3, "{sum}");
        assert!((lateness.equivalent_sigmas(one_sigma_s) - 1.0).abs() < 1e-9);
        assert_eq!(Lateness::gaussian(2.0).equivalent_sigmas(-6.0), 3.0);
        assert!((lateness.half_width_s(ONE_SIGMA) - one_sigma_s).abs() < 1e-6 * one_sigma_s);
        assert!((Lateness::gaussian(2.0).half_width_s(0.95) - 2.0 * 1.959_963_985).abs() < 1e-6);
        assert_eq!(Lateness::gaussian(0.0).half_width_s(0.95), 0.0);
        let (core, kept) = lateness.without_manoeuvres();
        assert!((kept - 0.8).abs() < 1e-12 && (core.share(-1e3, 1e3) - 1.0).abs() < 1e-12);
        assert!((core.share(-3.0, 3.0) - (0.7 * 0.866_385_597 + 0.3 * 0.331_768_169)).abs() < 1e-6);
        assert_eq!(Lateness::gaussian(2.0).without_manoeuvres(), (Lateness::gaussian(2.0), 1.0));
        // Manoeuvres are not searched: here a fifth of all delays.
        assert_eq!((lateness.reach_s(), lateness.is_cut()), (24.5, true));
        assert!(!Lateness::core_and_manoeuvres([(0.7, 2.0), (0.3, 7.0)], (0.02, 500.0)).is_cut());
        // The density is the slope of the cumulative distribution.
        let slope = (lateness.cumulative(5.001) - lateness.cumulative(4.999)) / 0.002;
        assert!((lateness.log_density(5.0) - slope.ln()).abs() < 1e-6);
        let blurred = lateness.blurred(3.0);
        assert!((blurred.parts().next().unwrap().1 - 13_f64.sqrt()).abs() < 1e-12);
    }
}
