//! Projection of a hemisphere onto a disk: the pole is in the middle, the equator at the rim, and the distance from the
//! middle is proportional to the angle from the pole.
//!
//! Longitude 0 is up and longitudes increase anticlockwise. For azimuths this is the sky as seen from below, with north
//! up and east left. For longitudes in a satellite's frame it is the view from above.

use std::f64::consts::{FRAC_PI_2, TAU};

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;
use rayon::prelude::*;

use super::axes::colour_bar;
use super::contour::contours;
use super::labels::Labels;
use super::picture::{INK, PAPER, Picture, Pixels, half_size, lines_of, width_of};
use super::scale::{ColourScale, Quantity};

/// Side of the squares of the contour lines, pixels.
const SQUARE: usize = 2;

/// When a contour line is computed, directions in the Earth's shadow count as fainter than the level of the line by
/// this difference, mag.
const SHADOW_BELOW_MAG: f64 = 2.0;

/// What is shown in one direction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum DiskContent {
    /// Magnitude of a satellite, or the value of another quantity.
    Value(f64),
    /// A satellite in the Earth's shadow.
    Shadow,
    /// No lit surface, or no value.
    Empty,
}

/// One disk with its labels.
pub struct Disk<'a> {
    /// Title above the disk.
    pub title: String,
    /// Quantity that the values represent.
    pub quantity: Quantity,
    /// If true, only the left half of the disk is drawn, with longitudes 0 to π.
    pub is_half: bool,
    /// Content as a function of the longitude and of the angle from the middle in [0, π/2], radians.
    pub content: Box<dyn Fn(f64, f64) -> DiskContent + Sync + 'a>,
    /// Values within this angle from the middle, radians, determine the colour scale.
    pub scaled_within_rad: f64,
    /// Longitude of the Sun, radians; `None` if the Sun has no single position.
    pub sun_longitude_rad: Option<f64>,
    /// Labels outside the rim, with their longitudes in degrees.
    pub rim: Vec<(f64, &'static str)>,
    /// Thin circles with labels, with their angles from the middle in degrees.
    pub circles: Vec<(f64, String)>,
    /// Angle of the Earth's limb from the middle, radians, drawn as a dashed circle.
    pub limb_rad: Option<f64>,
}

/// Content of a disk, pixel by pixel.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    /// Pixels along each side.
    pub side: usize,
    /// Pixels row by row from the top; `None` outside the disk.
    pub pixels: Vec<Option<DiskContent>>,
}

impl Disk<'_> {
    /// Evaluates every pixel of a disk of this radius (pixels). The raster extends one pixel beyond the rim on every
    /// side, so that the rim is smooth.
    pub(super) fn raster(&self, radius: usize) -> Raster {
        let side = 2 * radius + 2;
        let middle = side as f64 / 2.0;
        let pixels = (0..side * side)
            .into_par_iter()
            .map(|index| {
                // Centre of the pixel, to the right of and above the middle.
                let right = (index % side) as f64 + 0.5 - middle;
                let up = middle - (index / side) as f64 - 0.5;
                let distance = right.hypot(up) / radius as f64;
                // A pixel that is cut by the rim gets the content at the rim.
                let is_in = distance <= 1.0 + 1.0 / radius as f64 && !(self.is_half && right > 0.0);
                is_in.then(|| {
                    let longitude = (-right).atan2(up).rem_euclid(TAU);
                    (self.content)(longitude, distance.min(1.0) * FRAC_PI_2)
                })
            })
            .collect();
        Raster { side, pixels }
    }
}

/// Returns the position of a direction, to the right of and below the middle of a disk of radius 1.
pub(super) fn disk_position(longitude_rad: f64, from_middle_rad: f64) -> (f64, f64) {
    let (sin, cos) = longitude_rad.sin_cos();
    let distance = from_middle_rad / FRAC_PI_2;
    (-distance * sin, -distance * cos)
}

impl Raster {
    /// Returns all values with their angles from the middle, radians.
    pub fn values(&self) -> impl Iterator<Item = (f64, f64)> {
        let middle = self.side as f64 / 2.0;
        let angle = move |index: usize| {
            let (right, below) = ((index % self.side) as f64 + 0.5 - middle, (index / self.side) as f64 + 0.5 - middle);
            // The raster extends one pixel beyond the disk on every side.
            FRAC_PI_2 * right.hypot(below) / (middle - 1.0)
        };
        self.pixels.iter().enumerate().filter_map(move |(index, pixel)| match pixel {
            Some(DiskContent::Value(value)) => Some((angle(index), *value)),
            _ => None,
        })
    }

