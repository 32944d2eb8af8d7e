//! Preview of a frame as a PNG picture.

use image::{ImageFormat, Rgb, RgbImage};

use super::pixels::{PixelPosition, Plane};
use crate::error::{Error, ErrorKind};

/// Streak marked in a preview by two parallel lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// Positions along the streak in the frame, joined in order.
    pub line: Vec<PixelPosition>,
    /// Distance of each of the two lines from the streak, pixels of the frame. The pixels between the lines stay
    /// visible.
    pub half_width_pix: f64,
}

/// Longest side of the picture, pixels. Larger frames are reduced by an integer factor.
const LONGEST_SIDE: usize = 1600;
/// Longest side of an enlarged picture, pixels. Small frames are enlarged by the largest integer factor with which they
/// fit.
const ENLARGED_SIDE: usize = 400;
/// Fractions of the pixels with values below the level shown as black and below the level shown as white.
const BLACK_SHARE: f64 = 0.02;
const WHITE_SHARE: f64 = 0.997;
/// Strength of the asinh stretch, chosen so that the noise of the sky is as visible as the stars.
const SOFTENING: f64 = 8.0;
/// Approximate number of pixels from which the values of black and white are determined.
const SAMPLED: usize = 200_000;
const OVERLAY_COLOUR: Rgb<u8> = Rgb([255, 170, 40]);

/// Returns the frame as a PNG in grey, with the first row at the bottom and `overlays` in orange. The brightness is an
/// asinh stretch between the 2nd and the 99.7th percentile of the pixels.
///
/// Frames with a longest side above 1600 pixels are averaged down. Frames with a longest side of at most 200 pixels are
/// enlarged to at most 400 pixels. NaN pixels are dark blue.
///
/// # Errors
/// The frame has no pixels.
pub fn preview_png(plane: &Plane, overlays: &[Overlay]) -> Result<Vec<u8>, Error> {
    let (rows, columns) = (plane.rows(), plane.columns());
    if rows == 0 || columns == 0 {
        return Err(Error::invalid(
            "size of the frame",
            format!("{rows} rows by {columns} columns"),
            "at least one pixel",
        ));
    }
    let scale = Scale::for_size(rows, columns);
    let [black, white] = limits(plane);
    let (width, height) = scale.size(rows, columns);
    let mut picture = RgbImage::new(width, height);
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        let value = scale.mean(plane, x as usize, (height - 1 - y) as usize);
        *pixel = if value.is_finite() { grey(f64::from(value), black, white) } else { Rgb([10, 20, 70]) };
    }
    for overlay in overlays {
        draw(&mut picture, overlay, &scale, height);
    }
    let mut bytes = std::io::Cursor::new(Vec::new());
    let failed = |error: image::ImageError| Error::caused(ErrorKind::File, error).at("preview");
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(failed)?;
    Ok(bytes.into_inner())
}

/// Ratio of the sizes of frame and picture: pixels of the frame per pixel of the picture, or the reverse.
#[derive(Copy, Clone, Debug, PartialEq)]
enum Scale {
    Down(usize),
    Up(usize),
}

impl Scale {
    fn for_size(rows: usize, columns: usize) -> Self {
        let longest = rows.max(columns);
        if longest > LONGEST_SIDE {
            Self::Down(longest.div_ceil(LONGEST_SIDE))
        } else {
            Self::Up((ENLARGED_SIDE / longest).max(1))
        }
    }

    fn size(self, rows: usize, columns: usize) -> (u32, u32) {
        let side = |pixels: usize| match self {
            Self::Down(factor) => pixels.div_ceil(factor),
            Self::Up(factor) => pixels * factor,
        } as u32;
        (side(columns), side(rows))
    }

    /// Returns the mean of the finite pixels of the frame that lie in one pixel of the picture.
    fn mean(self, plane: &Plane, x: usize, y: usize) -> f32 {
        match self {
            Self::Up(factor) => plane.row(y / factor).get(x / factor).copied().unwrap_or(f32::NAN),
            Self::Down(factor) => {
                let (mut sum, mut count) = (0.0, 0u32);
                for row in y * factor..((y + 1) * factor).min(plane.rows()) {
                    let end = ((x + 1) * factor).min(plane.columns());
                    for value in
                        plane.row(row).get(x * factor..end).unwrap_or(&[]).iter().filter(|value| value.is_finite())
                    {
                        sum += value;
                        count += 1;
                    }
                }
                sum / count as f32
            }
        }
    }

