//! Element sets: catalogue number, epoch and the mean elements of SGP4, as published.

use std::fmt;
use std::sync::Arc;

use hifitime::{Epoch, Unit};
use serde::{Deserialize, Serialize};

/// NORAD catalogue number, up to nine digits. Displayed without padding.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NoradId(pub u32);

impl fmt::Display for NoradId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// Mean elements for SGP4 in their published units (degrees, revolutions a day), TEME of epoch.
///
/// Numbers are stored as read, so that the same record in another format gives a bit-identical ephemeris.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementSet {
    /// Catalogue number.
    pub norad_id: NoradId,
    /// Name, without the leading "0 " of three-line files and without surrounding blanks; empty if omitted.
    pub name: Arc<str>,
    /// COSPAR designator in the form `1998-067A`; empty if omitted.
    pub international_designator: Arc<str>,
    /// Epoch of the elements (UTC in the files).
    pub epoch: Epoch,
    /// Mean motion (Kozai), revolutions a day.
    pub mean_motion_rev_day: f64,
    /// Eccentricity, [0, 1).
    pub eccentricity: f64,
    /// Inclination, degrees, [0, 180].
    pub inclination_deg: f64,
    /// Right ascension of the ascending node, degrees.
    pub right_ascension_of_node_deg: f64,
    /// Argument of perigee, degrees.
    pub argument_of_perigee_deg: f64,
    /// Mean anomaly, degrees.
    pub mean_anomaly_deg: f64,
    /// Drag term B* of SGP4, 1/earth radii.
    pub bstar_per_earth_radius: f64,
    /// Half the first derivative of the mean motion as published (SGP4 does not use it), revolutions/day².
    pub mean_motion_dot_rev_day2: f64,
    /// A sixth of the second derivative of the mean motion as published (SGP4 does not use it), revolutions/day³.
    pub mean_motion_ddot_rev_day3: f64,
    /// Revolution number at epoch; 0 if omitted.
    pub revolution_at_epoch: u32,
    /// Origin of the record.
    pub origin: Origin,
}

/// Origin of an element set.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Read from a file.
    Published,
    /// Simulated by a [`Constellation`](super::Constellation): does not correspond to a real satellite.
    Synthetic,
}

/// Returns the fraction of element sets whose epoch differs from a time by more than `days`, [0, 1]; 1 without element
/// sets.
pub fn share_of_stale(elements: &[ElementSet], epoch: Epoch, days: f64) -> f64 {
    if elements.is_empty() {
        return 1.0;
    }
    let limit = Unit::Day * days;
    let stale = elements.iter().filter(|set| (set.epoch - epoch).abs() > limit).count();
    stale as f64 / elements.len() as f64
}
