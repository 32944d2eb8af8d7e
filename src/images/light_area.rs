//! The part of a frame that light falls on: without overscan and prescan.

use std::ops::Range;

use super::header::Header;
use super::plane::PixelPosition;

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
    /// Where the data's section is not within the frame, but LTV1 and LTV2 say where the frame was cut out, it is moved along and ends at the frame's borders.
    /// Sections are written `[x1:x2,y1:y2]`, counted from 1, ends included, in either order (Valdes, NOAO mosaic data structures, 1998).
    pub fn from_header(header: &Header, rows: usize, columns: usize) -> Self {
        let section =
            |keyword: &str| header.text(keyword).and_then(|text| Section::parse(&text)?.within(rows, columns));
        let has_bias = BIAS.iter().any(|keyword| section(keyword).is_some());
        let as_it_stands = section("DATASEC").or_else(|| section("TRIMSEC"));
        match as_it_stands {
            Some(area) if has_bias => area,
            None => Self::of_cut_out(header, rows, columns).unwrap_or(Self::whole(rows, columns)),
            Some(_) => Self::whole(rows, columns),
        }
    }

    /// The lit part of a frame that IRAF cut out of a raw one and that has the sections of that one; `None` where nothing of it is lit, or the header does not
    /// say where it lay.
    ///
    /// IRAF keeps x = LTM1_1 x₀ + LTV1 for a place x₀ of the raw frame. Cutting makes LTV1 smaller by the columns left of the cut, so a value below 0 tells of one.
    /// Mosaic cameras use the same keywords for the way from the chip to the raw frame; where CCDSEC and DATASEC begin at different pixels one cannot know
    /// which of the two x₀ is, and nothing is guessed.
    fn of_cut_out(header: &Header, rows: usize, columns: usize) -> Option<Self> {
        let raw = |keyword: &str| header.text(keyword).and_then(|text| Section::parse(&text));
        let data = raw("DATASEC").or_else(|| raw("TRIMSEC"))?;
        let moved = [header.integer("LTV1")?, header.integer("LTV2")?];
        let is_whole_scale = ["LTM1_1", "LTM2_2"].iter().all(|keyword| header.number(keyword).unwrap_or(1.0) == 1.0);
        let is_of_the_frame = !header.contains("CCDSEC")
            || raw("CCDSEC").is_some_and(|chip| chip.x[0] == data.x[0] && chip.y[0] == data.y[0]);
        if !is_whole_scale || !is_of_the_frame || moved.iter().all(|by| *by >= 0) {
            return None;
        }
        data.moved(moved).cut(rows, columns)
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

/// Pixels as a header names them: first and last along a row and along a column, counted from 1.
#[derive(Copy, Clone, Debug)]
struct Section {
    x: [i64; 2],
    y: [i64; 2],
}

impl Section {
    /// `[x1:x2,y1:y2]`, in either order.
    fn parse(text: &str) -> Option<Self> {
        let (x, y) = text.trim().strip_prefix('[')?.strip_suffix(']')?.split_once(',')?;
        let range = |text: &str| {
            let (from, to) = text.split_once(':')?;
            let (from, to) = (from.trim().parse::<u32>().ok()?, to.trim().parse::<u32>().ok()?);
            Some([i64::from(from.min(to)), i64::from(from.max(to))])
        };
        Some(Self { x: range(x)?, y: range(y)? })
    }

    /// The same pixels where their numbers have changed by so much along rows and columns.
    fn moved(self, by: [i64; 2]) -> Self {
        let [x, y] = [(self.x, by[0]), (self.y, by[1])].map(|(ends, by)| ends.map(|end| end.saturating_add(by)));
        Self { x, y }
    }

    /// Its pixels where all are within a frame; `None` otherwise.
    fn within(self, rows: usize, columns: usize) -> Option<LightArea> {
        let is_within = |[first, last]: [i64; 2], count: usize| first >= 1 && last <= count as i64;
        if is_within(self.x, columns) && is_within(self.y, rows) { self.cut(rows, columns) } else { None }
    }

    /// Those of its pixels that are within a frame; `None` where none is.
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
    fn verif_sections_of_a_cut_out_move_with_it() {
        // 100 by 100 pixels from column 2029 and row 101 on: the overscan begins at column 2105.
        let raw = "DATASEC = '[57:2104,51:4146]'\nBIASSECA= '[2105:2154,51:4146]'\n";
        let cut = |ltv1: i32, ltv2: i32, more: &str| {
            area(&format!("{raw}LTV1    = {ltv1:20}\nLTV2    = {ltv2:20}\n{more}"), 100, 100)
        };
        assert_eq!(cut(-2028, -100, ""), "[1:76,1:100]");
        assert_eq!(cut(-2028, -100, "LTM1_1  =                  1.0\nCCDSEC  = '[57:2104,51:4146]'"), "[1:76,1:100]");
        assert_eq!(cut(-20, 0, ""), "[37:100,51:100]");
        // As DECam's cut-outs have it: LTV of the chip, the same as in the raw frame; LBC's say nothing at all.
        for (ltv1, ltv2) in [(56, 50), (0, 0)] {
            assert_eq!(cut(ltv1, ltv2, "CCDSEC  = '[1:2048,1:4096]'"), "[1:100,1:100]");
        }
        // Cut, but out of the chip or out of the raw frame? And binned, and dark altogether.
        assert_eq!(cut(-1972, -50, "CCDSEC  = '[1:2048,1:4096]'"), "[1:100,1:100]");
        assert_eq!(cut(-2028, -100, "LTM1_1  =                  0.5"), "[1:100,1:100]");
        assert_eq!(cut(-2104, -100, ""), "[1:100,1:100]");
        assert_eq!(area(raw, 100, 100), "[1:100,1:100]");
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
