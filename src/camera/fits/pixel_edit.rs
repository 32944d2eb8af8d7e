//! The pixels of one image as they are to be: its own, with light added and values changed.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::super::header::Header;
use super::changed::Changed;
use super::checksum;
use super::deltas::Deltas;
use super::error::FrameError;
use super::hdu::{HduInfo, HduKind};
use super::overlay::Overlay;
use super::tiles::{Rebuilt, TileImage};

/// Touched bytes that lie nearer to one another are rewritten together.
const GAP: usize = 2048;
/// Share of the data, as its inverse, up to which touched bytes are rewritten in a copy; with more of them all data pass through memory.
const FEW: usize = 4;

/// Bytes that go from the input to the output at once: whole pixels of every type.
const CHUNK: usize = 1 << 20;

/// Changes to one image.
#[derive(Debug)]
pub(super) struct PixelEdit {
    path: PathBuf,
    info: HduInfo,
    columns: usize,
    light: Deltas,
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

impl PixelEdit {
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
            light: Deltas::new(info.shape.iter().product()),
            stored,
            changed: Changed::default(),
        })
    }

    /// Adds light to pixels of a row.
    pub(super) fn add(&mut self, row: usize, first_column: usize, values: &[f32]) {
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
        self.light.take(0..usize::MAX, |pixel, sum| {
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

    /// Parts of the data of an image as it is that are to change, bytes; `None` where they are many, or where there are tiles.
    pub(super) fn few_parts(&self) -> Option<Vec<Range<usize>>> {
        let StoredPixels::Plain(overlay) = &self.stored else { return None };
        let size = self.info.format.bitpix.bytes();
        let lit = self.light.touched().map(|pixels| pixels.start * size..pixels.end * size);
        let mut all: Vec<Range<usize>> = lit.chain(overlay.touched()).collect();
        all.sort_by_key(|range| range.start);
        let mut parts: Vec<Range<usize>> = Vec::new();
        for range in all {
            match parts.last_mut() {
                Some(last) if range.start < last.end + GAP => last.end = last.end.max(range.end),
                _ => parts.push(range),
            }
        }
        let touched: usize = parts.iter().map(Range::len).sum();
        (touched < self.info.data_length as usize / FEW).then_some(parts)
    }

    /// Rewrites parts of the data in a copy of them that begins at `data_at` of the output.
    pub(super) fn rewrite(
        &mut self,
        parts: &[Range<usize>],
        input: &mut File,
        mut output: &File,
        data_at: u64,
    ) -> io::Result<()> {
        let mut chunk = Vec::new();
        for part in parts {
            input.seek(SeekFrom::Start(self.info.data_at + part.start as u64))?;
            self.read_chunk(input, part.start, part.len(), &mut chunk)?;
            output.seek(SeekFrom::Start(data_at + part.start as u64))?;
            output.write_all(&chunk)?;
        }
        Ok(())
    }

    /// For an image as it is: its data from the input to the output, changed on the way; the sum of what was written, if it is wanted.
    ///
    /// While one chunk is written the next one is read, in the caller's pool of threads.
    pub(super) fn stream(&mut self, input: &mut File, output: &mut (impl Write + Send), sums: bool) -> io::Result<u32> {
        input.seek(SeekFrom::Start(self.info.data_at))?;
        let length = self.info.data_length as usize;
        let (mut ready, mut next) = (Vec::new(), Vec::new());
        let (mut from, mut sum) = (0, 0);
        self.read_chunk(input, from, CHUNK.min(length), &mut ready)?;
        while !ready.is_empty() {
            from += ready.len();
            let count = CHUNK.min(length - from);
            let (written, read) =
                rayon::join(|| output.write_all(&ready), || self.read_chunk(input, from, count, &mut next));
            written.and(read)?;
            if sums {
                sum = checksum::sum_padded(sum, &ready);
            }
            std::mem::swap(&mut ready, &mut next);
        }
        Ok(sum)
    }

    /// Some bytes of the data of an image as it is to be.
    fn read_chunk(&mut self, input: &mut File, from: usize, count: usize, chunk: &mut Vec<u8>) -> io::Result<()> {
        chunk.resize(count, 0);
        input.read_exact(chunk)?;
        let StoredPixels::Plain(overlay) = &self.stored else { return Ok(()) };
        overlay.patch(from, chunk);
        let (format, changed) = (self.info.format, &mut self.changed);
        let size = format.bitpix.bytes();
        let first = from / size;
        self.light.take(first..first + count / size, |pixel, sum| {
            let old = format.physical(format.raw(chunk, pixel - first));
            changed
                .set(old, old + sum + between_steps(pixel, format.step()), |new| format.put(chunk, pixel - first, new));
        });
        Ok(())
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
