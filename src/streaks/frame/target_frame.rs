//! Frame in a file into which streaks are injected, with its chips, exposure and count scale.

use std::collections::BTreeMap;
use std::path::Path;

use hifitime::Epoch;

use super::super::chip::{Chip, circle_of};
use super::super::count_scale::CountScale;
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, Gcrs};
use crate::images::{
    Calibration, CountBasis, ExposureTime, FrameFile, FrameImages, Header, HeaderSite, LightArea, PixelUnit, Wcs,
    site_from_headers, unused_coordinates,
};
use crate::passes::Exposure;

/// Values that replace those of a frame's header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameOverrides {
    /// Time at which the shutter opened.
    pub start: Option<Epoch>,
    /// Exposure time, seconds.
    pub duration_s: Option<f64>,
    /// Numbers of the HDUs to use, from 0; if empty, all images with world coordinates are used.
    pub hdus: Vec<usize>,
    /// Zero point, mag, and whether it is the magnitude of one count in the whole exposure or of one count per second.
    pub zero_point: Option<(f64, CountBasis)>,
    /// Gain, electrons per count.
    pub gain_e_adu: Option<f64>,
    /// Count at which a pixel is saturated, in the unit of the frame.
    pub saturation: Option<f64>,
    /// Side of a pixel, arcsec; used for random streaks in frames without world coordinates.
    pub pixel_scale_arcsec: Option<f64>,
}

/// Chip of a frame, with the header values that determine noise and saturation.
#[derive(Clone, Debug)]
pub struct TargetChip {
    /// Size, world coordinates and count scale.
    pub chip: Chip,
    /// Electrons per unit of the frame; `None` if unknown. This is the gain, multiplied by the exposure time if the
    /// frame contains counts per second.
    pub electrons_per_unit: Option<f64>,
    /// Count at which a pixel is saturated, in the unit of the frame.
    pub saturation: Option<f64>,
    /// Smallest and largest count that a frame of integers can hold.
    pub whole_range: Option<(f64, f64)>,
    /// HDU with the variance of each pixel, if the file is a masked image of Rubin's pipelines.
    pub variance_hdu: Option<usize>,
}

/// Frame whose file has been opened.
#[derive(Clone, Debug)]
pub struct TargetFrame {
    /// The file.
    pub file: FrameFile,
    /// Time at which the shutter opened.
    pub opened: Epoch,
    /// Error (one sigma) of that time by its digits or by the comment in the header, seconds; 0 if it is given.
    pub start_sigma_s: f64,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Chips with images, at least one.
    pub chips: Vec<TargetChip>,
    /// Roles of the images of the file. If HDUs are given, `frames` are these, and images that are neither given nor
    /// planes are not listed.
    pub images: FrameImages,
    /// HDUs of images without valid world coordinates, each with the reason.
    pub left_out: Vec<(usize, String)>,
    /// Filter or band as written in the header.
    pub filter: Option<String>,
    /// Sentences about times in the headers that can be read in two ways ([`ExposureTime::remarks`]).
    pub header_remarks: Vec<String>,
    /// Reason why the gain in the header is not used; `None` if it is used, overridden or missing.
    pub doubtful_gain: Option<String>,
    /// Bit of each mask plane that a mask in the file names.
    pub mask_planes: BTreeMap<String, u32>,
}

impl TargetFrame {
    /// Opens a frame and reads its headers.
    ///
    /// The images are the HDUs in the overrides, or else all frames of [`FrameImages`] with world coordinates. Each
    /// image needs a zero point in its header, in the primary header or in the overrides.
    ///
    /// # Errors
    /// The file cannot be read; it has no images; the start, the exposure time or the zero point is missing; or a value
    /// is invalid.
    pub fn open(path: &Path, overrides: &FrameOverrides) -> Result<Self, Error> {
        let file = FrameFile::open(path)?;
        let shown = path.display().to_string();
        let images = images(&file, overrides)?;
        let Some(&first) = images.frames.first() else {
            let (given, allowed) = images.no_frame();
            return Err(Error::invalid("number of images of two axes", given, allowed).in_file("", path));
        };
        let headers = |hdu: usize| -> Result<[&Header; 2], Error> { Ok([file.header(hdu)?, file.header(0)?]) };
        let exposure = ExposureTime::with_given(&headers(first)?, overrides.start, overrides.duration_s)
            .map_err(|error| error.in_file("", &shown))?;
        let (opened, exposure_s) = (exposure.start, exposure.duration_s);
        let (mut chips, mut left_out) = (Vec::new(), Vec::new());
        for &hdu in &images.frames {
            match chip_wcs(&file, hdu, overrides) {
                Ok((wcs, is_on_sky)) => {
                    chips.push(target_chip(&file, hdu, wcs, is_on_sky, exposure_s, overrides, &shown)?)
                }
                Err(error) => left_out.push((hdu, error)),
            }
        }
        if chips.is_empty() && !left_out.is_empty() {
            let (hdu, error) = left_out.swap_remove(0);
            return Err(error.in_hdu(path, hdu));
        }
        let first_headers = headers(first)?;
        let calibration = Calibration::from_headers(&first_headers);
        let zero_point = calibration.zero_point.filter(|_| overrides.zero_point.is_none());
        let assumed_zero_point = zero_point.and_then(|zero_point| zero_point.assumption());
        Ok(Self {
            opened,
            start_sigma_s: exposure.start_sigma_s,
            exposure_s,
            chips,
            images,
            left_out: left_out.into_iter().map(|(hdu, error)| (hdu, error.to_string())).collect(),
            header_remarks: exposure.remarks.into_iter().chain(assumed_zero_point).collect(),
            doubtful_gain: calibration.doubtful_gain.filter(|_| overrides.gain_e_adu.is_none()),
            filter: calibration.band.map(|band| band.value),
            mask_planes: mask_planes(&file)?,
            file,
        })
    }

