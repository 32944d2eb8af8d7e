//! Ensemble of walkers that draws from a posterior, by the affine-invariant stretch move of Goodman and Weare (2010,
//! CAMCoS 5, 65).
//!
//! A walker x moves along the line to a walker c of the other half: y = c + z (x - c), where z is drawn from g(z) ∝
//! 1/√z on [1/a, a]. The move is accepted with probability min(1, z^(n-1) p(y)/p(x)), as in emcee (Foreman-Mackey et
//! al. 2013). Half of the walkers move at the same time, so that their probabilities can be computed together
//! ([`LogProbability::of_many`]). Each walker has its own random numbers at each step. The chain therefore does not
//! depend on the number of threads, and a chain that is continued equals an uninterrupted one.
//!
//! The integrated autocorrelation time of a chain is computed with Sokal's window (1989 lectures, section 3) and
//! averaged over walkers, as in emcee:
//!
//! ```text
//! τ(M) = 1 + 2 Σ_{t=1..M} ρ(t),   M the least with M ≥ 5 τ(M)
//! ```

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::error::{Error, ErrorKind};

/// Logarithm of a probability density, up to an additive constant.
pub trait LogProbability: Sync {
    /// Returns the values at several positions; -∞ or NaN where the probability is zero.
    fn of_many(&self, positions: &[Vec<f64>]) -> Vec<f64>;
}

/// Samples drawn by an ensemble of walkers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chain {
    walkers: usize,
    parameters: usize,
    /// Positions of the walkers, with shape `(n_step, n_walker, n_param)`; the last index varies fastest.
    positions: Vec<f64>,
    /// Logarithms of the probability density, with shape `(n_step, n_walker)`.
    log_probabilities: Vec<f64>,
    /// Number of accepted proposals of each walker, `(n_walker)`.
    accepted: Vec<u64>,
}

impl Chain {
    /// Creates a chain from its arrays.
    ///
    /// # Errors
    /// Their lengths do not match.
    pub fn from_parts(
        walkers: usize,
        parameters: usize,
        positions: Vec<f64>,
        log_probabilities: Vec<f64>,
        accepted: Vec<u64>,
    ) -> Result<Self, Error> {
        let fits = walkers > 0
            && parameters > 0
            && accepted.len() == walkers
            && log_probabilities.len().is_multiple_of(walkers)
            && positions.len() == log_probabilities.len() * parameters;
        if !fits {
            return Err(wrong_length(positions.len(), walkers, parameters));
        }
        Ok(Self { walkers, parameters, positions, log_probabilities, accepted })
    }

    /// Returns the number of steps.
    pub fn steps(&self) -> usize {
        self.log_probabilities.len().checked_div(self.walkers).unwrap_or(0)
    }

