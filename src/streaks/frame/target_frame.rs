//! Frame in a file into which streaks are injected: its chips, exposure and count scale.

use std::collections::BTreeMap;
use std::path::Path;

use hifitime::Epoch;
use thiserror::Error;

use super::super::chip::{Chip, circle_of};
use super::super::count_scale::{CountScale, CountScaleError};
use crate::frames::{Direction, Gcrs};
use crate::images::{
    Calibration, CountBasis, ExposureError, ExposureTime, FrameError, FrameFile, Header, LightArea, PixelUnit, Wcs,
    WcsError,
};

/// Errors of a frame into which streaks are to be injected.
#[derive(Debug, Error)]
pub enum TargetError {
    /// Error of the file.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Error of the exposure time.
    #[error("{path}: {source}")]
    Exposure {
        /// The file.
        path: String,
        /// Cause.
        source: Box<ExposureError>,
    },
    /// The file has no image.
    #[error("{path}: no image of two axes (masks, weights and tables are ignored)")]
    NoImage {
        /// The file.
        path: String,
    },
    /// The header has no valid world coordinates.
    #[error("{path}: HDU {hdu}: {source}")]
    Wcs {
        /// The file.
        path: String,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// Cause.
        source: WcsError,
    },
    /// The header has no zero point.
    #[error("{path}: missing zero point of HDU {hdu} (no FLUXMAG0, MAGZERO, MAGZP, MAGZPT, ...); specify --zero-point")]
    NoZeroPoint {
        /// The file.
        path: String,
        /// Number of the HDU, from 0.
        hdu: usize,
    },
    /// The zero point is ambiguous.
    #[error(
        "{path}: {keyword} = {mag} is ambiguous: the magnitude of one count in the whole exposure, or of one count per second; specify --zero-point {mag} or --zero-point-1s {mag}"
    )]
    ZeroPointBasis {
        /// The file.
        path: String,
        /// Keyword of the zero point.
        keyword: String,
        /// Value of the zero point.
        mag: f64,
    },
    /// The zero point or exposure is out of range.
    #[error("{path}: {source}")]
    Scale {
        /// The file.
        path: String,
        /// Cause.
        source: CountScaleError,
    },
}

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
    pub left_out: Vec<(usize, WcsError)>,
    /// Filter or band as written in the header.
    pub filter: Option<String>,
    /// Names of instrument, telescope and observatory in the header, in this order.
    pub observatory: Vec<String>,
    /// Planes named by a mask in the file, with their bits.
    pub mask_planes: BTreeMap<String, u32>,
}

/// Words in EXTNAME or EXTTYPE of images that do not contain light.
const NON_IMAGE_WORDS: [&str; 9] = ["MASK", "VARIANCE", "WEIGHT", "WHT", "IVAR", "DQ", "ERR", "FLAG", "SIGMA"];

