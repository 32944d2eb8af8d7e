//! The invented satellite of `tests/data/elements`, and functions to read it.

use std::io::Write;
use streakcast::Error;

use flate2::Compression;
use flate2::write::GzEncoder;
use streakcast::elements::{Keep, NoradId, ReadOptions, Satellites, format_tle};

/// Returns the element set of the invented satellite in one format.
pub fn sample(name: &str) -> Vec<u8> {
    let path = super::golden_dir().join("elements").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Reads the bytes as one file.
pub fn read(bytes: &[u8]) -> Result<Satellites, Error> {
    Satellites::from_bytes("test", bytes, &ReadOptions::default())
}

/// Same as `read`, with a check that no record is rejected.
pub fn read_all(bytes: &[u8]) -> Satellites {
    let options = ReadOptions { keep: Keep::All, ..Default::default() };
    Satellites::from_bytes("test", bytes, &options).expect("readable")
}

/// Returns line number and reason of each rejected record.
pub fn reasons(catalogue: &Satellites) -> Vec<(usize, String)> {
    catalogue.rejected.iter().map(|rejected| (rejected.line, rejected.reason.to_string())).collect()
}

/// Returns the bytes compressed with gzip.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Returns the sample with another catalogue number and day of the epoch, and valid checksums.
pub fn pair(norad_id: u32, day: &str) -> String {
    let mut set = read(sample("sample.2le").as_slice()).unwrap().element_sets.remove(0);
    set.norad_id = NoradId(norad_id);
    let [line1, line2] = format_tle(&set).unwrap();
    let line1 = format!("{}{day}{}", &line1[..20], &line1[32..68]);
    format!("{line1}\n{line2}\n")
}
