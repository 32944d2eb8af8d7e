//! A frame on file that streaks are to be put into: its chips, when it was taken, and what its counts are worth.

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

/// Why nothing can be put into a frame.
#[derive(Debug, Error)]
pub enum TargetError {
    /// The file.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// When it was taken.
    #[error("{path}: {source}")]
    Exposure {
        /// The file.
        path: String,
        /// What is wrong.
        source: Box<ExposureError>,
    },
    /// No image in it.
    #[error("{path}: holds no image of two axes (masks, weights and tables do not count)")]
    NoImage {
        /// The file.
        path: String,
    },
    /// Not where it is on the sky.
    #[error("{path}: HDU {hdu}: {source}")]
    Wcs {
        /// The file.
        path: String,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// What is wrong.
        source: WcsError,
    },
    /// What a count is worth is not known.
    #[error(
        "{path}: HDU {hdu} says nothing of its zero point (looked for FLUXMAG0, MAGZERO, MAGZP, MAGZPT, ...); say it: --zero-point"
    )]
    NoZeroPoint {
        /// The file.
        path: String,
        /// Number of the HDU, from 0.
        hdu: usize,
    },
    /// What a zero point means is not known.
    #[error(
        "{path}: {keyword} = {mag} may be the magnitude of a count of the whole exposure or of a count a second; say which: --zero-point {mag} or --zero-point-1s {mag}"
    )]
    ZeroPointBasis {
        /// The file.
        path: String,
        /// Its keyword.
        keyword: String,
        /// Its value.
        mag: f64,
    },
    /// Numbers that make no scale.
    #[error("{path}: {source}")]
    Scale {
        /// The file.
        path: String,
        /// What is wrong.
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

/// A chip with what noise needs.
#[derive(Clone, Debug)]
pub struct TargetChip {
    /// Pixels, sky and counts.
    pub chip: Chip,
    /// Electrons that one unit of the frame stands for: the gain, times the exposure where the frame holds counts a second. `None` where it is not known.
    pub electrons_a_unit: Option<f64>,
    /// Where pixels saturate, the frame's unit.
    pub saturation: Option<f64>,
    /// Least and greatest count of a frame of whole numbers.
    pub whole_range: Option<(f64, f64)>,
    /// HDU of the plane that holds the variance of each of its pixels, where the file is a masked image of Rubin's pipelines.
    pub variance_hdu: Option<usize>,
}

/// An opened frame.
#[derive(Clone, Debug)]
pub struct TargetFrame {
    /// The file.
    pub file: FrameFile,
    /// When the shutter opened.
    pub opened: Epoch,
    /// For how long, seconds.
    pub exposure_s: f64,
    /// Its images, at least one.
    pub chips: Vec<TargetChip>,
    /// HDUs of images without a usable place on the sky, with the reason; others have one.
    pub left_out: Vec<(usize, WcsError)>,
    /// Filter or band as the header has it.
    pub filter: Option<String>,
    /// Names of instrument, telescope and observatory as the header has them: the nearest to the light first.
    pub observatory: Vec<String>,
    /// Planes that a mask in the file names, and their bits.
    pub mask_planes: BTreeMap<String, u32>,
}

/// Words in EXTNAME or EXTTYPE of what is no light.
const NO_LIGHT: [&str; 9] = ["MASK", "VARIANCE", "WEIGHT", "WHT", "IVAR", "DQ", "ERR", "FLAG", "SIGMA"];

impl TargetFrame {
    /// Opens a frame and reads what its headers say.
    ///
    /// The images are all HDUs of two axes that are no masks or weights and have a place on the sky, or those said. A zero point must be in the header of
    /// each or of the file, or said.
    ///
    /// # Errors
    /// [`TargetError`].
    pub fn open(path: &Path, said: &FrameOverrides) -> Result<Self, TargetError> {
        let file = FrameFile::open(path)?;
        let shown = path.display().to_string();
        let images = images(&file, said)?;
        let Some(&first) = images.first() else { return Err(TargetError::NoImage { path: shown }) };
        let headers = |hdu: usize| -> Result<[&Header; 2], FrameError> { Ok([file.header(hdu)?, file.header(0)?]) };
        let (opened, exposure_s) = exposure(&headers(first)?, said, &shown)?;
        let (mut chips, mut left_out) = (Vec::new(), Vec::new());
        for &hdu in &images {
            match place(&file, hdu, said) {
                Ok((wcs, is_on_sky)) => chips.push(target_chip(&file, hdu, wcs, is_on_sky, exposure_s, said, &shown)?),
                Err(Placing::Frame(error)) => return Err(error.into()),
                Err(Placing::Wcs(error)) => left_out.push((hdu, error)),
            }
        }
        if chips.is_empty()
            && let Some((hdu, source)) = left_out.first().cloned()
        {
            return Err(TargetError::Wcs { path: shown, hdu, source });
        }
        let said_headers = headers(first)?;
        let calibration = Calibration::from_headers(&said_headers);
        let text = |keyword: &str| said_headers.iter().find_map(|header| header.text(keyword));
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

    /// What the telescope points at, and the radius about it that holds all chips, radians.
    pub fn circle(&self) -> Option<(Direction<Gcrs>, f64)> {
        circle_of(self.chips.iter().map(|target| &target.chip))
    }
}

/// HDUs that hold light.
fn images(file: &FrameFile, said: &FrameOverrides) -> Result<Vec<usize>, FrameError> {
    if !said.hdus.is_empty() {
        let mut hdus = said.hdus.clone();
        hdus.sort_unstable();
        hdus.dedup();
        for &hdu in &hdus {
            file.header(hdu)?;
            // Its own words say what is wrong with one that is no image.
            file.image_size(hdu)?;
        }
        return Ok(hdus);
    }
    let mut found = file.images();
    found.retain(|&hdu| {
        let header = file.header(hdu).ok();
        let says = |keyword| header.and_then(|header| header.text(keyword)).unwrap_or_default().to_ascii_uppercase();
        let names = [says("EXTNAME"), says("EXTTYPE")];
        !NO_LIGHT.iter().any(|word| names.iter().any(|name| name.contains(word)))
    });
    Ok(found)
}

fn exposure(headers: &[&Header; 2], said: &FrameOverrides, path: &str) -> Result<(Epoch, f64), TargetError> {
    if let (Some(start), Some(duration_s)) = (said.start, said.duration_s) {
        return Ok((start, duration_s));
    }
    let failed = |source: ExposureError| TargetError::Exposure { path: path.to_owned(), source: Box::new(source) };
    // What is said takes the place of what may be missing or wrong in the header.
    let duration_s =
        said.duration_s.map_or_else(|| ExposureTime::duration_from_headers(headers), Ok).map_err(failed)?;
    let start = said.start.map_or_else(|| ExposureTime::start_from_headers(headers, duration_s), Ok).map_err(failed)?;
    Ok((start, duration_s))
}

enum Placing {
    Frame(FrameError),
    Wcs(WcsError),
}

/// Where a chip is on the sky, and whether its header says so.
fn place(file: &FrameFile, hdu: usize, said: &FrameOverrides) -> Result<(Wcs, bool), Placing> {
    let error = match Wcs::from_header(file.header(hdu).map_err(Placing::Frame)?) {
        Ok(wcs) => return Ok((wcs, true)),
        Err(error) => error,
    };
    match (said.pixel_scale_arcsec, &error) {
        (Some(scale_arcsec), WcsError::NoCelestialAxes { .. }) => {
            let [rows, columns] = file.image_size(hdu).map_err(Placing::Frame)?;
            let centre = Direction::from_lon_lat_rad(0.0, 0.0);
            Wcs::tangent(centre, scale_arcsec, 0.0, columns, rows).map(|wcs| (wcs, false)).map_err(Placing::Wcs)
        }
        _ => Err(Placing::Wcs(error)),
    }
}

fn target_chip(
    file: &FrameFile,
    hdu: usize,
    wcs: Wcs,
    is_on_sky: bool,
    exposure_s: f64,
    said: &FrameOverrides,
    path: &str,
) -> Result<TargetChip, TargetError> {
    let calibration = Calibration::from_headers(&[file.header(hdu)?, file.header(0)?]);
    let (mag, basis) = match (said.zero_point, &calibration.zero_point) {
        (Some(said), _) => said,
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
        // Of a frame whose own unit is that of a second the two are the same.
        CountBasis::Second if calibration.is_rate => CountScale::of_frame(mag, exposure_s),
        CountBasis::Frame => CountScale::of_frame(mag, exposure_s),
        CountBasis::Second => CountScale::of_a_second(mag, exposure_s),
    };
    let scale = scale.map_err(|source| TargetError::Scale { path: path.to_owned(), source })?;
    let [rows, columns] = file.image_size(hdu)?;
    let info = file.hdu(hdu)?;
    let name = info.name.clone();
    let light_area = LightArea::from_header(file.header(hdu)?, rows, columns);
    let is_flux = calibration.pixel_unit == PixelUnit::Flux;
    // A gain in the header of electrons or of a flux is that of the counts they were made from.
    let gain_e_adu = said.gain_e_adu.or(match calibration.pixel_unit {
        PixelUnit::Electrons => Some(1.0),
        PixelUnit::Flux => None,
        PixelUnit::Counts => calibration.gain_e_adu.map(|gain| gain.value),
    });
    let is_rate = calibration.is_rate;
    Ok(TargetChip {
        chip: Chip { hdu, name, rows, columns, light_area, wcs, is_on_sky, scale },
        electrons_a_unit: gain_e_adu.map(|gain| if is_rate { gain * exposure_s } else { gain }),
        whole_range: info.format.whole_range(),
        variance_hdu: variance_of(file, hdu)?,
        saturation: calibration.saturation_adu.map(|level| level.value).filter(|_| !is_flux && !is_rate),
    })
}

/// The plane of variances of a masked image as Rubin's pipelines write it: behind the planes IMAGE and MASK (EXTNAME, or EXTTYPE where tiles are compressed), of
/// the image's size.
fn variance_of(file: &FrameFile, hdu: usize) -> Result<Option<usize>, FrameError> {
    let is_plane = |hdu: usize, name: &str| {
        let header = file.header(hdu).ok();
        let says = |keyword| header.and_then(|header| header.text(keyword)).is_some_and(|text| text == name);
        file.image_size(hdu).is_ok() && (says("EXTNAME") || says("EXTTYPE"))
    };
    let are_planes = is_plane(hdu, "IMAGE") && is_plane(hdu + 1, "MASK") && is_plane(hdu + 2, "VARIANCE");
    Ok((are_planes && file.image_size(hdu + 2)? == file.image_size(hdu)?).then_some(hdu + 2))
}

/// `MP_` keywords of any mask in the file.
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
