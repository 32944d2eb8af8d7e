//! Frame in a file into which streaks are injected: its chips, exposure and count scale.

use std::collections::BTreeMap;
use std::path::Path;

use hifitime::Epoch;

use super::super::chip::{Chip, circle_of};
use super::super::count_scale::CountScale;
use super::super::error::StreaksError;
use crate::frames::{Direction, Gcrs};
use crate::images::{Calibration, CountBasis, ExposureTime, FrameFile, Header, ImagesError, LightArea, PixelUnit, Wcs};

/// Values of a frame that override its header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameOverrides {
    /// Shutter opening.
    pub start: Option<Epoch>,
    /// Length of the exposure, seconds.
    pub duration_s: Option<f64>,
    /// Only these HDUs; all images with world coordinates if empty.
    pub hdus: Vec<usize>,
    /// Zero point, and its basis.
    pub zero_point: Option<(f64, CountBasis)>,
    /// Electrons per count.
    pub gain_e_adu: Option<f64>,
    /// Side of a pixel, arcsec, for random streaks in frames without world coordinates.
    pub pixel_scale_arcsec: Option<f64>,
}

/// Chip with the data for noise.
#[derive(Clone, Debug)]
pub struct TargetChip {
    /// Pixels, world coordinates and count scale.
    pub chip: Chip,
    /// Electrons per unit of the frame: the gain, multiplied by the exposure if the frame contains counts per second;
    /// `None` if it is unknown.
    pub electrons_per_unit: Option<f64>,
    /// Saturation level of pixels, in the unit of the frame.
    pub saturation: Option<f64>,
    /// Least and greatest count of a frame of whole numbers.
    pub whole_range: Option<(f64, f64)>,
    /// HDU with the variance of each pixel, if the file is a masked image of Rubin's pipelines.
    pub variance_hdu: Option<usize>,
}

/// Opened frame.
#[derive(Clone, Debug)]
pub struct TargetFrame {
    /// The file.
    pub file: FrameFile,
    /// Shutter opening.
    pub opened: Epoch,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Images of the frame, at least one.
    pub chips: Vec<TargetChip>,
    /// HDUs of images without valid world coordinates, with the reason.
    pub left_out: Vec<(usize, String)>,
    /// Filter or band as written in the header.
    pub filter: Option<String>,
    /// Names of instrument, telescope and observatory in the header, in this order.
    pub observatory: Vec<String>,
    /// Planes named by a mask in the file, with their bits.
    pub mask_planes: BTreeMap<String, u32>,
}

impl TargetFrame {
    /// Opens a frame and reads its headers.
    ///
    /// The images are all HDUs of two axes with world coordinates that are not masks or weights, or the HDUs of the
    /// overrides. A zero point is required in the header of each image, in that of the file, or in the overrides.
    ///
    /// # Errors
    /// A file that cannot be read, a frame without images or without time, length or zero point, and invalid values.
    pub fn open(path: &Path, overrides: &FrameOverrides) -> Result<Self, StreaksError> {
        let file = FrameFile::open(path)?;
        let shown = path.display().to_string();
        let images = images(&file, overrides)?;
        let Some(&first) = images.first() else {
            return Err(StreaksError::invalid(
                format!("{shown}: number of images of two axes"),
                0,
                "1 or more (masks, weights and tables are ignored)",
            ));
        };
        let headers = |hdu: usize| -> Result<[&Header; 2], ImagesError> { Ok([file.header(hdu)?, file.header(0)?]) };
        let (opened, exposure_s) = exposure(&headers(first)?, overrides, &shown)?;
        let (mut chips, mut left_out) = (Vec::new(), Vec::new());
        for &hdu in &images {
            match chip_wcs(&file, hdu, overrides) {
                Ok((wcs, is_on_sky)) => {
                    chips.push(target_chip(&file, hdu, wcs, is_on_sky, exposure_s, overrides, &shown)?)
                }
                Err(error) => left_out.push((hdu, error)),
            }
        }
        if chips.is_empty() && !left_out.is_empty() {
            let (hdu, error) = left_out.swap_remove(0);
            return Err(error.in_hdu(path, hdu).into());
        }
        let first_headers = headers(first)?;
        let calibration = Calibration::from_headers(&first_headers);
        let text = |keyword: &str| first_headers.iter().find_map(|header| header.text(keyword));
        Ok(Self {
            opened,
            exposure_s,
            chips,
            left_out: left_out.into_iter().map(|(hdu, error)| (hdu, error.to_string())).collect(),
            filter: calibration.band.map(|band| band.value),
            observatory: ["INSTRUME", "TELESCOP", "OBSERVAT", "OBSERVATORY"].into_iter().filter_map(text).collect(),
            mask_planes: mask_planes(&file)?,
            file,
        })
    }

    /// Pointing of the telescope, and the radius of the circle around it that contains all chips, radians.
    pub fn circle(&self) -> Option<(Direction<Gcrs>, f64)> {
        circle_of(self.chips.iter().map(|target| &target.chip))
    }
}

/// Returns the HDUs of images that contain light.
fn images(file: &FrameFile, overrides: &FrameOverrides) -> Result<Vec<usize>, ImagesError> {
    if !overrides.hdus.is_empty() {
        let mut hdus = overrides.hdus.clone();
        hdus.sort_unstable();
        hdus.dedup();
        for &hdu in &hdus {
            file.header(hdu)?;
            // Fails with the kind of an HDU that is not an image.
            file.image_size(hdu)?;
        }
        return Ok(hdus);
    }
    Ok(file.light_images())
}