    /// Returns the number of walkers.
    pub fn walkers(&self) -> usize {
        self.walkers
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Returns the position of a walker after a step.
    pub fn at(&self, step: usize, walker: usize) -> &[f64] {
        let from = (step * self.walkers + walker) * self.parameters;
        &self.positions[from..from + self.parameters]
    }

    /// Returns all positions, with shape `(n_step, n_walker, n_param)`; the last index varies fastest.
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// Returns all log probabilities, with shape `(n_step, n_walker)`.
    pub fn log_probabilities(&self) -> &[f64] {
        &self.log_probabilities
    }

    /// Returns the number of accepted proposals of each walker.
    pub fn accepted(&self) -> &[u64] {
        &self.accepted
    }

    /// Returns the fraction of proposals that were accepted.
    pub fn acceptance(&self) -> f64 {
        let proposals = self.log_probabilities.len().max(1);
        self.accepted.iter().sum::<u64>() as f64 / proposals as f64
    }

    /// Returns the samples of one parameter after `burn_in` steps, for all walkers, step by step.
    pub fn column(&self, parameter: usize, burn_in: usize) -> Vec<f64> {
        let from = (burn_in * self.positions.len() / self.steps().max(1)).min(self.positions.len());
        self.positions[from..].iter().skip(parameter).step_by(self.parameters).copied().collect()
    }

    /// Returns the sorted samples of one parameter after `burn_in` steps.
    pub(in crate::fit) fn sorted(&self, parameter: usize, burn_in: usize) -> Vec<f64> {
        let mut samples = self.column(parameter, burn_in);
        samples.sort_by(f64::total_cmp);
        samples
    }

    /// Returns the means `(n_param)` and the covariance `(n_param, n_param)` of the steps after `burn_in`.
    pub(in crate::fit) fn moments(&self, burn_in: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
        let n = self.parameters;
        let rows = || {
            (burn_in.min(self.steps())..self.steps())
                .flat_map(|step| (0..self.walkers).map(move |walker| self.at(step, walker)))
        };
        let count = rows().count().max(1) as f64;
        let mean: Vec<f64> = (0..n).map(|i| rows().map(|row| row[i]).sum::<f64>() / count).collect();
        let moment = |i: usize, j: usize| {
            rows().map(|row| (row[i] - mean[i]) * (row[j] - mean[j])).sum::<f64>() / (count - 1.0).max(1.0)
        };
        let covariance = (0..n).map(|i| (0..n).map(|j| moment(i, j)).collect()).collect();
        (mean, covariance)
    }
}

/// Checks the number of walkers, which must be even, at least 4, and at least twice the number of parameters.
///
/// # Errors
/// An invalid number.
pub fn check_walkers(walkers: usize, parameters: usize) -> Result<(), Error> {
    let least = (2 * parameters).max(4);
    if walkers < least || walkers % 2 == 1 {
        return Err(Error::new(ErrorKind::Invalid, format!("{walkers} walkers for {parameters} parameters"))
            .allowing(format!("an even number of at least {least}")));
    }
    Ok(())
}

/// Walkers at their current positions, with the chain so far.
pub(in crate::fit) struct Ensemble<'a, P> {
    posterior: &'a P,
    seed: u64,
    positions: Vec<Vec<f64>>,
    log_probabilities: Vec<f64>,
    chain: Chain,
}

impl<'a, P: LogProbability> Ensemble<'a, P> {
    /// Creates an ensemble with one walker at each starting position.
    ///
    /// # Errors
    /// The number of walkers is too small or odd, a starting position has probability zero, or all
    /// starting positions are equal in a parameter.
    pub fn new(posterior: &'a P, starts: Vec<Vec<f64>>, seed: u64) -> Result<Self, Error> {
        let (walkers, parameters) = (starts.len(), starts.first().map_or(0, Vec::len));
        check_walkers(walkers, parameters)?;
        if let Some(parameter) = (0..parameters).find(|&i| starts.iter().all(|position| position[i] == starts[0][i])) {
            return Err(Error::new(
                ErrorKind::Invalid,
                format!("the starting positions of the walkers are equal in parameter {parameter}"),
            )
            .allowing("positions that differ in each"));
        }
        let log_probabilities = posterior.of_many(&starts);
        if let Some(walker) = log_probabilities.iter().position(|value| !value.is_finite()) {
            return Err(Error::new(
                ErrorKind::Invalid,
                format!("the starting position of walker {walker} is {:?}", starts[walker].clone()),
            )
            .allowing("positions with a probability above 0"));
        }
        let chain = Chain { walkers, parameters, accepted: vec![0; walkers], ..Chain::default() };
        Ok(Self { posterior, seed, positions: starts, log_probabilities, chain })
    }

    /// Continues a chain that was drawn from the same posterior with the same seed.
    ///
    /// # Errors
    /// The chain is empty; the errors of [`Self::new`] if its last positions are invalid.
    pub fn resume(posterior: &'a P, chain: Chain, seed: u64) -> Result<Self, Error> {
        let Some(last) = chain.steps().checked_sub(1) else {
            return Err(wrong_length(0, chain.walkers, chain.parameters));
        };
        let starts = (0..chain.walkers).map(|walker| chain.at(last, walker).to_vec()).collect();
        Ok(Self { chain, ..Self::new(posterior, starts, seed)? })
    }

