//! Discs side by side, a colour bar, and the words: laid out once, drawn by any backend.
//!
//! What is made of pixels (discs and bar) is painted into an [`Underlay`]; lines and words are drawn over it. Lengths are in pixels of a picture
//! at its own size; `scale` of a drawing is how many pixels of the backend one of them takes.

use std::f64::consts::FRAC_PI_2;

use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{DrawingArea, DrawingBackend, IntoFont, RGBAColor, RGBColor, ShapeStyle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, TextStyle};

use super::contour::contours;
use super::disc::{Disc, Raster, Seen, place};
use super::error::PlotError;
use super::font;
use super::scale::MagnitudeScale;

const INK: RGBColor = RGBColor(30, 30, 30);
const SHADOW: [u8; 3] = [150, 150, 150];
const PAPER: [u8; 3] = [255, 255, 255];
const SUN: RGBColor = RGBColor(255, 190, 0);

/// Between the rim of a disc and the border of its share of the picture.
const MARGIN: usize = 66;
const TITLE: usize = 46;
const DISC_TITLE: usize = 32;
const LEGEND: usize = 74;
const BAR_SHARE: usize = 120;
const BAR_WIDTH: usize = 26;
/// What a picture without any magnitude has for a scale.
const NO_SCALE: MagnitudeScale =
    MagnitudeScale { brightest_mag: 4.0, faintest_mag: 9.0, has_brighter: false, has_fainter: false };

/// A picture laid out: discs asked for all their pixels, and the scale that holds them.
pub struct Picture<'a> {
    title: String,
    caption: String,
    discs: Vec<(Disc<'a>, Raster)>,
    scale: MagnitudeScale,
    radius: usize,
    contour_mag: f64,
}

/// The pixels below the lines: red, green, blue, row by row.
pub(super) struct Underlay {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Three bytes a pixel.
    pub rgb: Vec<u8>,
}

impl<'a> Picture<'a> {
    /// Discs of `radius` pixels side by side under one title, with one colour bar for all, a line at `contour_mag` and a `caption` below. The discs are asked for all their pixels now, on all threads of the caller's pool.
    pub fn new(title: String, caption: String, discs: Vec<Disc<'a>>, radius: usize, contour_mag: f64) -> Self {
        let discs: Vec<_> = discs
            .into_iter()
            .map(|disc| {
                let raster = disc.raster(radius);
                (disc, raster)
            })
            .collect();
        let scale = MagnitudeScale::of(discs.iter().flat_map(|(_, raster)| raster.magnitudes())).unwrap_or(NO_SCALE);
        Self { title, caption, discs, scale, radius, contour_mag }
    }

