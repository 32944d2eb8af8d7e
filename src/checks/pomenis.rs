//! Pomenis: Starlink V1.5 seen from Mount Lemmon in 2022 (Fankhauser, Tyson and Askari 2023); height, altitude and azimuth with each magnitude.

use std::path::Path;

use nalgebra::Vector3;

use crate::frames::{Direction, EopTable, Gcrs, Horizontal, Itrs, Orientation, Position};
use crate::geometry::{Site, SunState, ViewingGeometry};
use crate::photometry::Magnitude;

use super::error::CheckError;
use super::photometry::{Measurement, range_to_height_km};
use super::rows::Rows;

const COLUMNS: [&str; 5] =
    ["observation_time", "satellite_height", "satellite_altitude", "satellite_azimuth", "ab_magnitude"];

/// Geodetic latitude and longitude, degrees, and height, m, of the telescope.
const SITE: (f64, f64, f64) = (32.4434, -110.7881, 2790.0);

pub(super) fn read(path: &Path) -> Result<Vec<Measurement>, CheckError> {
    let (latitude, longitude, height_m) = SITE;
    let site = Site::new_deg("Pomenis", latitude, longitude, height_m)
        .map_err(|error| CheckError::Unreadable { path: path.to_owned(), problem: error.to_string() })?;
    // UT1 - UTC was below 0.1 s in 2022: 1.5 arcsec.
    let eop = EopTable::none();
    let observer: Position<Itrs> = site.itrs();
    let rows = Rows::read(path, COLUMNS)?;
    let mut measured = Vec::new();
    for row in rows.iter() {
        let epoch = row.utc(0)?;
        let height_km = row.number(1, [100.0, 50_000.0], "a height of 100 to 50000 km")?;
        let altitude = row.number(2, [0.0, 90.0], "an altitude of 0 to 90 deg")?.to_radians();
        let azimuth = row.number(3, [-360.0, 360.0], "an azimuth in deg")?.to_radians();
        let magnitude = Magnitude(row.magnitude(4)?);
        let sight = Direction::<Horizontal>::from_vector(Vector3::new(
            altitude.cos() * azimuth.cos(),
            altitude.cos() * azimuth.sin(),
            altitude.sin(),
        ));
        let sight = site.horizon().inverse() * sight;
        let range_km = range_to_height_km(observer.vector(), sight.vector(), height_km);
        let to_gcrs = Orientation::at(epoch, &eop).itrs_to_gcrs;
        let [satellite, observer]: [Position<Gcrs>; 2] =
            [observer + sight.at_range(range_km), observer].map(|place| to_gcrs * place);
        let geometry = ViewingGeometry::new(&satellite, &observer, &SunState::at(epoch).sun);
        measured.extend(geometry.map(|geometry| Measurement::seen(magnitude.to_standard(range_km), geometry)));
    }
    Ok(measured)
}
