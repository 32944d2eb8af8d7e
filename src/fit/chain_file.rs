//! Chains in NumPy's `.npz` format, written atomically, so that an interrupted run can continue from the last saved
//! step.
//!
//! Arrays: `chain` (n_step, n_walker, n_param), `log_prob` (n_step, n_walker), `accepted` (n_walker), and `about`, the
//! bytes of a JSON text that identifies the fit. `numpy.load(path)["chain"]` equals emcee's `get_chain()`.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use npyz::{NpyFile, WriterBuilder};
use serde::{Deserialize, Serialize};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use crate::output::AtomicFile;

use super::error::FitError;
use super::inference::Chain;

/// Identification of the fit of a chain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainAbout {
    /// Version of the program.
    pub software: String,
    /// Names of the parameters, in the order of the last index.
    pub parameters: Vec<String>,
    /// Seed of the walkers.
    pub seed: u64,
    /// Hash of points, form and settings; a chain can only be continued with the same hash.
    pub fingerprint: String,
}

/// Writes a chain.
///
/// # Errors
/// [`FitError::ChainFile`] for any error of the system; an older file is then unchanged.
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
    // Random digits do not compress.
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored).large_file(true);
    archive.start_file(format!("{name}.npy"), options)?;
    let mut bytes = Vec::with_capacity(128 + size_of_val(values));
    let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut bytes).begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()?;
    archive.write_all(&bytes)
}

/// Reads a chain.
///
/// # Errors
/// [`FitError::ChainFile`] if the file is missing, truncated or invalid.
pub fn read_chain(path: &Path) -> Result<(Chain, ChainAbout), FitError> {
    let failed = |problem: String| FitError::ChainFile { path: path.to_owned(), problem };
    let file = File::open(path).map_err(|error| failed(error.to_string()))?;
    let mut archive = ZipArchive::new(file)
        .map_err(|_| failed("invalid .npz file; expected a chain written by fit run --mcmc".to_owned()))?;
    let (positions, shape) = read_array::<f64>(&mut archive, "chain").map_err(failed)?;
    let (log_probabilities, _) = read_array::<f64>(&mut archive, "log_prob").map_err(failed)?;
    let (accepted, _) = read_array::<u64>(&mut archive, "accepted").map_err(failed)?;
    let (about, _) = read_array::<u8>(&mut archive, "about").map_err(failed)?;
    let about: ChainAbout = serde_json::from_slice(&about).map_err(|error| failed(format!("about: {error}")))?;
    let &[_, walkers, parameters] = &shape[..] else {
        return Err(failed(format!("chain has {} axes, expected 3: steps, walkers, parameters", shape.len())));
    };
    if parameters as usize != about.parameters.len() {
        return Err(failed(format!("{parameters} parameters, but {} names", about.parameters.len())));
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