fn exposure(headers: &[&Header; 2], overrides: &FrameOverrides, path: &str) -> Result<(Epoch, f64), StreaksError> {
    if let (Some(start), Some(duration_s)) = (overrides.start, overrides.duration_s) {
        return Ok((start, duration_s));
    }
    let failed = |error: ImagesError| error.at(path);
    // The overrides replace missing or wrong values of the header.
    let duration_s =
        overrides.duration_s.map_or_else(|| ExposureTime::duration_from_headers(headers), Ok).map_err(failed)?;
    let start =
        overrides.start.map_or_else(|| ExposureTime::start_from_headers(headers, duration_s), Ok).map_err(failed)?;
    Ok((start, duration_s))
}

/// Returns the world coordinates of a chip, and true if they come from its header.
fn chip_wcs(file: &FrameFile, hdu: usize, overrides: &FrameOverrides) -> Result<(Wcs, bool), ImagesError> {
    let error = match Wcs::from_header(file.header(hdu)?) {
        Ok(wcs) => return Ok((wcs, true)),
        Err(error) => error,
    };
    match (overrides.pixel_scale_arcsec, &error) {
        (Some(scale_arcsec), ImagesError::NoCelestialAxes { .. }) => {
            let [rows, columns] = file.image_size(hdu)?;
            let centre = Direction::from_lon_lat_rad(0.0, 0.0);
            Wcs::tangent(centre, scale_arcsec, 0.0, columns, rows).map(|wcs| (wcs, false))
        }
        _ => Err(error),
    }
}

fn target_chip(
    file: &FrameFile,
    hdu: usize,
    wcs: Wcs,
    is_on_sky: bool,
    exposure_s: f64,
    overrides: &FrameOverrides,
    path: &str,
) -> Result<TargetChip, StreaksError> {
    let calibration = Calibration::from_headers(&[file.header(hdu)?, file.header(0)?]);
    let (mag, basis) = match (overrides.zero_point, &calibration.zero_point) {
        (Some(given), _) => given,
        (None, Some(stated)) => match stated.basis {
            Some(basis) => (stated.mag, basis),
            None => {
                let (keyword, mag) = (&stated.keyword, stated.mag);
                return Err(StreaksError::invalid(
                    format!("{path}: {keyword}"),
                    format!("{mag}, the magnitude of one count either in the whole exposure or per second"),
                    format!("--zero-point {mag} or --zero-point-1s {mag} to choose one"),
                ));
            }
        },
        (None, None) => {
            let allowed = "FLUXMAG0, MAGZERO, MAGZP, MAGZPT, ..., or --zero-point";
            return Err(StreaksError::invalid(format!("{path}: HDU {hdu}: zero point"), "missing", allowed));
        }
    };
    let scale = match basis {
        // In a frame with units per second both bases are the same.
        CountBasis::Second if calibration.is_rate => CountScale::of_frame(mag, exposure_s),
        CountBasis::Frame => CountScale::of_frame(mag, exposure_s),
        CountBasis::Second => CountScale::of_counts_per_second(mag, exposure_s),
    };
    let scale = scale.map_err(|error| error.at(path))?;
    let [rows, columns] = file.image_size(hdu)?;
    let info = file.hdu(hdu)?;
    let name = info.name.clone();
    let light_area = LightArea::from_header(file.header(hdu)?, rows, columns);
    let is_flux = calibration.pixel_unit == PixelUnit::Flux;
    // The gain in the header of a frame in electrons or in a flux is that of the original counts.
    let gain_e_adu = overrides.gain_e_adu.or(match calibration.pixel_unit {
        PixelUnit::Electrons => Some(1.0),
        PixelUnit::Flux => None,
        PixelUnit::Counts => calibration.gain_e_adu.map(|gain| gain.value),
    });
    let is_rate = calibration.is_rate;
    Ok(TargetChip {
        chip: Chip { hdu, name, rows, columns, light_area, wcs, is_on_sky, scale },
        electrons_per_unit: gain_e_adu.map(|gain| if is_rate { gain * exposure_s } else { gain }),
        whole_range: info.format.whole_range(),
        variance_hdu: variance_of(file, hdu)?,
        saturation: calibration.saturation_adu.map(|level| level.value).filter(|_| !is_flux && !is_rate),
    })
}

/// Returns the variance plane of a masked image of Rubin's pipelines: the HDU after the planes IMAGE and MASK (EXTNAME,
/// or EXTTYPE if tiles are compressed), of the same size.
fn variance_of(file: &FrameFile, hdu: usize) -> Result<Option<usize>, ImagesError> {
    let is_plane = |hdu: usize, name: &str| {
        let header = file.header(hdu).ok();
        let text_of = |keyword| header.and_then(|header| header.text(keyword)).is_some_and(|text| text == name);
        file.image_size(hdu).is_ok() && (text_of("EXTNAME") || text_of("EXTTYPE"))
    };
    let are_planes = is_plane(hdu, "IMAGE") && is_plane(hdu + 1, "MASK") && is_plane(hdu + 2, "VARIANCE");
    Ok((are_planes && file.image_size(hdu + 2)? == file.image_size(hdu)?).then_some(hdu + 2))
}

/// Returns the planes in the `MP_` keywords of any mask in the file.
fn mask_planes(file: &FrameFile) -> Result<BTreeMap<String, u32>, ImagesError> {
    let mut planes = BTreeMap::new();
    for info in file.hdus() {
        for card in file.header(info.index)?.cards() {
            let keyword = card.keyword();
            let Some(plane) = keyword.strip_prefix("MP_") else { continue };
            let bit = file.header(info.index)?.integer(&keyword).and_then(|bit| u32::try_from(bit).ok());
            if let Some(bit) = bit {
                planes.insert(plane.to_owned(), bit);
            }
        }
    }
    Ok(planes)
}
