//! Where Sun and observer stand in a satellite's own sky: all that the photometry ever sees.
//!
//! The body frame of Lu (2024), section 2.2: origin at the chassis, **z** to the satellite's zenith, **x** in the plane
//! of the chassis so that the Sun lies in the zx half plane with x > 0 (the Sun's longitude is 0 by construction),
//! **y** = z × x. Latitudes are positive above the chassis plane, so an observer on the ground has a negative one.
//! The vectors are geocentric celestial (GCRS) and geometric: light time moves a satellite by 20 m, which is nothing here.
//!
//! The paper takes angles with `arccos`, which loses half the digits near 0 and π (an observer straight below, the Sun on
//! the horizon of the zx plane); here every angle is an `atan2` of components, exact everywhere.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use crate::constants::{AU_KM, EARTH_EQUATORIAL_RADIUS_KM};
use crate::frames::{Body, Direction, Gcrs, Position};

/// The directions of Sun and observer from a satellite, and the distances that light travels.
///
/// Below, δ is a latitude above the chassis plane, α a longitude from the Sun's.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ViewingGeometry {
    /// δ of the Sun, [-π/2, π/2], radians; negative where it stands below the chassis plane.
    pub sun_latitude_rad: f64,
    /// α of the observer, [0, 2π), radians; 0 towards the Sun, growing right-handed about the zenith.
    pub observer_longitude_rad: f64,
    /// δ of the observer, [-π/2, π/2], radians; -π/2 straight below.
    pub observer_latitude_rad: f64,
    /// Satellite to observer, km.
    pub range_km: f64,
    /// Distance from the Earth's centre less 6378.137 km.
    pub height_km: f64,
    /// Satellite to Sun, au.
    pub sun_distance_au: f64,
}

impl ViewingGeometry {
    /// From the geocentric positions of the three.
    ///
    /// With the observer straight below or above, or the Sun in the zenith or nadir, the longitude has no meaning and is 0.
    /// `None` where a component is not finite, where the satellite stands at the Earth's centre, or where Sun or
    /// observer coincide with it.
    pub fn new(satellite: &Position<Gcrs>, observer: &Position<Gcrs>, sun: &Position<Gcrs>) -> Option<Self> {
        let to_sun = sun.vector() - satellite.vector();
        let to_observer = observer.vector() - satellite.vector();
        let radius_km = satellite.norm_km();
        let range_km = to_observer.norm();
        let sun_distance_km = to_sun.norm();
        let reachable = |distance: f64| distance > 0.0 && distance.is_finite();
        if !(reachable(radius_km) && reachable(range_km) && reachable(sun_distance_km)) {
            return None;
        }
        // r_z = R_sat / |R_sat|                                            Lu (2024), eq. 10
        let zenith = satellite.vector() / radius_km;
        let sun_up = zenith.dot(&to_sun);
        let observer_up = zenith.dot(&to_observer);
        // r_z × r lies in the chassis plane, a quarter turn ahead of r's own projection: angles between two such are longitudes.
        let sun_across = zenith.cross(&to_sun);
        let observer_across = zenith.cross(&to_observer);
        // δ = π/2 - Ang(r_z, r)                                            Lu (2024), eqs. 11, 12
        let sun_latitude_rad = sun_up.atan2(sun_across.norm());
        let observer_latitude_rad = observer_up.atan2(observer_across.norm());
        // α = Ang(r_z × r_sun, r_z × r_obs), past π where (r_sun × r_obs) · r_z < 0   Lu (2024), eq. 13
        let along = sun_across.dot(&observer_across);
        let ahead = zenith.dot(&sun_across.cross(&observer_across));
        Some(Self {
            sun_latitude_rad,
            observer_longitude_rad: turn(ahead.atan2(along)),
            observer_latitude_rad,
            range_km,
            height_km: radius_km - EARTH_EQUATORIAL_RADIUS_KM,
            sun_distance_au: sun_distance_km / AU_KM,
        })
    }

    /// From angles directly, the Sun at 1 au: for maps, fits and tests.
    ///
    /// The longitude may be any angle and is brought to [0, 2π). `None` where an angle or length is not finite, a
    /// latitude lies beyond ±π/2, or the range is not positive.
    pub fn from_angles(
        sun_latitude_rad: f64,
        observer_longitude_rad: f64,
        observer_latitude_rad: f64,
        range_km: f64,
        height_km: f64,
    ) -> Option<Self> {
        let latitude = |angle: f64| (-FRAC_PI_2..=FRAC_PI_2).contains(&angle);
        let sound = latitude(sun_latitude_rad)
            && latitude(observer_latitude_rad)
            && observer_longitude_rad.is_finite()
            && range_km > 0.0
            && range_km.is_finite()
            && height_km > -EARTH_EQUATORIAL_RADIUS_KM
            && height_km.is_finite();
        sound.then(|| Self {
            sun_latitude_rad,
            observer_longitude_rad: turn(observer_longitude_rad),
            observer_latitude_rad,
            range_km,
            height_km,
            sun_distance_au: 1.0,
        })
    }

    /// Unit vector from the satellite to the Sun; its y is 0.
    pub fn to_sun(&self) -> Direction<Body> {
        let (up, towards) = self.sun_latitude_rad.sin_cos();
        Direction::from_vector(Vector3::new(towards, 0.0, up))
    }

    /// Unit vector from the satellite to the observer.
    pub fn to_observer(&self) -> Direction<Body> {
        Direction::from_lon_lat_rad(self.observer_longitude_rad, self.observer_latitude_rad)
    }

    /// Angle Sun-satellite-observer in [0, π], radians; 0 where the observer stands before the Sun and sees a full disk.
    pub fn phase_angle_rad(&self) -> f64 {
        self.to_sun().separation_rad(&self.to_observer())
    }

    /// The same geometry with the observer's longitude folded to [0, π]: satellites here are symmetric about the zx plane.
    pub fn folded(&self) -> Self {
        let longitude = self.observer_longitude_rad;
        Self { observer_longitude_rad: if longitude > PI { TAU - longitude } else { longitude }, ..*self }
    }

    /// Altitude of the satellite above the plane through the observer square to its radius, radians.
    ///
    /// Follows from the triangle Earth's centre, observer, satellite; it differs from the altitude above a site's horizon by
    /// the deflection of the radius from the normal, 0.19° at most. `None` where the triangle does not close
    /// (angles given that reach no point off the Earth's centre).
    pub fn geocentric_altitude_rad(&self) -> Option<f64> {
        let radius_km = self.height_km + EARTH_EQUATORIAL_RADIUS_KM;
        let (up, across) = self.observer_latitude_rad.sin_cos();
        // Observer in the plane of the triangle, along and across the satellite's radius.
        let (along_km, across_km) = (radius_km + self.range_km * up, self.range_km * across);
        let observer_km = along_km.hypot(across_km);
        // Satellite minus observer, resolved along the observer's own radius.
        let rise = -self.range_km * (up * along_km + across * across_km);
        let level = self.range_km * (up * across_km - across * along_km).abs();
        (observer_km > 0.0).then(|| rise.atan2(level))
    }
}

/// An angle brought to [0, 2π).
fn turn(angle_rad: f64) -> f64 {
    let angle = angle_rad.rem_euclid(TAU);
    // rem_euclid of a tiny negative number rounds to 2π itself.
    if angle >= TAU { 0.0 } else { angle }
}
