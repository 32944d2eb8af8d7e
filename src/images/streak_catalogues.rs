//! Tables of detectors of streaks, converted to the columns of [`StreakTable`](super::StreakTable).
//!
//! - ASTRiDE (`streaks.txt`): a line of names that begins with `#ID`, and cells separated by blanks; `ep1_x`, `ep1_y`,
//!   `ep2_x` and `ep2_y` are the ends in pixels counted from 0. A part of a broken streak has the `ID` of the next part
//!   in `connectivity`.
//! - `acstools.findsat_mrt` (`ROOT_catalog.fits`): a table with `id`, `status` and `endpoints`, the ends
//!   ((x1, y1), (x2, y2)) in pixels counted from 0. A trail with the status 2 passed all tests of findsat_mrt; the
//!   others are left out, as in the masks of findsat_mrt.
//! - The same tables that astropy read and wrote as CSV, ECSV or FITS, and FITS tables with the columns of
//!   [`StreakTable`](super::StreakTable).
//! - Regions of SAOImage DS9 (`regions.rs`) with two ends: `line`, `vector`, `segment` and `projection`. The text of a
//!   region is the name of the streak.

use std::collections::HashMap;
use std::path::Path;

use super::fits::{BinaryCells, BinaryColumn, FrameFile, HduKind};
use super::regions::{Outline, Region, STREAKS, is_region_system, parse_regions};
use super::row_origin::RowOrigin;
use crate::error::Error;
use crate::input::{self, Column, TableRow, TableRows};

/// Status of a trail that passed all tests of findsat_mrt.
const ACCEPTED: f64 = 2.0;
/// Beginning of a file of regions that DS9 saved.
const DS9_HEAD: &str = "# Region file format: DS9";
/// Columns of the tables of findsat_mrt and of ASTRiDE, in lower case.
pub(super) const OF_FINDSAT: [&str; 3] = ["id", "status", "endpoints"];
pub(super) const OF_ASTRIDE: [&str; 5] = ["id", "ep1_x", "ep1_y", "ep2_x", "ep2_y"];

/// Table of streaks as text.
pub(super) struct StreakText {
    /// CSV or ECSV. Each row has its line in the file.
    pub text: String,
    /// Number of lines before the rows of a FITS table, which has no lines.
    pub lines_before_rows: Option<u64>,
    /// Numbers from 1 of the rows whose pixels are physical: regions of DS9 in this system.
    pub physical: Vec<usize>,
    /// Errors of rows of detectors that cannot be converted.
    pub invalid: Vec<Error>,
}

