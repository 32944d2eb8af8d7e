//! Pictures: lists of marks that any drawing backend can draw, and their font.
//!
//! Pixels are painted into an [`Underlay`], over which lines and text are drawn. Lengths are in pixels of the picture,
//! which a [`Canvas`] scales to pixels of the backend.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Polygon, Text};
use plotters::prelude::{
    BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, IntoFont, RGBAColor, RGBColor, ShapeStyle,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, TextStyle, register_font};

use super::raster::Raster;
use super::scale::ColourScale;
use crate::error::{Error, ErrorKind};

/// Colour of lines and text.
pub(super) const INK: RGBColor = RGBColor(30, 30, 30);
/// Colour of the background.
pub(super) const PAPER: [u8; 3] = [255, 255, 255];
/// Position of the line below the title, pixels from the top.
const SUBTITLE: f64 = 51.0;
const SUN: RGBColor = RGBColor(255, 190, 0);

/// Picture of a map or a chart, which can be encoded as PNG or SVG.
pub struct Picture {
    width: usize,
    height: usize,
    title: String,
    scales: Vec<ColourScale>,
    pixels: Vec<Pixels>,
    marks: Vec<Mark>,
}

/// Position and scale of a picture on the canvas of a drawing backend.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Canvas {
    /// Width of the canvas, pixels.
    pub width: usize,
    /// Height of the canvas, pixels.
    pub height: usize,
    /// Pixels of the canvas per pixel of the picture.
    pub scale: f64,
    /// Position of the upper left corner of the picture, pixels of the canvas.
    pub corner: (f64, f64),
}

impl Canvas {
    /// Returns the canvas on which a picture is as large as possible, in the middle.
    pub fn for_picture(picture: &Picture, (width, height): (usize, usize)) -> Self {
        let scale = (width as f64 / picture.width as f64).min(height as f64 / picture.height as f64);
        let margin = |canvas: usize, picture: usize| ((canvas as f64 - picture as f64 * scale) / 2.0).max(0.0);
        Self { width, height, scale, corner: (margin(width, picture.width), margin(height, picture.height)) }
    }

    /// Returns a position of the picture in pixels of the canvas.
    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.corner.0 + x * self.scale, self.corner.1 + y * self.scale)
    }

    /// Returns a position of the picture in whole pixels of the canvas.
    fn whole(&self, position: (f64, f64)) -> (i32, i32) {
        let (x, y) = self.at(position);
        (x.round() as i32, y.round() as i32)
    }
}

/// Grid of coloured rectangles.
pub(super) struct Pixels {
    /// Position of the upper left corner.
    pub corner: (f64, f64),
    /// Width and height of one rectangle.
    pub each: (f64, f64),
    /// Number of columns.
    pub columns: usize,
    /// Colours row by row from the top; `None` is transparent.
    pub colours: Vec<Option<[u8; 3]>>,
    /// Circle (middle and radius) outside which nothing is painted; `None` for no limit.
    pub within: Option<((f64, f64), f64)>,
}

/// Pixels below the lines, row by row.
pub(super) struct Underlay {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Red, green and blue of each pixel, one byte each.
    pub rgb: Vec<u8>,
}

enum Mark {
    Line { points: Vec<(f64, f64)>, colour: RGBAColor, width: f64 },
    Circle { middle: (f64, f64), radius: f64, colour: RGBAColor, width: f64 },
    Disk { middle: (f64, f64), radius: f64, colour: RGBColor },
    Patch { points: Vec<(f64, f64)>, colour: RGBAColor },
    Text(Words),
}

/// Line of text whose vertical middle is at `position`.
struct Words {
    text: String,
    position: (f64, f64),
    size: f64,
    horizontal: HPos,
    is_upright: bool,
    colour: RGBColor,
}

impl Picture {
    /// Creates an empty white picture.
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { width, height, title: String::new(), scales: Vec::new(), pixels: Vec::new(), marks: Vec::new() }
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Returns the title.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Draws the title of a chart.
    pub(super) fn set_title(&mut self, title: &str, position: (f64, f64), size: f64, horizontal: HPos) {
        title.clone_into(&mut self.title);
        self.text(title, position, size, horizontal);
    }

    /// Draws a line of text below the title of a chart, for example the site and the range of times.
    ///
    /// In pictures of disks, the titles of the disks are at this position.
    pub fn with_subtitle(mut self, text: &str) -> Self {
        self.text(text, (self.width as f64 / 2.0, SUBTITLE), 16.0, HPos::Center);
        self
    }

    /// Returns the colour scales, one for each quantity that has a colour bar; empty for charts of lines and points.
    #[doc(hidden)]
    pub fn scales(&self) -> &[ColourScale] {
        &self.scales
    }

