//! Streaks put into an image that is no file.

use std::path::Path;

use super::error::InjectionError;
use super::light::SkyOf;
use super::run::{Injections, inject_frames};
use super::said::InjectionSaid;
use crate::config::Setup;
use crate::images::{FrameFile, Header, ImageValues, NewImage, Pixels, write_frame};
use crate::output::ScratchFolder;

/// An image with streaks.
#[derive(Clone, Debug)]
pub struct ArrayInjected {
    /// Its pixels, of the type and in the order of those given.
    pub image: ImageValues,
    /// Bits for each pixel; `None` where no streak crosses it.
    pub mask: Option<Vec<i32>>,
    /// Truth and what the user should know; one frame.
    pub told: Injections,
}

/// Puts streaks into an image in memory.
///
/// The image goes the way of a file, through the folder `scratch`, which is left as it was: so it is the same to the last bit as a file of it would
/// be. `cards` are its header: world coordinates, and whatever is not said of exposure, zero point and gain.
///
/// # Errors
/// [`InjectionError`].
pub fn inject_into_array(
    said: &InjectionSaid,
    setup: &Setup,
    sky: Option<SkyOf<'_>>,
    image: &ImageValues,
    cards: &Header,
    scratch: &Path,
) -> Result<ArrayInjected, InjectionError> {
    let folder = ScratchFolder::new(scratch)?;
    let (input, output) = (folder.path().join("image"), folder.path().join("injected"));
    write_frame(&input, &[NewImage { name: "", values: image, cards: cards.cards(), rice: None }])?;
    let said = InjectionSaid { image: vec![input], synthetic: None, ..said.clone() };
    let mut told = inject_frames(&said, setup, sky, std::slice::from_ref(&output))?;
    for frame in &mut told.frames {
        // The file's name means nothing to anyone.
        frame.truth.columns.remove(0);
        frame.truth.rows.iter_mut().for_each(|row| drop(row.remove(0)));
    }
    let file = FrameFile::open(&output)?;
    let [rows, columns] = image.size();
    let values = file.read_rows(0, 0..rows)?;
    let pixels = match image.pixels() {
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
    let image = ImageValues::new(columns, pixels).ok_or_else(|| InjectionError::said("no image"))?;
    Ok(ArrayInjected { image, mask, told })
}
