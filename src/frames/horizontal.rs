//! The horizon of a place on the ellipsoid.

use nalgebra::Matrix3;

use super::frame::{Horizontal, Itrs};
use super::vector::Rotation;

/// From Earth-fixed axes to north, east, zenith of a place with the given east longitude and geodetic latitude, radians.
///
/// The zenith is the normal of the ellipsoid; the deflection of the vertical (up to a minute of arc in mountains) is not in it.
pub fn itrs_to_horizontal(longitude_rad: f64, latitude_rad: f64) -> Rotation<Itrs, Horizontal> {
    let (sin_lon, cos_lon) = longitude_rad.sin_cos();
    let (sin_lat, cos_lat) = latitude_rad.sin_cos();
    Rotation::from_matrix(Matrix3::new(
        -sin_lat * cos_lon,
        -sin_lat * sin_lon,
        cos_lat, // north
        -sin_lon,
        cos_lon,
        0.0, // east
        cos_lat * cos_lon,
        cos_lat * sin_lon,
        sin_lat, // zenith
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Direction;

    #[test]
    fn pole_star_stands_in_the_north_at_the_latitude() {
        let horizon = itrs_to_horizontal(1.0, 0.6);
        let pole = horizon * Direction::<Itrs>::from_lon_lat_rad(0.0, std::f64::consts::FRAC_PI_2);
        assert!((pole.latitude_rad() - 0.6).abs() < 1e-15);
        assert!(pole.longitude_rad().sin().abs() < 1e-15 && pole.longitude_rad().cos() > 0.0);
        let east = horizon * Direction::<Itrs>::from_lon_lat_rad(1.0 + std::f64::consts::FRAC_PI_2, 0.0);
        assert!((east.longitude_rad() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!(east.latitude_rad().abs() < 1e-15);
    }
}