    /// The colours it uses.
    pub fn scale(&self) -> &MagnitudeScale {
        &self.scale
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.share() * self.discs.len() + BAR_SHARE, TITLE + DISC_TITLE + self.share() + LEGEND)
    }

    /// What a disc takes across.
    fn share(&self) -> usize {
        2 * (self.radius + MARGIN)
    }

    /// The middle of a disc.
    fn middle(&self, index: usize) -> (f64, f64) {
        let half = self.share() as f64 / 2.0;
        (self.share() as f64 * index as f64 + half, (TITLE + DISC_TITLE) as f64 + half)
    }

    /// Left, top, right and bottom of the colour bar.
    fn bar(&self) -> [f64; 4] {
        let left = (self.share() * self.discs.len()) as f64 + 8.0;
        let (_, middle) = self.middle(0);
        let half = 0.85 * self.radius as f64;
        [left, middle - half, left + BAR_WIDTH as f64, middle + half]
    }

    /// Discs and bar, each pixel of them `fine` by `fine`.
    pub(super) fn underlay(&self, fine: usize) -> Underlay {
        let (width, height) = self.size();
        let (width, height) = (width * fine, height * fine);
        let mut rgb = PAPER.repeat(width * height);
        let mut paint = |column: usize, row: usize, colour: [u8; 3]| {
            let at = 3 * (row * width + column);
            if let Some(pixel) = rgb.get_mut(at..at + 3) {
                pixel.copy_from_slice(&colour);
            }
        };
        for (index, (_, raster)) in self.discs.iter().enumerate() {
            let (across, down) = self.middle(index);
            let corner = |middle: f64| middle as usize * fine - raster.side * fine / 2;
            let (left, top) = (corner(across), corner(down));
            let rim = (self.radius * fine) as f64;
            let middle = (raster.side * fine) as f64 / 2.0;
            for row in 0..raster.side * fine {
                for column in 0..raster.side * fine {
                    let Some(seen) = raster.pixels[row / fine * raster.side + column / fine] else { continue };
                    if (column as f64 + 0.5 - middle).hypot(row as f64 + 0.5 - middle) <= rim {
                        paint(left + column, top + row, self.colour(seen));
                    }
                }
            }
        }
        let [left, top, right, bottom] = self.bar().map(|side| (side * fine as f64).round() as usize);
        for row in top..bottom {
            let share = (row as f64 + 0.5 - top as f64) / (bottom - top) as f64;
            let magnitude = self.scale.brightest_mag + share * (self.scale.faintest_mag - self.scale.brightest_mag);
            for column in left..right {
                paint(column, row, self.scale.colour(magnitude));
            }
        }
        Underlay { width, height, rgb }
    }

    fn colour(&self, seen: Seen) -> [u8; 3] {
        match seen {
            Seen::Magnitude(magnitude) => self.scale.colour(magnitude),
            Seen::Shadow => SHADOW,
            Seen::Nothing => PAPER,
        }
    }

    /// Lines and words over the underlay.
    pub(super) fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: f64) -> Result<(), PlotError> {
        font::make_ready()?;
        let pen = Pen { area, scale };
        let (width, height) = self.size();
        pen.text(&self.title, (width as f64 / 2.0, 26.0), 23.0, HPos::Center)?;
        for (index, (disc, raster)) in self.discs.iter().enumerate() {
            self.draw_disc(&pen, disc, raster, self.middle(index))?;
        }
        self.draw_bar(&pen)?;
        self.draw_legend(&pen, height as f64)
    }

    fn draw_disc<B: DrawingBackend>(
        &self,
        pen: &Pen<'_, B>,
        disc: &Disc<'_>,
        raster: &Raster,
        (across, down): (f64, f64),
    ) -> Result<(), PlotError> {
        let radius = self.radius as f64;
        let at = |(right, below): (f64, f64)| (across + radius * right, down + radius * below);
        let corner = (across - raster.side as f64 / 2.0, down - raster.side as f64 / 2.0);
        for line in contours(raster, self.contour_mag) {
            let line: Vec<_> = line.iter().map(|(x, y)| (corner.0 + x, corner.1 + y)).collect();
            pen.line(&line, INK.to_rgba(), 4.0)?;
            pen.line(&line, RGBColor(255, 255, 255).to_rgba(), 2.0)?;
        }
        if let Some(limb) = disc.limb_rad {
            for dash in 0..60 {
                let arc: Vec<_> = (0..=4)
                    .map(|part| at(place((f64::from(dash) * 6.0 + f64::from(part) * 0.75).to_radians(), limb)))
                    .collect();
                pen.line(&arc, INK.mix(0.8), 1.5)?;
            }
        }
        for (angle_deg, words) in &disc.circles {
            let angle = angle_deg.to_radians();
            pen.circle((across, down), radius * angle / FRAC_PI_2, INK.mix(0.45), 1.0)?;
            // Words where the Sun is far from and no other words are.
            pen.note(words, at(place(disc.sun_longitude_rad + 112.5_f64.to_radians(), angle)))?;
        }
        pen.circle((across, down), radius, INK.to_rgba(), 1.6)?;
        for (longitude_deg, words) in disc.rim {
            let (right, below) = place(longitude_deg.to_radians(), FRAC_PI_2);
            let room = 17.0 + 1.6 * (words.chars().count() as f64 - 1.0) * right.abs() * 3.0;
            pen.text(words, (across + (radius + room) * right, down + (radius + 17.0) * below), 19.0, HPos::Center)?;
        }
        let (right, below) = place(disc.sun_longitude_rad, FRAC_PI_2);
        pen.sun((across + (radius + 46.0) * right, down + (radius + 46.0) * below))?;
        pen.text(&disc.title, (across, (TITLE + DISC_TITLE) as f64 - 16.0), 20.0, HPos::Center)
    }

    fn draw_bar<B: DrawingBackend>(&self, pen: &Pen<'_, B>) -> Result<(), PlotError> {
        let [left, top, right, bottom] = self.bar();
        let scale = &self.scale;
        let height = |magnitude: f64| bottom - (bottom - top) * scale.brightness(magnitude);
        pen.line(&[(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], INK.to_rgba(), 1.4)?;
        for tick in scale.ticks() {
            let y = height(tick);
            pen.line(&[(right, y), (right + 6.0, y)], INK.to_rgba(), 1.4)?;
            // Where colours end before the magnitudes do, the end says so.
            let beyond = if scale.has_brighter && tick == scale.brightest_mag {
                "≤ "
            } else if scale.has_fainter && tick == scale.faintest_mag {
                "≥ "
            } else {
                ""
            };
            pen.text(&format!("{beyond}{tick}"), (right + 11.0, y), 19.0, HPos::Left)?;
        }
        if (scale.brightest_mag..=scale.faintest_mag).contains(&self.contour_mag) {
            let mark = [(left, height(self.contour_mag)), (right, height(self.contour_mag))];
            pen.line(&mark, INK.to_rgba(), 4.0)?;
            pen.line(&mark, RGBColor(255, 255, 255).to_rgba(), 2.0)?;
        }
        pen.text("mag", (left, top - 20.0), 19.0, HPos::Left)
    }

    /// What the signs mean, and the caption.
    fn draw_legend<B: DrawingBackend>(&self, pen: &Pen<'_, B>, height: f64) -> Result<(), PlotError> {
        let y = height - LEGEND as f64 + 18.0;
        let mut x = 24.0;
        pen.sun((x + 12.0, y))?;
        x = pen.words("Sun", x + 32.0, y)?;
        if self.discs.iter().any(|(_, raster)| !contours(raster, self.contour_mag).is_empty()) {
            pen.line(&[(x, y), (x + 30.0, y)], INK.to_rgba(), 4.0)?;
            pen.line(&[(x, y), (x + 30.0, y)], RGBColor(255, 255, 255).to_rgba(), 2.0)?;
            x = pen.words(&format!("{} mag", self.contour_mag), x + 38.0, y)?;
        }
        for (seen, words) in [(Seen::Shadow, "Earth's shadow"), (Seen::Nothing, "nothing lit seen")] {
            if self.discs.iter().any(|(_, raster)| raster.shows(seen)) {
                let [red, green, blue] = self.colour(seen);
                pen.patch([x, y - 8.0, x + 24.0, y + 8.0], RGBColor(red, green, blue))?;
                x = pen.words(words, x + 32.0, y)?;
            }
        }
        if self.discs.iter().any(|(disc, _)| disc.limb_rad.is_some()) {
            for dash in 0..4 {
                let from = x + 8.0 * f64::from(dash);
                pen.line(&[(from, y), (from + 5.0, y)], INK.mix(0.8), 1.5)?;
            }
            pen.words("Earth's limb", x + 38.0, y)?;
        }
        pen.text(&self.caption, (24.0, y + 34.0), 16.0, HPos::Left)
    }
}

