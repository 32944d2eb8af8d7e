//! Places on a detector.

/// A place in a frame, pixels, counted from 0: the centre of the first pixel of the first row is (0, 0), its corners at ±0.5.
///
/// FITS headers, DS9 and most people count from 1: add 1 to both for them ([`PixelPosition::fits`]).
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct PixelPosition {
    /// Along a row (FITS axis 1).
    pub x: f64,
    /// Along a column (FITS axis 2).
    pub y: f64,
}

impl PixelPosition {
    /// From coordinates counted from 1.
    pub fn from_fits(x: f64, y: f64) -> Self {
        Self { x: x - 1.0, y: y - 1.0 }
    }

    /// Coordinates counted from 1, as FITS counts.
    pub fn fits(self) -> [f64; 2] {
        [self.x + 1.0, self.y + 1.0]
    }

    /// Distance to another place, pixels.
    pub fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}
