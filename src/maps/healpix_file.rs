//! Maps as HEALPix tables in FITS files, in the form that healpy and Aladin read.
//!
//! One row a cell of the whole sphere in RING order. Cells of the other half, and those without a magnitude, hold -1.6375e30, the mark of
//! HEALPix for missing data. Longitude and latitude of the cells are azimuth and altitude, or the observer's in the satellite's frame: the
//! keyword COORDSYS says which; neither is a place among the stars. Text in the header is ASCII: accents are left out, and three dots end what
//! is longer than a card.

use std::fs;
use std::path::Path;

use crate::images::{Card, CardValue, Cells, TableColumn, write_table};
use crate::math::healpix::cell_count;
use crate::output::ScratchFolder;

use super::body::BodyMap;
use super::card_text::card_text;
use super::error::MapError;
use super::facts::{Fact, FactValue};
use super::grid::Grid;
use super::sky::SkyMap;

/// What HEALPix holds for missing data.
const BAD_DATA: f64 = -1.6375e30;

/// A column: name, unit, and for each cell its value.
type CellColumn<'a> = (&'static str, &'static str, Box<dyn Fn(usize) -> Option<f64> + 'a>);

impl BodyMap {
    /// The bytes of a FITS file with the column `standard_magnitude`.
    ///
    /// CFITSIO works on files alone: one is made in the folder `scratch` and removed.
    ///
    /// # Errors
    /// [`MapError::Fits`] where the grid is none of HEALPix, and for whatever CFITSIO reports; [`MapError::Scratch`] where `scratch` cannot
    /// be written to.
    pub fn to_fits(&self, scratch: &Path) -> Result<Vec<u8>, MapError> {
        let magnitude = |index: usize| self.points[index].standard_magnitude.map(|magnitude| magnitude.0);
        let columns: [CellColumn<'_>; 1] = [("standard_magnitude", "mag", Box::new(magnitude))];
        to_fits(
            self.grid,
            &self.facts,
            &columns,
            (0..self.points.len()).map(|index| self.grid.southern_cell(index)),
            scratch,
        )
    }
}

impl SkyMap {
    /// The bytes of a FITS file with the columns `magnitude` and `range_km`.
    ///
    /// # Errors
    /// As [`BodyMap::to_fits`].
    pub fn to_fits(&self, scratch: &Path) -> Result<Vec<u8>, MapError> {
        let magnitude = |index: usize| self.points[index].magnitude.map(|magnitude| magnitude.0);
        let range = |index: usize| Some(self.points[index].range_km);
        let columns: [CellColumn<'_>; 2] =
            [("magnitude", "mag", Box::new(magnitude)), ("range_km", "km", Box::new(range))];
        to_fits(
            self.grid,
            &self.facts,
            &columns,
            (0..self.points.len()).map(|index| self.grid.northern_cell(index)),
            scratch,
        )
    }
}

fn to_fits(
    grid: Grid,
    facts: &[Fact],
    columns: &[CellColumn<'_>],
    cells: impl Iterator<Item = Option<u64>>,
    scratch: &Path,
) -> Result<Vec<u8>, MapError> {
    let no_cells = || MapError::Fits("a map of steps has no HEALPix cells; make it with an nside".to_owned());
    let nside = grid.nside().ok_or_else(no_cells)?;
    // Its errors name the folder.
    let folder = ScratchFolder::new(scratch).map_err(|error| MapError::Scratch(error.to_string()))?;
    let path = folder.path().join("map.fits");
    let cells: Vec<Option<u64>> = cells.collect();
    let count = cell_count(nside) as usize;
    let column = |(name, unit, value): &CellColumn<'_>| {
        let mut rows = vec![BAD_DATA; count];
        for (index, cell) in cells.iter().enumerate() {
            let place = cell.and_then(|cell| rows.get_mut(cell as usize));
            if let (Some(place), Some(value)) = (place, value(index)) {
                *place = value;
            }
        }
        TableColumn {
            name: (*name).to_owned(),
            unit: (*unit).to_owned(),
            meaning: String::new(),
            cells: Cells::Real(rows),
        }
    };
    let columns: Vec<TableColumn> = columns.iter().map(column).collect();
    write_table(&path, "HEALPIX", &columns, &cards(nside, facts)).map_err(|error| MapError::Fits(error.to_string()))?;
    fs::read(&path).map_err(|error| MapError::Scratch(format!("folder {}: {error}", scratch.display())))
}

fn cards(nside: u32, facts: &[Fact]) -> Vec<Card> {
    let version = concat!("streakcast ", env!("CARGO_PKG_VERSION"));
    let mut values: Vec<(&str, CardValue, &str)> = vec![
        ("PIXTYPE", "HEALPIX".into(), "HEALPix cells"),
        ("ORDERING", "RING".into(), "order of the cells"),
        ("NSIDE", i64::from(nside).into(), "division of the base cells"),
        ("FIRSTPIX", 0_i64.into(), "first cell"),
        ("LASTPIX", (cell_count(nside) as i64 - 1).into(), "last cell"),
        ("INDXSCHM", "IMPLICIT".into(), "row is the number of the cell"),
        ("OBJECT", "FULLSKY".into(), "every cell has its row"),
        ("BAD_DATA", BAD_DATA.into(), "nothing lit is seen, or not in this half"),
        ("CREATOR", version.into(), "software"),
    ];
    values.extend(facts.iter().map(|fact| {
        let value = match &fact.value {
            FactValue::Text(text) => CardValue::Text(card_text(text)),
            FactValue::Real(number) => (*number).into(),
        };
        (fact.keyword, value, fact.comment)
    }));
    values.iter().flat_map(|(keyword, value, comment)| Card::with_value(keyword, value, comment)).collect()
}
