//! One element set as it was published: who, when, and SGP4's mean elements.

use std::fmt;
use std::sync::Arc;

use hifitime::Epoch;
use serde::{Deserialize, Serialize};

/// A NORAD catalogue number, up to nine digits. Printed without padding.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NoradId(pub u32);

impl fmt::Display for NoradId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// Mean elements for SGP4 in the units in which they are published (degrees, revolutions a day), TEME of epoch.
///
/// The numbers stay as they were read, so that the same record in another syntax gives the same ephemeris bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementSet {
    /// Catalogue number.
    pub norad_id: NoradId,
    /// Name, without the leading "0 " of three-line files and without blanks around it; empty where none was given.
    pub name: Arc<str>,
    /// COSPAR designator in the form `1998-067A`; empty where none was given.
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
    /// SGP4's drag term B*, 1/earth radii.
    pub bstar_per_earth_radius: f64,
    /// Half the first derivative of the mean motion as published (SGP4 does not use it), revolutions/day².
    pub mean_motion_dot_rev_day2: f64,
    /// A sixth of the second derivative of the mean motion as published (SGP4 does not use it), revolutions/day³.
    pub mean_motion_ddot_rev_day3: f64,
    /// Revolution number at epoch; 0 where none was given.
    pub revolution_at_epoch: u32,
    /// Where the record came from.
    pub origin: Origin,
}

/// Where an element set came from.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Read from somebody's file.
    Published,
    /// Made by a [`Constellation`](super::Constellation): no such satellite is claimed to be there.
    Synthetic,
}
