//! Frames made from nothing.

use std::path::Path;

use crate::output::AtomicFile;

use super::super::card::Card;
use super::cfitsio::Rice;
use super::error::FrameError;
use super::image_values::ImageValues;
use super::new_hdu::{self, Place};
use super::output::write_hdu;

/// An image for [`write_frame`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct NewImage<'a> {
    /// EXTNAME; empty for none.
    pub name: &'a str,
    /// Its pixels.
    pub values: &'a ImageValues,
    /// Its cards; those that say how data lie (NAXIS, BITPIX, ...) are left out.
    pub cards: &'a [Card],
    /// How it is compressed, if it is.
    pub rice: Option<Rice>,
}

/// Makes a file of images: the first one in the primary HDU unless it is compressed, the others behind it. Each has its name and its cards.
///
/// # Errors
/// Whatever the system or CFITSIO reports; nothing half-written stays.
pub fn write_frame(target: &Path, images: &[NewImage<'_>]) -> Result<(), FrameError> {
    let io = FrameError::io(target);
    let output = AtomicFile::new(target).map_err(&io)?;
    let mut hdus = Vec::new();
    if images.first().is_none_or(|image| image.rice.is_some()) {
        hdus.push(new_hdu::empty_primary());
    }
    for image in images {
        let place = if hdus.is_empty() { Place::Primary } else { Place::Extension };
        hdus.push(match image.rice {
            Some(rice) => new_hdu::rice_image(image.name, image.values, image.cards, rice, folder_of(output.path()))?,
            None => new_hdu::image(place, image.name, image.values, image.cards),
        });
    }
    hdus.iter().try_for_each(|hdu| write_hdu(output.file(), hdu)).map_err(&io)?;
    output.finish_lazily().map_err(&io)
}

/// Where a file's neighbours lie.
pub(super) fn folder_of(target: &Path) -> &Path {
    target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
