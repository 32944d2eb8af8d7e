//! Posterior of the free parameters, drawn by walkers that start at a fit.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::math::quantile::quantile;

use super::error::FitError;
use super::inference::{AutocorrelationTime, Chain, Ensemble, autocorrelation_times};
use super::objective::Objective;
use super::solve::Fit;

/// Distinguishes the seed of the starting positions from that of the walk.
const START_SALT: u64 = 0x5354_4152_5453;
/// Half width of the starting positions of a parameter without sigma, as a fraction of the interval between its bounds.
const UNKNOWN_SPREAD: f64 = 1e-3;

/// Settings of a posterior.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct PosteriorSettings {
    /// Steps including burn-in.
    pub steps: usize,
    /// Steps at the beginning that are not used.
    pub burn_in: usize,
    /// Walkers; even, at least twice as many as free parameters.
    pub walkers: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for PosteriorSettings {
    /// 5,000 steps and 200 of burn-in (Lu 2024, figure of the posterior) of 32 walkers.
    fn default() -> Self {
        Self { steps: 5_000, burn_in: 200, walkers: 32, seed: 1 }
    }
}

/// Marginal distribution of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Marginal {
    /// Name of the parameter.
    pub name: String,
    /// Quantiles 0.16, 0.5 and 0.84.
    pub quantiles: [f64; 3],
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Steps per independent draw.
    pub autocorrelation: AutocorrelationTime,
}

/// Summary of a chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// One per free parameter.
    pub marginals: Vec<Marginal>,
    /// `(n_free, n_free)`.
    pub covariance: Vec<Vec<f64>>,
    /// Fraction of accepted proposals.
    pub acceptance: f64,
    /// Steps after burn-in.
    pub steps: usize,
}

/// Starting positions of walkers: uniform within a tenth of each parameter's sigma about the fit, inside the bounds.
fn starting_positions(fit: &Fit, settings: &PosteriorSettings) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(settings.seed ^ START_SALT);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut start = |_| {
        let one = |&i: &usize| {
            let p = &fit.parameters[i];
            let width = p.greatest - p.least;
            let spread = fit.uncertainty.sigma(i).map_or(UNKNOWN_SPREAD * width, |sigma| 0.1 * sigma.min(width));
            // A box about the fit, moved inside the bounds.
            let least = (p.value - spread).clamp(p.least, p.greatest - spread.min(width));
            let greatest = (least + 2.0 * spread).min(p.greatest);
            least + uniform() * (greatest - least)
        };
        fit.free.iter().map(one).collect()
    };
    (0..settings.walkers).map(&mut start).collect()
}

/// Draws until the chain has `settings.steps` steps. `resumed` is a chain to continue; `each` is called after every
/// step and may save the chain.
///
/// # Errors
/// [`FitError::Ensemble`] for an invalid number of walkers, and every error that `each` returns.
pub fn draw(
    objective: &Objective,
    fit: &Fit,
    settings: &PosteriorSettings,
    resumed: Option<Chain>,
    mut each: impl FnMut(&Chain) -> Result<(), FitError>,
) -> Result<Chain, FitError> {
    let mut ensemble = match resumed {
        Some(chain) if chain.steps() > 0 => Ensemble::resume(objective, chain, settings.seed)?,
        _ => Ensemble::new(objective, starting_positions(fit, settings), settings.seed)?,
    };
    while ensemble.chain().steps() < settings.steps {
        ensemble.step();
        each(ensemble.chain())?;
    }
    Ok(ensemble.into_chain())
}

/// Summarises a chain without its first `burn_in` steps.
pub fn posterior(chain: &Chain, fit: &Fit, burn_in: usize) -> Posterior {
    let (means, covariance) = chain.moments(burn_in);
    let times = autocorrelation_times(chain, burn_in);
    let marginals: Vec<Marginal> = fit
        .free
        .iter()
        .enumerate()
        .map(|(k, &i)| {
            let sorted = chain.sorted(k, burn_in);
            Marginal {
                name: fit.parameters[i].name.clone(),
                quantiles: [0.16, 0.5, 0.84].map(|share| quantile(&sorted, share)),
                mean: means[k],
                sigma: covariance[k][k].sqrt(),
                autocorrelation: times[k],
            }
        })
        .collect();
    Posterior { marginals, covariance, acceptance: chain.acceptance(), steps: chain.steps().saturating_sub(burn_in) }
}

impl Posterior {
    /// Names of free parameters whose sigma in the fit exceeds that of the draws by more than a factor of `times`, each
    /// with its factor.
    ///
    /// The draws treat points as independent, while the fit allows for errors shared within tracks; for these
    /// parameters the draws are overconfident.
    pub fn overconfident(&self, fit: &Fit, times: f64) -> Vec<(String, f64)> {
        let ratio = |(marginal, &i): (&Marginal, &usize)| {
            let ratio = fit.uncertainty.sigma(i)? / marginal.sigma;
            (ratio > times).then(|| (marginal.name.clone(), ratio))
        };
        self.marginals.iter().zip(&fit.free).filter_map(ratio).collect()
    }
}