impl TargetFrame {
    /// Opens a frame and reads its headers.
    ///
    /// The images are all HDUs of two axes with world coordinates that are not masks or weights, or the HDUs of the
    /// overrides. A zero point is required in the header of each image, in that of the file, or in the overrides.
    ///
    /// # Errors
    /// [`TargetError`].
    pub fn open(path: &Path, overrides: &FrameOverrides) -> Result<Self, TargetError> {
        let file = FrameFile::open(path)?;
        let shown = path.display().to_string();
        let images = images(&file, overrides)?;
        let Some(&first) = images.first() else { return Err(TargetError::NoImage { path: shown }) };
        let headers = |hdu: usize| -> Result<[&Header; 2], FrameError> { Ok([file.header(hdu)?, file.header(0)?]) };
        let (opened, exposure_s) = exposure(&headers(first)?, overrides, &shown)?;
        let (mut chips, mut left_out) = (Vec::new(), Vec::new());
        for &hdu in &images {
            match chip_wcs(&file, hdu, overrides) {
                Ok((wcs, is_on_sky)) => {
                    chips.push(target_chip(&file, hdu, wcs, is_on_sky, exposure_s, overrides, &shown)?)
                }
                Err(ChipError::Frame(error)) => return Err(error.into()),
                Err(ChipError::Wcs(error)) => left_out.push((hdu, error)),
            }
        }
        if chips.is_empty()
            && let Some((hdu, source)) = left_out.first().cloned()
        {
            return Err(TargetError::Wcs { path: shown, hdu, source });
        }
        let first_headers = headers(first)?;
        let calibration = Calibration::from_headers(&first_headers);
        let text = |keyword: &str| first_headers.iter().find_map(|header| header.text(keyword));
        Ok(Self {
            opened,
            exposure_s,
            chips,
            left_out,
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
fn images(file: &FrameFile, overrides: &FrameOverrides) -> Result<Vec<usize>, FrameError> {
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
    let mut found = file.images();
    found.retain(|&hdu| {
        let header = file.header(hdu).ok();
        let text_of = |keyword| header.and_then(|header| header.text(keyword)).unwrap_or_default().to_ascii_uppercase();
        let names = [text_of("EXTNAME"), text_of("EXTTYPE")];
        !NON_IMAGE_WORDS.iter().any(|word| names.iter().any(|name| name.contains(word)))
    });
    Ok(found)
}

fn exposure(headers: &[&Header; 2], overrides: &FrameOverrides, path: &str) -> Result<(Epoch, f64), TargetError> {
    if let (Some(start), Some(duration_s)) = (overrides.start, overrides.duration_s) {
        return Ok((start, duration_s));
    }
    let failed = |source: ExposureError| TargetError::Exposure { path: path.to_owned(), source: Box::new(source) };
    // The overrides replace missing or wrong values of the header.
    let duration_s =
        overrides.duration_s.map_or_else(|| ExposureTime::duration_from_headers(headers), Ok).map_err(failed)?;
    let start =
        overrides.start.map_or_else(|| ExposureTime::start_from_headers(headers, duration_s), Ok).map_err(failed)?;
    Ok((start, duration_s))
}

enum ChipError {
    Frame(FrameError),
    Wcs(WcsError),
}

/// Returns the world coordinates of a chip, and true if they come from its header.
fn chip_wcs(file: &FrameFile, hdu: usize, overrides: &FrameOverrides) -> Result<(Wcs, bool), ChipError> {
    let error = match Wcs::from_header(file.header(hdu).map_err(ChipError::Frame)?) {
        Ok(wcs) => return Ok((wcs, true)),
        Err(error) => error,
    };
    match (overrides.pixel_scale_arcsec, &error) {
        (Some(scale_arcsec), WcsError::NoCelestialAxes { .. }) => {
            let [rows, columns] = file.image_size(hdu).map_err(ChipError::Frame)?;
            let centre = Direction::from_lon_lat_rad(0.0, 0.0);
            Wcs::tangent(centre, scale_arcsec, 0.0, columns, rows).map(|wcs| (wcs, false)).map_err(ChipError::Wcs)
        }
        _ => Err(ChipError::Wcs(error)),
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
) -> Result<TargetChip, TargetError> {
    let calibration = Calibration::from_headers(&[file.header(hdu)?, file.header(0)?]);
    let (mag, basis) = match (overrides.zero_point, &calibration.zero_point) {
        (Some(given), _) => given,
        (None, Some(stated)) => match stated.basis {
            Some(basis) => (stated.mag, basis),
            None => {
                let (path, keyword) = (path.to_owned(), stated.keyword.clone());
                return Err(TargetError::ZeroPointBasis { path, keyword, mag: stated.mag });
            }
        },
        (None, None) => return Err(TargetError::NoZeroPoint { path: path.to_owned(), hdu }),
    };
    let scale = match basis {
        // In a frame with units per second both bases are the same.
        CountBasis::Second if calibration.is_rate => CountScale::of_frame(mag, exposure_s),
        CountBasis::Frame => CountScale::of_frame(mag, exposure_s),
        CountBasis::Second => CountScale::of_counts_per_second(mag, exposure_s),
    };
    let scale = scale.map_err(|source| TargetError::Scale { path: path.to_owned(), source })?;
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
fn variance_of(file: &FrameFile, hdu: usize) -> Result<Option<usize>, FrameError> {
    let is_plane = |hdu: usize, name: &str| {
        let header = file.header(hdu).ok();
        let text_of = |keyword| header.and_then(|header| header.text(keyword)).is_some_and(|text| text == name);
        file.image_size(hdu).is_ok() && (text_of("EXTNAME") || text_of("EXTTYPE"))
    };
    let are_planes = is_plane(hdu, "IMAGE") && is_plane(hdu + 1, "MASK") && is_plane(hdu + 2, "VARIANCE");
    Ok((are_planes && file.image_size(hdu + 2)? == file.image_size(hdu)?).then_some(hdu + 2))
}

/// Returns the planes in the `MP_` keywords of any mask in the file.
fn mask_planes(file: &FrameFile) -> Result<BTreeMap<String, u32>, FrameError> {
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
