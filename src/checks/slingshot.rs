//! Slingshot: Starlink V2 mini (Kandula et al. 2025); altitudes of Sun and satellite and the azimuth between them, no time.

use std::path::Path;

use nalgebra::Vector3;

use crate::constants::AU_KM;
use crate::frames::{Gcrs, Position};
use crate::geometry::ViewingGeometry;
use crate::photometry::Magnitude;

use super::error::CheckError;
use super::photometry::{Measurement, range_to_height_km};
use super::rows::Rows;

const COLUMNS: [&str; 5] = ["sun altitude", "sat altitude", "sat height", "measured_ab", "az diff"];

/// No site is named: the observer stands on a sphere of the Earth's mean radius, km.
const MEAN_RADIUS_KM: f64 = 6371.0;

pub(super) fn read(path: &Path) -> Result<Vec<Measurement>, CheckError> {
    let site = Vector3::new(MEAN_RADIUS_KM, 0.0, 0.0);
    let rows = Rows::read(path, COLUMNS)?;
    let mut measured = Vec::new();
    for row in rows.iter() {
        let sun_altitude = row.number(0, [-90.0, 90.0], "an altitude of -90 to 90 deg")?.to_radians();
        let altitude = row.number(1, [0.0, 90.0], "an altitude of 0 to 90 deg")?.to_radians();
        let height_m = row.number(2, [1e5, 5e7], "a height of 100000 to 50000000 m")?;
        let magnitude = Magnitude(row.magnitude(3)?);
        let azimuth = row.number(4, [-360.0, 360.0], "an azimuth in deg")?.to_radians();
        // Up is x; azimuths count from the Sun's.
        let towards = |altitude: f64, azimuth: f64| {
            Vector3::new(altitude.sin(), altitude.cos() * azimuth.cos(), altitude.cos() * azimuth.sin())
        };
        let sight = towards(altitude, azimuth);
        let range_km = range_to_height_km(&site, &sight, height_m / 1000.0);
        let places = [site + sight * range_km, site, towards(sun_altitude, 0.0) * AU_KM];
        let [satellite, observer, sun] = places.map(Position::<Gcrs>::from_vector);
        let geometry = ViewingGeometry::new(&satellite, &observer, &sun);
        measured.extend(geometry.map(|geometry| Measurement::seen(magnitude.to_standard(range_km), geometry)));
    }
    Ok(measured)
}
