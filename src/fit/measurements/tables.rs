//! Measurements and reduced pixels as tables.

use crate::output::{Column, Kind, Table};

use super::measurement::Measurements;
use super::reduce::{Pixel, Reduction};

const SUN: Column = Column::real("sun_latitude_deg", "deg", 5, "Sun above the plane of the chassis.");
const LONGITUDE: Column = Column::real(
    "observer_longitude_deg",
    "deg",
    5,
    "Observer in the satellite's frame, from the Sun's azimuth, right-handed about the satellite's zenith.",
);
const LATITUDE: Column =
    Column::real("observer_latitude_deg", "deg", 5, "Observer above the plane of the chassis; -90 is straight below.");
const HEIGHT: Column =
    Column::real("height_km", "km", 3, "Satellite's distance from the Earth's centre less 6378.137 km.");

const PIXELS: [Column; 12] = [
    Column::new("layer", Kind::Integer, "Layer of the Sun's latitude, in widths, rounded down."),
    Column::new("healpix_cell", Kind::Integer, "Cell of the observer's direction, HEALPix in RING order."),
    SUN,
    LONGITUDE,
    LATITUDE,
    HEIGHT,
    Column::real("mode_mag", "mag", 4, "Densest magnitude at 1000 km."),
    Column::real("median_mag", "mag", 4, "Median magnitude at 1000 km."),
    Column::real("iqr_mag", "mag", 4, "Interquartile range."),
    Column::new("count", Kind::Integer, "Points in the cell."),
    Column::new("tracks", Kind::Integer, "Tracks (satellites, nights, files: as rows are grouped) that they are of."),
    Column::new("kept", Kind::Boolean, "Whether there are enough points and tracks of little enough spread."),
];

const POINTS: [Column; 9] = [
    Column::time("utc", "When; empty where no time was recorded."),
    Column::new("norad_id", Kind::Integer, "Which satellite; empty where it is not known."),
    Column::new("group", Kind::Text, "Track, satellite, night or file: what was measured together."),
    Column::real("standard_magnitude", "mag", 4, "Magnitude at 1000 km."),
    Column::real("sigma_mag", "mag", 4, "One sigma as stated by the survey."),
    SUN,
    LONGITUDE,
    LATITUDE,
    HEIGHT,
];

impl Reduction {
    /// One row a pixel: layer, cell, mean angles, mode, median, spread, count, tracks, and whether it is kept.
    pub fn table(&self) -> Table {
        let row = |pixel: &Pixel| {
            vec![
                i64::from(pixel.layer).into(),
                (pixel.cell as i64).into(),
                pixel.sun_latitude_rad.to_degrees().into(),
                pixel.observer_longitude_rad.to_degrees().into(),
                pixel.observer_latitude_rad.to_degrees().into(),
                pixel.height_km.into(),
                pixel.mode_mag.into(),
                pixel.median_mag.into(),
                pixel.iqr_mag.into(),
                i64::from(pixel.count).into(),
                i64::from(pixel.tracks).into(),
                self.keeps(pixel).into(),
            ]
        };
        Table { columns: PIXELS.to_vec(), rows: self.pixels.iter().map(row).collect() }
    }
}

impl Measurements {
    /// One row a measurement.
    pub fn table(&self) -> Table {
        let rows = self.points.iter().map(|point| {
            vec![
                point.epoch.into(),
                point.norad_id.map(|id| i64::from(id.0)).into(),
                self.groups.get(point.group as usize).cloned().into(),
                point.magnitude.0.into(),
                point.sigma_mag.into(),
                point.geometry.sun_latitude_rad.to_degrees().into(),
                point.geometry.observer_longitude_rad.to_degrees().into(),
                point.geometry.observer_latitude_rad.to_degrees().into(),
                point.geometry.height_km.into(),
            ]
        });
        Table { columns: POINTS.to_vec(), rows: rows.collect() }
    }
}
