//! Observer of a sky: a site, or a telescope in orbit.

use hifitime::Epoch;

use crate::elements::{ElementSet, NoradId};
use crate::frames::{Direction, Gcrs, Orientation};
use crate::geometry::{EarthLimb, Observer, Site};
use crate::orbit::{OrbitError, Propagator};

/// Telescope in orbit, given by an element set. It has no horizon; the limb of the Earth bounds its view.
///
/// Its predicted position is taken as exact. An error of its elements, which is typically about a kilometre, shifts
/// every satellite at a range of 1000 km by about 0.06°.
#[derive(Clone, Debug)]
pub struct OrbitingObserver {
    name: String,
    propagator: Propagator,
    limb: EarthLimb,
}

impl OrbitingObserver {
    /// Creates an observer from the element set of an object; `limb` bounds its view.
    ///
    /// # Errors
    /// [`OrbitError::Elements`] if SGP4 cannot be initialised.
    pub fn new(elements: &ElementSet, limb: EarthLimb) -> Result<Self, OrbitError> {
        Ok(Self { name: elements.name.to_string(), propagator: Propagator::new(elements)?, limb })
    }

    /// Returns the name in the element set, or the catalogue number if it has no name.
    pub fn name(&self) -> String {
        if self.name.is_empty() { self.norad_id().to_string() } else { self.name.clone() }
    }

    /// Returns the NORAD catalogue number. The object with this number is not searched for.
    pub fn norad_id(&self) -> NoradId {
        self.propagator.norad_id()
    }

    /// Returns the epoch of the elements.
    pub fn elements_epoch(&self) -> Epoch {
        self.propagator.epoch()
    }

    /// Returns the limb of the Earth that bounds the view.
    pub fn limb(&self) -> EarthLimb {
        self.limb
    }

    pub(super) fn propagator(&self) -> &Propagator {
        &self.propagator
    }
}

/// Observer: a site or a telescope in orbit.
#[derive(Clone, Debug)]
pub enum Viewpoint {
    /// A site on the Earth.
    Site(Observer),
    /// A telescope in orbit.
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
    /// Returns the site; `None` for a telescope in orbit.
    pub fn site(&self) -> Option<&Observer> {
        match self {
            Self::Site(observer) => Some(observer),
            Self::Orbit(_) => None,
        }
    }

    /// Returns the telescope in orbit; `None` for a site.
    pub fn orbit(&self) -> Option<&OrbitingObserver> {
        match self {
            Self::Site(_) => None,
            Self::Orbit(observer) => Some(observer),
        }
    }

    /// Returns the name of the site or of the telescope.
    pub fn name(&self) -> String {
        match self {
            Self::Site(observer) => observer.site().name.clone(),
            Self::Orbit(observer) => observer.name(),
        }
    }

    /// Returns the name of the border below which nothing is visible: `the horizon` or `the Earth's limb`.
    pub fn border_name(&self) -> &'static str {
        match self {
            Self::Site(_) => "the horizon",
            Self::Orbit(_) => "the Earth's limb",
        }
    }

    /// Returns the altitude of a pointing, radians, without refraction and aberration (25" at most). It is measured
    /// from the horizon, or from the Earth's limb for an observer in orbit.
    ///
    /// # Errors
    /// [`OrbitError`] if the observer's own elements give no position.
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
