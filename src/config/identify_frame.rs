//! Sky positions and times of a streak from the FITS frame that contains it.

use std::path::Path;

use hifitime::Epoch;
use nalgebra::Vector2;

use super::error::request;
use crate::error::Error;
use crate::frames::{Direction, Gcrs};
use crate::identify::line_in_plane;
use crate::images::{
    ExposureTime, FrameFile, FrameImages, Header, HeaderSite, PixelPosition, Wcs, site_from_headers, unused_coordinates,
};

/// Parses pixel coordinates such as `1024.5,2048`, counted from 1.
pub(super) fn pixel(text: &str) -> Result<PixelPosition, Error> {
    let numbers = text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    numbers
        .filter(|(x, y): &(f64, f64)| x.is_finite() && y.is_finite())
        .map(|(x, y)| PixelPosition::from_fits(x, y))
        .ok_or_else(|| {
            request(format!("invalid pixel '{text}'")).allowing("X,Y counted from 1, for example 1024.5,2048")
        })
}

/// Opens a frame, and returns it with `hdu`. Without `hdu` it returns the only image that is not a mask, a weight map
/// or a variance.
fn image(path: &Path, hdu: Option<usize>) -> Result<(FrameFile, usize), Error> {
    let file = FrameFile::open(path)?;
    let images = if hdu.is_some() { FrameImages::default() } else { file.frame_images()? };
    let hdu = match (hdu, images.frames.as_slice()) {
        (Some(hdu), _) => hdu,
        (None, [only]) => *only,
        (None, []) => {
            let (given, allowed) = images.no_frame();
            return Err(Error::invalid("number of images of two axes", given, allowed).in_file("", path));
        }
        (None, several) => {
            let (count, first, last) = (several.len(), several[0], several[several.len() - 1]);
            let predicate = format!("contains {count} images; specify one with --hdu {first} to {last}");
            return Err(Error::about_file("", path, predicate));
        }
    };
    file.image_size(hdu)?;
    Ok((file, hdu))
}

/// Returns the header of the image in a frame.
pub(super) fn header(path: &Path, hdu: Option<usize>) -> Result<Header, Error> {
    let (file, hdu) = image(path, hdu)?;
    file.header(hdu).cloned()
}

/// Returns the ends of the part of a line in the frame, or the line if it has none. A line that is fitted to a streak
/// may have its ends outside of the frame.
pub(super) fn clipped(
    path: &Path,
    hdu: Option<usize>,
    pixels: [PixelPosition; 2],
) -> Result<[PixelPosition; 2], Error> {
    let (file, hdu) = image(path, hdu)?;
    let [rows, columns] = file.image_size(hdu)?;
    let [from, to] = pixels;
    // Shares of the line at which it enters and leaves the range of each axis (Liang and Barsky 1984).
    let mut shares = [0.0f64, 1.0];
    for (start, end, count) in [(from.x, to.x, columns), (from.y, to.y, rows)] {
        let [low, high] = [-0.5, count as f64 - 0.5];
        if start == end {
            if !(low..=high).contains(&start) {
                return Ok(pixels);
            }
            continue;
        }
        let [first, other] = [low, high].map(|edge| (edge - start) / (end - start));
        shares = [shares[0].max(first.min(other)), shares[1].min(first.max(other))];
    }
    if shares[0] >= shares[1] {
        return Ok(pixels);
    }
    let within = |at: f64, count: usize| at.clamp(-0.5, count as f64 - 0.5);
    Ok(shares.map(|share| PixelPosition {
        x: within(from.x + share * (to.x - from.x), columns),
        y: within(from.y + share * (to.y - from.y), rows),
    }))
}

/// Returns the sky positions of two pixels, and the pixel scale between them, arcsec.
pub(super) fn ends(
    path: &Path,
    hdu: Option<usize>,
    pixels: [PixelPosition; 2],
) -> Result<([Direction<Gcrs>; 2], f64), Error> {
    let [first, last] = directions(path, hdu, &pixels)?[..] else { unreachable!("two pixels have two directions") };
    let length_pix = pixels[0].distance(pixels[1]).max(1e-9);
    Ok(([first, last], first.separation_rad(&last).to_degrees() * 3600.0 / length_pix))
}

