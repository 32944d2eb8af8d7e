//! Directions of the Sun and the observer in the frame of a satellite: the input of the photometry.
//!
//! The body frame of Lu (2024), section 2.2: origin at the chassis, **z** to the satellite's zenith, **x** in the plane
//! of the chassis so that the Sun lies in the zx half plane with x > 0 (the Sun's longitude is 0 by construction),
//! **y** = z × x. Latitudes are positive above the chassis plane, so an observer on the ground has a negative one. The
//! vectors are geocentric celestial (GCRS) and geometric: light time moves a satellite by some 20 m, which is
//! negligible here.
//!
//! The paper computes angles with `arccos`, which loses half of the digits near 0 and π (an observer straight below, or
//! the Sun in the horizon of the satellite's body frame). Here every angle is an `atan2` of components, which is
//! accurate for all angles.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Matrix3, Vector3};

use crate::constants::{AU_KM, EARTH_EQUATORIAL_RADIUS_KM};
use crate::frames::{Body, Direction, Gcrs, Position, Rotation};

/// Directions of the Sun and the observer from a satellite, and their distances.
///
/// δ is the latitude above the chassis plane, and α the longitude measured from the Sun.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ViewingGeometry {
    /// Latitude δ of the Sun, [-π/2, π/2], radians; negative below the chassis plane.
    pub sun_latitude_rad: f64,
    /// Longitude α of the observer, [0, 2π), radians; 0 towards the Sun, increasing right-handed about the zenith.
    pub observer_longitude_rad: f64,
    /// Latitude δ of the observer, [-π/2, π/2], radians; -π/2 for an observer straight below the satellite.
    pub observer_latitude_rad: f64,
    /// Distance from the satellite to the observer, km.
    pub range_km: f64,
    /// Distance of the satellite from the Earth's centre minus 6378.137 km, km.
    pub height_km: f64,
    /// Distance from the satellite to the Sun, au.
    pub sun_distance_au: f64,
}

impl ViewingGeometry {
    /// Computes the geometry from the three geocentric positions.
    ///
    /// With the observer straight below or above, or the Sun in the zenith or nadir, the longitude is undefined and set
    /// to 0. `None` where a component is not finite, where the satellite is at the Earth's centre, or where the Sun or
    /// the observer coincides with the satellite.
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
        // r_z = R_sat / |R_sat|                                            Lu (2024), eq. 9
        let zenith = satellite.vector() / radius_km;
        let sun_up = zenith.dot(&to_sun);
        let observer_up = zenith.dot(&to_observer);
        // r_z × r lies in the chassis plane, 90° ahead of the projection of r. The angle between two such vectors is
        // therefore a difference of longitudes.
        let sun_across = zenith.cross(&to_sun);
        let observer_across = zenith.cross(&to_observer);
        // δ = π/2 - Ang(r_z, r)                                            Lu (2024), eqs. 10, 11
        let sun_latitude_rad = sun_up.atan2(sun_across.norm());
        let observer_latitude_rad = observer_up.atan2(observer_across.norm());
        // α = Ang(r_z × r_sun, r_z × r_obs), past π where (r_sun × r_obs) · r_z < 0   Lu (2024), eq. 12
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

    /// Creates a geometry from angles, with the Sun at 1 au. It is used for maps, fits and tests.
    ///
    /// The longitude may be any angle and is reduced to [0, 2π). `None` where an angle or length is not finite, a
    /// latitude is beyond ±π/2, or the range is not positive.
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

    /// Returns the unit vector from the satellite to the Sun; its y component is 0.
    pub fn to_sun(&self) -> Direction<Body> {
        let (up, towards) = self.sun_latitude_rad.sin_cos();
        Direction::from_vector(Vector3::new(towards, 0.0, up))
    }

    /// Returns the unit vector from the satellite to the observer.
    pub fn to_observer(&self) -> Direction<Body> {
        Direction::from_lon_lat_rad(self.observer_longitude_rad, self.observer_latitude_rad)
    }

    /// Returns the angle Sun-satellite-observer in [0, π], radians; 0 for an observer in the direction of the Sun (full
    /// phase).
    pub fn phase_angle_rad(&self) -> f64 {
        self.to_sun().separation_rad(&self.to_observer())
    }

