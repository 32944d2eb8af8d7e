//! Rotations from Earth-fixed axes to the horizon and from ICRS to the equator and equinox of date, and annual
//! aberration.

use hifitime::Epoch;
use nalgebra::{Matrix3, Vector3};

use super::orientation::matrix;
use super::time::tt_jd;
use super::vector::{Direction, Gcrs, Horizontal, Itrs, OfDate, Rotation, Velocity};
use crate::constants::SPEED_OF_LIGHT_KM_S;

/// Returns the rotation from Earth-fixed axes to north, east and zenith at an east longitude and a geodetic latitude,
/// radians.
///
/// The zenith is the normal of the ellipsoid; the deflection of the vertical (up to an arcminute in mountains) is
/// neglected.
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

/// Returns the rotation from ICRS to the true equator and equinox of date, IAU 2006/2000A (routine pnm06a of SOFA).
pub fn gcrs_to_of_date(epoch: Epoch) -> Rotation<Gcrs, OfDate> {
    let (day, fraction) = tt_jd(epoch);
    Rotation::from_matrix(matrix(&sofars::pnp::pnm06a(day, fraction)))
}

/// Returns the direction in which an observer with the barycentric velocity `observer` sees an object in the
/// astrometric `direction`.
///
/// With β = v/c:  p' = (p/γ + β (1 + p·β/(1 + 1/γ))) / (1 + p·β). SOFA's routine ab, without the term of the Sun's
/// potential (0.4 µas).
pub fn annual_aberration(direction: &Direction<Gcrs>, observer: &Velocity<Gcrs>) -> Direction<Gcrs> {
    let beta = observer.vector() / SPEED_OF_LIGHT_KM_S;
    aberrated(direction, &beta)
}

/// Returns the inverse of [`annual_aberration`].
pub fn without_annual_aberration(direction: &Direction<Gcrs>, observer: &Velocity<Gcrs>) -> Direction<Gcrs> {
    let beta = -observer.vector() / SPEED_OF_LIGHT_KM_S;
    aberrated(direction, &beta)
}

fn aberrated(direction: &Direction<Gcrs>, beta: &Vector3<f64>) -> Direction<Gcrs> {
    let p = direction.vector();
    let inverse_gamma = (1.0 - beta.norm_squared()).sqrt();
    let along = p.dot(beta);
    let seen = p * inverse_gamma + beta * (1.0 + along / (1.0 + inverse_gamma));
    Direction::from_vector(seen.normalize())
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn celestial_pole_is_north_at_the_altitude_of_the_latitude() {
        let horizon = itrs_to_horizontal(1.0, 0.6);
        let pole = horizon * Direction::<Itrs>::from_lon_lat_rad(0.0, std::f64::consts::FRAC_PI_2);
        assert!((pole.latitude_rad() - 0.6).abs() < 1e-15);
        assert!(pole.longitude_rad().sin().abs() < 1e-15 && pole.longitude_rad().cos() > 0.0);
        let east = horizon * Direction::<Itrs>::from_lon_lat_rad(1.0 + std::f64::consts::FRAC_PI_2, 0.0);
        assert!((east.longitude_rad() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!(east.latitude_rad().abs() < 1e-15);
    }

    #[test]
    fn aberration_is_twenty_arcseconds_and_returns() {
        let star = Direction::<Gcrs>::from_lon_lat_rad(1.0, 0.4);
        let velocity = Velocity::<Gcrs>::new(-20.0, 20.0, 8.0);
        let seen = annual_aberration(&star, &velocity);
        let shift_arcsec = seen.separation_rad(&star).to_degrees() * 3600.0;
        // sin of the angle between star and velocity times v/c.
        let expected = star.vector().cross(velocity.vector()).norm() / SPEED_OF_LIGHT_KM_S;
        assert!((shift_arcsec - expected.to_degrees() * 3600.0).abs() < 2e-3, "{shift_arcsec}");
        assert!(
            seen.cosine(&Direction::from_vector(velocity.vector().normalize()))
                > star.cosine(&Direction::from_vector(velocity.vector().normalize()))
        );
        // The velocity composition is exactly undone by the opposite velocity.
        assert!(without_annual_aberration(&seen, &velocity).separation_rad(&star) < 1e-15);
    }
}
