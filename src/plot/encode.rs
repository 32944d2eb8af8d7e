//! Pictures as PNG and SVG bytes.

use std::ffi::OsStr;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::prelude::{IntoDrawingArea, SVGBackend};

use super::file_options::{FileOptions, NATURAL_DPI, PROGRAM, PROVENANCE, TITLE};
use super::picture::{Canvas, Picture, Underlay, font_style_sheet};
use super::raster::Raster;
use crate::error::{Error, ErrorKind};

/// Supersampling factor of PNGs, which makes the edges of coloured pixels and letters smooth.
const FINE: usize = 2;

/// Number of steps into which the coordinates of an SVG divide a pixel.
const MESH: usize = 8;

const METRES_PER_INCH: f64 = 0.0254;

/// Program and version, as stated in files.
const SOFTWARE: &str = concat!("streakcast ", env!("CARGO_PKG_VERSION"));

/// Format of a picture.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
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
    /// The name does not end in `.png` or `.svg`.
    pub fn from_extension(path: &Path) -> Result<Self, Error> {
        let end = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match end.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("svg") => Ok(Self::Svg),
            Some("pdf") => Err(Error::new(
                ErrorKind::Invalid,
                format!("invalid picture name {}: PDF is not supported", path.display()),
            )
            .allowing("a name that ends in .png or .svg (rsvg-convert and Inkscape convert SVG to PDF)")),
            _ => Err(Error::new(ErrorKind::Invalid, format!("invalid picture name {}", path.display()))
                .allowing("a name that ends in .png or .svg")),
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
    pub fn to_bytes(&self, format: PictureFormat) -> Result<Vec<u8>, Error> {
        self.to_file(format, &FileOptions::default())
    }

    /// Returns the picture as the bytes of a file in a format, with a size, a resolution and metadata.
    ///
    /// # Errors
    /// The size or the resolution is out of range, or the drawing or encoding crate fails.
    pub fn to_file(&self, format: PictureFormat, options: &FileOptions) -> Result<Vec<u8>, Error> {
        match format {
            PictureFormat::Png => self.png_with(options),
            PictureFormat::Svg => self.svg_with(options).map(String::into_bytes),
        }
    }

    /// Returns a PNG of the size [`size`](Picture::size).
    ///
    /// # Errors
    /// The drawing or encoding crate fails.
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        self.png_with(&FileOptions::default())
    }

    /// Returns a self-contained SVG of the size [`size`](Picture::size), with an embedded font.
    ///
    /// # Errors
    /// The drawing or encoding crate fails.
    pub fn to_svg(&self) -> Result<String, Error> {
        self.svg_with(&FileOptions::default())
    }

    fn png_with(&self, options: &FileOptions) -> Result<Vec<u8>, Error> {
        let (width, height) = options.pixels(self.size())?;
        let canvas = Canvas::for_picture(self, (width * FINE, height * FINE));
        let mut raster = Raster::new((canvas.width, canvas.height), self.underlay(&canvas).rgb);
        self.rasterise(&mut raster, &canvas)?;
        let metadata = self.metadata(options);
        png(&averaged(&raster.rgb, canvas.width), (width, height), options.dpi(), &metadata)
    }

    fn svg_with(&self, options: &FileOptions) -> Result<String, Error> {
        let (width, height) = self.size();
        let canvas = Canvas::for_picture(self, (width * MESH, height * MESH));
        let mut text = String::new();
        {
            let size = (canvas.width as u32, canvas.height as u32);
            let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
            self.draw(&area, &canvas)?;
            area.present().map_err(|error| Error::new(ErrorKind::Invalid, format!("drawing failed: {error}")))?;
        }
        let Underlay { width: columns, height: rows, rgb } =
            self.underlay(&Canvas::for_picture(self, (width * FINE, height * FINE)));
        let pixels = STANDARD.encode(png(&rgb, (columns, rows), NATURAL_DPI, &[])?);
        // The pixel image must come first, so that it is below everything else. It follows the opening tag, which is
        // replaced, because it contains the size.
        let broken = || Error::new(ErrorKind::Invalid, "drawing failed: the SVG has no opening tag");
        let rest = text.strip_prefix("<svg").and_then(|text| text.split_once('>')).ok_or_else(broken)?.1;
        // The drawing is scaled to the given size, with margins if the shape differs.
        let (across, down) = options.svg_lengths((width, height));
        let (columns, rows) = (canvas.width, canvas.height);
        Ok(format!(
            "<svg width=\"{across}\" height=\"{down}\" viewBox=\"0 0 {columns} {rows}\" xmlns=\"http://www.w3.org/2000/svg\" \
             xmlns:xlink=\"http://www.w3.org/1999/xlink\">\n{}\n{}\n<image x=\"0\" y=\"0\" width=\"{columns}\" height=\"{rows}\" \
             xlink:href=\"data:image/png;base64,{pixels}\"/>{rest}",
            svg_metadata(&self.metadata(options)),
            font_style_sheet()
        ))
    }

    /// Returns the metadata of a file as keywords and texts: program, title, and provenance of the data.
    fn metadata(&self, options: &FileOptions) -> Vec<(&'static str, String)> {
        let mut all = vec![(PROGRAM, SOFTWARE.to_owned())];
        if !self.title().is_empty() {
            all.push((TITLE, self.title().to_owned()));
        }
        all.extend(options.provenance.iter().map(|json| (PROVENANCE, json.clone())));
        all
    }
}

/// Returns the metadata element of an SVG, which contains a JSON object.
fn svg_metadata(metadata: &[(&str, String)]) -> String {
    let text = |value: &str| serde_json::Value::from(value).to_string();
    let entry = |(keyword, value): &(&str, String)| match *keyword {
        PROVENANCE => format!("\"{keyword}\":{value}"),
        _ => format!("\"{keyword}\":{}", text(value)),
    };
    let entries: Vec<String> = metadata.iter().map(entry).collect();
    // Strings of JSON may contain the end of a CDATA section. The character > is therefore escaped, which does not
    // change the JSON value.
    format!("<metadata><![CDATA[{{{}}}]]></metadata>", entries.join(",").replace('>', "\\u003e"))
}

/// Averages blocks of [`FINE`] by [`FINE`] pixels.
fn averaged(rgb: &[u8], width: usize) -> Vec<u8> {
    let height = rgb.len() / 3 / width;
    let mut small = Vec::with_capacity(rgb.len() / (FINE * FINE));
    for row in 0..height / FINE {
        for column in 0..width / FINE {
            for channel in 0..3 {
                let sample = |right: usize, down: usize| {
                    u32::from(rgb[3 * ((row * FINE + down) * width + column * FINE + right) + channel])
                };
                let sum: u32 = (0..FINE * FINE).map(|index| sample(index % FINE, index / FINE)).sum();
                small.push((sum as f64 / (FINE * FINE) as f64).round() as u8);
            }
        }
    }
    small
}

fn png(rgb: &[u8], (width, height): (usize, usize), dpi: u32, metadata: &[(&str, String)]) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let mut write = || -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let per_metre = (f64::from(dpi) / METRES_PER_INCH).round() as u32;
        let unit = png::Unit::Meter;
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit }));
        for (keyword, text) in metadata {
            // International text, which is UTF-8.
            encoder.add_itxt_chunk((*keyword).to_owned(), text.clone())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(rgb)?;
        writer.finish()
    };
    write().map_err(|error| Error::new(ErrorKind::Invalid, format!("drawing failed: {error}")))?;
    Ok(bytes)
}
