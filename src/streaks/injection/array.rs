//! Injection of streaks into an image in memory, by way of a temporary file.

use std::path::{Path, PathBuf};

use super::super::error::StreaksError;
use super::run::Injections;
use crate::images::{FrameFile, Header, ImageValues, NewImage, Pixels, write_frame};
use crate::output::ScratchFolder;

/// Result of an injection into an image in memory.
#[derive(Clone, Debug)]
pub struct ArrayInjected {
    /// Pixels with streaks, in the type and order of the input.
    pub image: ImageValues,
    /// Mask of each pixel, as bits; `None` if no streak crosses the image.
    pub mask: Option<Vec<i32>>,
    /// Truth tables and warnings.
    pub injections: Injections,
}

/// Image in memory. It is written to a temporary file, so that the result is the same as for a file.
#[derive(Debug)]
pub struct ArrayFrame<'a> {
    image: &'a ImageValues,
    folder: ScratchFolder,
}

impl<'a> ArrayFrame<'a> {
    /// Writes the image and the header `cards` to a new folder in `scratch`, which is removed when this value is
    /// dropped.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(image: &'a ImageValues, cards: &Header, scratch: &Path) -> Result<Self, StreaksError> {
        let frame = Self { image, folder: ScratchFolder::new(scratch)? };
        write_frame(&frame.input(), &[NewImage { name: "", values: image, cards: cards.cards(), rice: None }])?;
        Ok(frame)
    }

    /// Returns the path of the file that contains the input image.
    pub fn input(&self) -> PathBuf {
        self.folder.path().join("image")
    }

    /// Returns the path of the file to which the injection must write its result.
    pub fn output(&self) -> PathBuf {
        self.folder.path().join("injected")
    }

    /// Reads the image with streaks from the output file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn finish(self, mut injections: Injections) -> Result<ArrayInjected, StreaksError> {
        for frame in &mut injections.frames {
            // The first column contains the name of the temporary file.
            frame.truth.columns.remove(0);
            frame.truth.rows.iter_mut().for_each(|row| drop(row.remove(0)));
        }
        let file = FrameFile::open(&self.output())?;
        let [rows, columns] = self.image.size();
        let values = file.read_rows(0, 0..rows)?;
        let pixels = match self.image.pixels() {
            Pixels::U8(_) => Pixels::U8(values.iter().map(|value| *value as u8).collect()),
            Pixels::I16(_) => Pixels::I16(values.iter().map(|value| *value as i16).collect()),
            Pixels::U16(_) => Pixels::U16(values.iter().map(|value| *value as u16).collect()),
            Pixels::I32(_) => Pixels::I32(values.iter().map(|value| *value as i32).collect()),
            Pixels::F32(_) => Pixels::F32(values.iter().map(|value| *value as f32).collect()),
            Pixels::F64(_) => Pixels::F64(values),
        };
        let mask_hdu = file.hdus().iter().find(|hdu| hdu.name == "MASK").map(|hdu| hdu.index);
        let mask = mask_hdu.map(|hdu| file.read_rows(hdu, 0..rows)).transpose()?;
        let mask = mask.map(|bits| bits.into_iter().map(|bit| bit as i32).collect());
        let image = ImageValues::new(columns, pixels)
            .ok_or_else(|| StreaksError::invalid("image", "empty", "at least one pixel"))?;
        Ok(ArrayInjected { image, mask, injections })
    }
}
