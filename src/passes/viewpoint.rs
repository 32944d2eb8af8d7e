//! Observer of a sky: a site, or a telescope in orbit.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use hifitime::Epoch;

use crate::constants::DAY_S;
use crate::elements::{ElementSet, Ephemeris, EphemerisObject, NoradId};
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, EopTable, Gcrs, Orientation, Position, seconds_after, seconds_between};
use crate::geometry::{EarthLimb, Observer, PointingAngles, PointingLimits, Site};
use crate::orbit::{DragModel, ObserverOrbit, OrbitClass, State, elements_of_age, uncertainty};

/// Distance of a typical satellite from a telescope in orbit, km: the median is 2,300 km for 219 crossings of fields of
/// 0.5° by active satellites in random exposures of Hubble.
const TYPICAL_RANGE_KM: f64 = 2_000.0;

/// Telescope in orbit, given by an element set or by ephemerides of its operator. It has no horizon; the limb of the
/// Earth bounds its view.
///
/// Crossings and probabilities take its position as exact. An error of its elements of a kilometre shifts every
/// satellite at a range of 1000 km by about 0.06°; exposures are not judged if the error is larger than the field.
#[derive(Clone, Debug)]
pub struct OrbitingObserver {
    name: String,
    object: EphemerisObject,
    orbit: ObserverOrbit,
    limb: EarthLimb,
    limits: PointingLimits,
    /// Empty for an element set.
    ephemerides: Vec<Arc<Ephemeris>>,
    /// Class of the element set, which determines its errors; `None` for ephemerides.
    class: Option<OrbitClass>,
    /// Numbers of other satellites that are the telescope, and of one that is not, although it has its number.
    same: Vec<NoradId>,
    other: Option<NoradId>,
}

impl OrbitingObserver {
    /// Creates an observer from the element set of an object; `limb` bounds its view.
    ///
    /// # Errors
    /// SGP4 cannot be initialised.
    pub fn new(elements: &ElementSet, limb: EarthLimb) -> Result<Self, Error> {
        Ok(Self {
            name: elements.name.to_string(),
            object: EphemerisObject::Norad(elements.norad_id),
            orbit: ObserverOrbit::of_elements(elements)?,
            limb,
            limits: PointingLimits::default(),
            ephemerides: Vec::new(),
            class: Some(OrbitClass::from_elements(elements, DragModel::default())),
            same: Vec::new(),
            other: None,
        })
    }

    /// Creates an observer from ephemerides of one object, for example the segments of one file; `limb` bounds its
    /// view. An exposure needs one ephemeris that covers it as a whole; of several, the one created last is used.
    /// `None` if there are no ephemerides.
    pub fn from_ephemerides(ephemerides: &[Arc<Ephemeris>], eop: &EopTable, limb: EarthLimb) -> Option<Self> {
        let first = ephemerides.first()?;
        Some(Self {
            name: first.name.to_string(),
            object: first.object.clone(),
            orbit: ObserverOrbit::of_ephemerides(ephemerides, eop),
            limb,
            limits: PointingLimits::default(),
            ephemerides: ephemerides.to_vec(),
            class: None,
            same: Vec::new(),
            other: None,
        })
    }

    /// Sets the NORAD catalogue number, for an ephemeris that has only a COSPAR designator.
    pub fn with_norad_id(self, norad_id: NoradId) -> Self {
        Self { object: EphemerisObject::Norad(norad_id), ..self }
    }

    /// Returns the name in the element set or ephemeris, or the catalogue number or COSPAR designator if it has no
    /// name.
    pub fn name(&self) -> String {
        if self.name.is_empty() { self.object.to_string() } else { self.name.clone() }
    }

    /// Returns the NORAD catalogue number or the COSPAR designator. This object is not searched for.
    #[doc(hidden)]
    pub fn object(&self) -> &EphemerisObject {
        &self.object
    }

    /// Sets the numbers of other satellites that are the telescope, and that of a satellite that is not, although it
    /// has the number of the telescope.
    pub(super) fn with_own_satellites(self, same: Vec<NoradId>, other: Option<NoradId>) -> Self {
        Self { same, other, ..self }
    }

    /// Returns true for the element set of the telescope itself.
    pub(super) fn is(&self, elements: &ElementSet) -> bool {
        self.same.contains(&elements.norad_id) || self.object.is_of(elements) && self.other != Some(elements.norad_id)
    }

    /// Returns the error of the position that its element set gives at a time, km: 68 % of the positions are nearer.
    /// `None` for ephemerides, whose positions are taken as exact.
    #[doc(hidden)]
    pub fn position_error_km(&self, epoch: Epoch) -> Option<f64> {
        let (class, of_set) = (self.class?, self.orbit.elements_epoch()?);
        let errors = uncertainty(class, seconds_between(of_set, epoch) / DAY_S);
        Some((errors.along_track_s * class.speed_km_s()).hypot(errors.cross_track_km))
    }