    /// Returns the lines on which the value equals `level`, in pixels right of and below the upper left corner.
    /// Directions in the Earth's shadow count as fainter than any level.
    pub fn contours(&self, level: f64) -> Vec<Vec<(f64, f64)>> {
        let value = |column: usize, row: usize| match self.pixels.get(row * self.side + column)? {
            Some(DiskContent::Value(value)) => Some(*value),
            // Shadow counts as fainter than any level, so that lines enclose bright regions also along the edge of the
            // shadow.
            Some(DiskContent::Shadow) => Some(level + SHADOW_BELOW_MAG),
            _ => None,
        };
        let mut lines = contours((self.side, self.side), SQUARE, level, value);
        // Contours count from the centre of the first pixel, which is half a pixel from the corner.
        lines.iter_mut().flatten().for_each(|(x, y)| (*x, *y) = (*x + 0.5, *y + 0.5));
        lines
    }

    /// Returns true if any pixel has this content.
    pub fn shows(&self, content: DiskContent) -> bool {
        self.pixels.contains(&Some(content))
    }
}

const SHADOW: [u8; 3] = [150, 150, 150];
/// Colour for missing values, darker than the middle of the residual colours.
const UNKNOWN: [u8; 3] = [205, 205, 205];
const WHITE: RGBColor = RGBColor(255, 255, 255);

/// Labels outside the horizon of a disk of azimuths, with their azimuths in degrees.
pub(super) const AZIMUTHS: [(f64, &str); 8] = [
    (0.0, "N"),
    (45.0, "45°"),
    (90.0, "E"),
    (135.0, "135°"),
    (180.0, "S"),
    (225.0, "225°"),
    (270.0, "W"),
    (315.0, "315°"),
];

/// Margin between the rim of a disk and the border of its part of the picture, pixels.
const MARGIN: usize = 66;
const TITLE: usize = 46;
const DISK_TITLE: usize = 32;
const LEGEND: usize = 74;
const BAR_SHARE: usize = 120;
const BAR_WIDTH: usize = 26;
const CAPTION_SIZE: f64 = 16.0;

/// Content of a picture of disks.
pub struct DiskSheet<'a> {
    /// Title.
    pub title: String,
    /// Caption below all disks.
    pub caption: String,
    /// Disks, evaluated on all threads of the current pool. If all disks show the same quantity they share one colour
    /// bar; otherwise each disk has its own bar, with the same scale for disks of the same quantity.
    pub disks: Vec<Disk<'a>>,
    /// Radius of each disk, pixels.
    pub radius: usize,
    /// Number of disks in a row, 1 or more.
    pub disks_per_row: usize,
    /// Magnitude of the contour line in every disk, and its label in the legend.
    pub contour_mag: Option<(f64, String)>,
    /// Label in the legend for directions without content.
    pub nothing: &'static str,
    /// Colour scale of all disks; `None` for one that contains nearly all values.
    pub scale: Option<ColourScale>,
}

/// Evaluated disks and their layout.
struct Layout<'a> {
    sheet: DiskSheet<'a>,
    rasters: Vec<Raster>,
    scales: Vec<ColourScale>,
}

impl DiskSheet<'_> {
    /// Evaluates the disks, lays them out and returns the picture.
    pub fn picture(self) -> Picture {
        let rasters: Vec<Raster> = self.disks.iter().map(|disk| disk.raster(self.radius)).collect();
        let mut scales: Vec<ColourScale> = self.scale.into_iter().collect();
        for disk in &self.disks {
            if scales.iter().all(|scale| scale.quantity != disk.quantity) {
                let alike = self.disks.iter().zip(&rasters).filter(|(other, _)| other.quantity == disk.quantity);
                let shown = || alike.clone().flat_map(|(disk, raster)| raster.values().map(move |value| (disk, value)));
                let counted = shown().filter(|(disk, (angle, _))| *angle <= disk.scaled_within_rad);
                let scale = ColourScale::from_values(disk.quantity, counted.map(|(_, (_, value))| value));
                scales.push(scale.showing(shown().map(|(_, (_, value))| value)));
            }
        }
        Layout { sheet: self, rasters, scales }.picture()
    }
}

