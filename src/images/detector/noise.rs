//! Random numbers of a frame: a stream for each row, so that the answer does not depend on threads.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Poisson, StandardNormal};

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
