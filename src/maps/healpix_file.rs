//! Maps as HEALPix tables in FITS files, which healpy and Aladin can read.
//!
//! The table has one row for each pixel of the whole sphere, in RING order. Pixels of the hemisphere that is not
//! computed, and pixels without a magnitude, contain -1.6375e30, the HEALPix value for missing data. The keyword
//! COORDSYS states whether longitude and latitude of the pixels are azimuth and altitude, or the observer's longitude
//! and latitude in the satellite's frame; they are not celestial coordinates. Header text is ASCII: accents are
//! removed, and text that is too long is truncated and ends in three dots.

use std::path::Path;

use crate::error::{Error, ErrorKind};
use crate::images::{Card, CardValue, Cells, TableColumn, write_table};
use crate::math::healpix::cell_count;
use crate::message::in_ascii;
use crate::output::ScratchFolder;

use super::body::BodyMap;
use super::grid::Grid;
use super::light::{Fact, FactValue};
use super::sky::SkyMap;

/// HEALPix value for missing data.
const BAD_DATA: f64 = -1.6375e30;

/// A column of the table: name, unit, and a function that returns the value of a pixel.
type CellColumn<'a> = (&'static str, &'static str, Box<dyn Fn(usize) -> Option<f64> + 'a>);

impl BodyMap {
    /// Returns the bytes of a FITS file with the column `standard_magnitude`.
    ///
    /// CFITSIO can only write to a file, so a temporary file is created in the folder `scratch` and deleted afterwards.
    ///
    /// # Errors
    /// The grid is not a HEALPix grid, CFITSIO fails, or files cannot be created in `scratch`.
    pub fn to_fits(&self, scratch: &Path) -> Result<Vec<u8>, Error> {
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
    /// Returns the bytes of a FITS file with the columns `magnitude` and `range_km`.
    ///
    /// # Errors
    /// The errors of [`BodyMap::to_fits`].
    pub fn to_fits(&self, scratch: &Path) -> Result<Vec<u8>, Error> {
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
) -> Result<Vec<u8>, Error> {
    let no_cells = || Error::new(ErrorKind::Invalid, "FITS: a regular grid has no HEALPix cells; specify an nside");
    let nside = grid.nside().ok_or_else(no_cells)?;
    // Error texts of CFITSIO contain the path of the folder.
    const IN_SCRATCH: &str = "cannot write a FITS file in the scratch folder";
    let folder = ScratchFolder::new(scratch).map_err(|error| Error::system(error).at(IN_SCRATCH))?;
    let path = folder.path().join("map.fits");
    let cells: Vec<Option<u64>> = cells.collect();
    let count = cell_count(nside) as usize;
    let column = |(name, unit, value): &CellColumn<'_>| {
        let mut rows = vec![BAD_DATA; count];
        for (index, cell) in cells.iter().enumerate() {
            let slot = cell.and_then(|cell| rows.get_mut(cell as usize));
            if let (Some(slot), Some(value)) = (slot, value(index)) {
                *slot = value;
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
    write_table(&path, "HEALPIX", &columns, &cards(nside, facts))
        .map_err(|error| Error::new(ErrorKind::Format, format!("FITS: {error}")))?;
    let failed = |error| Error::system(error).at(format_args!("folder {}", scratch.display())).at(IN_SCRATCH);
    crate::input::read(&path).map_err(failed)
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
        ("OBJECT", "FULLSKY".into(), "one row for each cell"),
        ("BAD_DATA", BAD_DATA.into(), "no lit surface visible, or other half"),
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

/// Longest text of one header card, in which a quote counts twice. CFITSIO truncates longer texts without an error.
const LONGEST: usize = 68;

/// End of a truncated text.
const TRUNCATED: &str = "...";

/// Returns text for a header card: without accents, with `?` for other non-ASCII characters, and with three dots at the
/// end if it had to be truncated.
fn card_text(text: &str) -> String {
    let plain = in_ascii(text);
    let width = |c: char| if c == '\'' { 2 } else { 1 };
    if plain.chars().map(width).sum::<usize>() <= LONGEST {
        return plain;
    }
    let mut end = 0;
    let fits = |c: &char| {
        end += width(*c);
        end + TRUNCATED.len() <= LONGEST
    };
    let mut cut: String = plain.chars().take_while(fits).collect();
    cut.push_str(TRUNCATED);
    cut
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_names_stay_readable() {
        for (name, card) in [
            ("Río Grande, Côte d’Azur", "Rio Grande, Cote d'Azur"),
            ("Ondřejov – Žebrák", "Ondrejov - Zebrak"),
            ("Skalnate\u{301} Pleso 20°", "Skalnate Pleso 20deg"),
            ("Straße, Ærø, Þórshöfn, İzmir", "Strasse, AEro, Thorshofn, Izmir"),
            ("紫金山 / Zijinshan\t", "??? / Zijinshan?"),
            ("~ plain ~", "~ plain ~"),
        ] {
            assert_eq!(card_text(name), card);
        }
    }

    #[test]
    fn verif_truncated_text_ends_in_dots() {
        let (fits, long) = ("x".repeat(68), "x".repeat(69));
        assert_eq!(card_text(&fits), fits);
        assert_eq!(card_text(&long), format!("{}...", "x".repeat(65)));
        // A quote takes two characters in the card.
        assert_eq!(card_text(&"'".repeat(34)), "'".repeat(34));
        assert_eq!(card_text(&"'".repeat(35)), format!("{}...", "'".repeat(32)));
    }
}
