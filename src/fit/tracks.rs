//! Tracks dealt into sets, and the pixels that some of the sets make: what errors and unseen points of fits to pixels rest on.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::measurements::{Measurement, Measurements, ReduceOptions, Reducer, Reduction};

use super::error::FitError;

/// Tracks are dealt in an order drawn with this seed: neighbours in a file share a night and its geometry.
const SEED: u64 = 1;
/// Measurements that go to a reducer at a time: the few that stay out of a set need no copy of all others.
const CHUNK: usize = 1 << 16;

/// Measurements whose groups (tracks, nights) are dealt into sets of like size.
pub(super) struct Dealt<'a> {
    measurements: &'a Measurements,
    /// Of each group, by its number.
    set_of_group: Vec<usize>,
    /// How many groups have a point.
    pub groups: usize,
}

impl<'a> Dealt<'a> {
    /// The same groups go to the same sets each time.
    pub fn new(measurements: &'a Measurements, sets: usize) -> Self {
        let mut groups: Vec<u32> = measurements.points.iter().map(|point| point.group).collect();
        groups.sort_unstable();
        groups.dedup();
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut drawn: Vec<(u64, u32)> = groups.iter().map(|&group| (random.next_u64(), group)).collect();
        drawn.sort_unstable();
        let mut set_of_group = vec![0; groups.last().map_or(0, |&last| last as usize + 1)];
        for (place, (_, group)) in drawn.into_iter().enumerate() {
            set_of_group[group as usize] = place % sets.max(1);
        }
        Self { measurements, set_of_group, groups: groups.len() }
    }

    /// Pixels of the sets that are wanted, and of no other.
    ///
    /// # Errors
    /// [`FitError::Reduction`] for options that cannot be.
    pub fn reduced(&self, options: ReduceOptions, wanted: impl Fn(usize) -> bool) -> Result<Reduction, FitError> {
        let mut reducer = Reducer::new(options)?;
        let stays = |point: &&Measurement| wanted(self.set_of_group[point.group as usize]);
        for chunk in self.measurements.points.chunks(CHUNK) {
            reducer.add(&chunk.iter().filter(stays).copied().collect::<Vec<_>>());
        }
        Ok(reducer.finish())
    }
}
