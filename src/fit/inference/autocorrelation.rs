//! How many steps of a chain make one independent draw.
//!
//! The integrated autocorrelation time by Sokal's windows (1989 lectures, section 3), averaged over walkers as emcee does:
//!
//! ```text
//! τ(M) = 1 + 2 Σ_{t=1..M} ρ(t),   M the least with M ≥ 5 τ(M)
//! ```

use super::ensemble::Chain;

/// c of the window M ≥ c τ(M).
const WINDOW: f64 = 5.0;
/// A chain shorter than this many τ does not yet know its τ.
const TRUSTED: f64 = 50.0;

/// Of one parameter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AutocorrelationTime {
    /// τ, steps; not a number where the parameter never moved.
    pub steps: f64,
    /// True where the chain is longer than 50 τ: below, τ is an estimate that mostly still grows.
    pub is_trusted: bool,
}

/// One for each parameter, of the steps after `burn_in`.
pub fn autocorrelation_times(chain: &Chain, burn_in: usize) -> Vec<AutocorrelationTime> {
    let steps = chain.steps().saturating_sub(burn_in);
    (0..chain.parameters())
        .map(|parameter| {
            let tracks: Vec<Vec<f64>> = (0..chain.walkers())
                .map(|walker| centred((burn_in..chain.steps()).map(|step| chain.at(step, walker)[parameter])))
                .collect();
            let tau = integrated(&tracks, steps);
            AutocorrelationTime { steps: tau, is_trusted: steps as f64 > TRUSTED * tau }
        })
        .collect()
}

fn centred(track: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut track: Vec<f64> = track.collect();
    let mean = track.iter().sum::<f64>() / track.len().max(1) as f64;
    track.iter_mut().for_each(|x| *x -= mean);
    track
}

fn integrated(tracks: &[Vec<f64>], steps: usize) -> f64 {
    // ρ(t) = C(t)/C(0), C(t) = Σ_i x_i x_{i+t}; the mean of ρ over the walkers. Lags are summed until the window closes.
    let product = |track: &[f64], lag: usize| track.iter().zip(&track[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let zero: Vec<f64> = tracks.iter().map(|track| product(track, 0)).collect();
    let mut sum = 0.0;
    let mut tau = f64::NAN;
    for lag in 0..steps {
        let rho =
            tracks.iter().zip(&zero).map(|(track, zero)| product(track, lag) / zero).sum::<f64>() / tracks.len() as f64;
        sum += rho;
        tau = 2.0 * sum - 1.0;
        // Not a number where a walker never moved: no window ever closes.
        if lag as f64 >= WINDOW * tau || tau.is_nan() {
            break;
        }
    }
    tau
}
