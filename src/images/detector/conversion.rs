//! Conversion of electrons to the numbers of a file, and random numbers of a frame: a stream for each row.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Poisson, StandardNormal};
use serde::Deserialize;

use super::error::DetectorError;

/// Whole counts within the converter's range.
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantisation {
    /// Least count, \[-1e6, 1e6\]; 0 unless said otherwise.
    #[serde(default)]
    pub least_adu: f64,
    /// Greatest count, above the least, up to 16777216 (2²⁴: above it single precision leaves out numbers); 65535 unless said otherwise.
    #[serde(default = "sixteen_bits")]
    pub greatest_adu: f64,
}

fn sixteen_bits() -> f64 {
    65_535.0
}

impl Default for Quantisation {
    fn default() -> Self {
        Self { least_adu: 0.0, greatest_adu: sixteen_bits() }
    }
}

impl Quantisation {
    pub(super) fn validate(&self) -> Result<(), DetectorError> {
        DetectorError::hold("quantisation.least_adu", self.least_adu, -1e6, 1e6)?;
        DetectorError::hold("quantisation.greatest_adu", self.greatest_adu, self.least_adu + 1.0, 16_777_216.0)
    }

    /// From a count to the next whole one when a signal comes on top: within the range, or where the count is beyond it, no farther beyond.
    pub(super) fn step(&self, count: f64, signal_adu: f64) -> f64 {
        (count + signal_adu).round().clamp(self.least_adu.min(count), self.greatest_adu.max(count)) - count
    }

    pub(super) fn apply(&self, count: f32) -> f32 {
        count.round().clamp(self.least_adu as f32, self.greatest_adu as f32)
    }
}

/// What a stream is for: streams of one seed never meet.
#[derive(Copy, Clone, Debug)]
pub(super) enum Purpose {
    Shot = 0,
    Read = 1,
    Rounding = 2,
}

/// The stream of one row.
pub(super) fn stream(seed: u64, purpose: Purpose, row: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(((purpose as u64) << 32) | row as u64);
    random
}

/// A number of electrons whose mean is `mean_e`; 0 for a mean that is not above 0.
pub(super) fn electrons(mean_e: f32, random: &mut ChaCha8Rng) -> f32 {
    Poisson::new(mean_e).map_or(0.0, |poisson| poisson.sample(random))
}

/// Gaussian noise of a sigma.
pub(super) fn gaussian(sigma: f32, random: &mut ChaCha8Rng) -> f32 {
    sigma * random.sample::<f32, _>(StandardNormal)
}

/// A number from -0.5 to 0.5.
pub(super) fn fraction(random: &mut ChaCha8Rng) -> f32 {
    random.random::<f32>() - 0.5
}
