//! Changed pixels of an uncompressed image, kept in small blocks until they are written.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

/// Pixels in a block: a streak a few tens of pixels wide touches one or two a row.
const BLOCK_PIXELS: usize = 64;

/// Blocks of an image's bytes, read when they are first touched.
#[derive(Debug)]
pub(super) struct Overlay {
    /// Where the data begin in the file, bytes.
    data_at: u64,
    /// Bytes of data.
    length: u64,
    block_bytes: usize,
    /// For each block one more than its number among those touched, 0 where it is not touched.
    slots: Vec<u32>,
    bytes: Vec<u8>,
}

impl Overlay {
    pub(super) fn new(data_at: u64, length: u64, pixel_bytes: usize) -> Self {
        let block_bytes = BLOCK_PIXELS * pixel_bytes;
        let blocks = length.div_ceil(block_bytes as u64) as usize;
        Self { data_at, length, block_bytes, slots: vec![0; blocks], bytes: Vec::new() }
    }

    /// The bytes of a range of the data as they are now; blocks not touched before are read from `file`.
    pub(super) fn read(&mut self, file: &mut (impl Read + Seek), range: Range<usize>) -> io::Result<Vec<u8>> {
        let mut found = Vec::with_capacity(range.len());
        for (block, within) in self.pieces(range) {
            if self.slots[block] == 0 {
                let from = (block * self.block_bytes) as u64;
                let count = (self.length - from).min(self.block_bytes as u64) as usize;
                let start = self.bytes.len();
                self.bytes.resize(start + self.block_bytes, 0);
                file.seek(SeekFrom::Start(self.data_at + from))?;
                file.read_exact(&mut self.bytes[start..start + count])?;
                self.slots[block] = (start / self.block_bytes) as u32 + 1;
            }
            found.extend_from_slice(&self.bytes[self.place(block, &within)]);
        }
        Ok(found)
    }

    /// Puts bytes into blocks that were read before.
    pub(super) fn write(&mut self, range: Range<usize>, bytes: &[u8]) {
        let mut rest = bytes;
        for (block, within) in self.pieces(range) {
            let (part, more) = rest.split_at(within.len());
            let place = self.place(block, &within);
            self.bytes[place].copy_from_slice(part);
            rest = more;
        }
    }

    /// Puts the touched blocks over bytes of the data that begin at `from`.
    pub(super) fn patch(&self, from: usize, bytes: &mut [u8]) {
        for (block, within) in self.pieces(from..from + bytes.len()).filter(|(block, _)| self.slots[*block] != 0) {
            let at = block * self.block_bytes + within.start - from;
            bytes[at..at + within.len()].copy_from_slice(&self.bytes[self.place(block, &within)]);
        }
    }

    /// Blocks of a range, and which of their bytes.
    fn pieces(&self, range: Range<usize>) -> impl Iterator<Item = (usize, Range<usize>)> + use<> {
        let size = self.block_bytes;
        (range.start / size..range.end.div_ceil(size)).map(move |block| {
            (block, range.start.max(block * size) - block * size..range.end.min((block + 1) * size) - block * size)
        })
    }

    fn place(&self, block: usize, within: &Range<usize>) -> Range<usize> {
        let start = (self.slots[block] as usize).saturating_sub(1) * self.block_bytes;
        start + within.start..start + within.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn verif_what_is_written_is_there_and_nothing_else() {
        let before: Vec<u8> = (0..1000).map(|n| (n % 251) as u8).collect();
        let mut file = Cursor::new(before.clone());
        let mut overlay = Overlay::new(100, 800, 1);
        assert_eq!(overlay.read(&mut file, 50..200).unwrap(), before[150..300]);
        overlay.write(60..130, &[9; 70]);
        assert_eq!(overlay.read(&mut file, 129..132).unwrap(), [9, before[230], before[231]]);
        overlay.read(&mut file, 790..800).unwrap();
        overlay.write(795..800, &[7; 5]);
        let mut expected = before.clone();
        expected[160..230].fill(9);
        expected[895..900].fill(7);
        for cut in [0, 70, 128, 799, 800] {
            let mut after = before.clone();
            let (first, second) = after[100..900].split_at_mut(cut);
            overlay.patch(0, first);
            overlay.patch(cut, second);
            assert_eq!(after, expected);
        }
    }
}