/// Returns the text of a table of streaks. Tables of detectors and FITS tables are converted.
///
/// # Errors
/// The file cannot be read, is a FITS file without a table, or a table of a detector is invalid.
pub(super) fn read(path: &Path) -> Result<StreakText, Error> {
    let bytes = input::read(path).map_err(Error::io(path))?;
    let (text, lines_before_rows) = if bytes.starts_with(b"SIMPLE  =") {
        let (text, lines) = fits(path)?;
        (text, Some(lines))
    } else {
        (input::text_of(bytes).map(input::without_mark).map_err(Error::io(path))?, None)
    };
    if is_ds9(&text) {
        let (text, physical) = ds9(path, &text)?;
        return Ok(StreakText { text, lines_before_rows, physical, invalid: Vec::new() });
    }
    let text = if text.starts_with("#ID ") { separated(path, &text)? } else { text };
    let rows = TableRows::new(text.clone()).map_err(Error::io(path))?.in_lower_case();
    let has = |columns: &[&'static str]| columns.iter().all(|column| rows.find(column).is_some());
    let mut invalid = Vec::new();
    let text = if has(&OF_FINDSAT) {
        findsat(path, rows, lines_before_rows, &mut invalid)
    } else if has(&OF_ASTRIDE) {
        astride(path, rows, &mut invalid)
    } else {
        text
    };
    Ok(StreakText { text, lines_before_rows, physical: Vec::new(), invalid })
}

/// Returns true for a file of regions: its first line is that of DS9, a coordinate system, `global` or a shape.
fn is_ds9(text: &str) -> bool {
    let first = text.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
    let is_shape = |text: &str| {
        let shapes = ["line(", "vector(", "segment(", "projection("];
        shapes.iter().any(|shape| text.trim_start_matches(['#', ' ']).starts_with(shape))
    };
    let (system, shape) = first.split_once(';').unwrap_or((first, ""));
    let is_system = is_region_system(system.trim()) && (shape.is_empty() || is_shape(shape));
    first.starts_with(DS9_HEAD) || first.starts_with("global ") || is_shape(first) || is_system
}

/// Converts regions: each row has its ends in pixels or on the sky. Also returns the numbers of the rows from 1 whose
/// pixels are physical.
fn ds9(path: &Path, text: &str) -> Result<(String, Vec<usize>), Error> {
    let regions = parse_regions(&path.display().to_string(), text, STREAKS)?;
    let in_pixels = |region: &Region| !matches!(region.outline, Outline::Sky(_));
    let is_physical = |region: &Region| matches!(region.outline, Outline::Physical(_));
    let physical = (1..).zip(&regions).filter(|(_, region)| is_physical(region)).map(|(number, _)| number).collect();
    let (has_pixels, has_sky) = (regions.iter().any(in_pixels), !regions.iter().all(in_pixels));
    let mut rows = Vec::new();
    for region in &regions {
        let ends: Vec<[f64; 2]> = match &region.outline {
            Outline::Pixels(corners) | Outline::Physical(corners) => {
                corners.iter().map(|corner| corner.fits()).collect()
            }
            Outline::Sky(corners) => corners
                .iter()
                .map(|corner| [corner.longitude_rad(), corner.latitude_rad()].map(f64::to_degrees))
                .collect(),
        };
        let &[[a, b], [c, d]] = &ends[..] else {
            let given = format!("a shape with {} corners", ends.len());
            let allowed = format!("{STREAKS}, which have two ends");
            return Err(Error::invalid("region", given, allowed).in_line("", path, region.line));
        };
        // In a file with pixels and sky, the columns of the other system are empty.
        let (before, after) = match (in_pixels(region), has_pixels && has_sky) {
            (_, false) => ("", ""),
            (true, true) => ("", ",,,,"),
            (false, true) => (",,,,", ""),
        };
        let name = region.name.replace([',', '"'], " ");
        rows.push((region.line as u64, format!("\"{name}\",{before}{a},{b},{c},{d}{after}")));
    }
    let columns = match (has_pixels, has_sky) {
        (true, false) => "id,x1_pix,y1_pix,x2_pix,y2_pix",
        (false, _) => "id,ra1_deg,dec1_deg,ra2_deg,dec2_deg",
        (true, true) => "id,x1_pix,y1_pix,x2_pix,y2_pix,ra1_deg,dec1_deg,ra2_deg,dec2_deg",
    };
    Ok((at_lines(columns, rows), physical))
}

/// Returns a table in which each row has its line, below the names of the columns in the first one. A row of the first
/// line, and one whose line is taken, is on the next free line.
fn at_lines(columns: &str, rows: impl IntoIterator<Item = (u64, String)>) -> String {
    let (mut text, mut next) = (format!("{columns}\n"), 2);
    for (line, row) in rows {
        text.extend((next..line).map(|_| '\n'));
        next = line.max(next) + 1;
        text += &row;
        text.push('\n');
    }
    text
}

/// Returns `streaks.txt` of ASTRiDE, whose cells are separated by blanks, as CSV. The number of cells is not checked.
fn separated(path: &Path, text: &str) -> Result<String, Error> {
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default().trim_start_matches('#').to_ascii_lowercase();
    let names: Vec<&str> = first.split_whitespace().collect();
    if let Some(missing) = OF_ASTRIDE.iter().find(|column| !names.contains(*column)) {
        let what = format!("column {missing} of ASTRiDE");
        let allowed = "a table with ID, ep1_x, ep1_y, ep2_x and ep2_y (ASTRiDE of 2024 or newer)";
        return Err(Error::invalid(what, "missing", allowed).in_file("", path));
    }
    let mut converted = names.join(",");
    for line in lines {
        let cells: Vec<&str> = line.split_whitespace().collect();
        converted.push('\n');
        converted += &cells.join(",").replace('"', " ");
    }
    Ok(converted + "\n")
}

/// Streak of a detector: line in its table, name, and ends in pixels counted from 0, which are not numbers yet.
struct Detected {
    line: u64,
    name: String,
    ends: [String; 4],
}

impl Detected {
    fn numbers(&self) -> Option<[f64; 4]> {
        let numbers: Vec<f64> = self.ends.iter().filter_map(|text| text.parse().ok()).collect();
        numbers.try_into().ok()
    }
}

/// Returns streaks as CSV, each on its line, with pixels counted from 1.
fn converted(streaks: &[Detected]) -> String {
    let row = |streak: &Detected| {
        // Cells that are not numbers give an error with their line when they are used.
        let ends = match streak.numbers() {
            Some(numbers) => numbers.map(|from_zero| (from_zero + 1.0).to_string()),
            None => streak.ends.clone(),
        };
        let cells = [&streak.name].into_iter().chain(&ends).map(|cell| cell.replace([',', '"'], " "));
        (streak.line, cells.collect::<Vec<_>>().join(","))
    };
    at_lines("id,x1_pix,y1_pix,x2_pix,y2_pix", streaks.iter().map(row))
}

/// Converts a table of ASTRiDE. Parts of a broken streak, each of which has the `ID` of the next one in the column
/// `connectivity`, are one streak between the two ends that are farthest apart.
fn astride(path: &Path, rows: TableRows, invalid: &mut Vec<Error>) -> String {
    let columns = OF_ASTRIDE.map(|name| rows.find(name));
    let connectivity = rows.find("connectivity");
    let mut streaks: Vec<(Detected, String)> = Vec::new();
    for row in valid_rows(path, rows, invalid) {
        let text = |column: Option<Column>| column.map_or_else(String::new, |column| row.text(column).to_owned());
        let [name, ends @ ..] = columns.map(text);
        streaks.push((Detected { line: row.line, name, ends }, text(connectivity)));
    }
    // From the last row, because the next part of a streak is below. A streak that was joined with another one is
    // `None`, and `into` has the number of the whole.
    let (mut joined, mut into): (Vec<Option<Detected>>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut of_part: HashMap<String, usize> = HashMap::new();
    while let Some((streak, next)) = streaks.pop() {
        let (name, whole) = (streak.name.clone(), joined.len());
        let following = of_part.get(&next).map(|part| {
            let mut part = *part;
            while into[part] != part {
                part = into[part];
            }
            part
        });
        let later = following.and_then(|index| {
            streak.numbers()?;
            joined[index].as_ref()?.numbers()?;
            into[index] = whole;
            joined[index].take()
        });
        joined.push(Some(match later {
            Some(later) => connected(streak, &later),
            None => streak,
        }));
        into.push(whole);
        if !name.is_empty() {
            of_part.insert(name, whole);
        }
    }
    let mut whole: Vec<Detected> = joined.into_iter().flatten().collect();
    whole.sort_by_key(|streak| streak.line);
    converted(&whole)
}

/// Returns the streak between the two ends of its parts that are farthest apart, in the line of the first part.
fn connected(first: Detected, later: &Detected) -> Detected {
    let ends: Vec<[f64; 2]> = [&first, later]
        .into_iter()
        .filter_map(Detected::numbers)
        .flat_map(|[x1, y1, x2, y2]| [[x1, y1], [x2, y2]])
        .collect();
    let pairs = ends.iter().enumerate().flat_map(|(at, end)| ends[..at].iter().map(move |other| [*other, *end]));
    let length = |[[x, y], [u, v]]: &[[f64; 2]; 2]| (x - u).hypot(y - v);
    let Some(farthest) = pairs.max_by(|one, other| length(one).total_cmp(&length(other))) else { return first };
    let ends = farthest.as_flattened().iter().map(f64::to_string).collect::<Vec<_>>();
    Detected {
        name: format!("{}+{}", first.name, later.name),
        ends: ends.try_into().unwrap_or(first.ends),
        line: first.line,
    }
}

/// Converts the catalog of findsat_mrt, without the trails that failed a test.
fn findsat(path: &Path, rows: TableRows, lines_before_rows: Option<u64>, invalid: &mut Vec<Error>) -> String {
    let [id, status, endpoints] = OF_FINDSAT.map(|name| rows.find(name));
    let mut streaks = Vec::new();
    for row in valid_rows(path, rows, invalid) {
        let text = |column: Option<Column>| column.map_or("", |column| row.text(column));
        let of_row = |error: Error| RowOrigin::new(path, row.line, lines_before_rows).of(error);
        match text(status).parse::<f64>() {
            Ok(status) if status == ACCEPTED => {}
            Ok(_) => continue,
            Err(_) => {
                let allowed = "a number; 2 for a trail that passed all tests";
                invalid.push(of_row(Error::invalid("status", format!("'{}'", text(status)), allowed)));
                continue;
            }
        }
        // `[[x1,y1],[x2,y2]]` in ECSV.
        let numbers = text(endpoints).split(['[', ']', ',', ' ']).filter(|number| !number.is_empty());
        let ends: Vec<String> = numbers.map(str::to_owned).collect();
        let count = ends.len();
        match ends.try_into() {
            Ok(ends) => streaks.push(Detected { line: row.line, name: text(id).to_owned(), ends }),
            Err(_) => invalid.push(of_row(Error::invalid("numbers in endpoints", count, "4 in each row"))),
        }
    }
    converted(&streaks)
}

/// Returns the rows that can be read, and adds the errors of the others to `invalid`.
fn valid_rows(path: &Path, rows: TableRows, invalid: &mut Vec<Error>) -> Vec<TableRow> {
    let (mut valid, failed) = (Vec::new(), Error::io(path));
    for row in rows {
        match row {
            Ok(row) => valid.push(row),
            Err(error) => invalid.push(failed(error)),
        }
    }
    valid
}

/// Returns the first table of a FITS file as ECSV, and the number of lines before its rows.
fn fits(path: &Path) -> Result<(String, u64), Error> {
    let file = FrameFile::open(path)?;
    let Some(table) = file.hdus().iter().find(|hdu| hdu.kind == HduKind::Table) else {
        let allowed = "a FITS file with a binary table, such as a catalog of findsat_mrt";
        return Err(Error::invalid("table of streaks", "missing", allowed).in_file("", path));
    };
    let columns = file.read_table(table.index)?;
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\"").replace(['\n', '\r'], " "));
    let mut text = "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n".to_owned();
    for column in &columns {
        let name = serde_json::Value::from(column.name.as_str());
        let unit = column.unit.as_deref().map(|unit| format!("unit: {}, ", serde_json::Value::from(unit)));
        text += &format!("# - {{name: {name}, {}datatype: string}}\n", unit.unwrap_or_default());
    }
    let names: Vec<String> = columns.iter().map(|column| quoted(&column.name)).collect();
    text += &format!("{}\n", names.join(","));
    let lines = text.lines().count() as u64;
    let rows = columns.iter().map(|column| match &column.cells {
        BinaryCells::Text(cells) => cells.len(),
        BinaryCells::Numbers { in_row, values } => values.len() / (*in_row).max(1),
    });
    for row in 0..rows.max().unwrap_or(0) {
        let cell = |column: &BinaryColumn| match &column.cells {
            BinaryCells::Text(cells) => quoted(&cells[row]),
            BinaryCells::Numbers { in_row: 1, values } if values[row].is_nan() => String::new(),
            BinaryCells::Numbers { in_row: 1, values } => values[row].to_string(),
            BinaryCells::Numbers { in_row, values } => {
                let numbers: Vec<String> = values[row * in_row..][..*in_row].iter().map(f64::to_string).collect();
                quoted(&format!("[{}]", numbers.join(",")))
            }
        };
        text += &format!("{}\n", columns.iter().map(cell).collect::<Vec<_>>().join(","));
    }
    Ok((text, lines))
}