    pub(super) fn set_scales(&mut self, scales: Vec<ColourScale>) {
        self.scales = scales;
    }

    pub(super) fn paint(&mut self, pixels: Pixels) {
        self.pixels.push(pixels);
    }

    pub(super) fn line(&mut self, points: &[(f64, f64)], colour: RGBAColor, width: f64) {
        self.marks.push(Mark::Line { points: points.to_vec(), colour, width });
    }

    /// Draws a dashed line; `stroke` and `gap` are the lengths of strokes and gaps; a stroke is
    /// longer than its width.
    pub(super) fn dashed(&mut self, points: &[(f64, f64)], [stroke, gap]: [f64; 2], colour: RGBAColor, width: f64) {
        // Strokes have round ends, each half the width longer.
        let (stroke, gap) = ((stroke - width).max(0.1), gap + width);
        let mut dash = Vec::new();
        let (mut is_stroke, mut left) = (true, stroke);
        for pair in points.windows(2) {
            let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
            let length = (x1 - x0).hypot(y1 - y0);
            if !length.is_finite() {
                continue;
            }
            let mut gone = 0.0;
            while gone < length {
                let at = |gone: f64| (x0 + (x1 - x0) * gone / length, y0 + (y1 - y0) * gone / length);
                let next = (gone + left).min(length);
                if is_stroke {
                    if dash.is_empty() {
                        dash.push(at(gone));
                    }
                    dash.push(at(next));
                }
                left -= next - gone;
                gone = next;
                // A smaller remainder is due to rounding and would never be used up.
                if left <= 1e-6 {
                    if is_stroke {
                        self.line(&dash, colour, width);
                        dash.clear();
                    }
                    is_stroke = !is_stroke;
                    left = if is_stroke { stroke } else { gap };
                }
            }
        }
        if dash.len() > 1 {
            self.line(&dash, colour, width);
        }
    }

    pub(super) fn circle(&mut self, middle: (f64, f64), radius: f64, colour: RGBAColor, width: f64) {
        self.marks.push(Mark::Circle { middle, radius, colour, width });
    }

    /// Draws a filled disk without a rim.
    pub(super) fn disk(&mut self, middle: (f64, f64), radius: f64, colour: RGBColor) {
        self.marks.push(Mark::Disk { middle, radius, colour });
    }

    /// Draws a filled area.
    pub(super) fn patch(&mut self, points: Vec<(f64, f64)>, colour: RGBAColor) {
        self.marks.push(Mark::Patch { points, colour });
    }

    /// Draws a filled rectangle.
    pub(super) fn rectangle(&mut self, sides: [f64; 4], colour: RGBAColor) {
        self.patch(corners(sides).to_vec(), colour);
    }

    /// Draws the border of a rectangle given by its left, top, right and bottom.
    pub(super) fn border(&mut self, sides: [f64; 4], width: f64) {
        let [a, b, c, d] = corners(sides);
        self.line(&[a, b, c, d, a], INK.to_rgba(), width);
    }

    /// Draws text whose vertical middle is at `position`.
    pub(super) fn text(&mut self, text: &str, position: (f64, f64), size: f64, horizontal: HPos) {
        self.marks.push(Mark::Text(Words { horizontal, ..Words::new(text, position, size) }));
    }

    /// Draws text in a colour, with its middle at `position`.
    pub(super) fn coloured_text(&mut self, text: &str, position: (f64, f64), size: f64, colour: RGBColor) {
        self.marks.push(Mark::Text(Words { colour, ..Words::new(text, position, size) }));
    }

    /// Draws text that runs upwards, with its middle at `position`.
    pub(super) fn upright(&mut self, text: &str, position: (f64, f64), size: f64) {
        self.marks.push(Mark::Text(Words { is_upright: true, ..Words::new(text, position, size) }));
    }

    /// Draws the text of a legend entry; returns the x position of the next entry.
    pub(super) fn legend_text(&mut self, text: &str, x: f64, y: f64) -> f64 {
        self.text(text, (x, y), 17.0, HPos::Left);
        x + width_of(text, 17.0) + 28.0
    }

    /// Draws small text on a light background, so that it is readable on any colour.
    pub(super) fn note(&mut self, text: &str, position: (f64, f64)) {
        self.note_of(text, position, 16.0);
    }

    /// Draws text of a given size on a light background.
    pub(super) fn note_of(&mut self, text: &str, position: (f64, f64), size: f64) {
        self.rectangle(around(position, half_size(text, size)), RGBColor(255, 255, 255).mix(0.72));
        self.text(text, position, size, HPos::Center);
    }

