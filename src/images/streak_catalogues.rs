//! Tables of detectors of streaks, converted to the columns of [`StreakTable`](super::StreakTable).
//!
//! - ASTRiDE (`streaks.txt`): a line of names that begins with `#ID`, and cells separated by blanks; `ep1_x`, `ep1_y`,
//!   `ep2_x` and `ep2_y` are the ends in pixels counted from 0.
//! - `acstools.findsat_mrt` (`ROOT_catalog.fits`): a FITS table with `id`, `status` and `endpoints`, the ends
//!   ((x1, y1), (x2, y2)) in pixels counted from 0. A trail with the status 2 passed all tests of findsat_mrt; the others
//!   are left out, as in the masks of findsat_mrt.

use std::path::Path;

use super::error::ImagesError;
use super::fits::{FrameFile, HduKind};
use crate::input;
use crate::message::Quoted;

/// Status of a trail that passed all tests of findsat_mrt.
const ACCEPTED: i64 = 2;

/// Returns the text of a table of streaks in CSV or ECSV. Tables of detectors are converted; each row keeps its line.
///
/// # Errors
/// The file cannot be read, or is a FITS file without the table of findsat_mrt.
pub(super) fn read(path: &Path) -> Result<String, ImagesError> {
    let bytes = input::read(path).map_err(ImagesError::io(path))?;
    if bytes.starts_with(b"SIMPLE  =") {
        return findsat(path);
    }
    let text = input::text_of(bytes).map_err(ImagesError::io(path))?;
    if text.starts_with("#ID ") { astride(path, &text) } else { Ok(text) }
}

fn astride(path: &Path, text: &str) -> Result<String, ImagesError> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().trim_start_matches('#').split_whitespace().collect();
    let find = |name: &str| {
        names.iter().position(|found| *found == name).ok_or_else(|| {
            let what = format!("{}: column {name} of ASTRiDE", path.display());
            ImagesError::invalid(
                what,
                "missing",
                "a table with ID, ep1_x, ep1_y, ep2_x and ep2_y (ASTRiDE of 2024 or newer)",
            )
        })
    };
    let columns = [find("ID")?, find("ep1_x")?, find("ep1_y")?, find("ep2_x")?, find("ep2_y")?];
    let mut converted = "id,x1_pix,y1_pix,x2_pix,y2_pix\n".to_owned();
    for (line, number) in lines.zip(2..) {
        let cells: Vec<&str> = line.split_whitespace().collect();
        if !cells.is_empty() && cells.len() != names.len() {
            let what = format!("{}: line {number}: number of cells", path.display());
            return Err(ImagesError::invalid(what, cells.len(), format!("{}, as in the first line", names.len())));
        }
        let cell = |(index, column): (usize, &usize)| -> String {
            let text = cells.get(*column).copied().unwrap_or_default();
            match text.parse::<f64>() {
                Ok(from_zero) if index > 0 => (from_zero + 1.0).to_string(),
                // Names are not quoted; a cell that is not a number gives an error later.
                _ => text.replace([',', '"'], " "),
            }
        };
        let row: Vec<String> = columns.iter().enumerate().map(cell).collect();
        converted += &if cells.is_empty() { String::new() } else { row.join(",") };
        converted.push('\n');
    }
    Ok(converted)
}

fn findsat(path: &Path) -> Result<String, ImagesError> {
    // The file is checked before CFITSIO reads it.
    let checked = FrameFile::open(path)?;
    if checked.hdus().get(1).is_none_or(|hdu| hdu.kind != HduKind::Table) {
        let allowed = "a catalog of findsat_mrt, with a table in the first extension";
        return Err(ImagesError::invalid(format!("{}: table of streaks", path.display()), "missing", allowed));
    }
    let failed = |error: fitsio::errors::Error| {
        let given = Quoted::new(&error.to_string()).to_string();
        let allowed = "a catalog of findsat_mrt with id, status and endpoints in the first extension";
        ImagesError::invalid(format!("{}: table of streaks", path.display()), given, allowed)
    };
    let mut file = fitsio::FitsFile::open(path).map_err(failed)?;
    let hdu = file.hdu(1).map_err(failed)?;
    let ids: Vec<i64> = hdu.read_col(&mut file, "id").map_err(failed)?;
    let status: Vec<i64> = hdu.read_col(&mut file, "status").map_err(failed)?;
    let ends: Vec<f64> = hdu.read_col(&mut file, "endpoints").map_err(failed)?;
    let mut converted = "id,x1_pix,y1_pix,x2_pix,y2_pix\n".to_owned();
    if ids.is_empty() {
        return Ok(converted);
    }
    if ends.len() != 4 * ids.len() || status.len() != ids.len() {
        let what = format!("{}: numbers in endpoints", path.display());
        return Err(ImagesError::invalid(what, ends.len(), format!("{}, 4 in each row", 4 * ids.len())));
    }
    for ((id, status), ends) in ids.iter().zip(&status).zip(ends.chunks_exact(4)) {
        if *status == ACCEPTED {
            let cells: Vec<String> = ends.iter().map(|from_zero| (from_zero + 1.0).to_string()).collect();
            converted += &format!("{id},{}\n", cells.join(","));
        }
    }
    Ok(converted)
}