#[cfg(test)]
mod tests {
    use super::super::fits::{Cells, TableColumn, write_table};
    use super::super::streak_table::{StreakEnds, StreakTable};
    use super::*;

    const HEAD: &str = "# Region file format: DS9 version 4.1\nglobal color=green\n";

    fn streak_table(path: &Path) -> StreakTable {
        StreakTable::read(path, 100, &[], |_| Ok(())).unwrap().0
    }

    #[test]
    fn regions_without_the_line_of_ds9_are_recognised() {
        for text in ["image\nline(1,2,3,4)\n", "image;line(1,2,3,4)\n", "global color=red\nimage\n# segment(1,2,3,4)\n"]
        {
            assert!(is_ds9(text), "{text}");
            let rows = ds9(Path::new("a.reg"), text).unwrap().0;
            assert!(rows.starts_with("id,x1_pix,y1_pix,x2_pix,y2_pix\n") && rows.contains("\n\"\",1,2,3,4"), "{rows}");
        }
        for text in [
            "image,x1,y1,x2,y2\na.fits,1,2,3,4\n",
            "id,ra1\n",
            "#ID ep1_x\n",
            "image;x1_pix;y1_pix\n",
            "image\tx1_pix\n",
            "",
        ] {
            assert!(!is_ds9(text), "{text}");
        }
    }

