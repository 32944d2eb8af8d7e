//! Response curves of bands, from files.

use std::path::Path;

use super::error;
use super::inputs::read_text;
use crate::error::Error;
use crate::input::TableRows;
use crate::photometry::ResponseBand;
use crate::units::MICROMETRES;

/// Columns of a response file, for errors.
const COLUMNS: &str = "wavelength_um (or wavelength_nm, wavelength_Angstrom) and response";

/// Reads a band from a table with the columns `wavelength_um` and `response`. The unit of the wavelength is that of the
/// header of ECSV, or of the name of the column.
pub(super) fn read_response(path: &Path) -> Result<ResponseBand, Error> {
    let what = "response file";
    let text = read_text(what, path)?;
    let failed = |source| error::unreadable(what, path, source);
    let rows = TableRows::new(text).map_err(failed)?;
    let wavelength = rows.numbers(&["wavelength_um", "wavelength"], &MICROMETRES, COLUMNS).map_err(failed)?;
    let response = rows.column("response", COLUMNS).map_err(failed)?;
    let mut curve: Vec<(f64, f64)> = Vec::new();
    for row in rows {
        let row = row.map_err(failed)?;
        let wavelength_um = row.number_in(wavelength, ResponseBand::WAVELENGTHS_UM).map_err(failed)?;
        if curve.last().is_some_and(|(last_um, _)| *last_um >= wavelength_um) {
            return Err(failed(row.wrong(wavelength, "wavelengths that increase")));
        }
        curve.push((wavelength_um, row.number_in(response, [0.0, f64::MAX]).map_err(failed)?));
    }
    ResponseBand::from_curve(&curve).ok_or_else(|| {
        Error::format("too few rows, or no response is positive")
            .in_file(what, path)
            .allowing("two rows or more, with positive responses")
    })
}
