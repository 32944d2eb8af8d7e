//! Posterior of a fit, sampled by an ensemble of walkers, and the file that stores the chain.
//!
//! The file is a NumPy archive (.npz) with the arrays `chain` (n_step, n_walker, n_param), `log_prob` (n_step,
//! n_walker), `accepted` (n_walker), and `about`, the bytes of a JSON text that identifies the fit.
//! `numpy.load(path)["chain"]` has the form of emcee's `get_chain()`.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use npyz::{NpyFile, WriterBuilder};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use super::error::FitError;
use super::inference::{AutocorrelationTime, Chain, Ensemble, autocorrelation_times};
use super::objective::Objective;
use super::solve::Fit;
use crate::input;
use crate::math::quantile::quantile;
use crate::output::AtomicFile;

/// Constant that makes the seed of the starting positions differ from the seed of the walkers.
const START_SALT: u64 = 0x5354_4152_5453;
/// Half width of the starting positions of a parameter without sigma, as a fraction of the interval between its bounds.
const UNKNOWN_SPREAD: f64 = 1e-3;

/// Settings for the sampling of a posterior.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct PosteriorSettings {
    /// Number of steps, including burn-in.
    pub steps: usize,
    /// Number of steps at the beginning that are not used.
    pub burn_in: usize,
    /// Number of walkers; it must be even, at least 4, and at least twice the number of free parameters.
    pub walkers: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for PosteriorSettings {
    /// Returns 32 walkers and 5,000 steps, of which 200 are burn-in, as in Lu (2024, figure of the posterior).
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
    /// Number of steps after which samples are independent.
    pub autocorrelation: AutocorrelationTime,
}

/// Summary of a chain: distributions of the parameters, and their covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// Marginal distributions, one per free parameter.
    pub marginals: Vec<Marginal>,
    /// Covariance of the free parameters; shape `(n_free, n_free)`.
    pub covariance: Vec<Vec<f64>>,
    /// Fraction of proposals that were accepted.
    pub acceptance: f64,
    /// Number of steps after burn-in.
    pub steps: usize,
}

/// Returns starting positions of the walkers: uniform within a tenth of each parameter's sigma around the fit, inside
/// the bounds.
fn starting_positions(fit: &Fit, settings: &PosteriorSettings) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(settings.seed ^ START_SALT);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut start = |_| {
        let one = |&i: &usize| {
            let p = &fit.parameters[i];
            let width = p.greatest - p.least;
            let spread = fit.uncertainty.sigma(i).map_or(UNKNOWN_SPREAD * width, |sigma| 0.1 * sigma.min(width));
            // The positions fill a box around the fit, which is moved inside the bounds.
            let least = (p.value - spread).clamp(p.least, p.greatest - spread.min(width));
            let greatest = (least + 2.0 * spread).min(p.greatest);
            least + uniform() * (greatest - least)
        };
        fit.free.iter().map(one).collect()
    };
    (0..settings.walkers).map(&mut start).collect()
}

/// Draws samples until the chain has `settings.steps` steps. `resumed` is a chain that is continued. `each` is called
/// after every step and may save the chain.
///
/// # Errors
/// [`FitError::Walkers`] for an invalid number of walkers, and any error that `each` returns.
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

/// Returns a summary of a chain without its first `burn_in` steps.
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
    /// Returns the free parameters whose sigma in the fit exceeds the sigma of the samples by more than the factor
    /// `times`, by name, each with its factor.
    ///
    /// The samples treat points as independent, whereas the fit allows for errors that the points of a track share. For
    /// these parameters the samples are overconfident.
    pub fn overconfident(&self, fit: &Fit, times: f64) -> Vec<(String, f64)> {
        let ratio = |(marginal, &i): (&Marginal, &usize)| {
            let ratio = fit.uncertainty.sigma(i)? / marginal.sigma;
            (ratio > times).then(|| (marginal.name.clone(), ratio))
        };
        self.marginals.iter().zip(&fit.free).filter_map(ratio).collect()
    }
}

/// Identification of the fit to which a chain belongs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainAbout {
    /// Version of the program.
    pub software: String,
    /// Names of the parameters, in the order of the last index of the chain.
    pub parameters: Vec<String>,
    /// Seed of the walkers.
    pub seed: u64,
    /// Hash of points, form and settings. A chain can be continued only by a fit with the same hash.
    pub fingerprint: String,
}

