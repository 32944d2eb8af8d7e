//! Table of streaks that a user or a detector of streaks wrote, one row a streak: the ends of each streak in pixels or
//! on the sky, and the frame to which it belongs. Upper and lower case of the names of columns are equivalent, unless
//! names differ in nothing else.

use std::io;
use std::path::{Path, PathBuf};

use super::pixels::PixelPosition;
use super::row_origin::RowOrigin;
use super::streak_catalogues::{self, OF_ASTRIDE, OF_FINDSAT, StreakText};
use crate::error::Error;
use crate::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};
use crate::input::{Column, TableRow, TableRows, comments_warning};
use crate::message::{Quoted, listed};
use crate::units::{DEGREES, PIXELS, Unit, is_right_ascension};

/// Ends of a streak.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum StreakEnds {
    /// Positions in the frame.
    Pixels([PixelPosition; 2]),
    /// ICRS directions.
    Sky([Direction<Gcrs>; 2]),
}

/// Largest accepted position and length, pixels.
const FARTHEST_PIX: f64 = 1e6;
/// Largest accepted length of a streak on the sky, degrees.
const LONGEST_DEG: f64 = 90.0;
/// The groups of columns of which each row must have one.
const FORMS: &str = "x1_pix, y1_pix, x2_pix, y2_pix; ra1_deg, dec1_deg, ra2_deg, dec2_deg; x_pix, y_pix, angle_deg, \
                     length_pix; or ra_deg, dec_deg, position_angle_deg, length_deg";

/// Column with numbers of a limited range.
#[derive(Copy, Clone, Debug)]
pub struct Bounded {
    name: &'static str,
    column: Column,
    range: [f64; 2],
}

/// Row of a table of streaks. Cells are read with the columns of its [`StreakTable`].
#[derive(Clone, Debug)]
pub struct StreakRow<'a> {
    table: &'a StreakTable,
    cells: &'a TableRow,
    /// Number of the row in the table, from 1.
    number: usize,
}

/// Table of streaks, read completely.
#[derive(Clone, Debug)]
pub struct StreakTable {
    path: PathBuf,
    names: Vec<String>,
    forms: Vec<Form>,
    id: Option<Column>,
    /// Name of the streak in a table of measured streaks, whose column `name` is that of the satellite, if it is known.
    streak: Option<Column>,
    image: Option<Column>,
    hdu: Option<Column>,
    comments_like_rows: usize,
    /// Names of the columns that the caller reads.
    also: Vec<&'static str>,
    /// Rows that can be read, with their numbers from 1.
    rows: Vec<(usize, TableRow)>,
    /// Errors of rows that cannot be read.
    invalid: Vec<Error>,
    /// Number of lines before the rows of a FITS table, whose rows have numbers in errors.
    lines_before_rows: Option<u64>,
    /// Numbers of the rows whose pixels are physical.
    physical: Vec<usize>,
}

/// The way in which four columns give the ends of a streak.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Kind {
    PixelEnds,
    SkyEnds,
    PixelCentre,
    SkyCentre,
}

/// Four columns that give the ends of a streak.
#[derive(Clone, Debug)]
struct Form {
    kind: Kind,
    columns: [Bounded; 4],
}

