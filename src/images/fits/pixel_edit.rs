//! The pixels of one image as they are to be: its own, with light added and values changed.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::super::header::Header;
use super::changed::{Changed, Outcome};
use super::checksum;
use super::chunks::write_in_chunks;
use super::deltas::Deltas;
use super::error::FrameError;
use super::hdu::{HduInfo, HduKind};
use super::overlay::Overlay;
use super::positioned::read_exact_at;
use super::tiles::{Rebuilt, TileImage};

/// Changes to one image.
#[derive(Debug)]
pub(super) struct PixelEdit<'a> {
    path: PathBuf,
    info: HduInfo,
    columns: usize,
    light: Deltas<'a>,
    stored: StoredPixels,
    /// What came of them so far.
    pub changed: Changed,
}

/// Numbers as they are stored.
#[derive(Debug)]
enum StoredPixels {
    Plain(Overlay),
    Tiles(Box<TileImage>),
}

impl<'a> PixelEdit<'a> {
    pub(super) fn new(path: &Path, info: &HduInfo, header: &Header, input: &mut File) -> Result<Self, FrameError> {
        let stored = if info.kind == HduKind::Image {
            StoredPixels::Plain(Overlay::new(info.data_at, info.data_length, info.format.bitpix.bytes()))
        } else {
            let io = FrameError::io(path);
            let mut bytes = vec![0; info.data_length as usize];
            input.seek(SeekFrom::Start(info.data_at)).map_err(&io)?;
            input.read_exact(&mut bytes).map_err(&io)?;
            let tiles = TileImage::new(info, header, bytes).map_err(|why| FrameError::Tiles {
                path: path.to_owned(),
                hdu: info.index,
                why,
            })?;
            StoredPixels::Tiles(Box::new(tiles))
        };
        Ok(Self {
            path: path.to_owned(),
            info: info.clone(),
            columns: info.shape[0],
            light: Deltas::default(),
            stored,
            changed: Changed::default(),
        })
    }

    /// Adds light to pixels of a row.
    pub(super) fn add(&mut self, row: usize, first_column: usize, values: Cow<'a, [f32]>) {
        self.light.add(row * self.columns + first_column, values);
    }

    /// Changes pixels of a row, light that was added before included.
    pub(super) fn change(
        &mut self,
        input: &mut File,
        row: usize,
        columns: Range<usize>,
        change: impl FnOnce(&mut [f64]),
    ) -> Result<Changed, FrameError> {
        let start = row * self.columns + columns.start;
        let pixels = start..start + columns.len();
        let format = self.info.format;
        let mut changed = Changed::default();
        match &mut self.stored {
            StoredPixels::Plain(overlay) => {
                let size = format.bitpix.bytes();
                let range = pixels.start * size..pixels.end * size;
                let mut bytes = overlay.read(input, range.clone()).map_err(FrameError::io(&self.path))?;
                self.light.take(pixels, |pixel, sum| {
                    let old = format.physical(format.raw(&bytes, pixel - start));
                    self.changed.set(old, old + sum + between_steps(pixel, format.step()), |new| {
                        format.put(&mut bytes, pixel - start, new)
                    });
                });
                let mut values = Vec::with_capacity(columns.len());
                format.decode(&bytes, &mut values);
                let before = values.clone();
                change(&mut values);
                for (index, (new, old)) in values.iter().zip(&before).enumerate() {
                    changed.set(*old, *new, |new| format.put(&mut bytes, index, new));
                }
                overlay.write(range, &bytes);
            }
            StoredPixels::Tiles(tiles) => {
                let of_tiles = |why: String| FrameError::Tiles { path: self.path.clone(), hdu: self.info.index, why };
                let old = tiles.read(row, columns.clone()).map_err(of_tiles)?;
                self.light.take(pixels, |pixel, sum| {
                    let index = pixel - start;
                    let between = between_steps(pixel, tiles.step(row, columns.start + index));
                    self.changed
                        .set(old[index], old[index] + sum + between, |new| tiles.set(row, columns.start + index, new));
                });
                let before = tiles.read(row, columns.clone()).map_err(of_tiles)?;
                let mut values = before.clone();
                change(&mut values);
                for (index, (new, old)) in values.iter().zip(&before).enumerate() {
                    changed.set(*old, *new, |new| tiles.set(row, columns.start + index, new));
                }
            }
        }
        self.changed += changed;
        Ok(changed)
    }

