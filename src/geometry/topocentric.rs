//! Directions as seen by an observer: light time, annual aberration, and the conversion of apparent positions to ICRS.

use hifitime::Epoch;

use super::sun::SunState;
use crate::constants::SPEED_OF_LIGHT_KM_S;
use crate::frames::{Direction, Gcrs, OfDate, Position, Velocity, gcrs_to_of_date, without_annual_aberration};

/// Direction and range of a satellite as seen by an observer.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Aspect {
    /// ICRS astrometric topocentric direction.
    pub direction: Direction<Gcrs>,
    /// Geometric vector from the observer to the satellite, both at the time of reception, km. Its components in the
    /// horizontal frame give altitude and azimuth.
    pub geometric: Position<Gcrs>,
    /// Length of `geometric`, km.
    pub range_km: f64,
}

/// Computes the aspect of a satellite at the time of reception. The arguments are the geocentric positions of satellite
/// and observer, the geocentric velocity of the satellite and the barycentric velocity of the Earth.
///
/// The light time is computed from the distance at reception. This shifts the satellite by 3 mm at 1000 km and by 40 mm
/// in the geostationary ring, below 10⁻⁸ rad for both. If satellite and observer coincide, the direction is NaN.
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

/// Converts an apparent position (true equator and equinox of date; "JNow" of mounts and of INDI) to ICRS.
///
/// Precession and nutation are IAU 2006/2000A, and annual aberration (up to 20") is removed. Light deflection by the
/// Sun (1.8" at its limb, 4 mas at 90 deg), diurnal aberration (0.3") and refraction are not removed. In 2026 the
/// apparent and the ICRS position differ by up to 0.4 deg.
pub fn icrs_of_apparent(apparent: &Direction<OfDate>, epoch: Epoch) -> Direction<Gcrs> {
    let seen = gcrs_to_of_date(epoch).inverse() * *apparent;
    without_annual_aberration(&seen, &SunState::at(epoch).earth_velocity)
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

    /// Tolerance, arcsec: light deflection and other effects that astropy includes in TETE.
    const TOLERANCE_ARCSEC: f64 = 0.1;

    /// (UTC, RA and declination of date, RA and declination ICRS), degrees; astropy 8.0.2,
    /// `SkyCoord(frame=TETE(obstime)).icrs`, geocentric, 2026-11-22, by tests/reference/make_apparent_places.py.
    const PLACES: &[(&str, [f64; 2], [f64; 2])] = &[
        ("2016-12-17T16:30:00 UTC", [279.2468485, -33.3385894], [278.9774252, -33.3553579]),
        ("2016-11-02T07:30:00 UTC", [314.4792403, -81.6776451], [313.8193641, -81.7388791]),
        ("2016-06-23T03:30:00 UTC", [168.4565830, -23.1995784], [168.2546428, -23.1075615]),
        ("2021-10-10T06:30:00 UTC", [91.7530516, -6.3065182], [91.4898187, -6.3070799]),
        ("2021-06-14T13:30:00 UTC", [358.3801020, 35.8258710], [358.1130128, 35.7117889]),
        ("2021-07-19T14:30:00 UTC", [356.0256532, -34.7071840], [355.7436508, -34.8286693]),
        ("2024-11-05T20:30:00 UTC", [15.8191229, -68.2237126], [15.5765248, -68.3551944]),
        ("2024-08-04T12:30:00 UTC", [167.8341691, 56.5467140], [167.4791927, 56.6762192]),
        ("2024-10-17T10:30:00 UTC", [178.8744367, -30.3293713], [178.5662757, -30.1948161]),
        ("2026-07-27T00:30:00 UTC", [69.2647718, 22.5856595], [68.8681167, 22.5309706]),
        ("2026-11-06T17:30:00 UTC", [1.3443271, 41.3071535], [0.9924122, 41.1529611]),
        ("2026-05-18T03:30:00 UTC", [96.3357496, 49.5227969], [95.8308449, 49.5345009]),
    ];

    #[test]
    fn valid_positions_against_astropy() {
        assert!(PLACES.len() > 5);
        for (utc, [ra, dec], [icrs_ra, icrs_dec]) in PLACES {
            let epoch: Epoch = utc.parse().unwrap();
            let of_date = Direction::from_lon_lat_rad(ra.to_radians(), dec.to_radians());
            let icrs = Direction::<Gcrs>::from_lon_lat_rad(icrs_ra.to_radians(), icrs_dec.to_radians());
            let error_arcsec = icrs_of_apparent(&of_date, epoch).separation_rad(&icrs).to_degrees() * 3600.0;
            assert!(error_arcsec < TOLERANCE_ARCSEC, "{utc} {ra} {dec}: {error_arcsec}");
        }
    }
}
