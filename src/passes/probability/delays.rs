//! Probability of the delays with which a satellite is in the field during an exposure, for one track.
//!
//! A satellite that is late by δ is at time t where it was predicted for t - δ. Let its predicted track be in the field
//! during the chord [a, b]. The satellite is in the field at some time of the exposure [start, end] if start - b ≤ δ ≤
//! end - a.

use super::super::track::Chord;
use crate::orbit::Lateness;

/// Probability and expected streak length of one satellite in one exposure.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(in crate::passes) struct Odds {
    /// Probability that the satellite is inside the field at any time of the exposure.
    pub probability: f64,
    /// Length of the streak, radians, averaged over all errors; errors with which the satellite misses the field count
    /// with 0.
    pub streak_length_rad: f64,
}

/// Distribution of the delay of one satellite, and the time interval of the exposure.
#[derive(Copy, Clone, Debug)]
pub(in crate::passes) struct Delays {
    pub start_s: f64,
    pub end_s: f64,
    pub lateness: Lateness,
    /// If true, only delays with which the satellite enters the field after `start_s` are counted; delays with which it
    /// is inside the field at `start_s` are not.
    pub only_entering: bool,
}

impl Delays {
    /// Returns probability and expected streak length for the chords of a track. `length_rad` returns the length of a
    /// chord.
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

    /// Returns the probability of the delays with which the satellite is on one of the chords during the exposure.
    /// Overlapping ranges of delays are joined. The satellite enters the field once, at the beginning of its first
    /// chord.
    fn probability(&self, chords: &[Chord]) -> f64 {
        if self.only_entering {
            let enters_s = chords.iter().map(|chord| chord.enter_s).min_by(f64::total_cmp);
            return enters_s.map_or(0.0, |enter_s| self.lateness.share(self.start_s - enter_s, self.end_s - enter_s));
        }
        let mut ranges: Vec<(f64, f64)> =
            chords.iter().map(|chord| (self.start_s - chord.exit_s, self.end_s - chord.enter_s)).collect();
        ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut total, mut done) = (0.0, f64::NEG_INFINITY);
        for (low, high) in ranges {
            if high > done {
                total += self.lateness.share(low.max(done), high);
                done = high;
            }
        }
        total
    }

    /// Returns the time that the satellite spends on a chord during the exposure, averaged over all delays, seconds.
    fn expected_stay_s(&self, chord: &Chord) -> f64 {
        // ∫₀ᵀ dt [P(δ ≤ t - a) - P(δ ≤ t - b)]
        let over = |edge_s: f64| {
            self.lateness.cumulative_integral_s(self.end_s - edge_s)
                - self.lateness.cumulative_integral_s(self.start_s - edge_s)
        };
        (over(chord.enter_s) - over(chord.exit_s)).max(0.0)
    }
}