    /// For a compressed image its table with the changed tiles packed again; `None` for others.
    pub(super) fn rebuilt(&mut self) -> Result<Option<Rebuilt>, FrameError> {
        let StoredPixels::Tiles(tiles) = &mut self.stored else { return Ok(None) };
        let of_tiles = |why: String| FrameError::Tiles { path: self.path.clone(), hdu: self.info.index, why };
        let (columns, changed) = (self.columns, &mut self.changed);
        let mut failed = None;
        self.light.settle();
        self.light.each(0..usize::MAX, |pixel, sum| {
            let (row, column) = (pixel / columns, pixel % columns);
            match tiles.read(row, column..column + 1) {
                Ok(old) => {
                    let between = between_steps(pixel, tiles.step(row, column));
                    changed.set(old[0], old[0] + sum + between, |new| tiles.set(row, column, new));
                }
                Err(why) => failed = Some(why),
            }
        });
        match failed {
            Some(why) => Err(of_tiles(why)),
            None => tiles.rebuilt().map(Some).map_err(of_tiles),
        }
    }

    /// For an image as it is: its data from the input into the output from `to` on, changed on the way; their sum, if it is wanted. With `is_flushed` what is
    /// written is on its way to the disk while the rest is made.
    pub(super) fn stream(
        &mut self,
        input: &File,
        output: &File,
        to: u64,
        is_summed: bool,
        is_flushed: bool,
    ) -> io::Result<Option<u32>> {
        self.light.settle();
        let chunks = write_in_chunks(output, to, self.info.data_length as usize, is_flushed, |range, bytes| {
            let mut changed = Changed::default();
            read_exact_at(input, bytes, self.info.data_at + range.start as u64)?;
            self.put_changes(range.start, bytes, &mut changed);
            Ok((changed, if is_summed { checksum::sum_padded(0, bytes) } else { 0 }))
        })?;
        let mut sum = 0;
        for (changed, of_chunk) in chunks {
            self.changed += changed;
            sum = checksum::sum(sum, &of_chunk.to_be_bytes());
        }
        Ok(is_summed.then_some(sum))
    }

    /// Brings some bytes of the data of an image to what they are to be.
    fn put_changes(&self, from: usize, bytes: &mut [u8], changed: &mut Changed) {
        let StoredPixels::Plain(overlay) = &self.stored else { return };
        overlay.patch(from, bytes);
        let format = self.info.format;
        let size = format.bitpix.bytes();
        let first = from / size;
        if format.is_plain_single() {
            // What most reduced frames are: several times faster than by way of any format.
            self.light.each(first..first + bytes.len() / size, |pixel, sum| {
                let Some(place) = bytes[size * (pixel - first)..].first_chunk_mut() else { return };
                let old = f32::from_be_bytes(*place);
                changed.set(f64::from(old), f64::from(old) + sum, |new| {
                    let new = new as f32;
                    *place = new.to_be_bytes();
                    Outcome { is_other: new != old, is_clipped: false }
                });
            });
            return;
        }
        self.light.each(first..first + bytes.len() / size, |pixel, sum| {
            let old = format.physical(format.raw(bytes, pixel - first));
            changed
                .set(old, old + sum + between_steps(pixel, format.step()), |new| format.put(bytes, pixel - first, new));
        });
    }
}

/// A fraction of the step between two values that a pixel can take, from minus to plus half of it: with it light of less than half a step is not rounded away
/// everywhere, but makes a whole step in as many pixels as it should. The same in every run, and another one for every pixel.
fn between_steps(pixel: usize, step: f64) -> f64 {
    if step == 0.0 {
        return 0.0;
    }
    // SplitMix64 (Steele, Lea & Flood 2014) of the pixel's number.
    let mut z = (pixel as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let share = ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
    (share - 0.5) * step
}
