//! The Earth's orientation and the Sun's place over any stretch of years, made as they are needed.

use std::collections::BTreeMap;

use hifitime::{Duration, Epoch, TimeScale, Unit};
use rayon::prelude::*;

use crate::constants::DAY_S;
use crate::frames::{EopTable, Gcrs, Orientation, OrientationTable, Position, seconds_after};
use crate::geometry::SunTable;

/// Days that a table covers: long against the two nodes that it has to spare, short against a survey of one night.
const BLOCK_DAYS: f64 = 16.0;

/// Tables for the blocks of days that have been asked for.
pub(super) struct Ephemeris {
    eop: EopTable,
    blocks: BTreeMap<i64, (OrientationTable, SunTable)>,
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
            let (block, _) = block_and_seconds(epoch);
            if wanted.last() != Some(&block) && !self.blocks.contains_key(&block) {
                wanted.push(block);
            }
        }
        wanted.sort_unstable();
        wanted.dedup();
        let eop = &self.eop;
        let made = wanted.into_par_iter().map(|block| {
            let start = Epoch::from_duration(Unit::Day * (block as f64 * BLOCK_DAYS), TimeScale::TAI);
            let end = seconds_after(start, BLOCK_DAYS * DAY_S);
            (block, (OrientationTable::new(start, end, eop), SunTable::new(start, end)))
        });
        self.blocks.extend(made.collect::<Vec<_>>());
    }

    /// At a moment that was prepared; else `None`.
    pub(super) fn at(&self, epoch: Epoch) -> Option<Moment> {
        let (block, seconds) = block_and_seconds(epoch);
        let (orientations, suns) = self.blocks.get(&block)?;
        Some(Moment { orientation: orientations.at_s(seconds), sun: suns.at_s(seconds).sun })
    }
}

/// Number of a block, from 1900 on by the clock of TAI (which has no leap seconds), and seconds within it.
fn block_and_seconds(epoch: Epoch) -> (i64, f64) {
    let since_1900: Duration = epoch.to_tai_duration();
    let seconds = since_1900.to_seconds();
    let block = (seconds / (BLOCK_DAYS * DAY_S)).floor();
    // The difference keeps the nanosecond that the sum in one f64 (4e9 s) has lost.
    let rest = since_1900 - Unit::Day * (block * BLOCK_DAYS);
    (block as i64, rest.to_seconds())
}
