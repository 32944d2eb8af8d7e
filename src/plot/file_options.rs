//! Size, resolution and metadata of picture files.

use std::str::FromStr;

use crate::error::Error;

/// Resolution at which one pixel of a chart is one pixel of its file, dots per inch.
pub(super) const NATURAL_DPI: u32 = 96;

/// Keywords of the metadata in a file.
pub(super) const PROGRAM: &str = "Software";
pub(super) const TITLE: &str = "Description";
pub(super) const PROVENANCE: &str = "Provenance";
const CM_PER_INCH: f64 = 2.54;
/// Least and greatest width and height of a file, pixels.
const SIDE: [f64; 2] = [100.0, 10_000.0];
/// Largest number of pixels of a file; drawing needs about 20 bytes for each.
const MOST_PIXELS: f64 = 32e6;
const DPI: [u32; 2] = [10, 1200];
const ALLOWED_SIZE: &str = "WIDTHxHEIGHT in pixels, inches or centimetres, for example 1600x900, 8x5in or 20x12cm";
const ALLOWED_PIXELS: &str = "100 to 10000 pixels on each side, at most 32 million in total";

/// Unit of a size.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Unit {
    Pixel,
    Inch,
    Centimetre,
}

/// Width and height of a picture file, for example `1600x900` (pixels), `8x5in` or `20x12cm`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PictureSize {
    width: f64,
    height: f64,
    unit: Unit,
}

impl FromStr for PictureSize {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let (numbers, unit) = match text.trim() {
            text if text.ends_with("px") => (&text[..text.len() - 2], Unit::Pixel),
            text if text.ends_with("in") => (&text[..text.len() - 2], Unit::Inch),
            text if text.ends_with("cm") => (&text[..text.len() - 2], Unit::Centimetre),
            text => (text, Unit::Pixel),
        };
        let side = |text: &str| text.trim().parse::<f64>().ok().filter(|side| side.is_finite() && *side > 0.0);
        let sides = numbers.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
        let invalid = || Error::invalid("the size of a picture", text, ALLOWED_SIZE);
        let (width, height) = sides.ok_or_else(invalid)?;
        Ok(Self { width, height, unit })
    }
}

impl PictureSize {
    /// Returns width and height in pixels, not rounded.
    fn pixels(&self, dpi: u32) -> (f64, f64) {
        let factor = match self.unit {
            Unit::Pixel => 1.0,
            Unit::Inch => f64::from(dpi),
            Unit::Centimetre => f64::from(dpi) / CM_PER_INCH,
        };
        (self.width * factor, self.height * factor)
    }

    /// Returns width and height as lengths of an SVG.
    fn svg_lengths(&self) -> (String, String) {
        let unit = match self.unit {
            Unit::Pixel => "",
            Unit::Inch => "in",
            Unit::Centimetre => "cm",
        };
        (format!("{}{unit}", self.width), format!("{}{unit}", self.height))
    }
}

/// Size, resolution and metadata of a picture file.
///
/// A chart keeps its layout: it is scaled with its fonts and lines. If the ratio of width to height differs from that
/// of the chart, white margins are added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileOptions {
    /// Size of the file; if omitted, the size of the chart, whose pixels are 1/96 inch wide.
    pub size: Option<PictureSize>,
    /// Dots per inch of a PNG, 10 to 1200; 96 if omitted. Sizes in pixels do not depend on it.
    pub dpi: Option<u32>,
    /// Provenance of the data as a JSON object.
    pub provenance: Option<String>,
}

impl FileOptions {
    /// Returns dots per inch.
    pub(super) fn dpi(&self) -> u32 {
        self.dpi.unwrap_or(NATURAL_DPI)
    }

    /// Returns the width and height of the PNG of a chart of this size, pixels.
    pub(super) fn pixels(&self, chart: (usize, usize)) -> Result<(usize, usize), Error> {
        if self.size.is_none() && self.dpi.is_none() {
            return Ok(chart);
        }
        let dpi = self.dpi();
        if !(DPI[0]..=DPI[1]).contains(&dpi) {
            let what = "the resolution of a picture".to_owned();
            let given = format!("{dpi} dots per inch");
            return Err(Error::invalid(what, given, "10 to 1200 dots per inch"));
        }
        let natural = |side: usize| side as f64 * f64::from(dpi) / f64::from(NATURAL_DPI);
        let (width, height) = match &self.size {
            Some(size) => size.pixels(dpi),
            None => (natural(chart.0), natural(chart.1)),
        };
        let (width, height) = (width.round(), height.round());
        let is_side = |side: f64| (SIDE[0]..=SIDE[1]).contains(&side);
        if !is_side(width) || !is_side(height) || width * height > MOST_PIXELS {
            let what = format!("the size of a picture at {dpi} dots per inch");
            let given = format!("{width} x {height} pixels");
            return Err(Error::invalid(what, given, ALLOWED_PIXELS));
        }
        Ok((width as usize, height as usize))
    }

    /// Returns width and height of the SVG of a chart of this size.
    pub(super) fn svg_lengths(&self, (width, height): (usize, usize)) -> (String, String) {
        self.size.as_ref().map_or_else(|| (width.to_string(), height.to_string()), PictureSize::svg_lengths)
    }

    /// Checks resolution and given size before a chart is drawn.
    ///
    /// # Errors
    /// The resolution is out of range, or the size has too few or too many pixels.
    pub fn check(&self) -> Result<(), Error> {
        // Without a given size, only the resolution is checked, because the size of the chart is not yet known. At 96
        // dots per inch, every chart is within the bounds.
        let size = self.size.unwrap_or(PictureSize { width: SIDE[0], height: SIDE[0], unit: Unit::Pixel });
        Self { size: Some(size), ..self.clone() }.pixels((0, 0)).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_sizes_have_units() {
        let pixels = |text: &str, dpi: u32| {
            let options = FileOptions { size: Some(text.parse().unwrap()), dpi: Some(dpi), ..FileOptions::default() };
            options.pixels((1, 1))
        };
        for (text, dpi, expected) in [
            ("1600x900", 300, (1600, 900)),
            ("1600x900px", 96, (1600, 900)),
            ("8x5in", 300, (2400, 1500)),
            ("20x12.7cm", 254, (2000, 1270)),
        ] {
            assert_eq!(pixels(text, dpi).unwrap(), expected, "{text}");
        }
        for text in ["", "8", "8x", "x5", "8x5mm", "-8x5in", "0x5in", "nanx5", "infx5", "8x5x3", "8*5"] {
            let error = text.parse::<PictureSize>().unwrap_err().to_string();
            assert!(error.contains(&format!("is {text};")) && error.contains("20x12cm"), "{error}");
        }
        for (text, dpi) in [("99x500", 96), ("10001x200", 96), ("8000x8000", 96), ("90x60in", 300), ("1x1in", 96)] {
            let error = pixels(text, dpi).unwrap_err().to_string();
            assert!(error.contains("allowed: 100 to 10000 pixels"), "{error}");
        }
        for dpi in [9, 1201] {
            assert!(pixels("500x500", dpi).unwrap_err().to_string().contains("allowed: 10 to 1200 dots"));
        }
        // Without a size, the pixels of a chart are those of 96 dots per inch.
        let own = |dpi: Option<u32>| FileOptions { dpi, ..FileOptions::default() }.pixels((1440, 846)).unwrap();
        assert_eq!([own(None), own(Some(192))], [(1440, 846), (2880, 1692)]);
        assert!(FileOptions { dpi: Some(5), ..FileOptions::default() }.check().is_err());
        assert!(FileOptions::default().check().is_ok());
    }
}
