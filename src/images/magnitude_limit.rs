//! Magnitude that is the same in all bands, or different by band.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Magnitude limit: one number, or numbers by band with `default` for the other bands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "invalid magnitude limit; allowed: a number, or a table of numbers by band")]
pub enum MagnitudeLimit {
    /// One limit for all exposures.
    All(f64),
    /// Limits by band name; `default` applies to the other bands.
    PerBand(BTreeMap<String, f64>),
}

impl MagnitudeLimit {
    /// Returns the limit for an exposure in this band. Returns `None` if the table has neither the band nor `default`.
    pub fn limit_in(&self, band: Option<&str>) -> Option<f64> {
        match self {
            MagnitudeLimit::All(limit) => Some(*limit),
            MagnitudeLimit::PerBand(limits) => {
                band.and_then(|band| limits.get(band)).or_else(|| limits.get("default")).copied()
            }
        }
    }

    /// Returns all numbers of the limit.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            MagnitudeLimit::All(limit) => vec![*limit],
            MagnitudeLimit::PerBand(limits) => limits.values().copied().collect(),
        }
    }
}