    /// Draws text that is wrapped between two x positions; the middle of the first line is at `y`.
    pub(super) fn paragraph(&mut self, text: &str, [left, right]: [f64; 2], y: f64, size: f64) {
        for (index, line) in lines_of(text, right - left, size).iter().enumerate() {
            self.text(line, (left, y + 1.4 * size * index as f64), size, HPos::Left);
        }
    }

    /// Draws a filled disk with a thin rim.
    pub(super) fn dot(&mut self, (x, y): (f64, f64), colour: RGBColor) {
        const RADIUS: f64 = 4.6;
        let corner = |part: u8| {
            let (sin, cos) = (f64::from(part) * TAU / 16.0).sin_cos();
            (x + RADIUS * cos, y + RADIUS * sin)
        };
        let corners: Vec<_> = (0..=16).map(corner).collect();
        self.patch(corners.clone(), colour.to_rgba());
        self.line(&corners, INK.mix(0.8), 0.9);
    }

    /// Draws a sun: a disk with rays.
    pub(super) fn sun(&mut self, (x, y): (f64, f64)) {
        for ray in 0..8 {
            let (sin, cos) = (f64::from(ray) * std::f64::consts::FRAC_PI_4).sin_cos();
            self.line(&[(x + 8.5 * cos, y + 8.5 * sin), (x + 12.5 * cos, y + 12.5 * sin)], INK.to_rgba(), 1.5);
        }
        let corner = |part: u8| {
            let (sin, cos) = (f64::from(part) * TAU / 24.0).sin_cos();
            (x + 6.5 * cos, y + 6.5 * sin)
        };
        let corners: Vec<_> = (0..=24).map(corner).collect();
        self.patch(corners.clone(), SUN.to_rgba());
        self.line(&corners, INK.to_rgba(), 1.2);
    }

    /// Returns all pixels of a canvas.
    pub(super) fn underlay(&self, canvas: &Canvas) -> Underlay {
        let Canvas { width, height, scale, corner } = *canvas;
        let mut rgb = PAPER.repeat(width * height);
        for field in &self.pixels {
            let rows = field.colours.len() / field.columns.max(1);
            let (left, top) = field.corner;
            let (right, bottom) = (left + field.columns as f64 * field.each.0, top + rows as f64 * field.each.1);
            // Pixels whose centres are inside the rectangle.
            let first = |side: f64, from: f64| (from + side * scale - 0.5).ceil().max(0.0) as usize;
            for row in first(top, corner.1)..first(bottom, corner.1).min(height) {
                for column in first(left, corner.0)..first(right, corner.0).min(width) {
                    let (x, y) = ((column as f64 + 0.5 - corner.0) / scale, (row as f64 + 0.5 - corner.1) / scale);
                    if field.within.is_some_and(|(middle, radius)| (x - middle.0).hypot(y - middle.1) > radius) {
                        continue;
                    }
                    let across = (((x - left) / field.each.0) as usize).min(field.columns - 1);
                    let down = (((y - top) / field.each.1) as usize).min(rows - 1);
                    if let Some(colour) = field.colours[down * field.columns + across] {
                        let at = 3 * (row * width + column);
                        rgb[at..at + 3].copy_from_slice(&colour);
                    }
                }
            }
        }
        Underlay { width, height, rgb }
    }

    /// Draws lines and text over the pixels, with a drawing backend.
    pub(super) fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, canvas: &Canvas) -> Result<(), Error> {
        register_embedded_font()?;
        let scale = canvas.scale;
        let at = |point: &(f64, f64)| canvas.whole(*point);
        let thin = |colour: RGBAColor, width: f64| ShapeStyle {
            color: colour,
            filled: false,
            stroke_width: (width * scale).round().max(1.0) as u32,
        };
        for mark in &self.marks {
            match mark {
                Mark::Line { points, colour, width } => {
                    let points: Vec<_> = points.iter().map(at).collect();
                    area.draw(&PathElement::new(points, thin(*colour, *width)))
                }
                Mark::Circle { middle, radius, colour, width } => {
                    let radius = (radius * scale).round() as i32;
                    area.draw(&Circle::new(at(middle), radius, thin(*colour, *width)))
                }
                Mark::Disk { middle, radius, colour } => {
                    let radius = (radius * scale).round().max(1.0) as i32;
                    area.draw(&Circle::new(at(middle), radius, colour.filled()))
                }
                Mark::Patch { points, colour } => {
                    let points: Vec<_> = points.iter().map(at).collect();
                    area.draw(&Polygon::new(points, colour.filled()))
                }
                Mark::Text(words) => area.draw(&words.element(canvas)),
            }
            .map_err(drawing_error)?;
        }
        Ok(())
    }

    /// Draws smooth lines, and text, over the pixels of a raster.
    pub(super) fn rasterise(&self, raster: &mut Raster, canvas: &Canvas) -> Result<(), Error> {
        register_embedded_font()?;
        let scale = canvas.scale;
        let at = |point: &(f64, f64)| canvas.at(*point);
        for mark in &self.marks {
            match mark {
                Mark::Line { points, colour, width } => {
                    raster.line(&points.iter().map(at).collect::<Vec<_>>(), *colour, width * scale);
                }
                Mark::Circle { middle, radius, colour, width } => {
                    raster.circle(at(middle), radius * scale, *colour, width * scale);
                }
                Mark::Disk { middle, radius, colour } => raster.disk(at(middle), radius * scale, colour.to_rgba()),
                Mark::Patch { points, colour } => raster.patch(&points.iter().map(at).collect::<Vec<_>>(), *colour),
                Mark::Text(words) => {
                    let size = (raster.width as u32, raster.height as u32);
                    let area = BitMapBackend::with_buffer(&mut raster.rgb, size).into_drawing_area();
                    area.draw(&words.element(canvas)).map_err(drawing_error)?;
                }
            }
        }
        Ok(())
    }
}

