//! Conversion of electrons to the counts of a file, and a random stream for each row of a frame.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Poisson, StandardNormal};
use serde::Deserialize;

use crate::error::Error;

/// Rounding of counts to integers within the range of the converter.
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantisation {
    /// Smallest count, \[-1e6, 1e6\]; by default 0.
    #[serde(default)]
    pub least_adu: f64,
    /// Largest count, above the smallest one and at most 16777216 (2²⁴, above which single precision does not resolve
    /// all integers); by default 65535.
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
    pub(super) fn validate(&self) -> Result<(), Error> {
        Error::check_range("quantisation.least_adu", self.least_adu, -1e6, 1e6)?;
        Error::check_range("quantisation.greatest_adu", self.greatest_adu, self.least_adu + 1.0, 16_777_216.0)
    }

    /// Returns the change of a count when a signal is added and the sum is rounded to an integer. The result is limited
    /// to the range of the converter; a count that is already outside the range does not move farther from it.
    pub(super) fn step(&self, count: f64, signal_adu: f64) -> f64 {
        (count + signal_adu).round().clamp(self.least_adu.min(count), self.greatest_adu.max(count)) - count
    }

    pub(super) fn apply(&self, count: f32) -> f32 {
        count.round().clamp(self.least_adu as f32, self.greatest_adu as f32)
    }
}

/// Purpose of a random stream. Streams of one seed with different purposes are independent.
#[derive(Copy, Clone, Debug)]
pub(super) enum Purpose {
    Shot = 0,
    Read = 1,
    Rounding = 2,
}

/// Returns the random stream for one purpose and one row.
pub(super) fn stream(seed: u64, purpose: Purpose, row: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(((purpose as u64) << 32) | row as u64);
    random
}

/// Draws a Poisson number of electrons with the mean `mean_e`; 0 if the mean is not above 0.
pub(super) fn electrons(mean_e: f32, random: &mut ChaCha8Rng) -> f32 {
    Poisson::new(mean_e).map_or(0.0, |poisson| poisson.sample(random))
}

/// Draws Gaussian noise with the standard deviation `sigma`.
pub(super) fn gaussian(sigma: f32, random: &mut ChaCha8Rng) -> f32 {
    sigma * random.sample::<f32, _>(StandardNormal)
}

/// Draws a number from -0.5 to 0.5.
pub(super) fn fraction(random: &mut ChaCha8Rng) -> f32 {
    random.random::<f32>() - 0.5
}