    /// Returns the angle satellite-observer-Sun in [0, π], radians.
    pub fn sun_angle_rad(&self) -> f64 {
        // The observer is at r u with the unit vector u from the satellite, the Sun at d s.
        let sun = self.to_sun().vector() * (self.sun_distance_au * AU_KM);
        let observer = self.to_observer().vector() * self.range_km;
        let (to_sun, to_satellite) = (sun - observer, -observer);
        to_satellite.cross(&to_sun).norm().atan2(to_satellite.dot(&to_sun))
    }

    /// Returns the same geometry with the observer's longitude folded to [0, π]: the satellite models are symmetric
    /// about the zx plane.
    pub fn folded(&self) -> Self {
        let longitude = self.observer_longitude_rad;
        Self { observer_longitude_rad: if longitude > PI { TAU - longitude } else { longitude }, ..*self }
    }

    /// Returns the altitude of the satellite above the plane that contains the observer and is perpendicular to the
    /// observer's geocentric radius, radians.
    ///
    /// It follows from the triangle of Earth's centre, observer and satellite. It differs from the altitude above a
    /// site's horizon by at most 0.19°, the angle between the radius and the normal of the ellipsoid. `None` for an
    /// observer at the Earth's centre.
    pub fn geocentric_altitude_rad(&self) -> Option<f64> {
        let radius_km = self.height_km + EARTH_EQUATORIAL_RADIUS_KM;
        let (up, across) = self.observer_latitude_rad.sin_cos();
        // Components of the observer's position in the plane of the triangle, along and across the satellite's radius.
        let (along_km, across_km) = (radius_km + self.range_km * up, self.range_km * across);
        let observer_km = along_km.hypot(across_km);
        // Components of the vector from observer to satellite, along and across the observer's radius.
        let rise = -self.range_km * (up * along_km + across * across_km);
        let level = self.range_km * (up * across_km - across * along_km).abs();
        (observer_km > 0.0).then(|| rise.atan2(level))
    }
}

/// Returns the rotation from the body frame of a satellite to GCRS, from geocentric positions.
///
/// With the Sun in the zenith or nadir, x is any direction in the plane of the chassis. `None` where a component is not
/// finite, where the satellite is at the Earth's centre, or where the Sun coincides with the satellite.
pub fn body_to_gcrs(satellite: &Position<Gcrs>, sun: &Position<Gcrs>) -> Option<Rotation<Body, Gcrs>> {
    let zenith = satellite.direction()?;
    let to_sun = (*sun - *satellite).direction()?;
    let zenith = zenith.vector();
    // An axis that is not parallel to the zenith.
    let other = || if zenith.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let y = zenith.cross(to_sun.vector()).try_normalize(0.0).unwrap_or_else(|| zenith.cross(&other()).normalize());
    Some(Rotation::from_matrix(Matrix3::from_columns(&[y.cross(zenith), y, *zenith])))
}

