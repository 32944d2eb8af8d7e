//! An ensemble of walkers that draws from a posterior.
//!
//! Half of the walkers are moved at a time, each along a line to one of the other half, so that a half can be judged at once
//! ([`LogProbability::of_many`]). Chance comes from one stream for each walker and step, so that the chain is the same at
//! any number of threads, and one that was cut short goes on as if it had not been.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use thiserror::Error;

use super::stretch::propose;

/// The logarithm of a probability density, up to a constant.
pub trait LogProbability: Sync {
    /// Of each place; -∞ where it is impossible. One that is not a number counts as impossible.
    fn of_many(&self, places: &[Vec<f64>]) -> Vec<f64>;
}

/// Why an ensemble cannot be made.
#[derive(Debug, Error, PartialEq)]
pub enum EnsembleError {
    /// Too few, or an odd number, of walkers.
    #[error("{walkers} walkers for {parameters} parameters: an even number of at least {least} is needed")]
    Walkers {
        /// How many were given.
        walkers: usize,
        /// How many parameters there are.
        parameters: usize,
        /// How many it needs.
        least: usize,
    },
    /// A walker that stands where nothing is possible.
    #[error("walker {walker} starts where the probability is zero or no number: {place:?}")]
    Impossible {
        /// Which.
        walker: usize,
        /// Where.
        place: Vec<f64>,
    },
    /// Walkers that only ever meet in a plane: they can never leave it.
    #[error("the walkers' starting places do not differ in parameter {parameter}")]
    Flat {
        /// Its index.
        parameter: usize,
    },
    /// A chain that does not fit the ensemble that is to go on with it.
    #[error("the chain has {given} numbers, not those of {walkers} walkers and {parameters} parameters at each step")]
    Shape {
        /// Its length.
        given: usize,
        /// Of the ensemble.
        walkers: usize,
        /// Of the ensemble.
        parameters: usize,
    },
}

/// What was drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chain {
    walkers: usize,
    parameters: usize,
    /// `(n_step, n_walker, n_param)`, the last index fastest.
    places: Vec<f64>,
    /// `(n_step, n_walker)`.
    log_probabilities: Vec<f64>,
    /// `(n_walker)`: how many proposals each took.
    accepted: Vec<u64>,
}

impl Chain {
    /// From its parts; `accepted` per walker.
    ///
    /// # Errors
    /// [`EnsembleError::Shape`] where their lengths do not fit one another.
    pub fn from_parts(
        walkers: usize,
        parameters: usize,
        places: Vec<f64>,
        log_probabilities: Vec<f64>,
        accepted: Vec<u64>,
    ) -> Result<Self, EnsembleError> {
        let fits = walkers > 0
            && parameters > 0
            && accepted.len() == walkers
            && log_probabilities.len().is_multiple_of(walkers)
            && places.len() == log_probabilities.len() * parameters;
        if !fits {
            return Err(EnsembleError::Shape { given: places.len(), walkers, parameters });
        }
        Ok(Self { walkers, parameters, places, log_probabilities, accepted })
    }

    /// How many steps there are.
    pub fn steps(&self) -> usize {
        self.log_probabilities.len().checked_div(self.walkers).unwrap_or(0)
    }

    /// How many walkers.
    pub fn walkers(&self) -> usize {
        self.walkers
    }

    /// How many parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Where a walker stood after a step.
    pub fn at(&self, step: usize, walker: usize) -> &[f64] {
        let from = (step * self.walkers + walker) * self.parameters;
        &self.places[from..from + self.parameters]
    }

    /// All places, `(n_step, n_walker, n_param)`, the last index fastest.
    pub fn places(&self) -> &[f64] {
        &self.places
    }

    /// All log probabilities, `(n_step, n_walker)`.
    pub fn log_probabilities(&self) -> &[f64] {
        &self.log_probabilities
    }

    /// How many proposals each walker took.
    pub fn accepted(&self) -> &[u64] {
        &self.accepted
    }

    /// Share of proposals that were taken, of all walkers.
    pub fn acceptance(&self) -> f64 {
        let proposals = self.log_probabilities.len().max(1);
        self.accepted.iter().sum::<u64>() as f64 / proposals as f64
    }

    /// Samples of one parameter after `burn_in` steps, all walkers, step by step.
    pub fn column(&self, parameter: usize, burn_in: usize) -> Vec<f64> {
        let from = (burn_in * self.places.len() / self.steps().max(1)).min(self.places.len());
        self.places[from..].iter().skip(parameter).step_by(self.parameters).copied().collect()
    }

    /// The same, sorted.
    pub fn sorted(&self, parameter: usize, burn_in: usize) -> Vec<f64> {
        let mut samples = self.column(parameter, burn_in);
        samples.sort_by(f64::total_cmp);
        samples
    }

