//! Walkers set out from a fit, and what they found.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::math::quantile::quantile;

use super::error::FitError;
use super::inference::{AutocorrelationTime, Chain, Ensemble, autocorrelation_times};
use super::objective::Objective;
use super::solve::Fit;

/// Seeds of starting places differ from those of the walk by this.
const START_SALT: u64 = 0x5354_4152_5453;
/// Where nothing is known of a parameter's error, walkers start within this share of the room between its bounds.
const UNKNOWN_SPREAD: f64 = 1e-3;

/// How a posterior is drawn.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct PosteriorSettings {
    /// Steps in all.
    pub steps: usize,
    /// Steps at the beginning that are not looked at.
    pub burn_in: usize,
    /// Walkers; even, at least twice as many as free parameters.
    pub walkers: usize,
    /// Of all chance.
    pub seed: u64,
}

impl Default for PosteriorSettings {
    /// 5,000 steps and 200 of burn-in (Lu 2024, figure of the posterior) of 32 walkers.
    fn default() -> Self {
        Self { steps: 5_000, burn_in: 200, walkers: 32, seed: 1 }
    }
}

/// One parameter as drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Marginal {
    /// Its name.
    pub name: String,
    /// Quantiles 0.16, 0.5 and 0.84.
    pub quantiles: [f64; 3],
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Steps that make an independent draw.
    pub autocorrelation: AutocorrelationTime,
}

/// What the walkers found.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// One for each free parameter.
    pub marginals: Vec<Marginal>,
    /// `(n_free, n_free)`.
    pub covariance: Vec<Vec<f64>>,
    /// Share of proposals that were taken.
    pub acceptance: f64,
    /// Steps that were looked at.
    pub steps: usize,
}

/// Places for walkers about a fit: drawn evenly within a tenth of each parameter's sigma, inside its bounds.
pub fn starting_places(fit: &Fit, settings: &PosteriorSettings) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(settings.seed ^ START_SALT);
    let mut even = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut place = |_| {
        let one = |&i: &usize| {
            let p = &fit.parameters[i];
            let room = p.greatest - p.least;
            let spread = fit.certainty.sigma(i).map_or(UNKNOWN_SPREAD * room, |sigma| (0.1 * sigma).min(0.1 * room));
            // A box about the fit, moved inside the bounds.
            let least = (p.value - spread).clamp(p.least, p.greatest - spread.min(room));
            let greatest = (least + 2.0 * spread).min(p.greatest);
            least + even() * (greatest - least)
        };
        fit.free.iter().map(one).collect()
    };
    (0..settings.walkers).map(&mut place).collect()
}

/// Draws until the chain has its steps. `resumed` goes on with a chain; `each` is told after every step, and may save it.
///
/// # Errors
/// [`FitError::Ensemble`], and whatever `each` returns.
pub fn draw(
    objective: &Objective,
    fit: &Fit,
    settings: &PosteriorSettings,
    resumed: Option<Chain>,
    mut each: impl FnMut(&Chain) -> Result<(), FitError>,
) -> Result<Chain, FitError> {
    let mut ensemble = match resumed {
        Some(chain) if chain.steps() > 0 => Ensemble::resume(objective, chain, settings.seed)?,
        _ => Ensemble::new(objective, starting_places(fit, settings), settings.seed)?,
    };
    while ensemble.chain().steps() < settings.steps {
        ensemble.step();
        each(ensemble.chain())?;
    }
    Ok(ensemble.into_chain())
}

/// What a chain says of each free parameter.
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
    /// Free parameters whose sigma of the fit, which knows what tracks share, is larger than that of the draws by more than `times`, each with
    /// how many times as large it is. The draws take points as independent: these are known less well than they say.
    pub fn overconfident(&self, fit: &Fit, times: f64) -> Vec<(String, f64)> {
        let ratio = |(marginal, &i): (&Marginal, &usize)| {
            let ratio = fit.certainty.sigma(i)? / marginal.sigma;
            (ratio > times).then(|| (marginal.name.clone(), ratio))
        };
        self.marginals.iter().zip(&fit.free).filter_map(ratio).collect()
    }
}