/// Reduces an angle to [0, 2π).
fn turn(angle_rad: f64) -> f64 {
    let angle = angle_rad.rem_euclid(TAU);
    // rem_euclid of a tiny negative number rounds to 2π itself.
    if angle >= TAU { 0.0 } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Tolerance of angles, radians: rounding of positions of 1.5e8 km and of a few operations.
    const ROUNDING_RAD: f64 = 1e-12;

    fn unit(longitude: f64, latitude: f64) -> Vector3<f64> {
        *Direction::<Body>::from_lon_lat_rad(longitude, latitude).vector()
    }

    /// Returns GCRS positions of satellite, observer and Sun with these body-frame angles, for a body rotated by any
    /// angle.
    fn placed(g: &ViewingGeometry, axis: Vector3<f64>, turn: f64) -> [Position<Gcrs>; 3] {
        let body = nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), turn);
        let satellite = body * Vector3::z() * (EARTH_EQUATORIAL_RADIUS_KM + g.height_km);
        let observer = satellite + body * unit(g.observer_longitude_rad, g.observer_latitude_rad) * g.range_km;
        let sun = satellite + body * unit(0.0, g.sun_latitude_rad) * (AU_KM * g.sun_distance_au);
        [satellite, observer, sun].map(Position::from_vector)
    }

    fn turned_apart(a: f64, b: f64) -> f64 {
        (a - b + PI).rem_euclid(TAU) - PI
    }

    proptest! {
        #[test]
        fn verif_angles_go_to_vectors_and_back(
            sun_latitude_rad in -1.5..1.5, longitude in 0.0..TAU, observer_latitude_rad in -1.5..1.5,
            range_km in 200.0..4000.0, height_km in 200.0..2000.0, sun_distance_au in 0.983..1.017,
            axis in prop::array::uniform3(-1.0..1.0f64), turn in 0.0..TAU,
        ) {
            let axis = Vector3::from(axis);
            prop_assume!(axis.norm() > 0.1);
            let g = ViewingGeometry {
                sun_latitude_rad,
                observer_longitude_rad: longitude,
                observer_latitude_rad,
                range_km,
                height_km,
                sun_distance_au,
            };
            let [satellite, observer, sun] = placed(&g, axis, turn);
            let back = ViewingGeometry::new(&satellite, &observer, &sun).unwrap();
            prop_assert!((back.sun_latitude_rad - sun_latitude_rad).abs() < ROUNDING_RAD);
            prop_assert!((back.observer_latitude_rad - observer_latitude_rad).abs() < ROUNDING_RAD);
            // Near the zenith a longitude difference is weighted by cos δ.
            let across = turned_apart(back.observer_longitude_rad, longitude)
                * observer_latitude_rad.cos().min(sun_latitude_rad.cos());
            prop_assert!(across.abs() < ROUNDING_RAD, "{across}");
            prop_assert!((back.range_km - range_km).abs() < 1e-9 && (back.height_km - height_km).abs() < 1e-9);
            prop_assert!((back.sun_distance_au - sun_distance_au).abs() < 1e-12);
            let at_observer = (satellite.vector() - observer.vector()).angle_atan2(&(sun.vector() - observer.vector()));
            prop_assert!((back.sun_angle_rad() - at_observer).abs() < ROUNDING_RAD);
            // The phase angle of the angles equals that of the vectors.
            let phase = (observer.vector() - satellite.vector()).angle_atan2(&(sun.vector() - satellite.vector()));
            prop_assert!((back.phase_angle_rad() - phase).abs() < ROUNDING_RAD);
        }
    }

    trait AngleAtan2 {
        fn angle_atan2(&self, other: &Self) -> f64;
    }
    impl AngleAtan2 for Vector3<f64> {
        // Kahan's formula: no cross product, independent of the code above.
        fn angle_atan2(&self, other: &Self) -> f64 {
            let (a, b) = (self.normalize(), other.normalize());
            2.0 * (a - b).norm().atan2((a + b).norm())
        }
    }

    #[test]
    fn verif_sign_of_the_longitude_follows_the_papers_rule() {
        // Satellite on x, Sun towards y: body z = x, x = y, y = z. An observer towards +z of GCRS has α < π.
        let satellite = Position::new(7000.0, 0.0, 0.0);
        let sun = Position::new(7000.0, AU_KM, 0.0);
        for (z, expected) in [(500.0, FRAC_PI_2), (-500.0, 1.5 * PI)] {
            let g = ViewingGeometry::new(&satellite, &Position::new(6500.0, 0.0, z), &sun).unwrap();
            assert!((g.observer_longitude_rad - expected).abs() < ROUNDING_RAD);
            assert!((g.observer_latitude_rad + std::f64::consts::FRAC_PI_4).abs() < ROUNDING_RAD);
            assert!(g.sun_latitude_rad.abs() < ROUNDING_RAD);
            assert!((g.folded().observer_longitude_rad - FRAC_PI_2).abs() < ROUNDING_RAD);
        }
    }

    #[test]
    fn verif_observer_straight_below_and_nearly_so() {
        let satellite = Position::new(0.0, 0.0, 6928.137);
        let sun = Position::new(AU_KM, 0.0, 0.0);
        let below = ViewingGeometry::new(&satellite, &Position::new(0.0, 0.0, 6378.137), &sun).unwrap();
        assert_eq!(below.observer_latitude_rad, -FRAC_PI_2);
        assert_eq!(below.observer_longitude_rad, 0.0);
        assert_eq!(below.height_km, 550.0);
        // A millimetre to the side is 1.8 nrad, which arccos cannot resolve.
        let aside = ViewingGeometry::new(&satellite, &Position::new(0.0, 1e-6, 6378.137), &sun).unwrap();
        assert!((aside.observer_latitude_rad + FRAC_PI_2 - 1e-6 / 550.0).abs() < 1e-15);
        assert!((aside.observer_longitude_rad - FRAC_PI_2).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn verif_body_frame_has_the_axes_of_the_angles(
            satellite in prop::array::uniform3(-9000.0..9000.0f64), sun in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let (satellite, sun) = (Vector3::from(satellite), Vector3::from(sun) * AU_KM);
            prop_assume!(satellite.norm() > 1000.0 && sun.norm() > 0.1 * AU_KM);
            let observer = Position::from_vector(satellite * 0.9 + Vector3::new(100.0, -200.0, 300.0));
            let [satellite, sun] = [satellite, sun].map(Position::from_vector);
            let geometry = ViewingGeometry::new(&satellite, &observer, &sun).unwrap();
            let to_gcrs = body_to_gcrs(&satellite, &sun).unwrap();
            for (body, target) in [(geometry.to_sun(), sun), (geometry.to_observer(), observer)] {
                let expected = (target - satellite).direction().unwrap();
                prop_assert!(((to_gcrs * body).vector() - expected.vector()).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn verif_body_frame_with_the_sun_in_the_zenith_is_a_rotation() {
        for (satellite, sun) in [
            (Position::new(7000.0, 0.0, 0.0), Position::new(AU_KM, 0.0, 0.0)),
            (Position::new(0.0, 0.0, 7000.0), Position::new(0.0, 0.0, -AU_KM)),
        ] {
            let matrix = *body_to_gcrs(&satellite, &sun).unwrap().matrix();
            assert!((matrix * matrix.transpose() - Matrix3::identity()).norm() < 1e-15);
            assert!((matrix.determinant() - 1.0).abs() < 1e-15);
        }
        assert!(body_to_gcrs(&Position::new(0.0, 0.0, 0.0), &Position::new(AU_KM, 0.0, 0.0)).is_none());
    }

    #[test]
    fn verif_sun_in_the_zenith_has_no_azimuth_but_a_result() {
        let satellite = Position::new(7000.0, 0.0, 0.0);
        let sun = Position::new(AU_KM, 0.0, 0.0);
        let g = ViewingGeometry::new(&satellite, &Position::new(6378.0, 100.0, 0.0), &sun).unwrap();
        assert_eq!(g.sun_latitude_rad, FRAC_PI_2);
        assert_eq!(g.observer_longitude_rad, 0.0);
    }

    #[test]
    fn verif_invalid_geometries_are_rejected() {
        let (satellite, observer) = (Position::new(7000.0, 0.0, 0.0), Position::new(6378.0, 0.0, 0.0));
        let sun = Position::new(0.0, AU_KM, 0.0);
        let (origin, nan) = (Position::new(0.0, 0.0, 0.0), Position::new(f64::NAN, 0.0, 0.0));
        assert!(ViewingGeometry::new(&satellite, &observer, &sun).is_some());
        for [a, b, c] in [
            [origin, observer, sun],
            [satellite, satellite, sun],
            [satellite, observer, satellite],
            [nan, observer, sun],
            [satellite, nan, sun],
            [satellite, observer, nan],
        ] {
            assert_eq!(ViewingGeometry::new(&a, &b, &c), None);
        }
        assert!(ViewingGeometry::from_angles(-0.2, -1.0, -0.9, 700.0, 550.0).unwrap().observer_longitude_rad > 5.0);
        for (sun, longitude, observer, range, height) in [
            (2.0, 0.0, 0.0, 700.0, 550.0),
            (0.0, f64::INFINITY, 0.0, 700.0, 550.0),
            (0.0, 0.0, -1.6, 700.0, 550.0),
            (0.0, 0.0, 0.0, 0.0, 550.0),
            (0.0, 0.0, 0.0, 700.0, f64::NAN),
        ] {
            assert_eq!(ViewingGeometry::from_angles(sun, longitude, observer, range, height), None);
        }
    }

    #[test]
    fn valid_geocentric_altitude_on_a_sphere() {
        // Site at latitude 0 on a sphere, satellite 550 km up, 10° along the equator.
        let (site_km, sat_km) = (6378.137, 6928.137);
        let (sin, cos) = 10_f64.to_radians().sin_cos();
        let satellite = Position::new(sat_km * cos, sat_km * sin, 0.0);
        let g = ViewingGeometry::new(&satellite, &Position::new(site_km, 0.0, 0.0), &Position::new(0.0, 0.0, AU_KM));
        let expected = ((sat_km * cos - site_km) / (sat_km * sin)).atan();
        assert!((g.unwrap().geocentric_altitude_rad().unwrap() - expected).abs() < ROUNDING_RAD);
    }
}
