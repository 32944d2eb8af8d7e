//! Posterior of a fit, sampled by an ensemble of walkers, and the file that stores the chain.
//!
//! The file is an ECSV table with one row for each step and walker: `step`, `walker`, the parameters, and `log_prob`.
//! The metadata identify the fit. With astropy, `Table.read(path)["c3"].reshape(-1, walkers)` has the axes step,
//! walker.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use super::inference::{AutocorrelationTime, Chain, Ensemble, autocorrelation_times};
use super::objective::Objective;
use super::solve::Fit;
use crate::error::{Error, ErrorKind};
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
#[non_exhaustive]
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
    #[doc(hidden)]
    pub autocorrelation: AutocorrelationTime,
}

/// Summary of a chain: distributions of the parameters, and their covariance.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
        let position = |&i: &usize| {
            let p = &fit.parameters[i];
            let width = p.greatest - p.least;
            let spread = fit.uncertainty.sigma(i).map_or(UNKNOWN_SPREAD * width, |sigma| 0.1 * sigma.min(width));
            // The positions fill a box around the fit, which is moved inside the bounds.
            let least = (p.value - spread).clamp(p.least, p.greatest - spread.min(width));
            let greatest = (least + 2.0 * spread).min(p.greatest);
            least + uniform() * (greatest - least)
        };
        fit.free.iter().map(position).collect()
    };
    (0..settings.walkers).map(&mut start).collect()
}

/// Draws samples until the chain has `settings.steps` steps. `resumed` is a chain that is continued. `each` is called
/// after every step and may save the chain.
///
/// # Errors
/// An invalid number of walkers, and any error that `each` returns.
pub fn draw(
    objective: &Objective,
    fit: &Fit,
    settings: &PosteriorSettings,
    resumed: Option<Chain>,
    mut each: impl FnMut(&Chain) -> Result<(), Error>,
) -> Result<Chain, Error> {
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

/// Metadata of a file of chains.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChainMeta {
    chain: ChainHeader,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChainHeader {
    about: ChainAbout,
    steps: usize,
    /// Number of accepted proposals of each walker.
    accepted: Vec<u64>,
}

/// Names of the columns before and after those of the parameters.
const INDEX_COLUMNS: [&str; 2] = ["step", "walker"];
const LOG_PROBABILITY_COLUMN: &str = "log_prob";
const META: &str = "# meta: ";

/// Writes a chain to an ECSV file, with as many digits as the numbers have.
///
/// # Errors
/// An error of the operating system; an older file is then unchanged.
pub fn write_chain(path: &Path, chain: &Chain, about: &ChainAbout) -> Result<(), Error> {
    let failed = |error: io::Error| Error::system(error).in_file("chains", path);
    let file = AtomicFile::new(path).map_err(failed)?;
    let mut out = BufWriter::new(file.file());
    write_table(&mut out, chain, about).and_then(|()| out.flush()).map_err(failed)?;
    drop(out);
    file.finish().map_err(failed)
}

fn write_table(out: &mut impl Write, chain: &Chain, about: &ChainAbout) -> io::Result<()> {
    let header = ChainHeader { about: about.clone(), steps: chain.steps(), accepted: chain.accepted().to_vec() };
    writeln!(out, "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:")?;
    let names = columns(about);
    for (index, name) in names.iter().enumerate() {
        let datatype = if index < INDEX_COLUMNS.len() { "int64" } else { "float64" };
        // Strings of JSON are valid YAML.
        writeln!(out, "# - {{name: {}, datatype: {datatype}}}", serde_json::to_string(name)?)?;
    }
    writeln!(out, "{META}{}\n# schema: astropy-2.0", serde_json::to_string(&ChainMeta { chain: header })?)?;
    csv::Writer::from_writer(&mut *out).write_record(&names)?;
    for step in 0..chain.steps() {
        for walker in 0..chain.walkers() {
            write!(out, "{step},{walker}")?;
            let log_probability = chain.log_probabilities()[step * chain.walkers() + walker];
            for value in chain.at(step, walker).iter().chain([&log_probability]) {
                // The shortest digits that identify the number, with an exponent if it is very small or large.
                write!(out, ",{value:?}")?;
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

fn columns(about: &ChainAbout) -> Vec<&str> {
    let parameters = about.parameters.iter().map(String::as_str);
    INDEX_COLUMNS.into_iter().chain(parameters).chain([LOG_PROBABILITY_COLUMN]).collect()
}

/// Reads a chain from a file of [`write_chain`].
///
/// # Errors
/// The file is missing, truncated or invalid.
pub fn read_chain(path: &Path) -> Result<(Chain, ChainAbout), Error> {
    let failed = |problem: String| Error::new(ErrorKind::File, problem).in_file("chains", path);
    let text = input::read_to_string(path).map_err(|error| failed(error.to_string()))?;
    let meta = text.lines().take_while(|line| line.starts_with('#')).find_map(|line| line.strip_prefix(META));
    let meta = meta.and_then(|meta| serde_json::from_str::<ChainMeta>(meta).ok());
    let Some(ChainMeta { chain: ChainHeader { about, steps, accepted } }) = meta else {
        return Err(failed("not a file of chains; allowed: an ECSV file written by fit run --mcmc".to_owned()));
    };
    let (positions, log_probabilities) = read_rows(&text, &about).map_err(failed)?;
    if log_probabilities.len() != steps.saturating_mul(accepted.len()) {
        return Err(failed(format!(
            "{} rows; allowed: one for each of {steps} steps and {} walkers",
            log_probabilities.len(),
            accepted.len()
        )));
    }
    let chain = Chain::from_parts(accepted.len(), about.parameters.len(), positions, log_probabilities, accepted)?;
    Ok((chain, about))
}

/// Returns positions, `(n_step, n_walker, n_param)`, and log probabilities, `(n_step, n_walker)`, of all rows.
fn read_rows(text: &str, about: &ChainAbout) -> Result<(Vec<f64>, Vec<f64>), String> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let names = reader.headers().map_err(|error| error.to_string())?;
    if !names.iter().eq(columns(about)) {
        return Err("the names of the columns differ from those of the parameters in the header".to_owned());
    }
    let (mut positions, mut log_probabilities) = (Vec::new(), Vec::new());
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| error.to_string())? {
        for (index, cell) in record.iter().enumerate().skip(INDEX_COLUMNS.len()) {
            let line = record.position().map_or(0, csv::Position::line);
            let value = cell.parse().map_err(|_| format!("line {line}: '{cell}'; allowed: a number"))?;
            if index + 1 < record.len() { positions.push(value) } else { log_probabilities.push(value) }
        }
    }
    Ok((positions, log_probabilities))
}
