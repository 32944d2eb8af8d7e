//! Illuminated part of a frame, without overscan and prescan.

use std::ops::Range;

use super::header::Header;
use super::pixels::PixelPosition;

/// Range of illuminated pixels of a frame, counted from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LightArea {
    /// Illuminated rows.
    pub rows: Range<usize>,
    /// Illuminated columns.
    pub columns: Range<usize>,
}

/// Keywords of bias sections. Keywords of single amplifiers end in the letter or number of the amplifier.
const BIAS: [&str; 5] = ["BIASSEC", "BIASSECA", "BIASSECB", "BIASSEC1", "TRIMSEC"];

impl LightArea {
    /// Creates an area that covers the whole frame.
    pub fn whole(rows: usize, columns: usize) -> Self {
        Self { rows: 0..rows, columns: 0..columns }
    }

    /// Reads the illuminated area of a raw frame of `rows` by `columns` pixels from the keyword DATASEC, or TRIMSEC if
    /// DATASEC is missing.
    ///
    /// Frames that were trimmed, cut or binned later often keep the sections of the raw frame. The sections are
    /// therefore used only if both the data section and a bias section (BIASSEC of the chip or of one amplifier, or
    /// TRIMSEC) lie within the frame; otherwise the whole frame is taken as illuminated. If the data section is not
    /// within the frame, but LTV1 and LTV2 give the position of the cutout in the raw frame, the section is shifted by
    /// them and clipped to the frame. Sections are written `[x1:x2,y1:y2]`, counted from 1, ends included, in either
    /// order (Valdes, NOAO mosaic data structures, 1998).
    pub fn from_header(header: &Header, rows: usize, columns: usize) -> Self {
        let section =
            |keyword: &str| header.text(keyword).and_then(|text| Section::parse(&text)?.within(rows, columns));
        let has_bias = BIAS.iter().any(|keyword| section(keyword).is_some());
        let data_section = section("DATASEC").or_else(|| section("TRIMSEC"));
        match data_section {
            Some(area) if has_bias => area,
            None => Self::of_cutout(header, rows, columns).unwrap_or(Self::whole(rows, columns)),
            Some(_) => Self::whole(rows, columns),
        }
    }

    /// Returns the illuminated area of a frame that IRAF cut out of a raw frame, if the header still has the sections
    /// of the raw frame. `None` if no part of the cutout is illuminated, or if the header does not give its position in
    /// the raw frame.
    ///
    /// IRAF defines x = LTM1_1 x₀ + LTV1 for a position x₀ in the raw frame. Cutting reduces LTV1 by the number of
    /// columns left of the cutout, so that a negative LTV1 indicates a cutout. Mosaic cameras use the same keywords for
    /// the transformation from the chip to the raw frame. If CCDSEC and DATASEC begin at different pixels, x₀ is
    /// therefore ambiguous, and `None` is returned.
    fn of_cutout(header: &Header, rows: usize, columns: usize) -> Option<Self> {
        let raw = |keyword: &str| header.text(keyword).and_then(|text| Section::parse(&text));
        let data = raw("DATASEC").or_else(|| raw("TRIMSEC"))?;
        let moved = [header.integer("LTV1")?, header.integer("LTV2")?];
        let is_whole_scale = ["LTM1_1", "LTM2_2"].iter().all(|keyword| header.number(keyword).unwrap_or(1.0) == 1.0);
        let is_of_the_frame = !header.contains("CCDSEC")
            || raw("CCDSEC").is_some_and(|chip| chip.x[0] == data.x[0] && chip.y[0] == data.y[0]);
        if !is_whole_scale || !is_of_the_frame || moved.iter().all(|by| *by >= 0) {
            return None;
        }
        data.shifted(moved).cut(rows, columns)
    }

    /// Returns the area as text in the form of a header section, `[x1:x2,y1:y2]`.
    pub fn section(&self) -> String {
        format!("[{}:{},{}:{}]", self.columns.start + 1, self.columns.end, self.rows.start + 1, self.rows.end)
    }

    /// Returns the number of pixels.
    pub fn pixels(&self) -> usize {
        self.rows.len() * self.columns.len()
    }

    /// Returns true if a position is on one of the pixels.
    pub fn contains(&self, at: PixelPosition) -> bool {
        let within =
            |value: f64, range: &Range<usize>| (range.start as f64..=range.end as f64).contains(&(value + 0.5));
        within(at.x, &self.columns) && within(at.y, &self.rows)
    }

    /// Returns the position at fractions of the width and the height. (0, 0) is the outer corner of the first pixel,
    /// (1, 1) the outer corner of the last pixel.
    pub fn position_at(&self, along_row: f64, along_column: f64) -> PixelPosition {
        let at = |range: &Range<usize>, share: f64| range.start as f64 - 0.5 + share * range.len() as f64;
        PixelPosition { x: at(&self.columns, along_row), y: at(&self.rows, along_column) }
    }
}

/// Pixels of a header section: first and last along a row and along a column, counted from 1.
#[derive(Copy, Clone, Debug)]
struct Section {
    x: [i64; 2],
    y: [i64; 2],
}

impl Section {
    /// Parses `[x1:x2,y1:y2]`, with the ends in either order.
    fn parse(text: &str) -> Option<Self> {
        let (x, y) = text.trim().strip_prefix('[')?.strip_suffix(']')?.split_once(',')?;
        let range = |text: &str| {
            let (from, to) = text.split_once(':')?;
            let (from, to) = (from.trim().parse::<u32>().ok()?, to.trim().parse::<u32>().ok()?);
            Some([i64::from(from.min(to)), i64::from(from.max(to))])
        };
        Some(Self { x: range(x)?, y: range(y)? })
    }