    /// Returns the reason why its element set does not give its position well enough for crossings of a field,
    /// whose bounding circle is given, at a time, and the age of the set, days; `None` if it does.
    ///
    /// This is the case if the set is older than those of the calibration ([`OrbitClass::is_known`]), or if the
    /// crossings of a satellite at the distance [`TYPICAL_RANGE_KM`] would be half wrong: its track is then shifted by
    /// more than the mean chord of the field.
    pub(super) fn reason_unknown(&self, epoch: Epoch, radius_rad: f64) -> Option<(String, f64)> {
        let (class, error_km) = (self.class?, self.position_error_km(epoch)?);
        let age_days = seconds_between(self.orbit.elements_epoch()?, epoch) / DAY_S;
        let age = elements_of_age(age_days);
        if !class.is_known(age_days) {
            return Some((format!("{age} of the telescope {}: its position is unknown", self.name()), age_days));
        }
        // The mean chord of a circle is π/2 times its radius. Shifted by a chord in a random direction, half of the
        // tracks through the circle still cross it: 1 - 2/π · s/2r = 1/2 for s = π r / 2.
        let chord_rad = FRAC_PI_2 * radius_rad;
        (error_km > chord_rad * TYPICAL_RANGE_KM).then(|| {
            let reason = format!(
                "{age} of the telescope {}: its position is known within {error_km:.1} km (68 %), which shifts satellites at \
                 {TYPICAL_RANGE_KM} km by more than the field ({:.2} deg)",
                self.name(),
                chord_rad.to_degrees()
            );
            (reason, age_days)
        })
    }

    /// Returns the epoch of the elements; `None` for ephemerides.
    pub fn elements_epoch(&self) -> Option<Epoch> {
        self.orbit.elements_epoch()
    }

    /// Returns the ephemerides; empty for an element set.
    pub fn ephemerides(&self) -> &[Arc<Ephemeris>] {
        &self.ephemerides
    }

    /// Returns true if two of its ephemerides are of one message and for the same time, and differ by more than a
    /// kilometre.
    #[doc(hidden)]
    pub fn has_contradictory_ephemerides(&self) -> bool {
        self.orbit.is_contradictory()
    }

    /// Returns the description of the first gap of its ephemerides in an interval, with the reason; `None` without one.
    pub(crate) fn gap_in(&self, interval: [Epoch; 2]) -> Option<String> {
        self.orbit.gap_in(interval)
    }

    /// Returns the geocentric position, km.
    ///
    /// # Errors
    /// Elements or ephemerides give no position at that time.
    pub fn position(&self, epoch: Epoch, orientation: &Orientation) -> Result<Position<Gcrs>, Error> {
        Ok(self.state(epoch, orientation)?.position)
    }

    /// Returns the geocentric position and velocity.
    ///
    /// # Errors
    /// Same as [`OrbitingObserver::position`].
    pub(super) fn state(&self, epoch: Epoch, orientation: &Orientation) -> Result<State<Gcrs>, Error> {
        self.orbit.state(epoch, &orientation.teme_to_gcrs)
    }

    /// Returns the limb of the Earth that bounds the view.
    pub fn limb(&self) -> EarthLimb {
        self.limb
    }

    /// Sets limits on the pointings.
    #[doc(hidden)]
    pub fn with_limits(self, limits: PointingLimits) -> Self {
        Self { limits, ..self }
    }

    /// Returns the limits on the pointings.
    #[doc(hidden)]
    pub fn limits(&self) -> &PointingLimits {
        &self.limits
    }

    /// Returns the angles of a pointing from zenith, Sun and limb; `sun` is the geocentric position of the Sun.
    ///
    /// # Errors
    /// Elements or ephemerides give no position at that time.
    #[doc(hidden)]
    pub fn pointing_angles(
        &self,
        pointing: &Direction<Gcrs>,
        epoch: Epoch,
        orientation: &Orientation,
        sun: &Position<Gcrs>,
    ) -> Result<PointingAngles, Error> {
        Ok(PointingAngles::new(pointing, &self.position(epoch, orientation)?, sun, &self.limb))
    }

    pub(super) fn orbit(&self) -> &ObserverOrbit {
        &self.orbit
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

    /// Returns the site, for queries that require a horizon.
    ///
    /// # Errors
    /// The observer is in orbit.
    #[doc(hidden)]
    pub fn required_site(&self) -> Result<&Observer, Error> {
        self.site().ok_or_else(|| {
            let sentence = format!("observer {} is in orbit and has no horizon", self.name());
            Error::new(ErrorKind::Invalid, sentence).allowing("a site")
        })
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
    /// The observer's own elements give no position.
    pub fn pointing_altitude_rad(
        &self,
        pointing: &Direction<Gcrs>,
        epoch: Epoch,
        orientation: &Orientation,
    ) -> Result<f64, Error> {
        match self {
            Self::Site(observer) => Ok((observer.state(orientation).horizon * *pointing).latitude_rad()),
            Self::Orbit(observer) => Ok(observer.limb.altitude_rad(&observer.position(epoch, orientation)?, pointing)),
        }
    }

    /// Returns the part of the time from `before_s` before an interval to `after_s` after it in which the position of
    /// the observer is known; `None` if it is unknown at a time of the interval itself. Only ephemerides of a telescope
    /// in orbit limit it.
    pub fn known_part(&self, interval: [Epoch; 2], before_s: f64, after_s: f64) -> Option<[Epoch; 2]> {
        let outer = [seconds_after(interval[0], -before_s), seconds_after(interval[1], after_s)];
        match self {
            Self::Site(_) => Some(outer),
            Self::Orbit(observer) => observer.orbit.known_part(outer, interval),
        }
    }
}
