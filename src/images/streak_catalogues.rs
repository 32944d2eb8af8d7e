//! Tables of detectors of streaks, converted to the columns of [`StreakTable`](super::StreakTable).
//!
//! - ASTRiDE (`streaks.txt`): a line of names that begins with `#ID`, and cells separated by blanks; `ep1_x`, `ep1_y`,
//!   `ep2_x` and `ep2_y` are the ends in pixels counted from 0.
//! - `acstools.findsat_mrt` (`ROOT_catalog.fits`): a FITS table with `id`, `status` and `endpoints`, the ends
//!   ((x1, y1), (x2, y2)) in pixels counted from 0. A trail with the status 2 passed all tests of findsat_mrt; the others
//!   are left out, as in the masks of findsat_mrt.
//! - Regions of SAOImage DS9: `line(x1,y1,x2,y2)` in `image` (pixels from 1) or in `fk5`, `j2000` or `icrs` (degrees, or
//!   hours and degrees with colons), and `vector(x,y,length,angle)` in `image`, also behind `#`, as DS9 saves it. The
//!   text of a region is the name of the streak.

use std::path::Path;

use super::fits::{FrameFile, HduKind};
use crate::error::Error;
use crate::frames::{parse_declination_deg, parse_right_ascension_deg};
use crate::input;
use crate::message::Quoted;

/// Status of a trail that passed all tests of findsat_mrt.
const ACCEPTED: i64 = 2;

/// Returns the text of a table of streaks in CSV or ECSV. Tables of detectors are converted; each row keeps its line.
///
/// # Errors
/// The file cannot be read, or is a FITS file without the table of findsat_mrt.
pub(super) fn read(path: &Path) -> Result<String, Error> {
    let bytes = input::read(path).map_err(Error::io(path))?;
    if bytes.starts_with(b"SIMPLE  =") {
        return findsat(path);
    }
    let text = input::text_of(bytes).map_err(Error::io(path))?;
    if text.starts_with("#ID ") {
        astride(path, &text)
    } else if text.starts_with("# Region file format: DS9") {
        ds9(path, &text)
    } else {
        Ok(text)
    }
}

fn ds9(path: &Path, text: &str) -> Result<String, Error> {
    const ALLOWED: &str =
        "line in image, fk5 or icrs, or vector in image, one on each line, all in one coordinate system";
    let mut system: Option<&'static str> = None;
    let mut converted = String::new();
    for (line, number) in text.lines().zip(1..) {
        let invalid = |given: &str| {
            Error::invalid("region", format!("'{}'", Quoted::new(given)), ALLOWED).in_line("", path, number)
        };
        // Each row keeps its line; the names of the columns are in the first one, which is a comment of DS9.
        converted.push_str(if number == 1 { "" } else { "\n" });
        let commented = line.trim_start_matches('#').trim_start();
        let line = if commented.starts_with("vector(") { commented } else { line };
        let name = [("text={", '}'), ("text=\"", '"'), ("text='", '\'')].into_iter().find_map(|(start, end)| {
            let (_, rest) = line.split_once(start)?;
            rest.split(end).next()
        });
        let mut shape = line.split('#').next().unwrap_or_default().trim();
        if let Some((first, rest)) = shape.split_once(';') {
            // `image;line(...)`, as in files with a system before each shape.
            system = Some(system_of(system, first.trim()).ok_or_else(|| invalid(line))?);
            shape = rest.trim();
        }
        if shape.is_empty() || shape.starts_with("global") {
            continue;
        }
        let Some((kind, numbers)) = shape.split_once('(') else {
            system = Some(system_of(system, shape).ok_or_else(|| invalid(line))?);
            continue;
        };
        let cells: Vec<&str> = numbers
            .split(')')
            .next()
            .unwrap_or_default()
            .split([',', ' '])
            .map(str::trim)
            .filter(|cell| !cell.is_empty())
            .collect();
        let [a, b, c, d] = cells[..] else { return Err(invalid(line)) };
        let ends = match (kind.trim(), system) {
            ("line", Some("image")) => [a, b, c, d].map(|cell| cell.parse::<f64>().ok()),
            ("vector", Some("image")) => {
                let [x, y, length, angle_deg] = [a, b, c, d].map(|cell| cell.parse::<f64>().unwrap_or(f64::NAN));
                let (sin, cos) = angle_deg.to_radians().sin_cos();
                [x, y, x + length * cos, y + length * sin].map(Some)
            }
            ("line", Some(_)) => {
                let ends = [(a, b), (c, d)]
                    .map(|(ra, dec)| [parse_right_ascension_deg(ra).ok(), parse_declination_deg(dec).ok()]);
                [ends[0][0], ends[0][1], ends[1][0], ends[1][1]]
            }
            _ => return Err(invalid(line)),
        };
        let [Some(a), Some(b), Some(c), Some(d)] = ends.map(|end| end.filter(|number| number.is_finite())) else {
            return Err(invalid(line));
        };
        let name = name.unwrap_or_default().replace([',', '"'], " ");
        converted += &format!("\"{name}\",{a},{b},{c},{d}");
    }
    let columns = match system {
        Some("image") => "id,x1_pix,y1_pix,x2_pix,y2_pix",
        _ => "id,ra1_deg,dec1_deg,ra2_deg,dec2_deg",
    };
    Ok(format!("{columns}{converted}\n"))
}

