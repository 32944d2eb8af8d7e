//! Observers on the rotating Earth.

use hifitime::Epoch;
use nalgebra::Vector3;

use super::site::Site;
use super::sun::{SunState, SunTable};
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::frames::{Gcrs, Horizontal, Itrs, Orientation, OrientationTable, Position, Rotation, Velocity};

/// Observer at a site, with the Earth-fixed quantities computed once.
#[derive(Clone, Debug, PartialEq)]
pub struct Observer {
    site: Site,
    itrs: Position<Itrs>,
    horizon: Rotation<Itrs, Horizontal>,
}

/// Position, velocity and horizon of an observer at one moment.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ObserverState {
    /// Geocentric position, km.
    pub position: Position<Gcrs>,
    /// Geocentric velocity, km/s: the Earth's rotation, at most 0.465.
    pub velocity: Velocity<Gcrs>,
    /// Rotation from the celestial axes to north, east, zenith.
    pub horizon: Rotation<Gcrs, Horizontal>,
}

impl Observer {
    /// Creates an observer at a site.
    pub fn new(site: Site) -> Self {
        let (itrs, horizon) = (site.itrs(), site.horizon());
        Self { site, itrs, horizon }
    }

    /// Returns the site.
    pub fn site(&self) -> &Site {
        &self.site
    }

    /// Returns the Earth-fixed position, km.
    pub fn itrs(&self) -> Position<Itrs> {
        self.itrs
    }

    /// Returns the celestial position only.
    pub fn position(&self, orientation: &Orientation) -> Position<Gcrs> {
        orientation.itrs_to_gcrs * self.itrs
    }

    /// Returns the celestial position, velocity and horizon.
    ///
    /// The velocity is ω × r about the pole of date; the length of day (10⁻⁸) and polar motion are neglected: below
    /// 0.01 mm/s.
    pub fn state(&self, orientation: &Orientation) -> ObserverState {
        let in_teme = (orientation.itrs_to_teme * self.itrs).vector().to_owned();
        let turn = Vector3::new(-in_teme.y, in_teme.x, 0.0) * EARTH_ROTATION_RAD_S;
        ObserverState {
            position: self.position(orientation),
            velocity: orientation.teme_to_gcrs * Velocity::from_vector(turn),
            horizon: self.horizon * orientation.itrs_to_gcrs.inverse(),
        }
    }

    /// Returns the altitude of the Sun's centre, radians, without refraction. Both tables have the same reference.
    pub(crate) fn sun_altitude_rad(&self, orientation: &OrientationTable, sun: &SunTable, seconds: f64) -> f64 {
        let state = self.state(&orientation.at_s(seconds));
        state.sine_of_altitude(&(sun.at_s(seconds).sun - state.position)).clamp(-1.0, 1.0).asin()
    }
}

impl ObserverState {
    /// Returns the altitude and azimuth (from north through east, [0, 2π)) of a position relative to the observer,
    /// radians, without refraction; `None` for the position of the observer.
    pub fn altitude_azimuth_rad(&self, geometric: &Position<Gcrs>) -> Option<(f64, f64)> {
        let direction = (self.horizon * *geometric).direction()?;
        Some((direction.latitude_rad(), direction.longitude_rad()))
    }

    /// Returns the altitude and azimuth of the Sun's centre, as [`altitude_azimuth_rad`](Self::altitude_azimuth_rad),
    /// without aberration (20"); `None` outside the years 1900 to 2100.
    pub fn sun_altitude_azimuth_rad(&self, moment: Epoch) -> Option<(f64, f64)> {
        let seen = self.altitude_azimuth_rad(&(SunState::at(moment).sun - self.position));
        seen.filter(|(altitude, _)| altitude.is_finite())
    }

    /// Returns the sine of the altitude, for tests without inverse functions; NaN for the position of the observer.
    pub fn sine_of_altitude(&self, geometric: &Position<Gcrs>) -> f64 {
        (self.horizon.matrix() * geometric.vector()).z / geometric.norm_km()
    }
}