/// Returns the sky positions of the ends of the part of a line in the frame, or of the corners of a region. If the
/// region reaches beyond the frame, they are those of a box of the same width around the part of its middle line in the
/// frame.
///
/// # Errors
/// The middle line is outside of the frame, or has no position on the sky.
pub(super) fn region(
    path: &Path,
    hdu: Option<usize>,
    corners: &[PixelPosition],
) -> Result<Vec<Direction<Gcrs>>, Error> {
    if let [from, to] = corners {
        return directions(path, hdu, &clipped(path, hdu, [*from, *to])?);
    }
    let (file, number) = image(path, hdu)?;
    let [rows, columns] = file.image_size(number)?;
    let is_within = |at: &PixelPosition| {
        (-0.5..=columns as f64 - 0.5).contains(&at.x) && (-0.5..=rows as f64 - 0.5).contains(&at.y)
    };
    if corners.iter().all(is_within) {
        return directions(path, hdu, corners);
    }
    let points: Vec<Vector2<f64>> = corners.iter().map(|at| Vector2::new(at.x, at.y)).collect();
    let line = line_in_plane(&points);
    let ends = [line.low, line.high].map(|way| line.middle + line.along * way);
    let ends = clipped(path, hdu, ends.map(|end| PixelPosition { x: end.x, y: end.y }))?;
    // Both ends are outside of the frame if the line is.
    directions(path, hdu, &ends)?;
    let side = line.across * line.half_width;
    let [from, to] = ends;
    let corner = |at: PixelPosition, sign: f64| PixelPosition { x: at.x + sign * side.x, y: at.y + sign * side.y };
    sky_positions(&file, path, number, &[corner(from, -1.0), corner(to, -1.0), corner(to, 1.0), corner(from, 1.0)])
}

/// Returns the sky positions of pixels.
pub(super) fn directions(
    path: &Path,
    hdu: Option<usize>,
    pixels: &[PixelPosition],
) -> Result<Vec<Direction<Gcrs>>, Error> {
    let (file, hdu) = image(path, hdu)?;
    let [rows, columns] = file.image_size(hdu)?;
    for pixel in pixels {
        let [x, y] = pixel.fits();
        // The centre of the first pixel has the coordinate 1, its lower edge 0.5.
        let is_within = |at: f64, count: usize| (0.5..=count as f64 + 0.5).contains(&at);
        if !(is_within(x, columns) && is_within(y, rows)) {
            let (right, top) = (columns as f64 + 0.5, rows as f64 + 0.5);
            let allowed = format!("X from 0.5 to {right}, Y from 0.5 to {top}, counted from 1");
            return Err(request(format!("pixel {x},{y} is outside of the frame")).allowing(allowed).in_hdu(path, hdu));
        }
    }
    sky_positions(&file, path, hdu, pixels)
}

/// Returns the sky positions of pixels, which may be outside of the frame.
fn sky_positions(
    file: &FrameFile,
    path: &Path,
    hdu: usize,
    pixels: &[PixelPosition],
) -> Result<Vec<Direction<Gcrs>>, Error> {
    let wcs = Wcs::from_header(file.header(hdu)?).map_err(|error| error.in_hdu(path, hdu))?;
    let sky_position = |pixel: &PixelPosition| {
        let [x, y] = pixel.fits();
        wcs.to_sky(*pixel).ok_or_else(|| {
            request(format!("pixel {x},{y} has no position on the sky"))
                .allowing("pixels inside the range of the world coordinates")
                .in_hdu(path, hdu)
        })
    };
    pixels.iter().map(sky_position).collect()
}

/// Returns the exposure: the given start and duration (seconds), or else those of the header, with remarks about it.
pub(super) fn exposure(
    path: &Path,
    hdu: Option<usize>,
    start: Option<Epoch>,
    duration_s: Option<f64>,
) -> Result<ExposureTime, Error> {
    if let (Some(start), Some(duration_s)) = (start, duration_s) {
        return Ok(ExposureTime::given(start, duration_s));
    }
    let (file, hdu) = image(path, hdu)?;
    let found = ExposureTime::with_given(&[file.header(hdu)?, file.header(0)?], start, duration_s)
        .map_err(|error| error.in_file("", path))?;
    let shown = path.display();
    let remarks = found.remarks.iter().map(|remark| format!("{shown}: {remark}")).collect();
    Ok(ExposureTime { remarks, ..found })
}

