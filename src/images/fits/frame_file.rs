//! Reader of frames in FITS files.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::super::header::Header;
use super::super::pixels::Plane;
use super::cfitsio::{CPixel, Handle};
use super::hdu::{HduInfo, HduKind, scan};
use super::tile_header::columns;
use super::tile_table::TileTable;
use crate::error::Error;
use crate::input;

/// FITS file with its structure: single images, mosaics, compressed tiles (`.fz`) and tables.
///
/// Opening reads and checks only the headers; pixels are read by CFITSIO. The file is never changed.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameFile {
    path: PathBuf,
    hdus: Vec<HduInfo>,
    headers: Vec<Header>,
}

impl FrameFile {
    /// Opens a file. The name is used literally: brackets and exclamation marks have no special meaning.
    ///
    /// # Errors
    /// - The file is missing, a directory, not readable, compressed as a whole, not FITS or truncated.
    /// - A header does not describe its data, or an HDU is followed by bytes that are not a header.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let io = Error::io(path);
        let mut file = input::open(path).map_err(&io)?;
        let (hdus, headers) = scan(path, &mut file)?.into_iter().unzip();
        Ok(Self { path: path.to_owned(), hdus, headers })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the HDUs in order.
    #[doc(hidden)]
    pub fn hdus(&self) -> &[HduInfo] {
        &self.hdus
    }

    /// Returns the numbers of the HDUs that contain a two-dimensional image.
    pub fn images(&self) -> Vec<usize> {
        self.hdus.iter().filter(|hdu| hdu.image_size().is_some()).map(|hdu| hdu.index).collect()
    }

    /// Returns one HDU.
    ///
    /// # Errors
    /// The file does not have this HDU.
    #[doc(hidden)]
    pub fn hdu(&self, hdu: usize) -> Result<&HduInfo, Error> {
        self.hdus.get(hdu).ok_or_else(|| {
            Error::invalid(format!("HDU {hdu}"), "missing", format!("0 to {}", self.hdus.len() - 1))
                .in_file("", &self.path)
        })
    }

    /// Returns the header of an HDU.
    ///
    /// # Errors
    /// The file does not have this HDU.
    pub fn header(&self, hdu: usize) -> Result<&Header, Error> {
        self.hdu(hdu).map(|info| &self.headers[info.index])
    }

    /// Returns the numbers of rows and columns of a two-dimensional image.
    ///
    /// # Errors
    /// The HDU is missing or not a two-dimensional image.
    pub fn image_size(&self, hdu: usize) -> Result<[usize; 2], Error> {
        self.image(hdu).map(|(_, size)| size)
    }

    /// Returns the HDU of an image, with its numbers of rows and columns.
    pub(super) fn image(&self, hdu: usize) -> Result<(&HduInfo, [usize; 2]), Error> {
        let info = self.hdu(hdu)?;
        let size = info.image_size().ok_or_else(|| {
            let remedy = info.cube.as_ref().filter(|_| info.is_image()).map(|(_, remedy)| remedy);
            let allowed = match (self.images(), remedy) {
                (images, Some(remedy)) if images.is_empty() => format!("an image of two axes: {remedy}"),
                (images, None) if images.is_empty() => "an image of two axes (the file has none)".to_owned(),
                (images, _) => format!("an image of two axes: HDU {images:?}"),
            };
            Error::invalid(format!("HDU {hdu}"), info.words(), allowed).in_file("", &self.path)
        })?;
        Ok((info, size))
    }

    /// Returns an error for pixels outside an image; `columns` are the first column and the one after the last.
    pub(super) fn outside(&self, hdu: usize, row: usize, columns: [usize; 2]) -> Error {
        let [first, end] = columns;
        let [rows, columns] = self.image_size(hdu).unwrap_or_default();
        Error::invalid(
            format!("row {row}, columns {first} to {}", end.max(1) - 1),
            "outside the image",
            format!("{rows} rows and {columns} columns, counted from 0"),
        )
        .in_hdu(&self.path, hdu)
    }

    /// Reads all pixels of an image as physical values (BSCALE and BZERO applied) in single precision. Pixels without a
    /// value (NaN, BLANK) become NaN.
    ///
    /// # Errors
    /// The HDU is missing or not a two-dimensional image, headers or tiles are invalid, or CFITSIO fails.
    pub fn read_plane(&self, hdu: usize) -> Result<Plane, Error> {
        let [rows, _] = self.image_size(hdu)?;
        self.read_strip(hdu, 0..rows)
    }

    /// Reads adjacent rows as [`read_plane`](FrameFile::read_plane) does.
    pub(crate) fn read_strip(&self, hdu: usize, rows: Range<usize>) -> Result<Plane, Error> {
        let (info, [row_count, columns]) = self.image(hdu)?;
        if rows.end > row_count {
            return Err(self.outside(hdu, rows.end - 1, [0, columns]));
        }
        let mut handle = self.checked(info)?;
        let mut strip = Plane::zeros(rows.len(), columns);
        handle.read_pixels(rows.start * columns, strip.values_mut(), has_marks(info))?;
        Ok(strip)
    }

    /// Reads some rows of an image as physical values in double precision, row by row. Pixels without a value become
    /// NaN.
    ///
    /// # Errors
    /// The errors of [`read_plane`](FrameFile::read_plane), and rows outside the image.
    pub fn read_rows(&self, hdu: usize, rows: impl IntoIterator<Item = usize>) -> Result<Vec<f64>, Error> {
        let (info, [row_count, columns]) = self.image(hdu)?;
        let rows: Vec<usize> = rows.into_iter().collect();
        if let Some(&row) = rows.iter().max().filter(|row| **row >= row_count) {
            return Err(self.outside(hdu, row, [0, columns]));
        }
        let mut handle = self.checked(info)?;
        let mut values = vec![f64::NO_VALUE; rows.len() * columns];
        let mut rest = &mut values[..];
        for neighbours in rows.chunk_by(|row, next| row + 1 == *next) {
            let (these, others) = rest.split_at_mut(neighbours.len() * columns);
            handle.read_pixels(neighbours[0] * columns, these, has_marks(info))?;
            rest = others;
        }
        Ok(values)
    }

    /// Opens the file in CFITSIO at an image, after checking the headers of all HDUs before it, which CFITSIO also
    /// reads.
    fn checked(&self, info: &HduInfo) -> Result<Handle<'_>, Error> {
        for (before, header) in self.hdus.iter().zip(&self.headers).take(info.index) {
            if before.kind == HduKind::Table {
                columns(header).map_err(|error| error.in_hdu(&self.path, before.index))?;
            }
        }
        if let HduKind::CompressedImage(_) = info.kind {
            TileTable::read(&self.path, info, &self.headers[info.index])?;
        }
        let mut handle = Handle::open(&self.path)?;
        handle.go_to(info.index)?;
        Ok(handle)
    }
}

/// Returns true if pixels without a value are marked by a number instead of NaN.
fn has_marks(info: &HduInfo) -> bool {
    info.kind != HduKind::Image || info.format.bitpix.is_integer()
}
