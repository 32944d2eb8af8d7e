//! Anti-aliased lines and areas: the colour of a mark is mixed into each pixel by the fraction that the mark covers.

use plotters::prelude::RGBAColor;

/// Rows into which a pixel is divided for the coverage by an area. Along a row, the coverage is exact.
const SUBROWS: usize = 4;

/// Pixels of a picture, row by row, and the coverage of each pixel by the mark that is drawn.
pub(super) struct Raster {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Red, green and blue of each pixel, one byte each.
    pub rgb: Vec<u8>,
    /// Covered fraction of each pixel, in parts of 255; zero between two marks.
    covered: Vec<u8>,
    /// First and last touched column of each row; empty ranges between two marks.
    touched: Vec<[usize; 2]>,
}

/// Range of columns that contains no column.
const UNTOUCHED: [usize; 2] = [usize::MAX, 0];

impl Raster {
    /// Creates a raster of `rgb`, which has three bytes for each pixel.
    pub fn new((width, height): (usize, usize), rgb: Vec<u8>) -> Self {
        Self { width, height, rgb, covered: vec![0; width * height], touched: vec![UNTOUCHED; height] }
    }

    /// Draws a line with round joins and ends. A single point is a disk.
    pub fn line(&mut self, points: &[(f64, f64)], colour: RGBAColor, width: f64) {
        let points = on_pixels(points);
        let half = 0.5 * width.max(1.0);
        if let [alone] = points.as_slice() {
            self.cover_segment(*alone, *alone, half);
        }
        points.windows(2).for_each(|pair| self.cover_segment(pair[0], pair[1], half));
        self.mix(colour);
    }

