//! The checksums of FITS: DATASUM of the data, CHECKSUM of a whole HDU.
//!
//! FITS standard 4.0, section 4.4.2.7 and appendix J: sums of 32-bit words in ones' complement, written as 16 letters and digits that make the sum of the
//! whole HDU all ones.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

use super::hdu::{BLOCK, padded};

/// Bytes in quotation marks of a CHECKSUM card.
const PLACE: Range<usize> = 11..27;

/// The ones' complement sum of bytes, their number a multiple of four, added to another.
pub(super) fn sum(start: u32, bytes: &[u8]) -> u32 {
    // 2^32 words fit before 64 bits run over; files are summed in chunks far below that.
    let words = bytes.chunks_exact(4).map(|word| u64::from(u32::from_be_bytes([word[0], word[1], word[2], word[3]])));
    let mut total: u64 = u64::from(start) + words.sum::<u64>();
    while total >> 32 != 0 {
        total = (total & 0xffff_ffff) + (total >> 32);
    }
    total as u32
}

/// The same for bytes of any number, with zeros behind them: the end of some data.
pub(super) fn sum_padded(start: u32, bytes: &[u8]) -> u32 {
    let whole = bytes.len() / 4 * 4;
    let mut last = [0; 4];
    last[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
    sum(sum(start, &bytes[..whole]), &last)
}

/// The sum of a range of a file and of the padding behind it.
pub(super) fn sum_of(file: &mut File, range: Range<u64>, pad_byte: u8) -> io::Result<u32> {
    file.seek(SeekFrom::Start(range.start))?;
    let length = range.end - range.start;
    let padding = vec![pad_byte; (padded(length) - length) as usize];
    let mut reader = file.take(length).chain(padding.as_slice());
    let mut chunk = vec![0; BLOCK * 100];
    let (mut left, mut total) = (padded(length), 0);
    while left > 0 {
        let count = left.min(chunk.len() as u64) as usize;
        reader.read_exact(&mut chunk[..count])?;
        total = sum(total, &chunk[..count]);
        left -= count as u64;
    }
    Ok(total)
}

/// Fills in the CHECKSUM card of a header's bytes, where it has one with room, given the sum of its data.
pub(super) fn seal(header: &mut [u8], datasum: u32) {
    let Some(card) = header.chunks_exact_mut(80).find(|card| card.starts_with(b"CHECKSUM= '")) else { return };
    card[PLACE].fill(b'0');
    let total = sum(datasum, header);
    let letters = encode(!total);
    if let Some(card) = header.chunks_exact_mut(80).find(|card| card.starts_with(b"CHECKSUM= '")) {
        card[PLACE].copy_from_slice(&letters);
    }
}

/// A number as 16 letters and digits whose sum, word by word, is the number.
fn encode(value: u32) -> [u8; 16] {
    let is_sign = |byte: u8| (0x3a..=0x40).contains(&byte) || (0x5b..=0x60).contains(&byte);
    let mut letters = [0; 16];
    for (place, byte) in value.to_be_bytes().into_iter().enumerate() {
        let quarter = byte / 4 + b'0';
        let mut parts = [quarter + byte % 4, quarter, quarter, quarter];
        // Signs are avoided by moving ones between two of the four.
        while parts.iter().any(|part| is_sign(*part)) {
            for pair in parts.chunks_exact_mut(2) {
                if is_sign(pair[0]) || is_sign(pair[1]) {
                    pair[0] += 1;
                    pair[1] -= 1;
                }
            }
        }
        for (row, part) in parts.into_iter().enumerate() {
            letters[4 * row + place] = part;
        }
    }
    // The text begins at column 12, one byte behind the beginning of a word.
    letters.rotate_right(1);
    letters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_a_sealed_header_sums_to_all_ones() {
        let mut header = vec![b' '; 2880];
        header[..27].copy_from_slice(b"CHECKSUM= 'xxxxxxxxxxxxxxxx");
        header[27] = b'\'';
        header[80..110].copy_from_slice(b"DATASUM = '2503531142'        ");
        seal(&mut header, 2_503_531_142);
        assert_eq!(sum(2_503_531_142, &header), u32::MAX);
        assert!(header[PLACE].iter().all(u8::is_ascii_alphanumeric));
    }

    #[test]
    fn valid_the_standards_own_example() {
        // FITS standard 4.0, appendix J: a sum of 868229149 = 0x33c0201d needs "hcHjjc9ghcEghc9g" to become all ones.
        assert_eq!(&encode(!868_229_149), b"hcHjjc9ghcEghc9g");
        assert_eq!(sum(0xffff_fffe, &[0, 0, 0, 3]), 2);
        assert_eq!(sum_padded(5, &[0, 0, 0, 1, 2, 3]), 6 + 0x0203_0000);
    }
}
