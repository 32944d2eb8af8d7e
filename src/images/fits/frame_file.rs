//! A frame in a file, to be read.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::super::header::Header;
use super::super::plane::Plane;
use super::cfitsio;
use super::error::FrameError;
use super::hdu::{HduInfo, HduKind, scan};
use super::room::Room;

/// Bytes that are read and turned at once.
const CHUNK: usize = 1 << 18;

/// A FITS file whose structure is known: single images, mosaics, compressed tiles (`.fz`), tables.
///
/// Opening reads the headers alone. The file is never written to. What is not compressed is read directly, what is compressed through CFITSIO.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameFile {
    path: PathBuf,
    hdus: Vec<HduInfo>,
    headers: Vec<Header>,
}

impl FrameFile {
    /// Opens a file. Its name is taken as it is: brackets and exclamation marks have no meaning.
    ///
    /// # Errors
    /// [`FrameError`]: missing, a directory, not readable; packed; no FITS; cut off; a header that does not describe its data; bytes behind an HDU
    /// that belong to none.
    pub fn open(path: &Path) -> Result<Self, FrameError> {
        let io = FrameError::io(path);
        let mut file = File::open(path).map_err(&io)?;
        if file.metadata().map_err(&io)?.is_dir() {
            return Err(io(std::io::Error::new(std::io::ErrorKind::IsADirectory, "is a directory")));
        }
        let (hdus, headers) = scan(path, &mut file)?.into_iter().unzip();
        Ok(Self { path: path.to_owned(), hdus, headers })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its parts, in order.
    pub fn hdus(&self) -> &[HduInfo] {
        &self.hdus
    }

    /// Numbers of the HDUs that hold an image of two axes.
    pub fn images(&self) -> Vec<usize> {
        self.hdus.iter().filter(|hdu| hdu.image_size().is_some()).map(|hdu| hdu.index).collect()
    }

    /// One of its parts.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`].
    pub fn hdu(&self, hdu: usize) -> Result<&HduInfo, FrameError> {
        self.hdus.get(hdu).ok_or_else(|| FrameError::NoHdu { path: self.path.clone(), hdu, last: self.hdus.len() - 1 })
    }

    /// The header of a part.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`].
    pub fn header(&self, hdu: usize) -> Result<&Header, FrameError> {
        self.hdu(hdu).map(|info| &self.headers[info.index])
    }

    /// Rows and columns of an image of two axes.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`], [`FrameError::NoImage`].
    pub fn image_size(&self, hdu: usize) -> Result<[usize; 2], FrameError> {
        self.image(hdu).map(|(_, size)| size)
    }

    /// Rows and columns of an image, with its part.
    pub(super) fn image(&self, hdu: usize) -> Result<(&HduInfo, [usize; 2]), FrameError> {
        let info = self.hdu(hdu)?;
        let size = info.image_size().ok_or_else(|| FrameError::NoImage {
            path: self.path.clone(),
            hdu,
            is: info.words(),
            images: self.images(),
        })?;
        Ok((info, size))
    }

    /// All pixels of an image, physical values (BSCALE and BZERO applied), in single precision; NaN where there is none (NaN, BLANK).
    ///
    /// # Errors
    /// [`FrameError::NoHdu`], [`FrameError::NoImage`], and whatever the system or CFITSIO reports.
    pub fn read_plane(&self, hdu: usize) -> Result<Plane, FrameError> {
        let (info, [rows, columns]) = self.image(hdu)?;
        let mut plane = Plane::zeros(rows, columns);
        if let HduKind::CompressedImage(_) = info.kind {
            cfitsio::read_image(&self.path, hdu, info.shape.len(), plane.values_mut())?;
            return Ok(plane);
        }
        let io = FrameError::io(&self.path);
        let mut file = File::open(&self.path).map_err(&io)?;
        file.seek(SeekFrom::Start(info.data_at)).map_err(&io)?;
        let size = info.format.bitpix.bytes();
        let mut room = Room::new(CHUNK);
        for values in plane.values_mut().chunks_mut(CHUNK / size) {
            let bytes = room.first(values.len() * size);
            file.read_exact(bytes).map_err(&io)?;
            info.format.decode_single(bytes, values);
        }
        Ok(plane)
    }

    /// Some rows of an image, physical values in double precision, row after row; NaN where there is none.
    ///
    /// # Errors
    /// As [`read_plane`](FrameFile::read_plane), and [`FrameError::Outside`] where the image has no such rows.
    pub fn read_rows(&self, hdu: usize, range: Range<usize>) -> Result<Vec<f64>, FrameError> {
        let (info, [rows, columns]) = self.image(hdu)?;
        if range.end > rows || range.start > range.end {
            let row = range.end.max(range.start).saturating_sub(1);
            return Err(FrameError::Outside {
                path: self.path.clone(),
                hdu,
                columns,
                rows,
                row,
                first: 0,
                last: columns - 1,
            });
        }
        if let HduKind::CompressedImage(_) = info.kind {
            let mut all = vec![0.0; rows * columns];
            cfitsio::read_image(&self.path, hdu, info.shape.len(), &mut all)?;
            return Ok(all[range.start * columns..range.end * columns].to_vec());
        }
        let io = FrameError::io(&self.path);
        let mut file = File::open(&self.path).map_err(&io)?;
        let row_length = columns * info.format.bitpix.bytes();
        file.seek(SeekFrom::Start(info.data_at + (range.start * row_length) as u64)).map_err(&io)?;
        let mut bytes = vec![0; range.len() * row_length];
        file.read_exact(&mut bytes).map_err(&io)?;
        let mut values = Vec::with_capacity(range.len() * columns);
        info.format.decode(&bytes, &mut values);
        Ok(values)
    }
}