/// Draws in the picture's own pixels on an area of any resolution.
struct Pen<'a, B: DrawingBackend> {
    area: &'a DrawingArea<B, Shift>,
    scale: f64,
}

impl<B: DrawingBackend> Pen<'_, B> {
    fn at(&self, (x, y): (f64, f64)) -> (i32, i32) {
        ((x * self.scale).round() as i32, (y * self.scale).round() as i32)
    }

    fn style(&self, colour: RGBAColor, width: f64) -> ShapeStyle {
        ShapeStyle { color: colour, filled: false, stroke_width: (width * self.scale).round().max(1.0) as u32 }
    }

    fn line(&self, places: &[(f64, f64)], colour: RGBAColor, width: f64) -> Result<(), PlotError> {
        let places: Vec<_> = places.iter().map(|place| self.at(*place)).collect();
        self.area.draw(&PathElement::new(places, self.style(colour, width))).map_err(told)
    }

    fn circle(&self, centre: (f64, f64), radius: f64, colour: RGBAColor, width: f64) -> Result<(), PlotError> {
        let radius = (radius * self.scale).round() as i32;
        self.area.draw(&Circle::new(self.at(centre), radius, self.style(colour, width))).map_err(told)
    }

    fn patch(&self, [left, top, right, bottom]: [f64; 4], colour: RGBColor) -> Result<(), PlotError> {
        let corners = [self.at((left, top)), self.at((right, bottom))];
        self.area.draw(&Rectangle::new(corners, colour.filled())).map_err(told)?;
        self.area.draw(&Rectangle::new(corners, self.style(INK.to_rgba(), 1.0))).map_err(told)
    }

    fn text(&self, words: &str, place: (f64, f64), size: f64, horizontal: HPos) -> Result<(), PlotError> {
        let style = self.text_style(size).pos(Pos::new(horizontal, VPos::Center));
        self.area.draw(&Text::new(words, self.at(place), style)).map_err(told)
    }

    fn text_style(&self, size: f64) -> TextStyle<'static> {
        TextStyle::from((font::FAMILY, size * self.scale).into_font()).color(&INK)
    }

    /// Words of the legend; says where the next sign may begin.
    fn words(&self, words: &str, x: f64, y: f64) -> Result<f64, PlotError> {
        self.text(words, (x, y), 17.0, HPos::Left)?;
        Ok(x + self.width(words, 17.0)? + 28.0)
    }

    fn width(&self, words: &str, size: f64) -> Result<f64, PlotError> {
        let (width, _) = self.area.estimate_text_size(words, &self.text_style(size)).map_err(told)?;
        Ok(f64::from(width) / self.scale)
    }

    /// Small words on a light ground, so that they can be read on any colour.
    fn note(&self, words: &str, (x, y): (f64, f64)) -> Result<(), PlotError> {
        let half = self.width(words, 16.0)? / 2.0 + 4.0;
        let corners = [self.at((x - half, y - 11.0)), self.at((x + half, y + 11.0))];
        let ground = RGBColor(255, 255, 255).mix(0.72).filled();
        self.area.draw(&Rectangle::new(corners, ground)).map_err(told)?;
        self.text(words, (x, y), 16.0, HPos::Center)
    }

    /// A disc with rays.
    fn sun(&self, (x, y): (f64, f64)) -> Result<(), PlotError> {
        for ray in 0..8 {
            let (sin, cos) = (f64::from(ray) * std::f64::consts::FRAC_PI_4).sin_cos();
            self.line(&[(x + 8.5 * cos, y + 8.5 * sin), (x + 12.5 * cos, y + 12.5 * sin)], INK.to_rgba(), 1.5)?;
        }
        let corner = |part: u8| {
            let (sin, cos) = (f64::from(part) * std::f64::consts::TAU / 24.0).sin_cos();
            (x + 6.5 * cos, y + 6.5 * sin)
        };
        let corners: Vec<_> = (0..=24).map(corner).collect();
        let filled = corners.iter().map(|place| self.at(*place)).collect::<Vec<_>>();
        self.area.draw(&Polygon::new(filled, SUN.filled())).map_err(told)?;
        self.line(&corners, INK.to_rgba(), 1.2)
    }
}

fn told(error: impl std::fmt::Display) -> PlotError {
    PlotError::Drawing(error.to_string())
}
