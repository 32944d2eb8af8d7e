//! Conversion of maps to tables.

use crate::output::{Column, Kind, Table, Value};

use super::body::BodyMap;
use super::grid::Grid;
use super::sky::SkyMap;

const CELL: Column = Column::new("healpix_cell", Kind::Integer, "HEALPix cell in RING order.");

const BODY: [Column; 3] = [
    Column::real(
        "observer_longitude_deg",
        "deg",
        6,
        "Longitude of the observer in the satellite's frame, from the Sun's azimuth, right-handed about the satellite's zenith.",
    ),
    Column::real("observer_latitude_deg", "deg", 6, "Observer above the chassis plane; -90 is straight below."),
    Column::real(
        "standard_magnitude",
        "mag",
        4,
        "Magnitude at 1000 km in full sunlight; empty where no lit surface is visible.",
    ),
];

const SKY: [Column; 4] = [
    Column::real("azimuth_deg", "deg", 6, "From north through east."),
    Column::real("altitude_deg", "deg", 6, "Above the horizon, without refraction."),
    Column::real("range_km", "km", 3, "Observer to satellite."),
    Column::real(
        "magnitude",
        "mag",
        4,
        "Apparent magnitude; empty in the Earth's shadow, where no lit surface is visible, and on the horizon with extinction.",
    ),
];

impl BodyMap {
    /// Returns a table with one row for each direction and the columns `observer_longitude_deg`,
    /// `observer_latitude_deg` and `standard_magnitude`; the table of a HEALPix map begins with the column
    /// `healpix_cell`.
    #[doc(hidden)]
    pub fn table(&self) -> Table {
        let row = |(index, point): (usize, &super::BodyPoint)| {
            let numbers = [
                point.observer_longitude_rad.to_degrees().into(),
                point.observer_latitude_rad.to_degrees().into(),
                point.standard_magnitude.map(|magnitude| magnitude.0).into(),
            ];
            (self.grid.southern_cell(index), numbers)
        };
        table(&BODY, self.grid, self.points.iter().enumerate().map(row))
    }
}

impl SkyMap {
    /// Returns a table with one row for each direction and the columns `azimuth_deg`, `altitude_deg`, `range_km` and
    /// `magnitude`; the table of a HEALPix map begins with the column `healpix_cell`.
    #[doc(hidden)]
    pub fn table(&self) -> Table {
        let row = |(index, point): (usize, &super::SkyPoint)| {
            let numbers = [
                point.azimuth_rad.to_degrees().into(),
                point.altitude_rad.to_degrees().into(),
                point.range_km.into(),
                point.magnitude.map(|magnitude| magnitude.0).into(),
            ];
            (self.grid.northern_cell(index), numbers)
        };
        table(&SKY, self.grid, self.points.iter().enumerate().map(row))
    }
}

fn table<const N: usize>(
    columns: &[Column; N],
    grid: Grid,
    rows: impl Iterator<Item = (Option<u64>, [Value; N])>,
) -> Table {
    let has_cells = grid.nside().is_some();
    let cell = |cell: Option<u64>| cell.and_then(|cell| i64::try_from(cell).ok()).map_or(Value::Null, Value::Integer);
    Table {
        columns: has_cells.then_some(CELL).into_iter().chain(columns.iter().copied()).collect(),
        rows: rows.map(|(of, numbers)| has_cells.then(|| cell(of)).into_iter().chain(numbers).collect()).collect(),
    }
}