    /// Returns the site in the header of the first image, or else in the primary header; `None` if neither has one.
    ///
    /// # Errors
    /// A position that is not on the Earth.
    pub fn site(&self) -> Result<Option<HeaderSite>, Error> {
        let first = self.chips.first().map_or(0, |target| target.chip.hdu);
        let headers = [self.file.header(first)?, self.file.header(0)?];
        site_from_headers(&headers).map_err(|error| error.at(self.file.path().display()))
    }

    /// Returns a sentence about coordinates in the headers that do not give the site.
    pub fn unused_coordinates(&self) -> Option<String> {
        let first = self.chips.first().map_or(0, |target| target.chip.hdu);
        unused_coordinates(&[self.file.header(first).ok()?, self.file.header(0).ok()?])
    }

    /// Returns remarks about what is read of the file: choices between values in its headers, and the roles of its
    /// images.
    pub fn remarks(&self) -> Vec<String> {
        let roles = self.images.summary().map(|summary| format!("{}: {summary}", self.file.path().display()));
        self.choices().into_iter().chain(roles).collect()
    }

    /// Returns remarks about values in the headers that can be read in two ways: start, exposure time and zero point.
    pub fn choices(&self) -> Vec<String> {
        let shown = self.file.path().display();
        self.header_remarks.iter().map(|remark| format!("{shown}: {remark}")).collect()
    }

    /// Returns the middle of all chips on the sky, and the radius in radians of the circle around it that contains
    /// them.
    pub fn circle(&self) -> Option<(Direction<Gcrs>, f64)> {
        circle_of(self.chips.iter().map(|target| &target.chip))
    }

    /// Returns the exposure of the frame, whose name is its path and whose pointing is the middle of all chips, and the
    /// radius in radians of the circle that contains them.
    ///
    /// # Errors
    /// The world coordinates do not cover the frame.
    pub fn exposure(&self) -> Result<(Exposure, f64), Error> {
        let (pointing, radius_rad) = self.circle().ok_or_else(|| {
            Error::invalid(
                "position of the corners of the frame on the sky",
                "undefined",
                "world coordinates that cover the frame",
            )
            .in_file("", self.file.path())
        })?;
        let id = self.file.path().display().to_string();
        let exposure = Exposure { id, start: self.opened, duration_s: self.exposure_s, pointing, rotation_rad: 0.0 };
        Ok((exposure, radius_rad))
    }
}

/// Returns the images of the sky and their companion planes.
fn images(file: &FrameFile, overrides: &FrameOverrides) -> Result<FrameImages, Error> {
    if !overrides.hdus.is_empty() {
        let mut hdus = overrides.hdus.clone();
        hdus.sort_unstable();
        hdus.dedup();
        for &hdu in &hdus {
            file.header(hdu)?;
            // This call rejects an HDU that is not an image.
            file.image_size(hdu)?;
        }
        // The given HDUs are frames, whatever their names are.
        let mut images = file.frame_images().unwrap_or_default();
        images.companions.retain(|plane| !hdus.contains(&plane.hdu));
        images.frames = hdus;
        return Ok(images);
    }
    file.frame_images()
}

