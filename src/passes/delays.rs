//! How likely a delay is that brings a satellite into an exposure: of one path through a field, run through late or early.
//!
//! A satellite that is late by δ stands at time t where it was predicted for t - δ, and is in the field during [start, end] where it was to be in
//! it during the chord [a, b]: for start - b ≤ δ ≤ end - a. Where the normal distribution of δ hardly bends over
//! these (chord and exposure are short against its sigma), it is taken for its tangent there.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use super::track::Chord;

/// Sigmas longer than this many times the delays of one crossing are taken for their tangent: a part in 2400 of a chance.
const STRAIGHT: f64 = 10.0;

/// What is to be expected of one satellite in one exposure.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(super) struct Odds {
    /// Probability that it is inside the field at any time.
    pub probability: f64,
    /// Length of its streak, averaged over all errors, those that lead past the field counting as 0; radians.
    pub streak_length_rad: f64,
}

/// The delays of one satellite in one exposure.
#[derive(Clone, Debug)]
pub(super) struct Delays {
    start_s: f64,
    end_s: f64,
    sigma_s: f64,
    /// Revolutions that lead through the field as this one does are so much later, seconds.
    turns_s: Vec<f64>,
    straight: Option<Straight>,
    only_entering: bool,
}

/// The density of delays about one of them, of all revolutions together.
#[derive(Copy, Clone, Debug)]
struct Straight {
    middle_s: f64,
    density: f64,
    slope: f64,
}

impl Delays {
    /// Gaussian about 0; certain for a sigma of 0.
    pub fn new((start_s, end_s): (f64, f64), sigma_s: f64) -> Self {
        Self { start_s, end_s, sigma_s, turns_s: vec![0.0], straight: None, only_entering: false }
    }

    /// With `true` only the delays by which the satellite comes into the field while the shutter is open count, not those by which it is in it as it opens.
    pub fn only_entering(self, only_entering: bool) -> Self {
        Self { only_entering, ..self }
    }

    /// The same of a path that is run through again and again, so much later (0 among them); `crossing_s` is about when it leads through the field, and
    /// `longest_s` the longest that it may take.
    pub fn of_turns(self, turns_s: Vec<f64>, crossing_s: f64, longest_s: f64) -> Self {
        let length_s = self.end_s - self.start_s + longest_s;
        let straight = (self.sigma_s > STRAIGHT * length_s).then(|| {
            let middle_s = 0.5 * (self.start_s + self.end_s) - crossing_s;
            let mut straight = Straight { middle_s, density: 0.0, slope: 0.0 };
            for turn_s in &turns_s {
                // φ(z) / σ and its slope -z φ(z) / σ²
                let z = (middle_s - turn_s) / self.sigma_s;
                let density = (-0.5 * z * z).exp() / (self.sigma_s * TAU.sqrt());
                straight.density += density;
                straight.slope -= z / self.sigma_s * density;
            }
            straight
        });
        Self { turns_s, straight, ..self }
    }

    /// Of a path's chords through the field.
    pub fn odds(&self, chords: &[Chord], length_rad: impl Fn(&Chord) -> f64) -> Odds {
        let streak_length_rad = chords
            .iter()
            .map(|chord| match chord.exit_s - chord.enter_s {
                duration_s if duration_s > 0.0 => length_rad(chord) * self.expected_stay_s(chord) / duration_s,
                _ => 0.0,
            })
            .sum();
        Odds { probability: self.probability(chords), streak_length_rad }
    }

    /// Share of delays that bring one of the chords into the exposure. Ranges of delay of neighbouring chords are joined. A satellite enters the
    /// field once, where its first chord begins.
    fn probability(&self, chords: &[Chord]) -> f64 {
        if self.only_entering {
            let enters_s = chords.iter().map(|chord| chord.enter_s).min_by(f64::total_cmp);
            return enters_s.map_or(0.0, |enter_s| self.share(self.start_s - enter_s, self.end_s - enter_s));
        }
        let mut ranges: Vec<(f64, f64)> =
            chords.iter().map(|chord| (self.start_s - chord.exit_s, self.end_s - chord.enter_s)).collect();
        ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut total, mut done) = (0.0, f64::NEG_INFINITY);
        for (low, high) in ranges {
            if high > done {
                total += self.share(low.max(done), high);
                done = high;
            }
        }
        total
    }

    /// Share of delays from one to another.
    fn share(&self, low_s: f64, high_s: f64) -> f64 {
        if let Some(Straight { middle_s, density, slope }) = self.straight {
            return (high_s - low_s) * (density + slope * (0.5 * (low_s + high_s) - middle_s)).max(0.0);
        }
        let of = |turn_s: &f64| normal_cdf(high_s - turn_s, self.sigma_s) - normal_cdf(low_s - turn_s, self.sigma_s);
        self.turns_s.iter().map(of).sum()
    }

    /// Time that a chord spends inside the exposure, averaged over all delays, seconds.
    fn expected_stay_s(&self, chord: &Chord) -> f64 {
        if let Some(Straight { middle_s, density, slope }) = self.straight {
            // ∫₀ᵀ dt ∫ₐᵇ dp f(t - p), f straight
            let delay_s = 0.5 * (self.start_s + self.end_s - chord.enter_s - chord.exit_s);
            let area = (self.end_s - self.start_s) * (chord.exit_s - chord.enter_s);
            return area * (density + slope * (delay_s - middle_s)).max(0.0);
        }
        // ∫₀ᵀ dt [Φ((t - a)/σ) - Φ((t - b)/σ)], and ∫ Φ(x/σ) dx = x Φ(x/σ) + σ φ(x/σ); without an error the overlap itself.
        let integral = |x: f64| {
            if self.sigma_s > 0.0 {
                let z = x / self.sigma_s;
                x * normal_cdf(x, self.sigma_s) + self.sigma_s * (-0.5 * z * z).exp() / TAU.sqrt()
            } else {
                x.max(0.0)
            }
        };
        let over = |edge_s: f64| integral(self.end_s - edge_s) - integral(self.start_s - edge_s);
        let of = |turn_s: &f64| (over(chord.enter_s + turn_s) - over(chord.exit_s + turn_s)).max(0.0);
        self.turns_s.iter().map(of).sum()
    }
}

/// Φ(x/σ); a step for σ = 0, the border counting as inside.
pub(super) fn normal_cdf(x: f64, sigma: f64) -> f64 {
    if sigma > 0.0 {
        0.5 * libm::erfc(-x / sigma * FRAC_1_SQRT_2)
    } else if x >= 0.0 {
        1.0
    } else {
        0.0
    }
}
