//! A half sphere on a disc: the pole in the middle, the equator at the rim, equal angles at equal distances.
//!
//! Longitude 0 is up and longitudes grow against the clock: for azimuths that is the sky as one sees it lying on the back, north up and east
//! left; for longitudes of a satellite's frame it is the view from above.

use std::f64::consts::{FRAC_PI_2, TAU};

use rayon::prelude::*;

use super::contour::contours;
use super::scale::Quantity;

/// Sides of the squares through which lines run, pixels.
const SQUARE: usize = 2;

/// What the shadow is taken for, below the line, mag.
const SHADOW_BELOW_MAG: f64 = 2.0;

/// What is seen in one direction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Seen {
    /// A satellite of this magnitude, or another quantity.
    Value(f64),
    /// A satellite in the Earth's shadow.
    Shadow,
    /// Nothing lit.
    Nothing,
}

/// One disc with its words.
pub struct Disc<'a> {
    /// Above it.
    pub title: String,
    /// What its values are.
    pub quantity: Quantity,
    /// Only the half of longitudes 0 to π, the left one, is drawn.
    pub is_half: bool,
    /// What is seen at a longitude and at an angle from the middle in [0, π/2], radians.
    pub seen: Box<dyn Fn(f64, f64) -> Seen + Sync + 'a>,
    /// Values farther from the middle than this angle, radians, have no part in where the colours end.
    pub scaled_within_rad: f64,
    /// Longitude of the Sun, radians; `None` where it has no one place.
    pub sun_longitude_rad: Option<f64>,
    /// Words outside of the rim, at longitudes in degrees.
    pub rim: Vec<(f64, &'static str)>,
    /// Thin circles with their words, at angles from the middle in degrees.
    pub circles: Vec<(f64, String)>,
    /// A dashed circle at an angle from the middle, radians: the Earth's limb.
    pub limb_rad: Option<f64>,
}

/// What a disc shows, pixel by pixel.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    /// Pixels a side.
    pub side: usize,
    /// Row by row from the top; `None` outside of the disc.
    pub pixels: Vec<Option<Seen>>,
}

impl Disc<'_> {
    /// Asks for every pixel of a disc of this radius, in pixels; the raster is a pixel wider on every side, so that no rim is ragged.
    pub(super) fn raster(&self, radius: usize) -> Raster {
        let side = 2 * radius + 2;
        let middle = side as f64 / 2.0;
        let pixels = (0..side * side)
            .into_par_iter()
            .map(|index| {
                // Pixel centres, right and up of the middle.
                let right = (index % side) as f64 + 0.5 - middle;
                let up = middle - (index / side) as f64 - 0.5;
                let distance = right.hypot(up) / radius as f64;
                // A pixel that the rim cuts shows what stands at the rim.
                let is_in = distance <= 1.0 + 1.0 / radius as f64 && !(self.is_half && right > 0.0);
                is_in.then(|| {
                    let longitude = (-right).atan2(up).rem_euclid(TAU);
                    (self.seen)(longitude, distance.min(1.0) * FRAC_PI_2)
                })
            })
            .collect();
        Raster { side, pixels }
    }
}

/// Right of and below the middle of a disc of radius 1: where a direction is drawn.
pub(super) fn place(longitude_rad: f64, from_middle_rad: f64) -> (f64, f64) {
    let (sin, cos) = longitude_rad.sin_cos();
    let distance = from_middle_rad / FRAC_PI_2;
    (-distance * sin, -distance * cos)
}

impl Raster {
    /// All values shown, with their angles from the middle, radians.
    pub fn values(&self) -> impl Iterator<Item = (f64, f64)> {
        let middle = self.side as f64 / 2.0;
        let angle = move |index: usize| {
            let (right, below) = ((index % self.side) as f64 + 0.5 - middle, (index / self.side) as f64 + 0.5 - middle);
            // The raster is a pixel wider than the disc on every side.
            FRAC_PI_2 * right.hypot(below) / (middle - 1.0)
        };
        self.pixels.iter().enumerate().filter_map(move |(index, pixel)| match pixel {
            Some(Seen::Value(value)) => Some((angle(index), *value)),
            _ => None,
        })
    }

    /// Lines on which the value is `level`, in pixels right of and below the upper left corner. The Earth's shadow is below any line.
    pub fn contours(&self, level: f64) -> Vec<Vec<(f64, f64)>> {
        let value = |column: usize, row: usize| match self.pixels.get(row * self.side + column)? {
            Some(Seen::Value(value)) => Some(*value),
            // Fainter than any line: what is brighter is enclosed along the shadow, whose border is as narrow as a pixel.
            Some(Seen::Shadow) => Some(level + SHADOW_BELOW_MAG),
            _ => None,
        };
        let mut lines = contours((self.side, self.side), SQUARE, level, value);
        // Pixel centres lie half a pixel in.
        lines.iter_mut().flatten().for_each(|(x, y)| (*x, *y) = (*x + 0.5, *y + 0.5));
        lines
    }

    /// True where any pixel is so.
    pub fn shows(&self, seen: Seen) -> bool {
        self.pixels.contains(&Some(seen))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_pixels_ask_for_the_direction_that_is_drawn_there() {
        let disc = Disc {
            title: String::new(),
            // The longitude and the angle in one number.
            seen: Box::new(|longitude, angle| Seen::Value(longitude + 10.0 * angle)),
            scaled_within_rad: FRAC_PI_2,
            sun_longitude_rad: Some(0.0),
            quantity: Quantity::Magnitude,
            is_half: false,
            rim: Vec::new(),
            circles: Vec::new(),
            limb_rad: None,
        };
        let raster = disc.raster(100);
        let middle = raster.side as f64 / 2.0;
        for (longitude, angle) in [(0.1, 0.5), (1.6, 1.2), (3.0, 0.9), (5.0, 0.3)] {
            let (right, down) = place(longitude, angle);
            let (column, row) = ((middle + 100.0 * right) as usize, (middle + 100.0 * down) as usize);
            let Some(Seen::Value(shown)) = raster.pixels[row * raster.side + column] else { panic!("nothing") };
            // Half a pixel is 0.008 rad of angle, and 0.03 rad of longitude at 0.3 rad.
            assert!((shown - longitude - 10.0 * angle).abs() < 0.2, "{longitude} {angle}: {shown}");
        }
        // Values come back with the angles at which they were asked.
        for (angle, value) in raster.values().filter(|(angle, _)| *angle <= FRAC_PI_2) {
            let longitude = value - 10.0 * angle;
            assert!((-1e-9..=TAU).contains(&longitude), "{angle} {value}");
        }
        // East is left.
        assert!(place(FRAC_PI_2, 0.5).0 < 0.0);
        assert!(raster.pixels[0].is_none());
    }

    #[test]
    fn verif_a_line_runs_along_the_shadow() {
        let half = |index: usize| Some(if index / 101 < 60 { Seen::Value(6.0) } else { Seen::Shadow });
        let lines = Raster { side: 101, pixels: (0..101 * 101).map(half).collect() }.contours(7.0);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].len() > 45 && lines[0].iter().all(|(_, y)| (y - 60.0).abs() < 1.5), "{:?}", lines[0]);
    }
}
