//! Frames with injected streaks, and their truth tables.

use std::path::Path;

use streakcast::images::FrameFile;

/// Small synthetic frame.
pub const SKY: &str = "columns = 400
rows = 300
pixel_scale_arcsec = 1.0
zero_point_1s_mag = 25.0
sky_mag_arcsec2 = 21.0
stars = { per_megapixel = 200, slope = 0.3, brightest_mag = 13, faintest_mag = 20 }
detector = { gain_e_adu = 2.0, read_noise_e = 5, bias_adu = 300, quantisation = { greatest_adu = 65535 } }
";

/// Flags for two random streaks.
pub const RANDOM: &[&str] =
    &["--random-streaks", "2", "--magnitude", "6,8", "--exposure", "30s", "--seeing", "2.5arcsec", "--quiet"];

/// Returns `SKY` with floating-point pixels, so that nothing is rounded.
pub fn unrounded() -> String {
    SKY.replace(", quantisation = { greatest_adu = 65535 }", "")
}

/// Returns the pixels of an HDU.
pub fn values(file: &str, hdu: usize) -> Vec<f32> {
    FrameFile::open(Path::new(file)).unwrap().read_plane(hdu).unwrap().values().to_vec()
}

/// Returns a column of a truth table as text.
pub fn column(rows: &[csv::StringRecord], name: &str) -> Vec<String> {
    let index = rows[0].iter().position(|header| header == name).unwrap_or_else(|| panic!("no column {name}"));
    rows[1..].iter().map(|row| row[index].to_owned()).collect()
}

/// Returns a column of a truth table as numbers.
pub fn numbers(rows: &[csv::StringRecord], name: &str) -> Vec<f64> {
    column(rows, name).iter().map(|cell| cell.parse().unwrap()).collect()
}

/// Sets the value of a header card, right-justified in columns 11 to 30 of its first 80-byte record.
pub fn with_card(file: &[u8], keyword: &str, value: &str) -> Vec<u8> {
    let mut bytes = file.to_vec();
    let start = format!("{keyword:<8}= ");
    let card = bytes.chunks_exact_mut(80).find(|card| card.starts_with(start.as_bytes())).expect("the card");
    card[10..30].copy_from_slice(format!("{value:>20}").as_bytes());
    bytes
}

/// Replaces the first cards of HISTORY of the primary header by others.
pub fn with_new_cards(file: &[u8], cards: &[(&str, &str)]) -> Vec<u8> {
    let mut bytes = file.to_vec();
    let history = bytes.chunks_exact_mut(80).filter(|card| card.starts_with(b"HISTORY "));
    for (card, (keyword, value)) in history.zip(cards) {
        card.copy_from_slice(format!("{:<80}", format!("{keyword:<8}= {value:>20}")).as_bytes());
    }
    bytes
}
