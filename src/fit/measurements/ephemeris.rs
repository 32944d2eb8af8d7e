//! Earth orientation, Sun and observer for any times within years, from tables that are made as needed.

use std::collections::BTreeMap;

use hifitime::{Duration, Epoch, TimeScale, Unit};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::constants::DAY_S;
use crate::elements::ElementSet;
use crate::frames::{
    EopTable, Gcrs, Horizontal, Itrs, Orientation, OrientationTable, Position, Rotation, seconds_after,
};
use crate::geometry::{Site, SunTable};

/// Length of a table, days. It is long enough that the additional nodes at both ends cost little.
const BLOCK_DAYS: f64 = 16.0;

/// Tables for the blocks of days that have been prepared.
pub(super) struct Ephemeris {
    eop: EopTable,
    blocks: BTreeMap<i64, (OrientationTable, SunTable)>,
}

/// Earth orientation and Sun at one time.
#[derive(Copy, Clone, Debug)]
pub(super) struct Moment {
    pub orientation: Orientation,
    /// Geocentric position of the Sun, km.
    pub sun: Position<Gcrs>,
}

impl Ephemeris {
    pub(super) fn new(eop: EopTable) -> Self {
        Self { eop, blocks: BTreeMap::new() }
    }

    /// Prepares the tables that these epochs need.
    pub(super) fn prepare(&mut self, epochs: impl Iterator<Item = Epoch>) {
        let mut missing: Vec<i64> = Vec::new();
        for epoch in epochs {
            let (block, _) = block_and_seconds(epoch);
            if missing.last() != Some(&block) && !self.blocks.contains_key(&block) {
                missing.push(block);
            }
        }
        missing.sort_unstable();
        missing.dedup();
        let eop = &self.eop;
        let made = missing.into_par_iter().map(|block| {
            let start = Epoch::from_duration(Unit::Day * (block as f64 * BLOCK_DAYS), TimeScale::TAI);
            let end = seconds_after(start, BLOCK_DAYS * DAY_S);
            (block, (OrientationTable::new(start, end, eop), SunTable::new(start, end)))
        });
        self.blocks.extend(made.collect::<Vec<_>>());
    }

    /// Returns the values at an epoch; `None` if its table was not prepared.
    pub(super) fn at(&self, epoch: Epoch) -> Option<Moment> {
        let (block, seconds) = block_and_seconds(epoch);
        let (orientations, suns) = self.blocks.get(&block)?;
        Some(Moment { orientation: orientations.at_s(seconds), sun: suns.at_s(seconds).sun })
    }
}

/// Returns the number of the block that contains an epoch, and the seconds since its beginning. Blocks are counted from
/// 1900 in TAI, which has no leap seconds.
fn block_and_seconds(epoch: Epoch) -> (i64, f64) {
    let since_1900: Duration = epoch.to_tai_duration();
    let seconds = since_1900.to_seconds();
    let block = (seconds / (BLOCK_DAYS * DAY_S)).floor();
    // The difference of durations keeps the nanoseconds, which one f64 of 4e9 s does not resolve.
    let rest = since_1900 - Unit::Day * (block * BLOCK_DAYS);
    (block as i64, rest.to_seconds())
}

/// Position and horizontal axes of a site.
pub(super) struct SiteAxes {
    pub position: Position<Itrs>,
    pub horizon: Rotation<Itrs, Horizontal>,
}

impl SiteAxes {
    pub(super) fn new(site: &Site) -> Self {
        Self { position: site.itrs(), horizon: site.horizon() }
    }

    /// Returns the position and the zenith in the GCRS.
    pub(super) fn at(&self, moment: &Moment) -> (Position<Gcrs>, Vector3<f64>) {
        let to_gcrs = &moment.orientation.itrs_to_gcrs;
        let zenith = self.horizon.matrix().row(2).transpose();
        (*to_gcrs * self.position, to_gcrs.matrix() * zenith)
    }
}

/// Returns the age of an element set at an epoch, days.
pub(super) fn age_days(set: &ElementSet, epoch: Epoch) -> f64 {
    let age: Duration = epoch - set.epoch;
    age.to_unit(Unit::Day)
}