/// Writes a chain to a file.
///
/// # Errors
/// [`FitError::ChainFile`] for any error of the operating system; an older file is then unchanged.
pub fn write_chain(path: &Path, chain: &Chain, about: &ChainAbout) -> Result<(), FitError> {
    let failed = |problem: String| FitError::ChainFile { path: path.to_owned(), problem };
    let io = |error: std::io::Error| failed(error.to_string());
    let file = AtomicFile::new(path).map_err(io)?;
    let mut archive = ZipWriter::new(file.file());
    let [steps, walkers, parameters] = [chain.steps(), chain.walkers(), chain.parameters()].map(|n| n as u64);
    let text = serde_json::to_vec(about).map_err(|error| failed(error.to_string()))?;
    write_array(&mut archive, "chain", &[steps, walkers, parameters], chain.positions()).map_err(io)?;
    write_array(&mut archive, "log_prob", &[steps, walkers], chain.log_probabilities()).map_err(io)?;
    write_array(&mut archive, "accepted", &[walkers], chain.accepted()).map_err(io)?;
    write_array(&mut archive, "about", &[text.len() as u64], &text).map_err(io)?;
    archive.finish().map_err(|error| failed(error.to_string()))?;
    file.finish().map_err(io)
}

fn write_array<T: npyz::AutoSerialize + Copy>(
    archive: &mut ZipWriter<&File>,
    name: &str,
    shape: &[u64],
    values: &[T],
) -> std::io::Result<()> {
    // The archive is not compressed, because random digits cannot be compressed.
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored).large_file(true);
    archive.start_file(format!("{name}.npy"), options)?;
    let mut bytes = Vec::with_capacity(128 + size_of_val(values));
    let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut bytes).begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()?;
    archive.write_all(&bytes)
}

/// Reads a chain from a file.
///
/// # Errors
/// [`FitError::ChainFile`] if the file is missing, truncated or invalid.
pub fn read_chain(path: &Path) -> Result<(Chain, ChainAbout), FitError> {
    let failed = |problem: String| FitError::ChainFile { path: path.to_owned(), problem };
    let file = input::open(path).map_err(|error| failed(error.to_string()))?;
    let mut archive = ZipArchive::new(file)
        .map_err(|_| failed("invalid .npz file; allowed: a chain written by fit run --mcmc".to_owned()))?;
    let (positions, shape) = read_array::<f64>(&mut archive, "chain").map_err(failed)?;
    let (log_probabilities, _) = read_array::<f64>(&mut archive, "log_prob").map_err(failed)?;
    let (accepted, _) = read_array::<u64>(&mut archive, "accepted").map_err(failed)?;
    let (about, _) = read_array::<u8>(&mut archive, "about").map_err(failed)?;
    let about: ChainAbout = serde_json::from_slice(&about).map_err(|error| failed(format!("about: {error}")))?;
    let &[_, walkers, parameters] = &shape[..] else {
        return Err(failed(format!("chain has {} axes; allowed: 3 (steps, walkers, parameters)", shape.len())));
    };
    if parameters as usize != about.parameters.len() {
        return Err(failed(format!(
            "the file has {} names of parameters; allowed: {parameters}, one for each parameter of the chain",
            about.parameters.len()
        )));
    }
    let chain = Chain::from_parts(walkers as usize, parameters as usize, positions, log_probabilities, accepted)?;
    Ok((chain, about))
}

fn read_array<T: npyz::Deserialize>(archive: &mut ZipArchive<File>, name: &str) -> Result<(Vec<T>, Vec<u64>), String> {
    let wrong = |error: String| format!("array {name}: {error}");
    let mut entry = archive.by_name(&format!("{name}.npy")).map_err(|error| wrong(error.to_string()))?;
    let mut bytes = Vec::new();
    entry.read_to_end(&mut bytes).map_err(|error| wrong(error.to_string()))?;
    let array = NpyFile::new(&bytes[..]).map_err(|error| wrong(error.to_string()))?;
    let shape = array.shape().to_vec();
    Ok((array.into_vec::<T>().map_err(|error| wrong(error.to_string()))?, shape))
}