/// Returns the coordinate system of a file of regions: `image` or `icrs`, from which FK5 of equinox 2000 differs by 0.02
/// arcsec. `None` if it is not supported, or another one than before.
fn system_of(before: Option<&'static str>, name: &str) -> Option<&'static str> {
    let system = match name.to_ascii_lowercase().as_str() {
        "image" => "image",
        "fk5" | "j2000" | "icrs" => "icrs",
        _ => return None,
    };
    before.is_none_or(|before| before == system).then_some(system)
}

fn astride(path: &Path, text: &str) -> Result<String, Error> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().trim_start_matches('#').split_whitespace().collect();
    let find = |name: &str| {
        names.iter().position(|found| *found == name).ok_or_else(|| {
            Error::invalid(
                format!("column {name} of ASTRiDE"),
                "missing",
                "a table with ID, ep1_x, ep1_y, ep2_x and ep2_y (ASTRiDE of 2024 or newer)",
            )
            .in_file("", path)
        })
    };
    let columns = [find("ID")?, find("ep1_x")?, find("ep1_y")?, find("ep2_x")?, find("ep2_y")?];
    let mut converted = "id,x1_pix,y1_pix,x2_pix,y2_pix\n".to_owned();
    for (line, number) in lines.zip(2..) {
        let cells: Vec<&str> = line.split_whitespace().collect();
        if !cells.is_empty() && cells.len() != names.len() {
            return Err(Error::invalid(
                "number of cells",
                cells.len(),
                format!("{}, as in the first line", names.len()),
            )
            .in_line("", path, number));
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

fn findsat(path: &Path) -> Result<String, Error> {
    // The file is checked before CFITSIO reads it.
    let checked = FrameFile::open(path)?;
    if checked.hdus().get(1).is_none_or(|hdu| hdu.kind != HduKind::Table) {
        let allowed = "a catalog of findsat_mrt, with a table in the first extension";
        return Err(Error::invalid("table of streaks", "missing", allowed).in_file("", path));
    }
    let failed = |error: fitsio::errors::Error| {
        let given = Quoted::new(error.to_string()).to_string();
        let allowed = "a catalog of findsat_mrt with id, status and endpoints in the first extension";
        Error::invalid("table of streaks", given, allowed).in_file("", path)
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
        return Err(Error::invalid("numbers in endpoints", ends.len(), format!("{}, 4 in each row", 4 * ids.len()))
            .in_file("", path));
    }
    for ((id, status), ends) in ids.iter().zip(&status).zip(ends.chunks_exact(4)) {
        if *status == ACCEPTED {
            let cells: Vec<String> = ends.iter().map(|from_zero| (from_zero + 1.0).to_string()).collect();
            converted += &format!("{id},{}\n", cells.join(","));
        }
    }
    Ok(converted)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "# Region file format: DS9 version 4.1\nglobal color=green\n";

    #[test]
    fn regions_of_ds9_are_converted_with_their_lines() {
        let of = |text: &str| ds9(Path::new("a.reg"), &format!("{HEAD}{text}"));
        let text = "image\nline(1,2,3.5,4) # line=0 0 text={one}\n# vector(10,20,5,90) vector=1\n";
        let rows = of(text).unwrap();
        let lines: Vec<&str> = rows.lines().collect();
        assert_eq!(lines[..4], ["id,x1_pix,y1_pix,x2_pix,y2_pix", "", "", "\"one\",1,2,3.5,4"]);
        let ends: Vec<f64> = lines[4].split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        assert!((ends[2] - 10.0).abs() < 1e-9 && (ends[3] - 25.0).abs() < 1e-9, "{rows}");
        let rows = of("fk5\nline(0:40:00,-10:30:00,10.5,-11)\n").unwrap();
        assert!(
            rows.starts_with("id,ra1_deg,dec1_deg,ra2_deg,dec2_deg\n") && rows.contains("\n\"\",10,-10.5,10.5,-11"),
            "{rows}"
        );
        for name in ["{#3}", "\"#3\"", "'#3'"] {
            let rows = of(&format!("image\nline(1,2,3,4) # text={name}\n")).unwrap();
            assert!(rows.contains("\n\"#3\",1,2,3,4"), "{rows}");
        }
        for (text, line) in [
            ("image\ncircle(1,2,3)\n", 4),
            ("line(1,2,3,4)\n", 3),
            ("galactic\nline(1,2,3,4)\n", 3),
            ("image\nline(1,2,3,4)\nfk5\nline(1,2,3,4)\n", 5),
            ("image\nline(1,2,3,x)\n", 4),
            ("fk5\nvector(1,2,3,4)\n", 4),
        ] {
            let message = of(text).unwrap_err().to_string();
            assert!(
                message.contains(&format!("a.reg: line {line}: region")) && message.contains("line in image"),
                "{message}"
            );
        }
    }
}