    #[test]
    fn regions_of_ds9_are_converted_with_their_lines() {
        let of = |text: &str| ds9(Path::new("a.reg"), &format!("{HEAD}{text}")).map(|(rows, _)| rows);
        let rows =
            of("image\nline(1,2,3.5,4) # line=0 0 text={one}\n\n# vector(10,20,5,0) text={#2, \"b\"}\n").unwrap();
        let lines: Vec<&str> = rows.lines().collect();
        let names = "id,x1_pix,y1_pix,x2_pix,y2_pix";
        assert_eq!(lines, [names, "", "", "\"one\",1,2,3.5,4", "", "\"#2   b \",10,20,15,20"]);
        // A vector on the sky, of angle 90°, points north.
        let rows = of("fk5\n# vector(0:40:00,-10:30:00,1800\",90) vector=1\n").unwrap();
        let lines: Vec<&str> = rows.lines().collect();
        assert_eq!((lines[0], lines.len()), ("id,ra1_deg,dec1_deg,ra2_deg,dec2_deg", 4));
        let ends: Vec<f64> = lines[3].split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        let expected = [10.0, -10.5, 10.0, -10.0];
        assert!(ends.iter().zip(expected).all(|(end, expected)| (end - expected).abs() < 1e-4), "{ends:?}");
        for (text, line, problem) in [
            ("image\ncircle(1,2,3)\n", 4, "unsupported shape 'circle'"),
            ("image\nbox(1,2,3,4)\n", 4, "a shape with 4 corners; allowed: line, vector, segment and projection"),
            ("line(1,2,3,4)\n", 3, "has no preceding coordinate system"),
            ("detector\nline(1,2,3,4)\n", 4, "unsupported coordinate system detector"),
        ] {
            let message = of(text).unwrap_err().to_string();
            assert!(message.contains(&format!("a.reg: line {line}: ")) && message.contains(problem), "{message}");
        }
    }