impl Layout<'_> {
    fn picture(&self) -> Picture {
        let sheet = &self.sheet;
        let (columns, rows) = self.grid();
        let bars = if self.is_mixed() { columns } else { 1 };
        let width = columns * self.share() + bars * BAR_SHARE;
        let caption = lines_of(&sheet.caption, width as f64 - 48.0, CAPTION_SIZE).len().max(1);
        let height = TITLE + rows * self.row() + LEGEND + (caption - 1) * 22;
        let mut picture = Picture::new(width, height);
        picture.set_scales(self.scales.clone());
        picture.set_title(&sheet.title, (width as f64 / 2.0, 26.0), 23.0, HPos::Center);
        for (index, (disk, raster)) in sheet.disks.iter().zip(&self.rasters).enumerate() {
            let middle = self.middle(index);
            self.draw_disk(&mut picture, disk, raster, middle);
            if self.is_mixed() {
                let left = (index % columns * (self.share() + BAR_SHARE) + self.share()) as f64;
                self.draw_bar(&mut picture, self.scale_of(disk.quantity), left, middle.1);
            }
        }
        if let (false, Some(scale)) = (self.is_mixed(), self.scales.first()) {
            let middle = TITLE as f64 + (rows * self.row() + DISK_TITLE) as f64 / 2.0;
            self.draw_bar(&mut picture, scale, (columns * self.share()) as f64, middle);
        }
        self.draw_legend(&mut picture, (TITLE + rows * self.row()) as f64 + 18.0);
        picture
    }

    fn is_mixed(&self) -> bool {
        self.scales.len() > 1
    }

    /// Returns the numbers of columns and rows of disks.
    fn grid(&self) -> (usize, usize) {
        let columns = self.sheet.disks_per_row.clamp(1, self.sheet.disks.len().max(1));
        (columns, self.sheet.disks.len().div_ceil(columns).max(1))
    }

    fn has_halves(&self) -> bool {
        self.sheet.disks.iter().all(|disk| disk.is_half)
    }

    /// Returns the width of a disk with its margins, pixels.
    fn share(&self) -> usize {
        2 * MARGIN + self.sheet.radius * if self.has_halves() { 1 } else { 2 }
    }

    /// Returns the height of a row of disks, pixels.
    fn row(&self) -> usize {
        DISK_TITLE + 2 * (self.sheet.radius + MARGIN)
    }

    /// Returns the position of the middle of a disk; for a half disk, the middle of its straight side.
    fn middle(&self, index: usize) -> (f64, f64) {
        let (columns, _) = self.grid();
        let step = self.share() + if self.is_mixed() { BAR_SHARE } else { 0 };
        let left = (index % columns * step) as f64 + (MARGIN + self.sheet.radius) as f64;
        (left, (TITLE + index / columns * self.row() + DISK_TITLE + MARGIN + self.sheet.radius) as f64)
    }

    fn scale_of(&self, quantity: Quantity) -> &ColourScale {
        self.scales.iter().find(|scale| scale.quantity == quantity).unwrap_or(&self.scales[0])
    }

    fn colour(&self, quantity: Quantity, content: DiskContent) -> [u8; 3] {
        match content {
            DiskContent::Value(value) => self.scale_of(quantity).colour(value),
            DiskContent::Shadow => SHADOW,
            DiskContent::Empty if self.sheet.contour_mag.is_none() => UNKNOWN,
            DiskContent::Empty => PAPER,
        }
    }

    fn draw_disk(&self, picture: &mut Picture, disk: &Disk<'_>, raster: &Raster, middle: (f64, f64)) {
        let radius = self.sheet.radius as f64;
        let at = |(right, below): (f64, f64)| (middle.0 + radius * right, middle.1 + radius * below);
        let corner = (middle.0 - raster.side as f64 / 2.0, middle.1 - raster.side as f64 / 2.0);
        let colours =
            raster.pixels.iter().map(|pixel| pixel.map(|content| self.colour(disk.quantity, content))).collect();
        let within = Some((middle, radius));
        picture.paint(Pixels { corner, each: (1.0, 1.0), columns: raster.side, colours, within });
        let contours = self.sheet.contour_mag.iter().flat_map(|(level, _)| raster.contours(*level));
        let mut lines: Vec<Vec<(f64, f64)>> =
            contours.map(|line| line.iter().map(|(x, y)| (corner.0 + x, corner.1 + y)).collect()).collect();
        for line in &lines {
            picture.line(line, INK.to_rgba(), 4.0);
            picture.line(line, WHITE.to_rgba(), 2.0);
        }
        if let Some(limb) = disk.limb_rad {
            for dash in 0..60 {
                let part =
                    |part: u8| at(disk_position((f64::from(dash) * 6.0 + f64::from(part) * 0.75).to_radians(), limb));
                let dash: Vec<_> = (0..=4).map(part).collect();
                picture.line(&dash, INK.mix(0.8), 1.5);
                lines.push(dash);
            }
        }
        // Draws a circle about the middle, or half of it.
        let round = |picture: &mut Picture, angle: f64, colour, width| {
            if disk.is_half {
                let arc: Vec<_> =
                    (0..=90).map(|part| at(disk_position(f64::from(2 * part).to_radians(), angle))).collect();
                picture.line(&arc, colour, width);
            } else {
                picture.circle(middle, radius * angle / FRAC_PI_2, colour, width);
            }
        };
        let mut labels = Labels::new([middle.0 - radius, middle.1 - radius, middle.0 + radius, middle.1 + radius]);
        lines.iter().for_each(|line| labels.add_line(0, line));
        for (angle_deg, _) in &disk.circles {
            // A light and a dark line are visible on all colours.
            round(picture, angle_deg.to_radians(), WHITE.mix(0.35), 3.0);
            round(picture, angle_deg.to_radians(), INK.mix(0.6), 1.0);
        }
        for (angle_deg, text) in &disk.circles {
            // Labels are at a longitude away from the Sun, from contour lines and from other labels, if there is such a
            // longitude.
            let sun_deg = disk.sun_longitude_rad.unwrap_or(0.0).to_degrees();
            let longitudes = (0..16).map(|part| (sun_deg + 112.5 + 22.5 * f64::from(part)).rem_euclid(360.0));
            let longitudes = longitudes.filter(|longitude| !disk.is_half || (20.0..=160.0).contains(longitude));
            let position = |longitude: f64, aside: f64| {
                let angle = angle_deg.to_radians() + FRAC_PI_2 * aside / radius;
                at(disk_position(longitude.to_radians(), angle))
            };
            // A label that does not fit on its circle is next to it.
            let asides = [0.0, 24.0, -24.0].into_iter();
            let candidates = asides.flat_map(|aside| longitudes.clone().map(move |longitude| (longitude, aside)));
            let half = half_size(text, CAPTION_SIZE);
            let free = labels.place(half, candidates.map(|(longitude, aside)| position(longitude, aside)));
            picture.note(text, free.unwrap_or_else(|| position(sun_deg + 112.5, 0.0)));
        }
        round(picture, FRAC_PI_2, INK.to_rgba(), 1.6);
        if disk.is_half {
            picture.line(&[at((0.0, -1.0)), at((0.0, 1.0))], INK.to_rgba(), 1.6);
        }
        for (longitude_deg, text) in &disk.rim {
            let (right, below) = disk_position(longitude_deg.to_radians(), FRAC_PI_2);
            let margin = 17.0 + 1.6 * (text.chars().count() as f64 - 1.0) * right.abs() * 3.0;
            let label_position = (middle.0 + (radius + margin) * right, middle.1 + (radius + 17.0) * below);
            picture.text(text, label_position, 19.0, HPos::Center);
        }
        if let Some(sun_rad) = disk.sun_longitude_rad {
            picture.sun(at(disk_position(sun_rad, FRAC_PI_2 * (radius + 46.0) / radius)));
        }
        let across = match (disk.is_half, self.sheet.disks.len()) {
            // The title of a single disk is below that of the picture.
            (false, 1) => picture.size().0 as f64 / 2.0,
            (false, _) => middle.0,
            (true, _) => middle.0 - radius / 2.0,
        };
        let above = middle.1 - radius - MARGIN as f64 - 16.0;
        // A long title becomes smaller, so that it fits.
        let room = if self.sheet.disks.len() == 1 { picture.size().0 } else { self.share() } as f64 - 16.0;
        let size = 20.0 * (room / width_of(&disk.title, 20.0).max(1.0)).min(1.0);
        picture.text(&disk.title, (across, above), size, HPos::Center);
    }

    /// Draws a colour bar in the part of the picture that begins at `left`.
    fn draw_bar(&self, picture: &mut Picture, scale: &ColourScale, left: f64, middle: f64) {
        let half = 0.85 * self.sheet.radius as f64;
        // Bars of half disks are next to the straight side.
        let left = left + 8.0 - if self.has_halves() { 30.0 } else { 0.0 };
        let (top, right, bottom) = (middle - half, left + BAR_WIDTH as f64, middle + half);
        colour_bar(picture, scale, [left, top, right, bottom], &scale.label());
        let contour = self.sheet.contour_mag.as_ref().map(|(level, _)| *level);
        if let Some(level) = contour.filter(|level| (scale.least..=scale.greatest).contains(level)) {
            let y = bottom - (bottom - top) * scale.share(level);
            picture.line(&[(left, y), (right, y)], INK.to_rgba(), 4.0);
            picture.line(&[(left, y), (right, y)], WHITE.to_rgba(), 2.0);
        }
    }

    /// Draws the legend and the caption.
    fn draw_legend(&self, picture: &mut Picture, y: f64) {
        let mut x = 24.0;
        if self.sheet.disks.iter().any(|disk| disk.sun_longitude_rad.is_some()) {
            picture.sun((x + 12.0, y));
            x = picture.legend_text("Sun", x + 32.0, y);
        }
        if let Some((level, text)) = &self.sheet.contour_mag
            && self.rasters.iter().any(|raster| !raster.contours(*level).is_empty())
        {
            picture.line(&[(x, y), (x + 30.0, y)], INK.to_rgba(), 4.0);
            picture.line(&[(x, y), (x + 30.0, y)], WHITE.to_rgba(), 2.0);
            x = picture.legend_text(text, x + 38.0, y);
        }
        for (content, text) in [(DiskContent::Shadow, "Earth's shadow"), (DiskContent::Empty, self.sheet.nothing)] {
            if self.rasters.iter().any(|raster| raster.shows(content)) {
                let [red, green, blue] = self.colour(Quantity::Magnitude, content);
                picture.rectangle([x, y - 8.0, x + 24.0, y + 8.0], RGBColor(red, green, blue).to_rgba());
                picture.border([x, y - 8.0, x + 24.0, y + 8.0], 1.0);
                x = picture.legend_text(text, x + 32.0, y);
            }
        }
        if self.sheet.disks.iter().any(|disk| disk.limb_rad.is_some()) {
            picture.dashed(&[(x, y), (x + 30.0, y)], [5.0, 3.0], INK.mix(0.8), 1.5);
            picture.legend_text("Earth's limb", x + 38.0, y);
        }
        picture.paragraph(&self.sheet.caption, [24.0, picture.size().0 as f64 - 24.0], y + 34.0, CAPTION_SIZE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_pixels_are_evaluated_at_their_direction() {
        let disk = Disk {
            title: String::new(),
            // Longitude and angle encoded in one number.
            content: Box::new(|longitude, angle| DiskContent::Value(longitude + 10.0 * angle)),
            scaled_within_rad: FRAC_PI_2,
            sun_longitude_rad: Some(0.0),
            quantity: Quantity::Magnitude,
            is_half: false,
            rim: Vec::new(),
            circles: Vec::new(),
            limb_rad: None,
        };
        let raster = disk.raster(100);
        let middle = raster.side as f64 / 2.0;
        for (longitude, angle) in [(0.1, 0.5), (1.6, 1.2), (3.0, 0.9), (5.0, 0.3)] {
            let (right, down) = disk_position(longitude, angle);
            let (column, row) = ((middle + 100.0 * right) as usize, (middle + 100.0 * down) as usize);
            let Some(DiskContent::Value(shown)) = raster.pixels[row * raster.side + column] else { panic!("nothing") };
            // Half a pixel is 0.008 rad of angle, and 0.03 rad of longitude at 0.3 rad.
            assert!((shown - longitude - 10.0 * angle).abs() < 0.2, "{longitude} {angle}: {shown}");
        }
        // Values are returned with their angles from the middle.
        for (angle, value) in raster.values().filter(|(angle, _)| *angle <= FRAC_PI_2) {
            let longitude = value - 10.0 * angle;
            assert!((-1e-9..=TAU).contains(&longitude), "{angle} {value}");
        }
        // East is left.
        assert!(disk_position(FRAC_PI_2, 0.5).0 < 0.0);
        assert!(raster.pixels[0].is_none());
    }

    #[test]
    fn verif_a_line_runs_along_the_shadow() {
        let half = |index: usize| Some(if index / 101 < 60 { DiskContent::Value(6.0) } else { DiskContent::Shadow });
        let lines = Raster { side: 101, pixels: (0..101 * 101).map(half).collect() }.contours(7.0);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].len() > 45 && lines[0].iter().all(|(_, y)| (y - 60.0).abs() < 1.5), "{:?}", lines[0]);
    }
}
