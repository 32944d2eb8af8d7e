//! The Earth's orientation and the Sun's place over any stretch of years, made as they are needed.

use std::collections::BTreeMap;

use hifitime::{Epoch, TimeScale};
use rayon::prelude::*;

use crate::constants::DAY_S;
use crate::frames::{
    EopTable, Gcrs, Orientation, OrientationTable, Position, epoch_from_mjd, mjd_utc, seconds_after, seconds_between,
};
use crate::geometry::SunTable;

/// Days that a table covers: long against the two nodes that it has to spare, short against a survey of one night.
const BLOCK_DAYS: f64 = 16.0;

/// Tables for the blocks of days that have been asked for.
pub(super) struct Ephemeris {
    eop: EopTable,
    blocks: BTreeMap<i64, (Epoch, OrientationTable, SunTable)>,
}

/// What does not depend on the satellite.
#[derive(Copy, Clone, Debug)]
pub(super) struct Moment {
    pub orientation: Orientation,
    /// Geocentric.
    pub sun: Position<Gcrs>,
}

impl Ephemeris {
    pub(super) fn new(eop: EopTable) -> Self {
        Self { eop, blocks: BTreeMap::new() }
    }

    /// Makes the tables that these moments need.
    pub(super) fn prepare(&mut self, epochs: impl Iterator<Item = Epoch>) {
        let mut wanted: Vec<i64> = Vec::new();
        for epoch in epochs {
            let block = block_of(epoch);
            if wanted.last() != Some(&block) && !self.blocks.contains_key(&block) {
                wanted.push(block);
            }
        }
        wanted.sort_unstable();
        wanted.dedup();
        let eop = &self.eop;
        let made = wanted.into_par_iter().filter_map(|block| {
            let start = epoch_from_mjd(block as f64 * BLOCK_DAYS, TimeScale::UTC).ok()?;
            let end = seconds_after(start, BLOCK_DAYS * DAY_S);
            Some((block, (start, OrientationTable::new(start, end, eop), SunTable::new(start, end))))
        });
        self.blocks.extend(made.collect::<Vec<_>>());
    }

    /// At a moment that was prepared; else `None`.
    pub(super) fn at(&self, epoch: Epoch) -> Option<Moment> {
        let (start, orientations, suns) = self.blocks.get(&block_of(epoch))?;
        let seconds = seconds_between(*start, epoch);
        Some(Moment { orientation: orientations.at_s(seconds), sun: suns.at_s(seconds).sun })
    }
}

fn block_of(epoch: Epoch) -> i64 {
    (mjd_utc(epoch) / BLOCK_DAYS).floor() as i64
}
