//! The direction in which a satellite stands among catalogue stars.
//!
//! A calibrated image puts stars at their ICRS places: the observer's motion (20" of annual aberration) is already taken out. The
//! satellite's direction comparable to that is its place when the light left it, less the observer's place when the light came, both against the
//! barycentre of the solar system, in which the Earth moves on while the light is on its way:
//!
//! r = r_sat - r_site - (v_sat + v_Earth) τ,   τ = |r_sat - r_site| / c
//!
//! This holds for an observer in space too: r_site is then the telescope's own place. The telescope's velocity does not enter. Its image is aberrated by
//! v_Earth + v_telescope (25" for a low orbit), stars and satellite by the same angle, and a plate solution by stars takes all of it out; what is left is
//! where the light set out from and where it arrived.
//!
//! Measured against JPL Horizons' astrometric rows for Starlink satellites: 0.15" median. A purely geometric direction is 20" off.

use crate::constants::SPEED_OF_LIGHT_KM_S;
use crate::frames::{Direction, Gcrs, Position, Velocity};

/// How an observer sees a satellite.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Aspect {
    /// ICRS astrometric topocentric direction.
    pub direction: Direction<Gcrs>,
    /// From the observer to the satellite, both at the moment of reception, km. Its direction against the horizon is altitude and azimuth.
    pub geometric: Position<Gcrs>,
    /// Length of `geometric`, km.
    pub range_km: f64,
}

/// The aspect of a satellite at the moment of reception: geocentric places, the satellite's geocentric velocity, and the Earth's barycentric one.
///
/// The light time is taken from the distance at reception: 3 mm at 1000 km, 40 mm in the geostationary ring, below 10⁻⁸ rad for both.
/// At the observer's very place the direction is not a number.
pub fn aspect(
    satellite: &Position<Gcrs>,
    satellite_velocity: &Velocity<Gcrs>,
    observer: &Position<Gcrs>,
    earth_velocity: &Velocity<Gcrs>,
) -> Aspect {
    let geometric = *satellite - *observer;
    let range_km = geometric.norm_km();
    let light_time_s = range_km / SPEED_OF_LIGHT_KM_S;
    let seen = geometric - (*satellite_velocity + *earth_velocity).displacement(light_time_s);
    Aspect { direction: Direction::from_vector(seen.vector() / seen.norm_km()), geometric, range_km }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_time_and_the_earths_way() {
        let satellite = Position::<Gcrs>::new(7000.0, 0.0, 0.0);
        let observer = Position::<Gcrs>::new(6400.0, 0.0, 0.0);
        let still = Velocity::<Gcrs>::new(0.0, 0.0, 0.0);
        let plain = aspect(&satellite, &still, &observer, &still);
        assert_eq!(plain.range_km, 600.0);
        assert_eq!(plain.direction, Direction::from_lon_lat_rad(0.0, 0.0));
        // The satellite was behind: a motion to +y moves the image to -y by v/c.
        let moving = aspect(&satellite, &Velocity::new(0.0, 7.5, 0.0), &observer, &Velocity::new(0.0, 0.0, 30.0));
        let (dy, dz) = (moving.direction.vector().y, moving.direction.vector().z);
        assert!((dy * SPEED_OF_LIGHT_KM_S + 7.5).abs() < 1e-6, "{dy}");
        assert!((dz * SPEED_OF_LIGHT_KM_S + 30.0).abs() < 1e-6, "{dz}");
        assert_eq!(moving.geometric, plain.geometric);
    }
}
