//! Ephemeris as read from a file.

use std::fmt;
use std::sync::Arc;

use hifitime::Epoch;

use super::super::element_set::{ElementSet, NoradId};

/// States of one satellite in time order.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ephemeris {
    /// Identifier of the satellite.
    #[doc(hidden)]
    pub object: EphemerisObject,
    /// Name of the satellite; empty if omitted.
    pub name: Arc<str>,
    /// Name of the file as given.
    pub file: Arc<str>,
    /// Creation time of the file; `None` if omitted.
    pub created: Option<Epoch>,
    /// Frame of positions and velocities.
    #[doc(hidden)]
    pub frame: EphemerisFrame,
    /// Interval in which positions can be computed (of an OEM: USEABLE_START_TIME and USEABLE_STOP_TIME, and START_TIME
    /// and STOP_TIME if there are states outside of them); `None` for an end at which the first or last state is the
    /// limit. States outside serve only for the interpolation.
    pub usable: [Option<Epoch>; 2],
    /// States: at least eight, at increasing times within 366 days.
    #[doc(hidden)]
    pub states: Vec<EphemerisState>,
    /// Covariances in time order; empty if omitted.
    #[doc(hidden)]
    pub covariances: Vec<PositionCovariance>,
}

/// Identifier of a satellite in an ephemeris.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum EphemerisObject {
    /// NORAD catalogue number.
    Norad(NoradId),
    /// COSPAR designator in the form `1998-067A`.
    Designator(Arc<str>),
}

/// Frame of an ephemeris.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum EphemerisFrame {
    /// Mean equator and equinox of J2000 (EME2000).
    Eme2000,
    /// Geocentric frame with the axes of GCRF or ICRF.
    Gcrf,
    /// True equator and mean equinox of date, the frame of SGP4.
    Teme,
    /// Earth-fixed frame: any realisation of ITRF.
    Itrf,
}

/// Position and velocity at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct EphemerisState {
    /// Time of the state.
    pub epoch: Epoch,
    /// Geocentric position, km.
    pub position_km: [f64; 3],
    /// Velocity relative to the axes of the frame, km/s.
    pub velocity_km_s: [f64; 3],
}

/// Covariance of a position at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PositionCovariance {
    /// Time of the covariance.
    pub epoch: Epoch,
    /// Axes of the components.
    pub axes: CovarianceAxes,
    /// Lower triangle by rows: xx, yx, yy, zx, zy, zz, km².
    pub terms_km2: [f64; 6],
}

/// Axes of a covariance.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum CovarianceAxes {
    /// Radial; in the orbital plane perpendicular to it (along-track); normal to the plane (RTN, RSW, UVW).
    Radial,
    /// Along the velocity; in the orbital plane perpendicular to it; normal to the plane (TNW).
    Tangential,
    /// Axes of the frame of the states.
    States,
}

impl EphemerisObject {
    /// Returns true if the element set is of this satellite.
    pub fn is_of(&self, elements: &ElementSet) -> bool {
        match self {
            Self::Norad(norad_id) => elements.norad_id == *norad_id,
            Self::Designator(designator) => elements.international_designator == *designator,
        }
    }
}

impl fmt::Display for EphemerisObject {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Norad(norad_id) => norad_id.fmt(formatter),
            Self::Designator(designator) => designator.fmt(formatter),
        }
    }
}

impl Ephemeris {
    /// Returns true if the element set is of the same satellite.
    pub fn is_of(&self, elements: &ElementSet) -> bool {
        self.object.is_of(elements)
    }

    /// Returns the interval in which positions can be computed: from the first to the last state, as far as the file
    /// states that they are usable.
    pub fn interval(&self) -> (Epoch, Epoch) {
        let (first, last) = (self.states[0].epoch, self.states[self.states.len() - 1].epoch);
        let [from, to] = self.usable;
        (from.map_or(first, |from| from.max(first)), to.map_or(last, |to| to.min(last)))
    }
}

impl fmt::Display for Ephemeris {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let id = &self.object;
        if self.name.is_empty() { write!(formatter, "{id}") } else { write!(formatter, "{} ({id})", self.name) }
    }
}
