//! The part of a frame that light falls on: without overscan and prescan.

use std::ops::Range;

use super::header::Header;
use super::pixel::PixelPosition;

/// Pixels of a frame that light falls on, counted from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightArea {
    /// Its rows.
    pub rows: Range<usize>,
    /// Its columns.
    pub columns: Range<usize>,
}

/// Where amplifiers have sections of their own, these end in their letters.
const BIAS: [&str; 5] = ["BIASSEC", "BIASSECA", "BIASSECB", "BIASSEC1", "TRIMSEC"];

impl LightArea {
    /// All of a frame.
    pub fn whole(rows: usize, columns: usize) -> Self {
        Self { rows: 0..rows, columns: 0..columns }
    }

    /// What the header of a raw frame of `rows` by `columns` says: DATASEC, or TRIMSEC where that is missing.
    ///
    /// Frames that were trimmed, cut or binned later often keep the sections of the raw one. They count only where both that of the data and that of the bias
    /// (BIASSEC of the chip or of one amplifier; TRIMSEC does too) lie within the frame; all of it is lit otherwise.
    /// Sections are written `[x1:x2,y1:y2]`, counted from 1, ends included, in either order (Valdes, NOAO mosaic data structures, 1998).
    pub fn from_header(header: &Header, rows: usize, columns: usize) -> Self {
        let section = |keyword: &str| header.text(keyword).and_then(|text| Self::parse(&text, rows, columns));
        let has_bias = BIAS.iter().any(|keyword| section(keyword).is_some());
        section("DATASEC").or_else(|| section("TRIMSEC")).filter(|_| has_bias).unwrap_or(Self::whole(rows, columns))
    }

    /// A section within a frame; `None` for anything else.
    fn parse(text: &str, rows: usize, columns: usize) -> Option<Self> {
        let (x, y) = text.trim().strip_prefix('[')?.strip_suffix(']')?.split_once(',')?;
        let range = |text: &str, count: usize| {
            let (from, to) = text.split_once(':')?;
            let (from, to) = (from.trim().parse::<usize>().ok()?, to.trim().parse::<usize>().ok()?);
            let (least, greatest) = (from.min(to), from.max(to));
            (least >= 1 && greatest <= count).then(|| least - 1..greatest)
        };
        Some(Self { rows: range(y, rows)?, columns: range(x, columns)? })
    }

    /// As a section is written in headers.
    pub fn section(&self) -> String {
        format!("[{}:{},{}:{}]", self.columns.start + 1, self.columns.end, self.rows.start + 1, self.rows.end)
    }

    /// How many pixels it has.
    pub fn pixels(&self) -> usize {
        self.rows.len() * self.columns.len()
    }

    /// True for a place on one of its pixels.
    pub fn holds(&self, at: PixelPosition) -> bool {
        let within =
            |value: f64, range: &Range<usize>| (range.start as f64..=range.end as f64).contains(&(value + 0.5));
        within(at.x, &self.columns) && within(at.y, &self.rows)
    }

    /// A place on it from its shares of the way along a row and along a column: (0, 0) is the outer corner of its first pixel, (1, 1) that of its last.
    pub fn place(&self, along_row: f64, along_column: f64) -> PixelPosition {
        let at = |range: &Range<usize>, share: f64| range.start as f64 - 0.5 + share * range.len() as f64;
        PixelPosition { x: at(&self.columns, along_row), y: at(&self.rows, along_column) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(cards: &str, rows: usize, columns: usize) -> String {
        LightArea::from_header(&Header::from_text(cards), rows, columns).section()
    }

    #[test]
    fn verif_sections_count_where_the_overscan_is_still_there() {
        // The chip of a raw DECam frame: sections of amplifiers.
        let decam = "BIASSECA= '[7:56,51:4146]'\nDATASEC = '[57:2104,51:4146]'\nTRIMSEC = '[57:2104,51:4146]'";
        assert_eq!(area(decam, 4146, 2160), "[57:2104,51:4146]");
        // Trimmed later, or cut: the sections of the raw frame are none of this one's.
        assert_eq!(area(decam, 4096, 2048), "[1:2048,1:4096]");
        assert_eq!(area(decam, 400, 400), "[1:400,1:400]");
        // A section alone does not say that there is more than light.
        assert_eq!(area("DATASEC = '[5:90,1:100]'", 100, 100), "[1:100,1:100]");
        // The bias is gone, so the data were moved.
        assert_eq!(area("DATASEC = '[11:100,1:100]'\nBIASSEC = '[101:110,1:100]'", 100, 100), "[1:100,1:100]");
        assert_eq!(area("DATASEC = '[100:11, 1:100]'\nBIASSEC = '[1:10,1:100]'", 100, 100), "[11:100,1:100]");
        assert_eq!(area("TRIMSEC = '[11:100,2:99]'", 100, 100), "[11:100,2:99]");
        for broken in ["[0:90,1:100]", "[1:90]", "1:90,1:100", "[a:b,1:100]", "[1:90:2,1:100]", ""] {
            let cards = format!("DATASEC = '{broken}'\nBIASSEC = '[91:100,1:100]'");
            assert_eq!(area(&cards, 100, 100), "[1:100,1:100]", "{broken}");
        }
    }

    #[test]
    fn verif_places_are_its_pixels() {
        let area = LightArea { rows: 10..20, columns: 5..9 };
        assert_eq!(area.pixels(), 40);
        assert_eq!(area.place(0.5, 0.5), PixelPosition { x: 6.5, y: 14.5 });
        assert!(area.holds(area.place(0.0, 1.0)) && area.holds(PixelPosition { x: 8.5, y: 9.5 }));
        assert!(!area.holds(PixelPosition { x: 4.4, y: 12.0 }) && !area.holds(PixelPosition { x: 6.0, y: 19.6 }));
    }
}
