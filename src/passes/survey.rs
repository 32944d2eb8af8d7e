//! The satellites of a sky asked one by one, on all threads.

use rayon::prelude::*;

use super::sky::Sky;
use crate::orbit::{LeftOut, OrbitError, Propagator};

/// Satellites that a thread takes at a time at least.
const TOGETHER: usize = 8;

impl Sky {
    /// What `look` finds of the wanted satellites, in the catalogue's order, and those of them without a position: from the beginning, or where `look` fails.
    /// What it had found by then stays.
    pub(super) fn survey<T: Send>(
        &self,
        is_wanted: impl Fn(usize) -> bool,
        look: impl Fn(usize, &Propagator, &mut Vec<T>) -> Result<(), OrbitError> + Sync,
    ) -> (Vec<T>, Vec<LeftOut>) {
        let wanted: Vec<usize> = (0..self.index().len()).filter(|one| is_wanted(*one)).collect();
        let look_at = |&element_index: &usize| {
            let mut found = Vec::new();
            let left_out = self.index().propagator(element_index).and_then(|propagator| {
                let failed = look(element_index, propagator, &mut found).err();
                failed.map(|reason| LeftOut { norad_id: propagator.norad_id(), element_index, reason })
            });
            (found, left_out)
        };
        let looks: Vec<(Vec<T>, Option<LeftOut>)> = wanted.par_iter().with_min_len(TOGETHER).map(look_at).collect();
        let from_the_beginning = self.index().left_out().iter().filter(|one| is_wanted(one.element_index));
        let mut left_out: Vec<LeftOut> = from_the_beginning.cloned().collect();
        let mut all = Vec::new();
        for (found, failed) in looks {
            all.extend(found);
            left_out.extend(failed);
        }
        left_out.sort_by_key(|one| one.element_index);
        (all, left_out)
    }
}