    /// Draws a circle.
    pub fn circle(&mut self, middle: (f64, f64), radius: f64, colour: RGBAColor, width: f64) {
        // Chords of this length are within 0.01 pixels of the circle: sagitta = length² / (8 radius).
        let count = (std::f64::consts::TAU * radius / (0.08 * radius).sqrt()).ceil().max(12.0) as usize;
        let point = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
            (middle.0 + radius * cos, middle.1 + radius * sin)
        };
        self.line(&(0..=count).map(point).collect::<Vec<_>>(), colour, width);
    }

    /// Draws a filled disk without a rim.
    pub fn disk(&mut self, middle: (f64, f64), radius: f64, colour: RGBAColor) {
        self.line(&[middle], colour, 2.0 * radius);
    }

    /// Draws a filled polygon; parts that the border encloses more than once in the same direction are inside.
    pub fn patch(&mut self, points: &[(f64, f64)], colour: RGBAColor) {
        let points = on_pixels(points);
        let (top, bottom) = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(top, bottom), (_, y)| (top.min(*y), bottom.max(*y)));
        let edges = || points.iter().zip(points.iter().cycle().skip(1));
        let mut crossings: Vec<(f64, i32)> = Vec::new();
        for row in self.rows(top, bottom) {
            for subrow in 0..SUBROWS {
                let y = row as f64 + (subrow as f64 + 0.5) / SUBROWS as f64;
                crossings.clear();
                for (&(x0, y0), &(x1, y1)) in edges() {
                    if (y0 <= y) != (y1 <= y) {
                        crossings.push((x0 + (x1 - x0) * (y - y0) / (y1 - y0), if y0 <= y { 1 } else { -1 }));
                    }
                }
                crossings.retain(|crossing| crossing.0.is_finite());
                crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
                let mut turns = 0;
                for pair in crossings.windows(2) {
                    turns += pair[0].1;
                    if turns != 0 {
                        self.cover_part(row, [pair[0].0, pair[1].0]);
                    }
                }
            }
        }
        self.mix(colour);
    }

    /// Returns the rows of the picture between two y coordinates.
    fn rows(&self, top: f64, bottom: f64) -> std::ops::Range<usize> {
        pixels_between([top, bottom], self.height)
    }

    /// Covers the pixels within `half` of a segment.
    fn cover_segment(&mut self, (x0, y0): (f64, f64), (x1, y1): (f64, f64), half: f64) {
        // The coverage of a pixel whose centre is this far or farther away is zero.
        let reach = half + 0.5;
        let (dx, dy) = (x1 - x0, y1 - y0);
        let square = dx * dx + dy * dy;
        for row in self.rows(y0.min(y1) - reach, y0.max(y1) + reach) {
            let y = row as f64 + 0.5;
            // Part of the segment whose y coordinates are within reach, and so the columns that it may cover.
            let mut part = [0.0, 1.0];
            if dy != 0.0 {
                let ends = [(y - reach - y0) / dy, (y + reach - y0) / dy];
                part = [ends[0].min(ends[1]).clamp(0.0, 1.0), ends[0].max(ends[1]).clamp(0.0, 1.0)];
            }
            let [a, b] = part.map(|share| x0 + share * dx);
            let columns = pixels_between([a.min(b) - reach, a.max(b) + reach], self.width);
            if columns.is_empty() {
                continue;
            }
            self.touch(row, columns.clone());
            for column in columns {
                let x = column as f64 + 0.5;
                let share = if square > 0.0 { (((x - x0) * dx + (y - y0) * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
                let distance = (x - x0 - share * dx).hypot(y - y0 - share * dy);
                let covered = &mut self.covered[row * self.width + column];
                *covered = (*covered).max(parts(reach - distance));
            }
        }
    }

    /// Adds the coverage by the part of one subrow between two x coordinates.
    fn cover_part(&mut self, row: usize, [from, to]: [f64; 2]) {
        let columns = pixels_between([from, to], self.width);
        if columns.is_empty() {
            return;
        }
        self.touch(row, columns.clone());
        for column in columns {
            let left = column as f64;
            let share = (to.min(left + 1.0) - from.max(left)) / SUBROWS as f64;
            let covered = &mut self.covered[row * self.width + column];
            *covered = covered.saturating_add(parts(share));
        }
    }

    /// Adds a range of columns, which is not empty, to the touched columns of a row.
    fn touch(&mut self, row: usize, columns: std::ops::Range<usize>) {
        let touched = &mut self.touched[row];
        *touched = [touched[0].min(columns.start), touched[1].max(columns.end - 1)];
    }

    /// Mixes a colour into the covered pixels, and removes the coverage.
    fn mix(&mut self, colour: RGBAColor) {
        let RGBAColor(red, green, blue, opacity) = colour;
        for (row, touched) in self.touched.iter_mut().enumerate() {
            for column in touched[0]..=touched[1] {
                let at = row * self.width + column;
                let share = f32::from(self.covered[at]) / 255.0 * opacity as f32;
                self.covered[at] = 0;
                if share > 0.0 {
                    for (channel, value) in self.rgb[3 * at..3 * at + 3].iter_mut().zip([red, green, blue]) {
                        *channel =
                            (f32::from(*channel) + share * (f32::from(value) - f32::from(*channel))).round() as u8;
                    }
                }
            }
            *touched = UNTOUCHED;
        }
    }
}

/// Returns a fraction in parts of 255.
fn parts(fraction: f64) -> u8 {
    // Numbers outside the range of bytes become 0 or 255.
    (255.0 * fraction).round() as u8
}

/// Returns the pixels, of `count`, between two coordinates.
fn pixels_between([from, to]: [f64; 2], count: usize) -> std::ops::Range<usize> {
    // Negative and invalid numbers become 0.
    (from.floor() as usize)..(to.ceil() as usize).min(count)
}

/// Returns points whose lines all run along rows and columns at whole coordinates, so that these lines are sharp and
/// neighbouring rectangles have no seam; other points are unchanged.
fn on_pixels(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let is_along = points.len() > 1 && points.windows(2).all(|pair| pair[0].0 == pair[1].0 || pair[0].1 == pair[1].1);
    let round = |&(x, y): &(f64, f64)| if is_along { (x.round(), y.round()) } else { (x, y) };
    points.iter().map(round).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: RGBAColor = RGBAColor(0, 0, 0, 1.0);

    fn white() -> Raster {
        Raster::new((100, 100), vec![255; 30_000])
    }

    /// Returns the covered area in pixels.
    fn area(raster: &Raster) -> f64 {
        raster.rgb.iter().step_by(3).map(|red| 1.0 - f64::from(*red) / 255.0).sum()
    }

    /// The covered area is that of the shape, also between pixels and at any slope.
    #[test]
    fn verif_areas_of_shapes() {
        // Tolerance: shares of pixels from distances, and 256 grey levels.
        const TOLERANCE: f64 = 0.01;
        let drawn = |draw: &dyn Fn(&mut Raster)| {
            let mut raster = white();
            draw(&mut raster);
            area(&raster)
        };
        let pi = std::f64::consts::PI;
        for (name, given, expected) in [
            // The line has round ends.
            ("line", drawn(&|r| r.line(&[(10.3, 20.6), (80.1, 43.9)], BLACK, 3.0)), 73.587 * 3.0 + pi * 2.25),
            ("circle", drawn(&|r| r.circle((50.2, 49.7), 30.0, BLACK, 2.0)), 2.0 * pi * 30.0 * 2.0),
            ("disk", drawn(&|r| r.disk((50.2, 49.7), 20.3, BLACK)), pi * 20.3 * 20.3),
            ("triangle", drawn(&|r| r.patch(&[(10.2, 10.1), (90.6, 30.0), (40.0, 80.3)], BLACK)), 2525.49),
            (
                "half outside",
                drawn(&|r| r.patch(&[(-50.0, 10.0), (50.0, 10.0), (50.0, 30.0), (-50.0, 30.0)], BLACK)),
                1000.0,
            ),
            ("outside", drawn(&|r| r.line(&[(-90.0, -10.0), (-10.0, -80.0)], BLACK, 5.0)), 0.0),
        ] {
            assert!((given - expected).abs() <= TOLERANCE * expected, "{name}: {given}, expected {expected}");
        }
    }

    /// A slanted line has no steps: neighbouring columns have the same total coverage.
    #[test]
    fn verif_slanted_lines_have_no_steps() {
        let mut raster = white();
        raster.line(&[(5.0, 40.0), (95.0, 52.0)], BLACK, 2.0);
        let column = |x: usize| (0..100).map(|y| 1.0 - f64::from(raster.rgb[3 * (100 * y + x)]) / 255.0).sum::<f64>();
        // The height of a line of this slope is its width divided by the cosine of the slope.
        let expected = 2.0 * (1.0_f64 + (12.0_f64 / 90.0).powi(2)).sqrt();
        for x in 10..90 {
            assert!((column(x) - expected).abs() < 0.1, "{x}: {}", column(x));
        }
    }

    /// Overlapping parts of one line are mixed once, and neighbouring rectangles have no seam.
    #[test]
    fn verif_overlaps_and_seams() {
        let mut raster = white();
        raster.line(&[(10.0, 50.0), (50.0, 51.0), (10.0, 52.0)], RGBAColor(0, 0, 0, 0.5), 8.0);
        assert!(raster.rgb.iter().all(|value| *value >= 127));
        let mut raster = white();
        let half = RGBAColor(0, 0, 0, 0.5);
        raster.patch(&[(10.0, 10.0), (40.4, 10.0), (40.4, 60.0), (10.0, 60.0)], half);
        raster.patch(&[(40.4, 10.0), (80.0, 10.0), (80.0, 60.0), (40.4, 60.0)], half);
        let values: Vec<u8> = (10..80).map(|x| raster.rgb[3 * (100 * 30 + x)]).collect();
        assert!(values.iter().all(|value| *value == values[0]), "{values:?}");
    }
}