    /// Each row has its ends in the system of its region.
    #[test]
    fn regions_in_pixels_and_on_the_sky_are_one_table() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("a.reg");
        let text = "image;line(1,2,3,4);line(5,6,7,8)\nicrs\nline(10,-10,11,-11)\nphysical;# vector(9,9,1,0)\n";
        std::fs::write(&path, text).unwrap();
        let table = streak_table(&path);
        let ends: Vec<StreakEnds> = table.rows().map(|row| row.ends().unwrap()).collect();
        let are_physical: Vec<bool> = table.rows().map(|row| row.is_physical()).collect();
        assert_eq!(are_physical, [false, false, false, true]);
        let [StreakEnds::Pixels(_), StreakEnds::Pixels(second), StreakEnds::Sky(third), StreakEnds::Pixels(_)] =
            &ends[..]
        else {
            panic!("{ends:?}")
        };
        assert_eq!(second.map(|end| end.fits()), [[5.0, 6.0], [7.0, 8.0]]);
        assert!((third[1].latitude_rad().to_degrees() + 11.0).abs() < 1e-9);
    }

    /// Rows of `streaks.txt`: ID, connectivity and ends.
    fn of_astride(rows: &[(i32, i32, [f64; 4])]) -> String {
        let rows = rows.iter().map(|(id, next, [a, b, c, d])| format!("{id:2} 9.00 {next:2} {a} {b} {c} {d} 9.0\n"));
        "#ID area connectivity ep1_x ep1_y ep2_x ep2_y length\n".to_owned() + &rows.collect::<String>()
    }

    fn converted_table(text: &str) -> String {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("streaks.txt");
        std::fs::write(&path, text).unwrap();
        read(&path).unwrap().text
    }

    #[test]
    fn connected_parts_of_astride_are_one_streak() {
        const NAMES: &str = "id,x1_pix,y1_pix,x2_pix,y2_pix\n";
        // Two parts, the right one first, as ASTRiDE finds them; three parts of which two have the same next one.
        let text = of_astride(&[(1, 2, [50.0, 30.0, 90.0, 50.0]), (2, -1, [10.0, 10.0, 45.0, 28.0])]);
        assert_eq!(converted_table(&text), format!("{NAMES}1+2,91,51,11,11\n"));
        let parts = [(1, 5, [0.0, 0.0, 9.0, 0.0]), (2, -1, [7.0, 7.0, 8.0, 8.0])];
        let more = [(3, 5, [20.0, 0.0, 29.0, 0.0]), (5, -1, [40.0, 0.0, 31.0, 0.0])];
        let text = of_astride(&[parts, more].concat());
        assert_eq!(converted_table(&text), format!("{NAMES}1+3+5,1,1,41,1\n2,8,8,9,9\n"));
        // The same table as CSV, with a comment. Rows keep their lines.
        let csv =
            text.trim_start_matches('#').lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(","));
        let csv = format!("# seen\n{}\n", csv.collect::<Vec<_>>().join("\n"));
        assert_eq!(converted_table(&csv), format!("{NAMES}\n1+3+5,1,1,41,1\n2,8,8,9,9\n"));
    }

    #[test]
    fn the_catalog_of_findsat_is_read_from_ecsv() {
        let text = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: id, datatype: int64}\n\
                    # - {name: endpoints, datatype: string, subtype: 'float64[2,2]'}\n\
                    # - {name: status, datatype: int64}\nid endpoints status\n\
                    1 [[0.0,5.5],[9.0,7.25]] 2\n2 [[0.0,1.0],[2.0,3.0]] 1\n3 [[4.0,1.0],[2.0,3.0]] 2\n";
        let rows = converted_table(text);
        let rows: Vec<&str> = rows.lines().collect();
        assert_eq!((rows[7], rows[8], rows[9]), ("1,1,6.5,10,8.25", "", "3,5,2,3,4"));
    }

    /// Rows of detectors that are broken do not stop the others.
    #[test]
    fn broken_rows_of_detectors_are_named() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("found.txt");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let table = streak_table(&path);
            let ids: Vec<String> = table.rows().map(|row| row.id()).collect();
            (ids, table.invalid().iter().map(ToString::to_string).collect::<Vec<_>>())
        };
        let text = of_astride(&[(1, -1, [1.0, 1.0, 9.0, 9.0]), (2, -1, [20.0, 1.0, 20.0, 9.0])]);
        let (ids, errors) = read(&text.replacen(" 9.0\n", "\n", 1));
        assert_eq!(ids, ["2"]);
        assert!(errors.len() == 1 && errors[0].contains("found.txt: line 2: 7 cells, but 8 columns"), "{errors:?}");
        let (ids, errors) =
            read("id,status,endpoints\n1,2,\"[[0,1],[2,3]]\"\n2,2,\"[[0,1],[2]]\"\n3,good,\"[[0,1],[2,3]]\"\n4,1,\n");
        assert_eq!(ids, ["1"]);
        assert_eq!(errors.len(), 2, "{errors:?}");
        assert!(
            errors[0].ends_with("found.txt: line 3: numbers in endpoints is 3; allowed: 4 in each row"),
            "{errors:?}"
        );
        assert!(errors[1].contains("found.txt: line 4: status is 'good'; allowed: a number"), "{errors:?}");
    }

    /// Rows without a name and without a next part are streaks of their own.
    #[test]
    fn rows_of_astride_without_names_are_not_connected() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("streaks.csv");
        std::fs::write(&path, "ID,ep1_x,ep1_y,ep2_x,ep2_y\n,1,1,9,9\n,20,1,20,9\n,40,40,1,60\n").unwrap();
        assert_eq!(streak_table(&path).rows().count(), 3);
    }

    /// Units and missing numbers of a FITS table are kept, also with names in capitals, and its rows have numbers.
    #[test]
    fn fits_tables_with_the_columns_of_streaks_are_read() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("night[1].fits");
        let column = |name: &str, unit: &str, cells: Cells| TableColumn {
            name: name.to_owned(),
            unit: unit.to_owned(),
            meaning: String::new(),
            cells,
        };
        let angles = |name: &str| column(name, "rad", Cells::Real(vec![0.5, f64::NAN]));
        let columns = [
            column("ID", "", Cells::Text(vec!["a \"b\", c".to_owned(), "d".to_owned()])),
            column("hdu", "", Cells::Integer(vec![Some(0), None])),
            angles("RA1"),
            angles("Dec1"),
            angles("ra2"),
            column("dec2", "rad", Cells::Real(vec![0.25, 9.0])),
        ];
        write_table(&path, "STREAKS", &columns, &[]).unwrap();
        let table = streak_table(&path);
        let rows: Vec<_> = table.rows().collect();
        let StreakEnds::Sky([first, second]) = rows[0].ends().unwrap() else { panic!("ends in pixels") };
        assert!((first.separation_rad(&second) - 0.25).abs() < 1e-9);
        assert_eq!(
            (rows[0].id().as_str(), rows[0].hdu().unwrap(), rows[1].hdu().unwrap()),
            ("a \"b\", c", Some(0), None)
        );
        let error = rows[1].ends().unwrap_err().to_string();
        assert!(error.contains("night[1].fits: row 2: "), "{error}");
    }
}
