//! Stars and constellations above the horizon of a site, in a disk with the zenith in the middle.

use std::f64::consts::FRAC_PI_2;

use hifitime::TimeScale;
use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::bright_stars::bright_stars;
use super::constellations::constellations;
use super::labels::Labels;
use super::picture::{INK, Picture, around, half_size, width_of};
use super::sky_disk::{AZIMUTHS, disk_position};
use crate::frames::{Direction, EopTable, Gcrs, Horizontal, Orientation, Rotation, epoch_from_mjd};
use crate::geometry::{Observer, Site};

/// Altitudes of the circles, degrees.
pub(super) const CIRCLES_DEG: [f64; 2] = [30.0, 60.0];
/// Steps into which a line between two stars is divided. They are at most 26 degrees apart.
const STEPS: u32 = 12;
/// Names cover no star that is brighter.
const COVERED_MAG: f64 = 3.7;

/// Disk of the sky as seen from below: zenith in the middle, horizon at the rim, north up and east left.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct SkyDisk {
    /// Position of the zenith, pixels.
    pub middle: (f64, f64),
    /// Radius of the horizon, pixels.
    pub radius: f64,
}

impl SkyDisk {
    /// Returns the position of a direction in the picture, right and down.
    pub fn at(&self, azimuth_deg: f64, altitude_deg: f64) -> (f64, f64) {
        let (right, below) = disk_position(azimuth_deg.to_radians(), FRAC_PI_2 - altitude_deg.to_radians());
        (self.middle.0 + self.radius * right, self.middle.1 + self.radius * below)
    }

    fn position(&self, seen: &Direction<Horizontal>) -> (f64, f64) {
        self.at(seen.longitude_rad().to_degrees(), seen.latitude_rad().to_degrees())
    }

    /// Fills the disk.
    pub fn fill(&self, picture: &mut Picture, colour: RGBColor) {
        picture.disk(self.middle, self.radius, colour);
    }

    /// Draws circles of altitude, the meridian and the horizon with its labels.
    pub fn draw_circles(&self, picture: &mut Picture) {
        for altitude_deg in CIRCLES_DEG {
            picture.circle(self.middle, self.radius * (90.0 - altitude_deg) / 90.0, INK.mix(0.45), 1.0);
        }
        for azimuth_deg in [0.0, 90.0] {
            picture.line(&[self.at(azimuth_deg, 0.0), self.at(azimuth_deg + 180.0, 0.0)], INK.mix(0.25), 1.0);
        }
        picture.circle(self.middle, self.radius, INK.to_rgba(), 1.6);
        for (azimuth_deg, text) in AZIMUTHS {
            picture.text(text, self.rim_position(azimuth_deg), rim_size(text), HPos::Center);
            picture.line(&[self.at(azimuth_deg, 0.0), self.at(azimuth_deg, 1.5)], INK.to_rgba(), 1.2);
        }
    }

    /// Reserves the places of the labels of the horizon, and draws the labels of the circles where no line is, if there
    /// is such a position.
    pub fn label_circles(&self, picture: &mut Picture, labels: &mut Labels) {
        for (azimuth_deg, text) in AZIMUTHS {
            labels.add_box(around(self.rim_position(azimuth_deg), half_size(text, rim_size(text))));
        }
        for altitude_deg in CIRCLES_DEG {
            let text = format!("{altitude_deg:.0}°");
            let candidates = (0..24).map(|part| self.at(112.5 + 15.0 * f64::from(part), altitude_deg));
            let position = labels.place(half_size(&text, 16.0), candidates);
            picture.note(&text, position.unwrap_or_else(|| self.at(112.5, altitude_deg)));
        }
    }

    /// Returns the position of a label outside the horizon.
    fn rim_position(&self, azimuth_deg: f64) -> (f64, f64) {
        let (x, y) = self.at(azimuth_deg, 0.0);
        let away = |from: f64, to: f64| (to - from) / self.radius * 18.0;
        // Labels of azimuths are wider than high.
        let aside = if azimuth_deg % 90.0 == 0.0 { 1.0 } else { 1.5 };
        (x + aside * away(self.middle.0, x), y + away(self.middle.1, y))
    }
}

/// Returns the size of the text of a label of the horizon.
fn rim_size(text: &str) -> f64 {
    if text.len() > 1 { 16.0 } else { 19.0 }
}

/// Sizes and colours of stars and constellations.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct StarStyle {
    /// Magnitude of the faintest stars.
    pub faintest_mag: f64,
    /// Radius of the faintest stars, pixels.
    pub radius: f64,
    /// Growth of the radius with brightness, pixels per magnitude.
    pub radius_per_mag: f64,
    /// Colour of stars.
    pub stars: RGBColor,
    /// Colour of lines of constellations.
    pub lines: RGBColor,
    /// Colour of names.
    pub names: RGBColor,
    /// Size of names, pixels.
    pub name_size: f64,
}

/// Stars and constellations of a site at one time.
pub(super) struct StarField {
    horizon: Rotation<Gcrs, Horizontal>,
}