    /// Converts a position in the frame to one in the picture, before the picture is flipped.
    fn position(self, at: PixelPosition) -> (f64, f64) {
        let along = |value: f64| match self {
            Self::Down(factor) => (value + 0.5) / factor as f64 - 0.5,
            Self::Up(factor) => (value + 0.5) * factor as f64 - 0.5,
        };
        (along(at.x), along(at.y))
    }

    fn factor(self) -> f64 {
        match self {
            Self::Down(factor) => 1.0 / factor as f64,
            Self::Up(factor) => factor as f64,
        }
    }
}

/// Returns the values of black and of white.
fn limits(plane: &Plane) -> [f64; 2] {
    let step = (plane.values().len() / SAMPLED).max(1);
    let mut values: Vec<f32> = plane.values().iter().step_by(step).copied().filter(|value| value.is_finite()).collect();
    values.sort_by(f32::total_cmp);
    let at = |share: f64| {
        values.get((share * values.len().saturating_sub(1) as f64) as usize).map_or(0.0, |&value| f64::from(value))
    };
    [at(BLACK_SHARE), at(WHITE_SHARE)]
}

fn grey(value: f64, black: f64, white: f64) -> Rgb<u8> {
    // Grey level asinh(s x) / asinh(s), where x is 0 for black and 1 for white. A frame of equal pixels is half grey.
    let share = if white > black { ((value - black) / (white - black)).clamp(0.0, 1.0) } else { 0.2 };
    let level = ((SOFTENING * share).asinh() / SOFTENING.asinh() * 255.0).round() as u8;
    Rgb([level, level, level])
}

fn draw(picture: &mut RgbImage, overlay: &Overlay, scale: &Scale, height: u32) {
    for pair in overlay.line.windows(2) {
        let (from, to) = (scale.position(pair[0]), scale.position(pair[1]));
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy);
        if !(length > 0.0 && length.is_finite()) {
            continue;
        }
        let beside = (overlay.half_width_pix * scale.factor()).max(3.0);
        for side in [-beside, beside] {
            let steps = length.ceil().min(10_000.0) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                let x = from.0 + share * dx - side * dy / length;
                let y = from.1 + share * dy + side * dx / length;
                let row = f64::from(height) - 1.0 - y;
                if x >= -0.5 && row >= -0.5 {
                    let (x, row) = (x.round() as u32, row.round() as u32);
                    if x < picture.width() && row < picture.height() {
                        picture.put_pixel(x, row, OVERLAY_COLOUR);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(bytes: &[u8]) -> RgbImage {
        image::load_from_memory_with_format(bytes, ImageFormat::Png).unwrap().to_rgb8()
    }

    #[test]
    fn verif_the_first_row_is_at_the_bottom_and_bright_pixels_are_white() {
        let mut plane = Plane::zeros(500, 450);
        for (index, value) in plane.values_mut().iter_mut().enumerate() {
            *value = (index % 7) as f32;
        }
        plane.row_mut(3)[440] = 1000.0;
        plane.row_mut(400)[10] = f32::NAN;
        let picture = decoded(&preview_png(&plane, &[]).unwrap());
        assert_eq!(picture.dimensions(), (450, 500));
        assert_eq!(picture.get_pixel(440, 499 - 3), &Rgb([255, 255, 255]));
        assert_eq!(picture.get_pixel(10, 499 - 400), &Rgb([10, 20, 70]));
    }

    #[test]
    fn verif_sizes_are_whole_multiples_and_overlays_are_parallel_lines() {
        let large = decoded(&preview_png(&Plane::zeros(4000, 1000), &[]).unwrap());
        assert_eq!(large.dimensions(), (334, 1334));
        let overlay = Overlay {
            line: vec![PixelPosition { x: 10.0, y: 20.0 }, PixelPosition { x: 80.0, y: 20.0 }],
            half_width_pix: 5.0,
        };
        let small = decoded(&preview_png(&Plane::zeros(100, 90), &[overlay]).unwrap());
        assert_eq!(small.dimensions(), (360, 400));
        let rows: Vec<u32> = (0..400).filter(|&row| small.get_pixel(200, row) == &OVERLAY_COLOUR).collect();
        // Row 20 of 100 is centred at 81.5 of 400 from below; the lines are 20 pixels of the picture away.
        assert_eq!(rows, [298, 338]);
        assert!(preview_png(&Plane::zeros(0, 5), &[]).is_err());
    }
}