/// Returns the world coordinates of a chip, and whether they come from its header (true) or are a substitute (false).
fn chip_wcs(file: &FrameFile, hdu: usize, overrides: &FrameOverrides) -> Result<(Wcs, bool), Error> {
    let error = match Wcs::from_header(file.header(hdu)?) {
        Ok(wcs) => return Ok((wcs, true)),
        Err(error) => error,
    };
    match overrides.pixel_scale_arcsec {
        Some(scale_arcsec) if error.kind() == ErrorKind::NoCoordinates => {
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
) -> Result<TargetChip, Error> {
    let calibration = Calibration::from_headers(&[file.header(hdu)?, file.header(0)?]);
    if let (PixelUnit::Magnitudes, Some(unit)) = (calibration.pixel_unit, &calibration.unit) {
        let allowed = "a unit of light, such as adu, electron or Jy";
        return Err(Error::invalid("BUNIT", format_args!("'{}'", unit.value), allowed).in_hdu(path.as_ref(), hdu));
    }
    // Pixels of stacks of Pan-STARRS are asinh magnitudes of the light.
    if let Some(softening) = file.header(hdu)?.number("BSOFTEN") {
        let given = format!("{softening}: the pixels are an asinh of the light");
        return Err(
            Error::invalid("BSOFTEN", given, "pixels that are proportional to the light").in_hdu(path.as_ref(), hdu)
        );
    }
    let (mag, basis) = match (overrides.zero_point, &calibration.zero_point) {
        (Some(given), _) => given,
        (None, Some(stated)) => match stated.basis {
            Some(basis) => (stated.mag, basis),
            None => {
                let (keyword, mag) = (&stated.keyword, stated.mag);
                return Err(Error::invalid(
                    keyword,
                    format!("{mag}, the magnitude of one count either in the whole exposure or per second"),
                    format!("--zero-point {mag} or --zero-point-1s {mag} to choose one"),
                )
                .in_file("", path));
            }
        },
        (None, None) => {
            let allowed = "FLUXMAG0, MAGZERO, MAGZP, MAGZPT, ..., or --zero-point";
            return Err(Error::invalid("zero point", "missing", allowed).in_hdu(path.as_ref(), hdu));
        }
    };
    let scale = match basis {
        // In a frame in counts per second, the magnitude of one count and that of one count per second are the same.
        CountBasis::Second if calibration.is_rate => CountScale::of_frame(mag, exposure_s),
        CountBasis::Frame => CountScale::of_frame(mag, exposure_s),
        CountBasis::Second => CountScale::of_counts_per_second(mag, exposure_s),
    };
    let scale = scale.map_err(|error| error.in_file("", path))?;
    let [rows, columns] = file.image_size(hdu)?;
    let info = file.hdu(hdu)?;
    let name = info.name.clone();
    let light_area = LightArea::from_header(file.header(hdu)?, rows, columns);
    let is_flux = calibration.pixel_unit == PixelUnit::Flux;
    // The header of a frame in electrons or in a calibrated flux often still contains the gain of the raw counts.
    let gain_e_adu = overrides.gain_e_adu.or(match calibration.pixel_unit {
        PixelUnit::Electrons => Some(1.0),
        PixelUnit::Flux | PixelUnit::Magnitudes => None,
        PixelUnit::Counts => calibration.gain_e_adu.map(|gain| gain.value),
    });
    let is_rate = calibration.is_rate;
    Ok(TargetChip {
        chip: Chip { hdu, name, rows, columns, light_area, wcs, is_on_sky, scale },
        electrons_per_unit: gain_e_adu.map(|gain| if is_rate { gain * exposure_s } else { gain }),
        whole_range: info.format.whole_range(),
        variance_hdu: variance_of(file, hdu)?,
        saturation: overrides
            .saturation
            .or(calibration.saturation_adu.map(|level| level.value).filter(|_| !is_flux && !is_rate)),
    })
}

/// Returns the HDU of the variance plane that belongs to an image of Rubin's pipelines: the HDU of the same size after
/// the planes IMAGE and MASK. The planes are named by EXTNAME, or by EXTTYPE if the file is compressed in tiles.
fn variance_of(file: &FrameFile, hdu: usize) -> Result<Option<usize>, Error> {
    let is_plane = |hdu: usize, name: &str| {
        let header = file.header(hdu).ok();
        let text_of = |keyword| header.and_then(|header| header.text(keyword)).is_some_and(|text| text == name);
        file.image_size(hdu).is_ok() && (text_of("EXTNAME") || text_of("EXTTYPE"))
    };
    let are_planes = is_plane(hdu, "IMAGE") && is_plane(hdu + 1, "MASK") && is_plane(hdu + 2, "VARIANCE");
    Ok((are_planes && file.image_size(hdu + 2)? == file.image_size(hdu)?).then_some(hdu + 2))
}

/// Returns the mask planes, with their bits, in the `MP_` keywords of all masks in the file.
fn mask_planes(file: &FrameFile) -> Result<BTreeMap<String, u32>, Error> {
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