impl StarField {
    /// Returns the sky of a site at a time, MJD (UTC); `None` for a time outside the range of dates.
    ///
    /// Refraction, aberration and proper motion are not included. The positions are accurate to half a degree at the
    /// horizon, and to 0.1 degrees above 10 degrees.
    pub fn new(site: &Site, mjd: f64) -> Option<Self> {
        let moment = epoch_from_mjd(mjd, TimeScale::UTC).ok()?;
        let state = Observer::new(site.clone()).state(&Orientation::at(moment, &EopTable::embedded()));
        Some(Self { horizon: state.horizon })
    }

    /// Returns a direction above the horizon; `None` below it.
    fn seen(&self, direction: &Direction<Gcrs>) -> Option<Direction<Horizontal>> {
        let seen = self.horizon * *direction;
        (seen.latitude_rad() > 0.0).then_some(seen)
    }

    /// Draws the lines of constellations and, over them, the stars.
    pub fn draw(&self, picture: &mut Picture, disk: &SkyDisk, style: &StarStyle) {
        for chain in constellations().flat_map(|constellation| constellation.chains) {
            let mut line = Vec::new();
            for pair in chain.windows(2) {
                for step in 0..=STEPS {
                    let share = f64::from(step) / f64::from(STEPS);
                    let between = (1.0 - share) * pair[0].vector() + share * pair[1].vector();
                    match self.seen(&Direction::from_vector(between.normalize())) {
                        Some(seen) => line.push(disk.position(&seen)),
                        None => draw_line(picture, &mut line, style),
                    }
                }
            }
            draw_line(picture, &mut line, style);
        }
        for star in bright_stars().filter(|star| star.v_mag <= style.faintest_mag) {
            if let Some(seen) = self.seen(&star.direction) {
                picture.disk(disk.position(&seen), style.star_radius(star.v_mag), style.stars);
            }
        }
    }

    /// Draws the names of bright stars beside them and of constellations in their middle, where they are in the disk
    /// and cover no labels and no lines of `labels`. Names without a free position are left out.
    pub fn draw_names(&self, picture: &mut Picture, labels: &mut Labels, disk: &SkyDisk, style: &StarStyle) {
        for star in bright_stars().filter(|star| star.v_mag <= COVERED_MAG) {
            if let Some(seen) = self.seen(&star.direction) {
                let radius = style.star_radius(star.v_mag);
                labels.add_box(around(disk.position(&seen), (radius, radius)));
            }
        }
        let mut draw = |text: &str, candidates: Vec<(f64, f64)>, half: (f64, f64)| {
            let inside = candidates.into_iter().filter(|(x, y)| {
                let (right, down) = ((x - disk.middle.0).abs() + half.0, (y - disk.middle.1).abs() + half.1);
                right.hypot(down) < disk.radius
            });
            if let Some(position) = labels.place(half, inside) {
                picture.coloured_text(text, position, style.name_size, style.names);
            }
        };
        for star in bright_stars() {
            let Some((name, seen)) = star.name.zip(self.seen(&star.direction)) else { continue };
            let (x, y) = disk.position(&seen);
            let half = half_of_name(name, style.name_size);
            let radius = style.star_radius(star.v_mag);
            let (aside, above) = (half.0 + radius + 2.0, half.1 + radius + 1.0);
            draw(name, vec![(x + aside, y), (x - aside, y), (x, y - above), (x, y + above)], half);
        }
        for constellation in constellations() {
            let Some(sum) = constellation.chains[0].iter().map(|star| *star.vector()).reduce(|sum, star| sum + star)
            else {
                continue;
            };
            let Some(seen) = self.seen(&Direction::from_vector(sum.normalize())) else { continue };
            let (x, y) = disk.position(&seen);
            let name = constellation.name.to_uppercase();
            let half = half_of_name(&name, style.name_size);
            let shifts = [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0].map(|steps| steps * 1.3 * half.1);
            let across = [0.0, 0.4, -0.4, 0.8, -0.8].map(|steps| steps * half.0);
            let candidates = shifts.into_iter().flat_map(|down| across.map(|right| (x + right, y + down)));
            draw(&name, candidates.collect(), half);
        }
    }
}

impl StarStyle {
    /// Returns the radius of a star, pixels.
    fn star_radius(&self, v_mag: f64) -> f64 {
        self.radius + self.radius_per_mag * (self.faintest_mag - v_mag)
    }
}

fn half_of_name(name: &str, size: f64) -> (f64, f64) {
    (width_of(name, size) / 2.0 + 1.0, 0.5 * size)
}

/// Draws a line of a constellation, and clears its points.
fn draw_line(picture: &mut Picture, line: &mut Vec<(f64, f64)>, style: &StarStyle) {
    if line.len() > 1 {
        picture.line(line, style.lines.to_rgba(), 1.0);
    }
    line.clear();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_sky_has_north_up_and_east_left() {
        let disk = SkyDisk { middle: (408.0, 424.0), radius: 330.0 };
        let near = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1) < 1e-9;
        assert!(near(disk.at(0.0, 90.0), disk.middle) && near(disk.at(123.0, 90.0), disk.middle));
        assert!(near(disk.at(0.0, 0.0), (408.0, 94.0)));
        assert!(near(disk.at(90.0, 45.0), (243.0, 424.0)));
    }
}
