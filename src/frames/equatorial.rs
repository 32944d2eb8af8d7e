//! Between the fixed axes of ICRS and the true equator and equinox of a date.
//!
//! Places among catalogue stars are given in ICRS everywhere in this library. Telescope mounts, old catalogues and some almanacs want the
//! equator and equinox *of date*; that is this rotation and nothing else: aberration is a matter of the direction itself, see
//! [`annual_aberration`].

use hifitime::Epoch;
use nalgebra::Vector3;

use super::frame::{Gcrs, OfDate};
use super::orientation::matrix;
use super::time::tt_jd;
use super::vector::{Direction, Rotation, Velocity};
use crate::constants::SPEED_OF_LIGHT_KM_S;

/// From the axes of ICRS to the true equator and equinox of date, IAU 2006/2000A (SOFA pnm06a).
pub fn gcrs_to_of_date(epoch: Epoch) -> Rotation<Gcrs, OfDate> {
    let (day, fraction) = tt_jd(epoch);
    Rotation::from_matrix(matrix(&sofars::pnp::pnm06a(day, fraction)))
}

/// Where a thing in `direction` (astrometric, as a barycentric observer sees it) appears to an observer of velocity `observer` against the barycentre.
///
/// With β = v/c:  p' = (p/γ + β (1 + p·β/(1 + 1/γ))) / (1 + p·β)        (SOFA ab, without the Sun's potential: 0.4 µas)
pub fn annual_aberration(direction: &Direction<Gcrs>, observer: &Velocity<Gcrs>) -> Direction<Gcrs> {
    let beta = observer.vector() / SPEED_OF_LIGHT_KM_S;
    aberrated(direction, &beta)
}

/// The way back from [`annual_aberration`].
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