    /// Moves every walker once.
    pub fn step(&mut self) {
        let walkers = self.positions.len();
        let step = self.chain.steps();
        for half in 0..2 {
            // First the even walkers move along lines to the odd ones, then the reverse.
            let moved: Vec<usize> = (half..walkers).step_by(2).collect();
            let mut decisions = Vec::with_capacity(moved.len());
            let mut factors = Vec::with_capacity(moved.len());
            let mut proposals = Vec::with_capacity(moved.len());
            for &walker in &moved {
                let [uniform, other, decision] = draws(self.seed, walker, step);
                let other = 1 - half + 2 * ((other * (walkers / 2) as f64) as usize);
                let proposal = propose(&self.positions[walker], &self.positions[other], uniform);
                factors.push(proposal.log_factor);
                proposals.push(proposal.to);
                decisions.push(decision);
            }
            let values = self.posterior.of_many(&proposals);
            for (k, (walker, to)) in moved.into_iter().zip(proposals).enumerate() {
                // ln q = (n - 1) ln z + ln p(y) - ln p(x). A comparison with NaN is false, so that such a move is
                // rejected.
                if decisions[k].ln() < factors[k] + values[k] - self.log_probabilities[walker] {
                    self.positions[walker] = to;
                    self.log_probabilities[walker] = values[k];
                    self.chain.accepted[walker] += 1;
                }
            }
        }
        self.positions.iter().for_each(|position| self.chain.positions.extend_from_slice(position));
        self.chain.log_probabilities.extend_from_slice(&self.log_probabilities);
    }

    /// Returns the samples so far.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Converts the ensemble into its samples.
    pub fn into_chain(self) -> Chain {
        self.chain
    }
}

/// Returns three uniform numbers from [0, 1). Each walker has its own stream of ChaCha8, and each step one block of it.
fn draws(seed: u64, walker: usize, step: usize) -> [f64; 3] {
    /// Number of 32-bit words in a block.
    const BLOCK_WORDS: u128 = 16;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(walker as u64);
    random.set_word_pos(step as u128 * BLOCK_WORDS);
    // The upper 53 bits give the fraction.
    std::array::from_fn(|_| (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
}

/// Parameter a of the distribution g.
const SCALE: f64 = 2.0;

/// Proposed move of a walker.
struct Proposal {
    to: Vec<f64>,
    /// Logarithm of the factor z^(n-1) of the acceptance probability.
    log_factor: f64,
}

/// Returns a proposal from a walker's position and that of a walker of the other half; `uniform` is from [0, 1).
fn propose(from: &[f64], other: &[f64], uniform: f64) -> Proposal {
    // z = ((a - 1) u + 1)² / a
    let z = ((SCALE - 1.0) * uniform + 1.0).powi(2) / SCALE;
    let to = from.iter().zip(other).map(|(from, other)| other + z * (from - other)).collect();
    Proposal { to, log_factor: (from.len() as f64 - 1.0) * z.ln() }
}

/// Factor c in the window M ≥ c τ(M) of the autocorrelation time.
const WINDOW: f64 = 5.0;
/// Smallest length of a chain, in units of τ, for which τ is reliable.
const TRUSTED: f64 = 50.0;

/// Integrated autocorrelation time of one parameter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AutocorrelationTime {
    /// Autocorrelation time τ in steps; NaN if the parameter never changed.
    pub steps: f64,
    /// True if the chain is longer than 50 τ; for shorter chains τ is usually underestimated.
    pub is_trusted: bool,
}

/// Returns the autocorrelation time of each parameter after `burn_in` steps, averaged over walkers as in emcee, with
/// Sokal's window (1989 lectures, section 3).
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
    // ρ(t) = C(t)/C(0), C(t) = Σ_i x_i x_{i+t}, averaged over walkers
    let product = |track: &[f64], lag: usize| track.iter().zip(&track[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let zero: Vec<f64> = tracks.iter().map(|track| product(track, 0)).collect();
    let mut sum = 0.0;
    let mut tau = f64::NAN;
    for lag in 0..steps {
        let rho =
            tracks.iter().zip(&zero).map(|(track, zero)| product(track, lag) / zero).sum::<f64>() / tracks.len() as f64;
        // τ(M) = 1 + 2 Σ_{t=1..M} ρ(t), where M is the smallest number with M ≥ 5 τ(M)
        sum += rho;
        tau = 2.0 * sum - 1.0;
        // τ is NaN if a walker never moved.
        if lag as f64 >= WINDOW * tau || tau.is_nan() {
            break;
        }
    }
    tau
}

/// The length of a chain does not match its numbers of walkers and parameters.
fn wrong_length(numbers: usize, walkers: usize, parameters: usize) -> Error {
    Error::new(ErrorKind::Invalid, format!("the chain has {numbers} numbers"))
        .allowing(format!("as many as {walkers} walkers and {parameters} parameters give in whole steps"))
}
