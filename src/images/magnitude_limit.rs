//! Magnitude that is the same in all bands, or different by band.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::message::Quoted;

/// Magnitude limit: one number, or numbers by band with `default` for the other bands. In files it may also be a text,
/// as on the command line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Written")]
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

impl FromStr for MagnitudeLimit {
    type Err = Error;

    /// Parses one number, `7`, or limits by band, `g=7,y=5,default=6`.
    fn from_str(text: &str) -> Result<Self, Error> {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        if let Some(limit) = number(text) {
            return Ok(MagnitudeLimit::All(limit));
        }
        let pairs = text.split(',').map(|part| {
            let (band, limit) = part.split_once('=')?;
            Some((band.trim().to_owned(), number(limit)?)).filter(|(band, _)| !band.is_empty())
        });
        let mut limits = BTreeMap::new();
        for pair in pairs {
            let (band, limit) = pair.ok_or_else(|| {
                Error::format(format!("invalid magnitude limit '{}'", Quoted::new(text)))
                    .allowing("a number, or numbers by band such as g=7,y=5,default=6")
            })?;
            if limits.insert(band.clone(), limit).is_some() {
                return Err(Error::format(format!("band {band} has two limits in '{}'", Quoted::new(text)))
                    .allowing("one number for each band, such as g=7,y=5,default=6"));
            }
        }
        Ok(MagnitudeLimit::PerBand(limits))
    }
}

/// Forms of a limit in files.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "invalid magnitude limit; allowed: a number, a text such as g=7,default=6, or a table of numbers by band"
)]
enum Written {
    Text(String),
    All(f64),
    PerBand(BTreeMap<String, f64>),
}

impl TryFrom<Written> for MagnitudeLimit {
    type Error = Error;

    fn try_from(written: Written) -> Result<Self, Error> {
        match written {
            Written::Text(text) => text.parse(),
            Written::All(limit) => Ok(Self::All(limit)),
            Written::PerBand(limits) => Ok(Self::PerBand(limits)),
        }
    }
}
