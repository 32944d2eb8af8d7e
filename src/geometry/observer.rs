//! A site that turns with the Earth.

use hifitime::Epoch;
use nalgebra::Vector3;

use super::site::Site;
use super::sun::SunState;
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::frames::{Gcrs, Horizontal, Itrs, Orientation, Position, Rotation, Velocity};

/// A site with what is needed to stand it among the stars, computed once.
#[derive(Clone, Debug, PartialEq)]
pub struct Observer {
    site: Site,
    itrs: Position<Itrs>,
    horizon: Rotation<Itrs, Horizontal>,
}

/// An observer at one moment.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ObserverState {
    /// Geocentric place, km.
    pub position: Position<Gcrs>,
    /// Geocentric velocity, km/s: the Earth's rotation, at most 0.465.
    pub velocity: Velocity<Gcrs>,
    /// From the celestial axes to north, east, zenith.
    pub horizon: Rotation<Gcrs, Horizontal>,
}

impl Observer {
    /// An observer at a site.
    pub fn new(site: Site) -> Self {
        let (itrs, horizon) = (site.itrs(), site.horizon());
        Self { site, itrs, horizon }
    }

    /// The site.
    pub fn site(&self) -> &Site {
        &self.site
    }

    /// Earth-fixed place, km.
    pub fn itrs(&self) -> Position<Itrs> {
        self.itrs
    }

    /// The place among the stars, nothing more: the cheapest of the three.
    pub fn position(&self, orientation: &Orientation) -> Position<Gcrs> {
        orientation.itrs_to_gcrs * self.itrs
    }

    /// Place, velocity and horizon among the stars.
    ///
    /// The velocity is ω × r about the pole of date; the length of day (10⁻⁸) and the pole's own motion are left out: below 0.01 mm/s.
    pub fn state(&self, orientation: &Orientation) -> ObserverState {
        let in_teme = (orientation.itrs_to_teme * self.itrs).vector().to_owned();
        let turn = Vector3::new(-in_teme.y, in_teme.x, 0.0) * EARTH_ROTATION_RAD_S;
        ObserverState {
            position: self.position(orientation),
            velocity: orientation.teme_to_gcrs * Velocity::from_vector(turn),
            horizon: self.horizon * orientation.itrs_to_gcrs.inverse(),
        }
    }
}

impl ObserverState {
    /// Altitude and azimuth (from north through east, [0, 2π)) of what stands at `geometric` from the observer, radians, without refraction.
    ///
    /// `None` for the observer's own place.
    pub fn altitude_azimuth_rad(&self, geometric: &Position<Gcrs>) -> Option<(f64, f64)> {
        let direction = (self.horizon * *geometric).direction()?;
        Some((direction.latitude_rad(), direction.longitude_rad()))
    }

    /// Altitude and azimuth of the Sun's centre, as of [`altitude_azimuth_rad`](Self::altitude_azimuth_rad), without aberration (20"); `None` outside the years
    /// 1900 to 2100.
    pub fn sun_altitude_azimuth_rad(&self, moment: Epoch) -> Option<(f64, f64)> {
        let seen = self.altitude_azimuth_rad(&(SunState::at(moment).sun - self.position));
        seen.filter(|(altitude, _)| altitude.is_finite())
    }

    /// Sine of the altitude: the test "above the horizon" without inverse functions. Not a number for the observer's own place.
    pub fn sine_of_altitude(&self, geometric: &Position<Gcrs>) -> f64 {
        (self.horizon.matrix() * geometric.vector()).z / geometric.norm_km()
    }
}