/// Names, unit and range of the columns of each form.
type FormColumns = (Kind, [(&'static str, &'static str, &'static Unit, [f64; 2]); 4]);

static FORM_COLUMNS: [FormColumns; 4] = {
    const PIX: [f64; 2] = [-FARTHEST_PIX, FARTHEST_PIX];
    const RA: [f64; 2] = [-360.0, 360.0];
    const DEC: [f64; 2] = [-90.0, 90.0];
    [
        (
            Kind::PixelEnds,
            [
                ("x1_pix", "x1", &PIXELS, PIX),
                ("y1_pix", "y1", &PIXELS, PIX),
                ("x2_pix", "x2", &PIXELS, PIX),
                ("y2_pix", "y2", &PIXELS, PIX),
            ],
        ),
        (
            Kind::SkyEnds,
            [
                ("ra1_deg", "ra1", &DEGREES, RA),
                ("dec1_deg", "dec1", &DEGREES, DEC),
                ("ra2_deg", "ra2", &DEGREES, RA),
                ("dec2_deg", "dec2", &DEGREES, DEC),
            ],
        ),
        (
            Kind::PixelCentre,
            [
                ("x_pix", "x", &PIXELS, PIX),
                ("y_pix", "y", &PIXELS, PIX),
                ("angle_deg", "angle", &DEGREES, RA),
                ("length_pix", "length_pix", &PIXELS, [0.0, FARTHEST_PIX]),
            ],
        ),
        (
            Kind::SkyCentre,
            [
                ("ra_deg", "ra", &DEGREES, RA),
                ("dec_deg", "dec", &DEGREES, DEC),
                ("position_angle_deg", "position_angle", &DEGREES, RA),
                ("length_deg", "length_deg", &DEGREES, [0.0, LONGEST_DEG]),
            ],
        ),
    ]
};

impl StreakTable {
    /// Reads a table of at most `most` streaks. `further` returns further columns of the rows, which have the names
    /// `also`.
    ///
    /// # Errors
    /// The file cannot be read, no form of the ends has all of its columns, two columns have the same name, a unit is
    /// invalid, or there are more streaks.
    pub(crate) fn read<T>(
        path: &Path,
        most: usize,
        also: &[&'static str],
        further: impl FnOnce(&TableRows) -> io::Result<T>,
    ) -> Result<(Self, T), Error> {
        let failed = Error::io(path);
        let StreakText { text, lines_before_rows, physical, mut invalid } = streak_catalogues::read(path)?;
        let mut rows = TableRows::new(text).map_err(&failed)?.in_lower_case();
        let check = |name: &&'static str| rows.check_unambiguous(name).map_err(&failed);
        let mut forms = Vec::new();
        for (kind, columns) in &FORM_COLUMNS {
            let mut found = Vec::new();
            for &(name, short, unit, range) in columns {
                found.extend(Bounded::find(&rows, &[name, short], unit, range).map_err(&failed)?);
            }
            forms.extend(<[Bounded; 4]>::try_from(found).ok().map(|columns| Form { kind: *kind, columns }));
        }
        if forms.is_empty() {
            let of_ends =
                FORM_COLUMNS.iter().flat_map(|(_, columns)| columns.iter().flat_map(|column| [column.0, column.1]));
            of_ends.chain(OF_FINDSAT).chain(OF_ASTRIDE).try_for_each(|name| check(&name))?;
            let given = format!("columns {}", listed(rows.names().iter().map(String::as_str)));
            return Err(Error::invalid("table of streaks", given, FORMS).in_file("", path));
        }
        let [id, name, streak, image, hdu] = ["id", "name", "streak", "image", "hdu"].map(|column| rows.find(column));
        let names_of_streaks: &[&str] = if id.is_some() { &[] } else { &["id", "name"] };
        names_of_streaks.iter().chain(&["streak", "image", "hdu"]).chain(also).try_for_each(check)?;
        let id = id.or(name);
        let more = further(&rows).map_err(&failed)?;
        let (names, comments_like_rows) = (rows.names().to_vec(), rows.comments_like_rows);
        let mut read = Vec::new();
        for (row, number) in rows.by_ref().zip(1..) {
            match row {
                Ok(row) => read.push((number, row)),
                Err(error) => invalid.push(failed(error)),
            }
            if number > most {
                let allowed = format!("1 to {most}");
                return Err(Error::invalid("number of streaks", format!("above {most}"), allowed).in_file("", path));
            }
        }
        let (path, rows, also) = (path.to_owned(), read, also.to_vec());
        let table = Self {
            path,
            names,
            forms,
            id,
            streak,
            image,
            hdu,
            comments_like_rows,
            also,
            rows,
            invalid,
            lines_before_rows,
            physical,
        };
        Ok((table, more))
    }

    /// Returns remarks about the columns: which group gives the ends if there are several, and which columns are not
    /// used.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let path = self.path.display();
        let groups: Vec<String> =
            self.forms.iter().map(|form| form.columns.map(|column| column.name).join(", ")).collect();
        let several = (groups.len() > 1).then(|| {
            format!("{path}: the ends of each streak are those of the first complete group: {}", groups.join("; "))
        });
        let of_ends =
            FORM_COLUMNS.iter().flat_map(|(_, columns)| columns.iter().flat_map(|column| [column.0, column.1]));
        let known: Vec<&str> = ["id", "streak", "name", "image", "hdu"]
            .into_iter()
            .chain(of_ends)
            .chain(self.also.iter().copied())
            .collect();
        // A column may have another unit than the one in the known name.
        let stem = |name: &str| name.rsplit_once('_').map(|(stem, _)| stem.to_owned());
        let is_known = |name: &str| {
            known.iter().any(|known| *known == name || stem(name).is_some_and(|own| stem(known) == Some(own)))
        };
        let others: Vec<&str> = self.names.iter().map(String::as_str).filter(|name| !is_known(name)).collect();
        let unused = (!others.is_empty()).then(|| format!("{path}: columns that are not used: {}", listed(others)));
        let comments = comments_warning(self.comments_like_rows).map(|warning| format!("{path}: {warning}"));
        several.into_iter().chain(unused).chain(comments).collect()
    }

    /// Returns the errors of rows that cannot be read, such as those of another number of cells.
    pub fn invalid(&self) -> &[Error] {
        &self.invalid
    }

    /// Returns the rows that can be read.
    pub fn rows(&self) -> impl Iterator<Item = StreakRow<'_>> {
        self.rows.iter().map(|(number, cells)| StreakRow { table: self, cells, number: *number })
    }
}

impl Bounded {
    /// Returns a column whose numbers are limited to `range`; `None` if it is missing. `accepted` are its names, the
    /// first of which errors name.
    ///
    /// # Errors
    /// The errors of [`TableRows::optional_numbers`].
    pub(crate) fn find(
        rows: &TableRows,
        accepted: &[&'static str],
        unit: &'static Unit,
        range: [f64; 2],
    ) -> io::Result<Option<Self>> {
        let column = rows.optional_numbers(accepted, unit)?;
        Ok(column.map(|column| Self { name: accepted[0], column, range }))
    }
}

impl StreakRow<'_> {
    /// Returns the text of a cell; empty if the column is missing.
    pub(crate) fn text(&self, column: Option<Column>) -> &str {
        column.map_or("", |column| self.cells.text(column))
    }

    /// Returns the table and the line, or the row of a FITS table, for errors.
    pub(crate) fn origin(&self) -> RowOrigin {
        RowOrigin::new(&self.table.path, self.cells.line, self.table.lines_before_rows)
    }

    /// Returns the error of an invalid cell, with file, line and column.
    pub(crate) fn invalid(&self, column: &str, given: &str, allowed: impl Into<String>) -> Error {
        let given = if given.is_empty() { "missing".to_owned() } else { format!("'{}'", Quoted::new(given)) };
        self.origin().of(Error::invalid(column, given, allowed))
    }

    /// Returns the number in a cell; `None` if the column is missing or the cell is empty.
    ///
    /// # Errors
    /// The cell is not a number, the number is out of range, or it contradicts another column of the same quantity.
    pub(crate) fn number(&self, column: Option<Bounded>) -> Result<Option<f64>, Error> {
        let Some(Bounded { name, column, range: [least, most] }) = column else { return Ok(None) };
        let text = self.cells.text(column);
        if self.cells.is_missing(column) {
            return Ok(None);
        }
        if let Some(error) = self.cells.contradiction(column) {
            return Err(self.origin().of(error));
        }
        let sexagesimal = if is_right_ascension(name) {
            Some((parse_right_ascension_deg as fn(&str) -> Result<f64, Error>, "12h34m56s"))
        } else {
            name.starts_with("dec").then_some((parse_declination_deg as _, "-30d30m15s"))
        };
        let angle_deg = || sexagesimal.and_then(|(parse, _)| parse(text).ok());
        match self.cells.number(column).or_else(angle_deg) {
            Some(number) if (least..=most).contains(&number) => Ok(Some(number)),
            _ => {
                let or = sexagesimal.map_or_else(String::new, |(_, example)| format!(", or text such as {example}"));
                let range = match least {
                    f64::MIN_POSITIVE => format!("above 0, at most {most}"),
                    _ => format!("{least} to {most}{or}"),
                };
                Err(self.invalid(name, text, range))
            }
        }
    }

    /// Returns the name of the streak: the cell `id`, or `name` in a table without this column, or the number of the
    /// row from 1 if it and the cell `streak` are empty.
    pub fn id(&self) -> String {
        let names = [self.table.id, self.table.streak].map(|column| self.text(column));
        names.into_iter().find(|name| !name.is_empty()).map_or_else(|| self.number.to_string(), str::to_owned)
    }

    /// Returns true if ends in pixels are in physical pixels: see [`PixelPosition::of_physical`].
    pub fn is_physical(&self) -> bool {
        self.table.physical.contains(&self.number)
    }

    /// Returns the name of the file to which the row belongs; `None` for all.
    pub fn image(&self) -> Option<&str> {
        Some(self.text(self.table.image)).filter(|image| !image.is_empty())
    }

    /// Returns the number of the HDU to which the row belongs; `None` for all.
    ///
    /// # Errors
    /// The cell is not the number of an HDU.
    pub fn hdu(&self) -> Result<Option<usize>, Error> {
        match self.text(self.table.hdu) {
            "" => Ok(None),
            text => {
                let hdu = text.parse().map_err(|_| self.invalid("hdu", text, "the number of an HDU, from 0"))?;
                Ok(Some(hdu))
            }
        }
    }

    /// Returns true if the four cells of a form of the ends are not empty.
    pub fn has_ends(&self) -> bool {
        let is_given = |column: &Bounded| !self.cells.is_missing(column.column);
        self.table.forms.iter().any(|form| form.columns.iter().all(is_given))
    }

    /// Returns the ends of the streak: those of the first form whose four cells have numbers, in the order pixel ends,
    /// ends on the sky, centre in pixels, centre on the sky.
    ///
    /// # Errors
    /// No form is complete, or a number is out of range.
    pub fn ends(&self) -> Result<StreakEnds, Error> {
        let mut incomplete = None;
        for Form { kind, columns } in &self.table.forms {
            let empty = columns.iter().filter(|column| self.cells.is_missing(column.column));
            match empty.clone().count() {
                0 => return self.ends_of(*kind, columns),
                4 => {}
                _ => incomplete = incomplete.or(empty.map(|column| column.name).next()),
            }
        }
        Err(self.invalid(incomplete.unwrap_or("ends of the streak"), "", FORMS))
    }

    fn ends_of(&self, kind: Kind, columns: &[Bounded; 4]) -> Result<StreakEnds, Error> {
        let [mut a, mut b, mut c, mut d] = [0.0; 4];
        for (number, column) in [&mut a, &mut b, &mut c, &mut d].into_iter().zip(columns) {
            *number = self.number(Some(*column))?.unwrap_or_default();
        }
        let direction =
            |ra_deg: f64, dec_deg: f64| Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians());
        Ok(match kind {
            Kind::PixelEnds => StreakEnds::Pixels([PixelPosition::from_fits(a, b), PixelPosition::from_fits(c, d)]),
            Kind::SkyEnds => StreakEnds::Sky([direction(a, b), direction(c, d)]),
            Kind::PixelCentre => {
                let (sin, cos) = c.to_radians().sin_cos();
                let end = |half: f64| PixelPosition::from_fits(a + half * d * cos, b + half * d * sin);
                StreakEnds::Pixels([end(-0.5), end(0.5)])
            }
            Kind::SkyCentre => {
                let centre: Direction<Gcrs> = direction(a, b);
                let (east, north) = centre.east_north();
                let ahead = east * c.to_radians().sin() + north * c.to_radians().cos();
                let end = |half: f64| {
                    let (sin, cos) = (half * d.to_radians()).sin_cos();
                    Direction::from_vector(centre.vector() * cos + ahead * sin)
                };
                StreakEnds::Sky([end(-0.5), end(0.5)])
            }
        })
    }
}
