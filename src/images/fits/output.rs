//! Headers and data as they are written.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;

use super::super::card::{Card, CardValue};
use super::super::header::Header;
use super::checksum;
use super::hdu::{HduInfo, HduKind, padded};
use super::new_hdu::NewHdu;

/// Copies a range of a file to where another one stands; by the kernel where it can.
pub(super) fn copy_range(input: &mut File, mut output: &File, range: Range<u64>) -> io::Result<()> {
    input.seek(SeekFrom::Start(range.start))?;
    let length = range.end - range.start;
    let copied = io::copy(&mut input.take(length), &mut output)?;
    if copied < length {
        return Err(io::Error::from(io::ErrorKind::UnexpectedEof));
    }
    Ok(())
}

/// Fills up a block behind so many bytes; the length with it.
pub(super) fn pad(mut output: &File, length: u64, byte: u8) -> io::Result<u64> {
    let end = padded(length);
    output.write_all(&vec![byte; (end - length) as usize])?;
    Ok(end)
}

/// What stands behind data: blanks for text, else zeros.
pub(super) fn pad_byte(info: &HduInfo) -> u8 {
    if info.kind == HduKind::TextTable { b' ' } else { 0 }
}

/// A header as it stands in a file: with END, filled up with blanks.
pub(super) fn header_bytes(header: &Header) -> Vec<u8> {
    let mut bytes: Vec<u8> = header.cards().iter().flat_map(Card::bytes).copied().collect();
    bytes.extend_from_slice(b"END");
    bytes.resize(padded(bytes.len() as u64) as usize, b' ');
    bytes
}

/// Whether a header holds a sum.
pub(super) fn has_sums(header: &Header) -> bool {
    header.contains("CHECKSUM") || header.contains("DATASUM")
}

/// A header's bytes with the right sums, in those of both cards that it has.
pub(super) fn sealed(header: &Header, datasum: u32) -> Vec<u8> {
    let mut header = header.clone();
    if header.contains("DATASUM") {
        header.set("DATASUM", &CardValue::Text(datasum.to_string()), "");
    }
    if header.contains("CHECKSUM") {
        header.set("CHECKSUM", &"0000000000000000".into(), "");
    }
    let mut bytes = header_bytes(&header);
    checksum::seal(&mut bytes, datasum);
    bytes
}

/// A whole HDU.
pub(super) fn write_hdu(mut output: &File, hdu: &NewHdu) -> io::Result<()> {
    output.write_all(&header_bytes(&hdu.header))?;
    output.write_all(&hdu.data)?;
    pad(output, hdu.data.len() as u64, 0).map(drop)
}
