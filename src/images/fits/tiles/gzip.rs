//! GZIP_1 and GZIP_2: bytes packed by gzip, for GZIP_2 those of all pixels' first bytes before those of their second ones.

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;

/// Unpacks; never more than `limit` bytes.
pub(super) fn unpack(packed: &[u8], limit: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    MultiGzDecoder::new(packed).take(limit as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() > limit {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "more bytes than pixels"));
    }
    Ok(bytes)
}

/// Packs.
pub(super) fn pack(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Brings the bytes of each pixel together.
pub(super) fn gathered(bytes: &[u8], size: usize) -> Vec<u8> {
    let count = bytes.len() / size;
    (0..count * size).map(|place| bytes[place % size * count + place / size]).collect()
}

/// Parts the bytes of the pixels: all first ones, all second ones, ...
pub(super) fn parted(bytes: &[u8], size: usize) -> Vec<u8> {
    let count = bytes.len() / size;
    (0..count * size).map(|place| bytes[place % count * size + place / count]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_there_and_back() {
        let bytes: Vec<u8> = (0..24).collect();
        assert_eq!(parted(&bytes, 4)[..7], [0, 4, 8, 12, 16, 20, 1]);
        assert_eq!(gathered(&parted(&bytes, 4), 4), bytes);
        assert_eq!(unpack(&pack(&bytes).unwrap(), 24).unwrap(), bytes);
        assert!(unpack(&pack(&bytes).unwrap(), 23).is_err());
        assert!(unpack(b"nonsense", 100).is_err());
    }
}
