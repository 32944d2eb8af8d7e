//! Viewpoint of a sky: a site, or a telescope in orbit.

use hifitime::Epoch;

use crate::elements::{ElementSet, NoradId};
use crate::frames::{Direction, Gcrs, Orientation};
use crate::geometry::{EarthLimb, Observer, Site};
use crate::orbit::{OrbitError, Propagator};

/// A telescope in orbit, given by an element set. It has no horizon; the Earth's limb hides what is behind it.
///
/// The prediction of its own position is taken as exact: an error of its elements (about a kilometre) shifts every
/// satellite at 1000 km by some 0.06°.
#[derive(Clone, Debug)]
pub struct OrbitingObserver {
    name: String,
    propagator: Propagator,
    limb: EarthLimb,
}

impl OrbitingObserver {
    /// The object of this element set as an observer; `limb` is the border of the Earth.
    ///
    /// # Errors
    /// [`OrbitError::Elements`] where SGP4 cannot start.
    pub fn new(elements: &ElementSet, limb: EarthLimb) -> Result<Self, OrbitError> {
        Ok(Self { name: elements.name.to_string(), propagator: Propagator::new(elements)?, limb })
    }

    /// The name in its element set, or its number.
    pub fn name(&self) -> String {
        if self.name.is_empty() { self.norad_id().to_string() } else { self.name.clone() }
    }

    /// NORAD catalogue number: an object of this number is not seen by itself.
    pub fn norad_id(&self) -> NoradId {
        self.propagator.norad_id()
    }

    /// Epoch of its elements.
    pub fn elements_epoch(&self) -> Epoch {
        self.propagator.epoch()
    }

    /// The border of the Earth.
    pub fn limb(&self) -> EarthLimb {
        self.limb
    }

    pub(super) fn propagator(&self) -> &Propagator {
        &self.propagator
    }
}

/// Viewpoint of a sky.
#[derive(Clone, Debug)]
pub enum Viewpoint {
    /// A site on the Earth.
    Site(Observer),
    /// An orbit.
    Orbit(Box<OrbitingObserver>),
}

impl From<Site> for Viewpoint {
    fn from(site: Site) -> Self {
        Self::Site(Observer::new(site))
    }
}

impl From<Observer> for Viewpoint {
    fn from(observer: Observer) -> Self {
        Self::Site(observer)
    }
}

impl From<OrbitingObserver> for Viewpoint {
    fn from(observer: OrbitingObserver) -> Self {
        Self::Orbit(Box::new(observer))
    }
}

impl Viewpoint {
    /// The site; `None` in orbit.
    pub fn site(&self) -> Option<&Observer> {
        match self {
            Self::Site(observer) => Some(observer),
            Self::Orbit(_) => None,
        }
    }

    /// The telescope in orbit; `None` for a site.
    pub fn orbit(&self) -> Option<&OrbitingObserver> {
        match self {
            Self::Site(_) => None,
            Self::Orbit(observer) => Some(observer),
        }
    }

    /// Its name.
    pub fn name(&self) -> String {
        match self {
            Self::Site(observer) => observer.site().name.clone(),
            Self::Orbit(observer) => observer.name(),
        }
    }

    /// `the horizon` or `the Earth's limb`: the border that a pointing can be below.
    pub fn border_name(&self) -> &'static str {
        match self {
            Self::Site(_) => "the horizon",
            Self::Orbit(_) => "the Earth's limb",
        }
    }

    /// Altitude of a pointing above the horizon, or in orbit above the Earth's limb, radians, without refraction and
    /// aberration (25" at most).
    ///
    /// # Errors
    /// [`OrbitError`] where the observer's own elements give no position.
    pub fn pointing_altitude_rad(
        &self,
        pointing: &Direction<Gcrs>,
        epoch: Epoch,
        orientation: &Orientation,
    ) -> Result<f64, OrbitError> {
        match self {
            Self::Site(observer) => Ok((observer.state(orientation).horizon * *pointing).latitude_rad()),
            Self::Orbit(observer) => {
                let state = observer.propagator.state(epoch, &orientation.teme_to_gcrs)?;
                Ok(observer.limb.altitude_rad(&state.position, pointing))
            }
        }
    }
}
