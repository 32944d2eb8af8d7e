//! Slow functions of time, sampled on a grid of half days and interpolated.

use hifitime::Epoch;

use super::time::{epoch_from_utc_day, mjd_utc, seconds_after, seconds_between};
use crate::math::interpolation::cubic_weights;

/// Spacing of the nodes, seconds. Precession, nutation, the Earth's orbit and the Moon's perturbations vary slowly on
/// this scale: a cubic through four nodes has a relative error below 3·10⁻¹⁰. Daily tables of the Earth's orientation
/// have all their rows at nodes.
const STEP_S: f64 = 43_200.0;

/// `N` smooth functions of time, given by their values at evenly spaced nodes.
#[derive(Clone, Debug)]
pub(crate) struct Sampled<const N: usize> {
    /// Seconds from the reference epoch to the first node.
    first_s: f64,
    /// Values at the nodes; there are at least four nodes.
    nodes: Vec<[f64; N]>,
}

impl<const N: usize> Sampled<N> {
    /// Samples `function` from `start` to `end` and half a day on either side; seconds count from `start`.
    ///
    /// Nodes lie at 0h and 12h UTC (shifted by the leap seconds within the interval). The rows of Earth orientation
    /// tables are at 0h UTC.
    pub(crate) fn new(start: Epoch, end: Epoch, function: impl Fn(Epoch) -> [f64; N]) -> Self {
        let midnight = epoch_from_utc_day(mjd_utc(start).floor() as i64);
        let lead_s = seconds_between(midnight, start);
        let lead_nodes = (lead_s / STEP_S).floor();
        let first_s = (lead_nodes - 1.0) * STEP_S - lead_s;
        let span_s = seconds_between(start, end).max(0.0);
        // One node before the start, two after the end, and at least the four that a cubic needs.
        let count = ((span_s - first_s) / STEP_S).floor() as usize + 3;
        let nodes = (0..count).map(|node| function(seconds_after(start, first_s + node as f64 * STEP_S))).collect();
        Self { first_s, nodes }
    }

    /// Returns the same functions with the reference epoch moved later by `seconds`.
    pub(crate) fn counted_from(&self, seconds: f64) -> Self {
        Self { first_s: self.first_s - seconds, nodes: self.nodes.clone() }
    }

    /// Returns the index of the node before `seconds` (never the last node) and the fraction of the step from that node
    /// to the next. Before the first and after the last node the fraction is outside [0, 1].
    fn locate(&self, seconds: f64) -> (usize, f64) {
        let position = (seconds - self.first_s) / STEP_S;
        // A NaN or a negative position becomes 0 in the cast.
        let node = (position as usize).min(self.nodes.len() - 2);
        (node, position - node as f64)
    }

    /// Interpolates linearly between two nodes, for functions that are themselves tables with linear interpolation.
    pub(crate) fn linear_at(&self, seconds: f64) -> [f64; N] {
        let (node, fraction) = self.locate(seconds);
        let (left, right) = (&self.nodes[node], &self.nodes[node + 1]);
        std::array::from_fn(|k| left[k] + (right[k] - left[k]) * fraction)
    }

    /// Interpolates by a cubic through the four nearest nodes.
    pub(crate) fn cubic_at(&self, seconds: f64) -> [f64; N] {
        let (node, _) = self.locate(seconds);
        let first = node.clamp(1, self.nodes.len() - 3) - 1;
        let weights = cubic_weights((seconds - self.first_s) / STEP_S - first as f64);
        let nodes = &self.nodes[first..first + 4];
        std::array::from_fn(|k| {
            weights[0] * nodes[0][k] + weights[1] * nodes[1][k] + weights[2] * nodes[2][k] + weights[3] * nodes[3][k]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_pass_through_a_table_of_any_length() {
        for start in ["2024-01-01T00:00:00 UTC", "2024-01-01T12:00:00 UTC", "2024-01-01T11:59:59.5 UTC"] {
            let start: Epoch = start.parse().expect("an epoch");
            // A cubic of time is reproduced exactly, also before the start and after the end.
            let cubic = |days: f64| 1.0 + days * (2.0 - days * (0.5 - 0.25 * days));
            for span_s in [0.0, 1e-3, 43_199.0, 43_200.0, 43_201.0, 1e6] {
                let table = Sampled::new(start, seconds_after(start, span_s), |epoch| {
                    [cubic(seconds_between(start, epoch) / 86_400.0)]
                });
                for seconds in [-20_000.0, 0.0, 0.5 * span_s, span_s, span_s + 20_000.0] {
                    let [value] = table.cubic_at(seconds);
                    let exact = cubic(seconds / 86_400.0);
                    assert!(
                        (value - exact).abs() < 1e-9 * exact.abs().max(1.0),
                        "{start} {span_s} {seconds}: {value} {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_end_before_the_start_and_a_time_that_is_no_number() {
        let start: Epoch = "2024-01-01T00:00:00 UTC".parse().expect("an epoch");
        let table = Sampled::new(start, seconds_after(start, -1e6), |_| [1.0]);
        assert_eq!(table.cubic_at(0.0), [1.0]);
        assert_eq!(table.linear_at(-1e9), [1.0]);
        assert!(table.cubic_at(f64::NAN)[0].is_nan());
    }
}