    /// Shifts the section along rows and columns.
    fn shifted(self, by: [i64; 2]) -> Self {
        let [x, y] = [(self.x, by[0]), (self.y, by[1])].map(|(ends, by)| ends.map(|end| end.saturating_add(by)));
        Self { x, y }
    }

    /// Returns the pixels of the section; `None` if not all of them are within a frame of this size.
    fn within(self, rows: usize, columns: usize) -> Option<LightArea> {
        let is_within = |[first, last]: [i64; 2], count: usize| first >= 1 && last <= count as i64;
        if is_within(self.x, columns) && is_within(self.y, rows) { self.cut(rows, columns) } else { None }
    }

    /// Returns those pixels of the section that are within a frame of this size; `None` if there are none.
    fn cut(self, rows: usize, columns: usize) -> Option<LightArea> {
        let range = |[first, last]: [i64; 2], count: usize| {
            let (start, end) = ((first.max(1) - 1) as usize, last.clamp(0, count as i64) as usize);
            (start < end).then_some(start..end)
        };
        Some(LightArea { rows: range(self.y, rows)?, columns: range(self.x, columns)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(cards: &str, rows: usize, columns: usize) -> String {
        LightArea::from_header(&Header::from_text(cards), rows, columns).section()
    }

    #[test]
    fn verif_sections_are_used_if_the_frame_has_its_overscan() {
        // Chip of a raw DECam frame, with the bias section of one amplifier.
        let decam = "BIASSECA= '[7:56,51:4146]'\nDATASEC = '[57:2104,51:4146]'\nTRIMSEC = '[57:2104,51:4146]'";
        assert_eq!(area(decam, 4146, 2160), "[57:2104,51:4146]");
        // If the frame was trimmed or cut later, the sections of the raw frame do not apply.
        assert_eq!(area(decam, 4096, 2048), "[1:2048,1:4096]");
        assert_eq!(area(decam, 400, 400), "[1:400,1:400]");
        // A data section alone does not prove that the frame has dark pixels.
        assert_eq!(area("DATASEC = '[5:90,1:100]'", 100, 100), "[1:100,1:100]");
        // The bias section is outside the frame, so the frame was trimmed and the data were moved.
        assert_eq!(area("DATASEC = '[11:100,1:100]'\nBIASSEC = '[101:110,1:100]'", 100, 100), "[1:100,1:100]");
        assert_eq!(area("DATASEC = '[100:11, 1:100]'\nBIASSEC = '[1:10,1:100]'", 100, 100), "[11:100,1:100]");
        assert_eq!(area("TRIMSEC = '[11:100,2:99]'", 100, 100), "[11:100,2:99]");
        for broken in ["[0:90,1:100]", "[1:90]", "1:90,1:100", "[a:b,1:100]", "[1:90:2,1:100]", ""] {
            let cards = format!("DATASEC = '{broken}'\nBIASSEC = '[91:100,1:100]'");
            assert_eq!(area(&cards, 100, 100), "[1:100,1:100]", "{broken}");
        }
    }

    #[test]
    fn verif_sections_of_a_cutout_are_shifted() {
        // 100 by 100 pixels from column 2029 and row 101 on: the overscan begins at column 2105.
        let raw = "DATASEC = '[57:2104,51:4146]'\nBIASSECA= '[2105:2154,51:4146]'\n";
        let cut = |ltv1: i32, ltv2: i32, more: &str| {
            area(&format!("{raw}LTV1    = {ltv1:20}\nLTV2    = {ltv2:20}\n{more}"), 100, 100)
        };
        assert_eq!(cut(-2028, -100, ""), "[1:76,1:100]");
        assert_eq!(cut(-2028, -100, "LTM1_1  =                  1.0\nCCDSEC  = '[57:2104,51:4146]'"), "[1:76,1:100]");
        assert_eq!(cut(-20, 0, ""), "[37:100,51:100]");
        // DECam cutouts keep LTV1 and LTV2 of the raw frame, which transform from the chip to the raw frame; LBC
        // cutouts give no shift.
        for (ltv1, ltv2) in [(56, 50), (0, 0)] {
            assert_eq!(cut(ltv1, ltv2, "CCDSEC  = '[1:2048,1:4096]'"), "[1:100,1:100]");
        }
        // A cutout with an ambiguous reference (chip or raw frame), a binned frame, and a frame that is not
        // illuminated.
        assert_eq!(cut(-1972, -50, "CCDSEC  = '[1:2048,1:4096]'"), "[1:100,1:100]");
        assert_eq!(cut(-2028, -100, "LTM1_1  =                  0.5"), "[1:100,1:100]");
        assert_eq!(cut(-2104, -100, ""), "[1:100,1:100]");
        assert_eq!(area(raw, 100, 100), "[1:100,1:100]");
    }

    #[test]
    fn verif_positions_lie_on_the_pixels() {
        let area = LightArea { rows: 10..20, columns: 5..9 };
        assert_eq!(area.pixels(), 40);
        assert_eq!(area.position_at(0.5, 0.5), PixelPosition { x: 6.5, y: 14.5 });
        assert!(area.contains(area.position_at(0.0, 1.0)) && area.contains(PixelPosition { x: 8.5, y: 9.5 }));
        assert!(!area.contains(PixelPosition { x: 4.4, y: 12.0 }) && !area.contains(PixelPosition { x: 6.0, y: 19.6 }));
    }
}
