//! Factor of the error along the track of each kind, from delays that `streakcast measure` measured.

use std::path::Path;

use crate::elements::NoradId;
use crate::error::{Error, ErrorKind};
use crate::input::TableRows;
use crate::passes::LearnedLateness;

/// Degrees of freedom of Student's t, which describes the delays because they have wings.
const FREEDOM: f64 = 4.0;
/// Square of the scale of Student's t with four degrees of freedom, in units of the square of the half width that
/// contains 68.27 % (one sigma): 1 / 1.1416².
const SCALE2: f64 = 0.7673;
/// Largest error (one sigma) of a prediction for which `streakcast measure` searches all delays up to three sigmas,
/// seconds: it searches delays of at most 5 s.
const MOST_EXPECTED_SIGMA_S: f64 = 5.0 / 3.0;
/// Weight of the usual error (a factor of 1), as a number of delays.
const PRIOR_COUNT: f64 = 10.0;
/// Number of iterations of the weights; each reduces their error by a factor of two or more.
const ITERATIONS: usize = 100;
/// Smallest and largest factor.
const FACTORS: [f64; 2] = [0.1, 10.0];

/// Measured delay of one satellite.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MeasuredDelay {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Delay, seconds; positive is late.
    pub late_s: f64,
    /// Error (one sigma) of the measurement, seconds.
    pub sigma_s: f64,
    /// Error (one sigma) of the prediction, seconds.
    pub expected_sigma_s: f64,
}

impl MeasuredDelay {
    /// Returns true if all delays up to three sigmas of the prediction were searched. Otherwise large delays are
    /// missing, and the learned error would be too small.
    pub fn is_range_searched(&self) -> bool {
        self.expected_sigma_s <= MOST_EXPECTED_SIGMA_S
    }
}

/// Reads the delays of a table that `streakcast measure` wrote as CSV or ECSV. Streaks without an end in the frame have
/// no delay and are omitted.
///
/// # Errors
/// The file cannot be read, a column is missing, a number is invalid, or the table was measured with a learned file, so
/// that its errors are corrected already.
pub fn read_delays(path: &Path) -> Result<Vec<MeasuredDelay>, Error> {
    let error = |problem: String| Error::new(ErrorKind::Invalid, problem).in_file("measurements", path);
    let failed = |problem: std::io::Error| error(problem.to_string());
    let rows = TableRows::open(path).map_err(failed)?;
    if rows.comments.contains("learned") {
        return Err(error("it was measured with --learned; allowed: tables measured without it".to_owned()));
    }
    let column = |name| rows.column(name, "a table that streakcast measure wrote as CSV or ECSV").map_err(failed);
    let [id, late, sigma, expected] =
        [column("norad_id")?, column("late_s")?, column("late_sigma_s")?, column("late_expected_sigma_s")?];
    let mut delays = Vec::new();
    for row in rows {
        let row = row.map_err(failed)?;
        if row.text(late).is_empty() {
            continue;
        }
        delays.push(MeasuredDelay {
            norad_id: NoradId(row.parsed(id, "a catalogue number").map_err(failed)?),
            late_s: row.number_in(late, [f64::MIN, f64::MAX]).map_err(failed)?,
            sigma_s: row.number_in(sigma, [0.0, f64::MAX]).map_err(failed)?,
            expected_sigma_s: row.number_in(expected, [1e-6, f64::MAX]).map_err(failed)?,
        });
    }
    Ok(delays)
}

/// Returns the factor of the error along the track that the delays of one kind imply; `None` without delays of which
/// the [range was searched](MeasuredDelay::is_range_searched). Other delays are not used.
///
/// The factor is shrunk towards 1, as if ten more delays had the usual error.
pub fn learn_lateness(delays: &[MeasuredDelay]) -> Option<LearnedLateness> {
    let delays: Vec<&MeasuredDelay> = delays.iter().filter(|delay| delay.is_range_searched()).collect();
    if delays.is_empty() {
        return None;
    }
    let n = delays.len() as f64;
    let mut factor2 = 1.0;
    for _ in 0..ITERATIONS {
        // δ ~ t₄ √v, v = q (f² s² + σ²); u = 5 / (4 + δ²/v); k = f² s² / (f² s² + σ²);
        // f² = (10 + Σ (u k² δ² + q k σ²) / (q s²)) / (10 + n)
        let mut sum = PRIOR_COUNT;
        for delay in &delays {
            let (expected2, own2) = (delay.expected_sigma_s.powi(2), delay.sigma_s.powi(2));
            let v = SCALE2 * (factor2 * expected2 + own2);
            let weight = (FREEDOM + 1.0) / (FREEDOM + delay.late_s.powi(2) / v);
            // Posterior of the part of the delay that is not the error of the measurement.
            let kept = factor2 * expected2 / (factor2 * expected2 + own2);
            sum += (weight * kept.powi(2) * delay.late_s.powi(2) + SCALE2 * kept * own2) / (SCALE2 * expected2);
        }
        factor2 = sum / (PRIOR_COUNT + n);
    }
    let [least, most] = FACTORS;
    // The variance of the scale of Student's t with ν degrees of freedom: (ν + 3) / (2 ν n)
    let relative_sigma = ((FREEDOM + 3.0) / (2.0 * FREEDOM * (PRIOR_COUNT + n))).sqrt();
    Some(LearnedLateness { measurements: delays.len(), factor: factor2.sqrt().clamp(least, most), relative_sigma })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn delays(n: usize, factor: f64) -> Vec<MeasuredDelay> {
        // Quantiles of Student's t with four degrees of freedom by bisection of its cumulative distribution.
        let student = |t: f64| {
            let q = (1.0 + t * t / 4.0_f64).sqrt();
            0.5 + 0.375 * (t / q) * (1.0 - t * t / (12.0 * q * q))
        };
        let quantile = |share: f64| {
            let (mut low, mut high) = (-100.0, 100.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if student(middle) < share { low = middle } else { high = middle }
            }
            low
        };
        let delay = |i: usize| MeasuredDelay {
            norad_id: NoradId(1),
            late_s: factor * quantile((i as f64 + 0.5) / n as f64) / 1.1416,
            sigma_s: 0.01,
            expected_sigma_s: 1.0,
        };
        (0..n).map(delay).collect()
    }

    #[test]
    fn verif_many_delays_determine_the_factor_and_few_do_not() {
        assert_eq!(learn_lateness(&[]), None);
        let [near] = delays(1, 1.0)[..] else { unreachable!() };
        assert_eq!(learn_lateness(&[MeasuredDelay { expected_sigma_s: 1.7, ..near }; 40]), None);
        for factor in [0.5, 1.0, 3.0] {
            let many = learn_lateness(&delays(2000, factor)).unwrap();
            assert!((many.factor / factor - 1.0).abs() < 0.03, "{many:?} for {factor}");
        }
        // Two delays of three sigmas each are not evidence of a factor of 3.
        let few = learn_lateness(&[delays(2000, 3.0)[1500]; 2]).unwrap();
        assert!(few.factor > 1.0 && few.factor < 1.3, "{few:?}");
    }
}