    /// Means and covariance, `(n_param)` and `(n_param)` rows of `(n_param)`, of the steps after `burn_in`.
    pub fn moments(&self, burn_in: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
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

/// That so many walkers can draw from so many parameters: an even number of them, at least twice as many as parameters.
///
/// # Errors
/// [`EnsembleError::Walkers`].
pub fn check_walkers(walkers: usize, parameters: usize) -> Result<(), EnsembleError> {
    let least = (2 * parameters).max(4);
    if walkers < least || walkers % 2 == 1 {
        return Err(EnsembleError::Walkers { walkers, parameters, least });
    }
    Ok(())
}

/// Walkers ready to go on.
pub struct Ensemble<'a, P> {
    posterior: &'a P,
    seed: u64,
    places: Vec<Vec<f64>>,
    log_probabilities: Vec<f64>,
    chain: Chain,
}

impl<'a, P: LogProbability> Ensemble<'a, P> {
    /// From starting places, one for each walker: an even number of them, at least twice as many as parameters.
    ///
    /// # Errors
    /// [`EnsembleError`]: too few or an odd number of walkers, an impossible place, places that do not differ.
    pub fn new(posterior: &'a P, starts: Vec<Vec<f64>>, seed: u64) -> Result<Self, EnsembleError> {
        let (walkers, parameters) = (starts.len(), starts.first().map_or(0, Vec::len));
        check_walkers(walkers, parameters)?;
        if let Some(parameter) = (0..parameters).find(|&i| starts.iter().all(|place| place[i] == starts[0][i])) {
            return Err(EnsembleError::Flat { parameter });
        }
        let log_probabilities = posterior.of_many(&starts);
        if let Some(walker) = log_probabilities.iter().position(|value| !value.is_finite()) {
            return Err(EnsembleError::Impossible { walker, place: starts[walker].clone() });
        }
        let chain = Chain { walkers, parameters, accepted: vec![0; walkers], ..Chain::default() };
        Ok(Self { posterior, seed, places: starts, log_probabilities, chain })
    }

    /// Goes on where a chain of the same posterior and seed ended.
    ///
    /// # Errors
    /// [`EnsembleError::Shape`] where the chain has no step; as [`Self::new`] where its last places cannot be.
    pub fn resume(posterior: &'a P, chain: Chain, seed: u64) -> Result<Self, EnsembleError> {
        let Some(last) = chain.steps().checked_sub(1) else {
            return Err(EnsembleError::Shape { given: 0, walkers: chain.walkers, parameters: chain.parameters });
        };
        let starts = (0..chain.walkers).map(|walker| chain.at(last, walker).to_vec()).collect();
        Ok(Self { chain, ..Self::new(posterior, starts, seed)? })
    }

    /// Draws once for every walker.
    pub fn step(&mut self) {
        let walkers = self.places.len();
        let step = self.chain.steps();
        for half in 0..2 {
            // Even walkers against odd ones, then odd against even.
            let moved: Vec<usize> = (half..walkers).step_by(2).collect();
            let mut decisions = Vec::with_capacity(moved.len());
            let mut factors = Vec::with_capacity(moved.len());
            let mut proposals = Vec::with_capacity(moved.len());
            for &walker in &moved {
                let [even, other, decision] = draws(self.seed, walker, step);
                let other = 1 - half + 2 * ((other * (walkers / 2) as f64) as usize);
                let proposal = propose(&self.places[walker], &self.places[other], even);
                factors.push(proposal.log_factor);
                proposals.push(proposal.to);
                decisions.push(decision);
            }
            let values = self.posterior.of_many(&proposals);
            for (k, (walker, to)) in moved.into_iter().zip(proposals).enumerate() {
                // ln q = (n - 1) ln z + ln p(y) - ln p(x); comparisons with what is no number are false
                if decisions[k].ln() < factors[k] + values[k] - self.log_probabilities[walker] {
                    self.places[walker] = to;
                    self.log_probabilities[walker] = values[k];
                    self.chain.accepted[walker] += 1;
                }
            }
        }
        self.places.iter().for_each(|place| self.chain.places.extend_from_slice(place));
        self.chain.log_probabilities.extend_from_slice(&self.log_probabilities);
    }

    /// What was drawn so far.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// The same, when no more is wanted.
    pub fn into_chain(self) -> Chain {
        self.chain
    }
}

/// Three numbers evenly from [0, 1): one stream of ChaCha8 for each walker, one block of it for each step.
fn draws(seed: u64, walker: usize, step: usize) -> [f64; 3] {
    /// 32-bit words in a block.
    const BLOCK_WORDS: u128 = 16;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(walker as u64);
    random.set_word_pos(step as u128 * BLOCK_WORDS);
    // The upper 53 bits as a fraction.
    std::array::from_fn(|_| (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
}
