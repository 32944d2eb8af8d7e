//! Pictures as PNG and SVG bytes.

use std::ffi::OsStr;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use plotters::prelude::{BitMapBackend, IntoDrawingArea, SVGBackend};

use super::error::PlotError;
use super::picture::{Picture, Underlay, font_style_sheet};

/// Supersampling factor of PNGs, which makes lines and letters smooth.
const FINE: usize = 2;

/// Number of steps into which the coordinates of an SVG divide a pixel.
const MESH: usize = 8;

/// Format of a picture.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Pixels only.
    Png,
    /// Scalable lines and text over an embedded pixel image.
    Svg,
}

impl PictureFormat {
    /// Returns the format that the extension of a file name indicates.
    ///
    /// # Errors
    /// The name ends in neither `.png` nor `.svg`.
    pub fn of(path: &Path) -> Result<Self, PlotError> {
        let end = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match end.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("svg") => Ok(Self::Svg),
            _ => Err(PlotError::UnknownFormat { name: path.display().to_string() }),
        }
    }
}

/// Returns a PNG as the text of a data URL.
pub fn data_url(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

impl Picture {
    /// Returns the picture as the bytes of a file in a format.
    ///
    /// # Errors
    /// The drawing or encoding crate fails.
    pub fn to_bytes(&self, format: PictureFormat) -> Result<Vec<u8>, PlotError> {
        match format {
            PictureFormat::Png => self.to_png(),
            PictureFormat::Svg => self.to_svg().map(String::into_bytes),
        }
    }

    /// Returns a PNG of the size [`size`](Picture::size).
    ///
    /// # Errors
    /// The drawing or encoding crate fails.
    pub fn to_png(&self) -> Result<Vec<u8>, PlotError> {
        let Underlay { width, height, mut rgb } = self.underlay(FINE);
        let area = BitMapBackend::with_buffer(&mut rgb, (width as u32, height as u32)).into_drawing_area();
        self.draw(&area, FINE as f64)?;
        area.present().map_err(|error| PlotError::Drawing(error.to_string()))?;
        drop(area);
        png(&averaged(&rgb, width), width / FINE, height / FINE)
    }

    /// Returns a self-contained SVG of the size [`size`](Picture::size), with an embedded font.
    ///
    /// # Errors
    /// The drawing or encoding crate fails.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        let (width, height) = self.size();
        let (across, down) = (width * MESH, height * MESH);
        let mut text = String::new();
        {
            let area = SVGBackend::with_string(&mut text, (across as u32, down as u32)).into_drawing_area();
            self.draw(&area, MESH as f64)?;
            area.present().map_err(|error| PlotError::Drawing(error.to_string()))?;
        }
        let underlay = self.underlay(FINE);
        let pixels = STANDARD.encode(png(&underlay.rgb, underlay.width, underlay.height)?);
        // The pixel image must come first, so that it is below everything: immediately after the opening tag, which
        // contains the size.
        let broken = || PlotError::Drawing("the SVG has no opening tag".to_owned());
        let rest = text.strip_prefix("<svg").and_then(|text| text.split_once('>')).ok_or_else(broken)?.1;
        Ok(format!(
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {across} {down}\" xmlns=\"http://www.w3.org/2000/svg\" \
             xmlns:xlink=\"http://www.w3.org/1999/xlink\">\n{}\n<image x=\"0\" y=\"0\" width=\"{across}\" height=\"{down}\" \
             xlink:href=\"data:image/png;base64,{pixels}\"/>{rest}",
            font_style_sheet()
        ))
    }
}

/// Averages blocks of [`FINE`] by [`FINE`] pixels.
fn averaged(rgb: &[u8], width: usize) -> Vec<u8> {
    let height = rgb.len() / 3 / width;
    let mut small = Vec::with_capacity(rgb.len() / (FINE * FINE));
    for row in 0..height / FINE {
        for column in 0..width / FINE {
            for channel in 0..3 {
                let one = |right: usize, down: usize| {
                    u32::from(rgb[3 * ((row * FINE + down) * width + column * FINE + right) + channel])
                };
                let sum: u32 = (0..FINE * FINE).map(|index| one(index % FINE, index / FINE)).sum();
                small.push((sum as f64 / (FINE * FINE) as f64).round() as u8);
            }
        }
    }
    small
}

fn png(rgb: &[u8], width: usize, height: usize) -> Result<Vec<u8>, PlotError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(rgb, width as u32, height as u32, ExtendedColorType::Rgb8)
        .map_err(|error| PlotError::Drawing(error.to_string()))?;
    Ok(bytes)
}
