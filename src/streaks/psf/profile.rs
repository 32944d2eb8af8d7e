//! A point's light on the pixels of a detector.

use super::blur::{Blur, BlurError};
use super::parts::Parts;
use super::tables::ProfileTables;

/// A point's light on the detector: round on the sky, of unit flux, each pixel with the average over its square (or rectangle), never the value at its middle.
///
/// Seeing of a pixel's width or more is kept in tables over the pixels themselves ([`ProfileTables`]). Narrower seeing is kept, and drawn, over finer pixels, so many that
/// it is as wide as one of them, and these are summed: exact, and as many times slower. Oblong pixels are cut into squares likewise (of sides alike to
/// one per cent, three at worst, for ratios between 0.4 and 2.5 to one).
#[derive(Clone, Debug, PartialEq)]
pub struct RadialProfile {
    blur: Blur,
    parts: Parts,
    tables: ProfileTables,
}

impl RadialProfile {
    /// The profile of a blur; takes from a third of a millisecond (seeing alone) to some milliseconds (a ring many pixels wide).
    ///
    /// # Errors
    /// As in [`BlurError`]: a number outside its range, a hole as large as its ring, wings beyond 4000 pixels.
    pub fn of(blur: &Blur) -> Result<Self, BlurError> {
        Self::on_oblong(blur, 1.0)
    }

    /// The same on pixels `aspect` times as wide (along rows) as high, within [0.4, 2.5]; lengths of the blur are in pixels of the mean scale, a side of a square of
    /// the same area.
    ///
    /// # Errors
    /// As in [`BlurError`].
    pub fn on_oblong(blur: &Blur, aspect: f64) -> Result<Self, BlurError> {
        blur.validate()?;
        BlurError::hold("aspect", aspect, LEAST_ASPECT, 1.0 / LEAST_ASPECT)?;
        let parts = Parts::of(blur.seeing.narrowest_fwhm_pix(), aspect);
        let tables = ProfileTables::of(&if parts.is_whole() { *blur } else { blur.magnified(parts.mean()) })?;
        Ok(Self { blur: *blur, parts, tables })
    }

    /// What it was made of.
    pub fn blur(&self) -> &Blur {
        &self.blur
    }

    /// Into how many parts a pixel is cut for drawing.
    pub fn parts(&self) -> Parts {
        self.parts
    }

    /// The profile over these parts.
    pub fn tables(&self) -> &ProfileTables {
        &self.tables
    }

    /// Surface brightness at a distance from the centre in pixels of the mean scale, per pixel.
    pub fn at(&self, r_pix: f64) -> f64 {
        let mean = self.parts.mean();
        self.tables.at(r_pix * mean) * mean * mean
    }

    /// Share of the light in a pixel whose centre lies this far from the profile's.
    pub fn pixel(&self, dx_pix: f64, dy_pix: f64) -> f64 {
        let Parts { x, y } = self.parts;
        let (dx, dy) = (dx_pix * x as f64, dy_pix * y as f64);
        self.parts.offsets().map(|[x, y]| self.tables.pixel(dx + x, dy + y)).sum()
    }

    /// Light in a pixel of a long straight line of unit light per pixel of its length, at `angle_rad` from the rows, that passes the pixel's
    /// centre at a distance.
    pub fn line(&self, across_pix: f64, angle_rad: f64) -> f64 {
        if self.parts.is_whole() {
            return self.tables.line(across_pix, angle_rad);
        }
        // A unit vector along the line and areas, in parts.
        let (sin, cos) = angle_rad.sin_cos();
        let (u, v) = (cos * self.parts.x as f64, sin * self.parts.y as f64);
        let length = u.hypot(v);
        let across = across_pix * (self.parts.x * self.parts.y) as f64 / length;
        let of_part = |[x, y]: [f64; 2]| self.tables.line(across + (x * v - y * u) / length, v.atan2(u)) / length;
        self.parts.offsets().map(of_part).sum()
    }

    /// A length of one pixel across a line at `angle_rad` from the rows, in pixels of the mean scale across it on the sky: 1 where pixels are squares.
    pub fn mean_pixels_across(&self, angle_rad: f64) -> f64 {
        let (sin, cos) = angle_rad.sin_cos();
        // Areas are kept: across times along.
        self.parts.mean() / (cos * self.parts.x as f64).hypot(sin * self.parts.y as f64)
    }

    /// Full width at half of the greatest brightness, pixels of the mean scale; of a ring, its outer edges'.
    pub fn fwhm_pix(&self) -> f64 {
        self.tables.fwhm_pix() / self.parts.mean()
    }

    /// Radius that holds half of the light, pixels of the mean scale.
    pub fn half_light_pix(&self) -> f64 {
        self.tables.half_light_pix() / self.parts.mean()
    }

    /// Where the profile ends, pixels along the shorter side.
    pub fn reach_pix(&self) -> f64 {
        self.tables.reach_pix() / self.parts.x.min(self.parts.y) as f64
    }

    /// How far from its centre a point puts light into pixels, pixels.
    pub fn pixel_reach_pix(&self) -> f64 {
        self.reach_pix() + std::f64::consts::FRAC_1_SQRT_2
    }

    /// Variance along one axis, square pixels of the mean scale.
    pub fn variance_pix2(&self) -> f64 {
        self.tables.variance_pix2() / (self.parts.x * self.parts.y) as f64
    }
}

/// Least ratio of the sides of pixels that is drawn.
const LEAST_ASPECT: f64 = 0.4;