impl Words {
    /// Returns horizontal text in the colour of lines, with its middle at `position`.
    fn new(text: &str, position: (f64, f64), size: f64) -> Self {
        Self { text: text.to_owned(), position, size, horizontal: HPos::Center, is_upright: false, colour: INK }
    }

    /// Returns the text as an element of a drawing backend.
    fn element(&self, canvas: &Canvas) -> Text<'_, (i32, i32), &str> {
        let mut font = (FONT_FAMILY, self.size * canvas.scale).into_font();
        if self.is_upright {
            font = font.transform(FontTransform::Rotate270);
        }
        let style = TextStyle::from(font).color(&self.colour).pos(Pos::new(self.horizontal, VPos::Center));
        Text::new(self.text.as_str(), canvas.whole(self.position), style)
    }
}

fn drawing_error(error: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Invalid, format!("drawing failed: {error}"))
}

fn corners([left, top, right, bottom]: [f64; 4]) -> [(f64, f64); 4] {
    [(left, top), (right, top), (right, bottom), (left, bottom)]
}

/// Returns the width of a text, pixels.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    // The text is measured at a larger size, because the font crate returns whole pixels.
    const LARGE: f64 = 8.0;
    // If the font cannot be loaded, drawing returns the error.
    if register_embedded_font().is_err() {
        return 0.0;
    }
    (FONT_FAMILY, size * LARGE).into_font().box_size(text).map_or(0.0, |(width, _)| f64::from(width) / LARGE)
}

/// Returns half the width and height of a text of this size with a margin, pixels.
pub(super) fn half_size(text: &str, size: f64) -> (f64, f64) {
    (width_of(text, size) / 2.0 + 4.0, 0.6 * size + 1.0)
}

/// Returns left, top, right and bottom of a box about a position.
pub(super) fn around((x, y): (f64, f64), half: (f64, f64)) -> [f64; 4] {
    [x - half.0, y - half.1, x + half.0, y + half.1]
}

/// Wraps text at spaces into lines of at most this width, pixels. A line with a single word may be wider.
pub(super) fn lines_of(text: &str, width: f64, size: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width_of(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// DejaVu Sans 2.37 as bundled with matplotlib 3.11.2, subset by fonttools 4.68.0 (`pyftsubset`, unhinted) on
/// 2026-11-21.
pub(super) const DEJAVU_SANS: &[u8] = include_bytes!("fonts/DejaVuSans-subset.ttf");

/// Name of the font in the drawing crate and in SVG.
const FONT_FAMILY: &str = "DejaVu Sans";

/// Returns the style sheet that embeds the font in an SVG, with a sans serif font for viewers without embedded fonts.
pub(super) fn font_style_sheet() -> String {
    let bytes = STANDARD.encode(DEJAVU_SANS);
    format!(
        "<style>@font-face{{font-family:\"{FONT_FAMILY}\";src:url(data:font/ttf;base64,{bytes}) format(\"truetype\")}}\
         polyline{{stroke-linecap:round;stroke-linejoin:round}}text{{font-family:\"{FONT_FAMILY}\",sans-serif}}</style>"
    )
}

/// Registers the font once per process.
fn register_embedded_font() -> Result<(), Error> {
    static READY: OnceLock<bool> = OnceLock::new();
    let is_ready = READY.get_or_init(|| register_font(FONT_FAMILY, FontStyle::Normal, DEJAVU_SANS).is_ok());
    if *is_ready {
        Ok(())
    } else {
        Err(Error::new(ErrorKind::Invalid, "drawing failed: the embedded font cannot be loaded"))
    }
}