/// Returns the site in the header of a frame, `None` if it has none, and a sentence about coordinates that do not give
/// it.
pub(super) fn site(path: &Path, hdu: Option<usize>) -> Result<(Option<HeaderSite>, Option<String>), Error> {
    let (file, hdu) = image(path, hdu)?;
    let headers: [&Header; 2] = [file.header(hdu)?, file.header(0)?];
    let site = site_from_headers(&headers).map_err(|error| error.in_file("", path))?;
    Ok((site, unused_coordinates(&headers)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::fit_line;

    /// Writes a frame of 120 by 100 pixels of 1 arcsec, with north up and east left.
    fn write_frame(path: &Path) {
        let cards = "SIMPLE  = T\nBITPIX  = 8\nNAXIS   = 2\nNAXIS1  = 120\nNAXIS2  = 100\nCTYPE1  = 'RA---TAN'\n\
                     CTYPE2  = 'DEC--TAN'\nCRVAL1  = 150.0\nCRVAL2  = 0.0\nCRPIX1  = 60.5\nCRPIX2  = 50.5\n\
                     CDELT1  = -2.7777777777777778E-4\nCDELT2  = 2.7777777777777778E-4\nEND";
        let header: String = cards.lines().map(|card| format!("{card:80}")).collect();
        std::fs::write(path, format!("{header:2880}{}", "\0".repeat(5 * 2880))).unwrap();
    }

    /// Returns the corners of `box(x,y,width,height,angle)`, counted from 1.
    fn corners([x, y, width, height, angle_deg]: [f64; 5]) -> Vec<PixelPosition> {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            .map(|(along, across)| (along * width, across * height))
            .map(|(along, across)| {
                PixelPosition::from_fits(x + along * cos - across * sin, y + along * sin + across * cos)
            })
            .to_vec()
    }

    /// The part of a box in the frame is lopsided; the line is that of the whole box.
    #[test]
    fn verif_boxes_beyond_the_frame_keep_their_direction() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("boxes.fits");
        write_frame(&path);
        for (shape, angle_deg, half_width_arcsec, length_arcsec) in [
            ([60.5, 50.5, 60.0, 10.0, 20.0], 110.0, 5.0, 60.0),
            ([100.0, 90.0, 160.0, 30.0, 45.0], 135.0, 15.0, 10.5 * 2f64.sqrt() + 80.0),
            ([115.0, 50.0, 100.0, 40.0, 20.0], 110.0, 20.0, 50.0 + 5.5 / 20f64.to_radians().cos()),
            ([2.0, 50.0, 60.0, 10.0, 150.0], 60.0, 5.0, 30.0 + 1.5 / 30f64.to_radians().cos()),
        ] {
            let line = fit_line(&[region(&path, None, &corners(shape)).unwrap()]).unwrap();
            let found_deg = line.ends[0].position_angle_rad(&line.ends[1]).to_degrees().rem_euclid(180.0);
            let length = line.ends[0].separation_rad(&line.ends[1]).to_degrees() * 3600.0;
            let half_width = line.half_width_rad.to_degrees() * 3600.0;
            assert!((found_deg - angle_deg).abs() < 0.01, "{shape:?}: {found_deg}");
            assert!((length - length_arcsec).abs() < 0.01, "{shape:?}: {length}");
            assert!((half_width - half_width_arcsec).abs() < 0.01, "{shape:?}: {half_width}");
        }
        for outside in [[121.0, 50.0, 1.0, 10.0, 0.0], [121.4, 50.0, 4.0, 10.0, 0.0]] {
            let error = region(&path, None, &corners(outside)).unwrap_err().to_string();
            assert!(error.contains("is outside of the frame"), "{outside:?}: {error}");
        }
    }
}
