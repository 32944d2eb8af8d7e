//! Options of the measurement of streaks in frames, and its execution.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hifitime::TimeScale;
use serde::Deserialize;

use super::document::Config;
use super::error;
use super::injection_plan::{SkyOf, checked_size, seeing_form};
use super::measure_frame::FrameRun;
use super::measured_tables::{MeasuredTables, rows_left_out};
use super::required::FRAMES;
use super::values::{parse_angle_deg, parse_exposure_s};
use crate::error::{Error, ErrorKind};
use crate::frames::{is_covered, parse_start, seconds_after};
use crate::geometry::Site;
use crate::images::{Calibration, CountBasis, FrameFile, HeaderSite};
use crate::measure::{
    ListedMeasurement, MeasuredPass, StarTable, listed_table, measurement_table, predict_within_passes,
};
use crate::message::first_of;
use crate::orbit::LeftOut;
use crate::output::{Provenance, Table};
use crate::passes::no_ephemeris;
use crate::streaks::{FrameOverrides, Optics, TargetFrame};
use crate::watch::Watch;

/// Initial seeing of the fit of the width if no seeing is given, pixels.
const SEEING_PIX: f64 = 4.0;
/// Largest distance of the sites in the headers of the frames of one run, km.
const ONE_SITE_KM: f64 = 1.0;

/// File of a frame that cannot be used, with the reason.
type FrameError = (PathBuf, Error);

/// Frames and options of a measurement, in addition to [`Config`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct MeasureConfig {
    /// Frames (FITS) with world coordinates, including mosaics and tile-compressed .fz
    #[cfg_attr(feature = "cli", arg(value_name = "FRAME"))]
    pub image: Vec<PathBuf>,
    /// Tables of streaks, instead of predicted satellites: CSV, ECSV or FITS with their ends, streaks.txt of ASTRiDE,
    /// the catalog of acstools.findsat_mrt, or regions of DS9. With --elements or --shells the streaks are identified
    #[cfg_attr(feature = "cli", arg(long, value_name = "TABLE", num_args = 1..))]
    pub streaks: Vec<PathBuf>,
    /// Folder to which names of frames in `streaks` are relative; that of each table if omitted.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub streaks_folder: Option<PathBuf>,
    /// Position error (one sigma) of the ends of --streaks with its unit; 3 pixels if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", requires = "streaks"))]
    pub place_sigma: Option<String>,
    /// HDUs to use, counted from 0; all images with world coordinates if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", num_args = 1.., value_delimiter = ','))]
    pub hdu: Vec<usize>,
    /// Shutter opening, for example 2020-03-06T00:04:15.410Z; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub start: Option<String>,
    /// Exposure time with its unit, for example 30s or 2min; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub exposure: Option<String>,
    /// Seeing: FWHM of a star's image with its unit, for example 1.2arcsec; that of --telescope if omitted; without
    /// both it is that of --stars, or fitted to each streak
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE"))]
    pub seeing: Option<String>,
    /// Fit the width of each streak instead of using the given seeing
    #[cfg_attr(feature = "cli", arg(long))]
    pub fit_width: bool,
    /// Point spread function: gaussian, moffat (β 3.5), moffat:BETA, double; moffat if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "FORM"))]
    pub psf: Option<String>,
    /// Diameter of the satellites in m, 0 for points; that of the model if omitted, with an error of half of it
    #[cfg_attr(feature = "cli", arg(long, value_name = "M"))]
    pub satellite_size: Option<f64>,
    /// Zero point: magnitude of a star with a total of 1 in the frame's unit; from the header if omitted; without both,
    /// magnitudes are instrumental
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true))]
    pub zero_point: Option<f64>,
    /// Zero point for 1 count per second, instead of --zero-point
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "MAG", allow_hyphen_values = true, conflicts_with = "zero_point")
    )]
    pub zero_point_1s: Option<f64>,
    /// Zero point from stars: table (CSV) with ra_deg, dec_deg, mag and, optionally, mag_sigma, band and colour
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "TABLE", conflicts_with_all = ["zero_point", "zero_point_1s"])
    )]
    pub stars: Option<PathBuf>,
    /// Only stars of --stars with a colour in this range, mag: 0.7,0.95 for stars like the Sun in Gaia's BP - RP
    #[cfg_attr(feature = "cli", arg(long, value_name = "BLUEST,REDDEST", allow_hyphen_values = true))]
    pub star_colours: Option<String>,
    /// Gain, electrons per count; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "E"))]
    pub gain: Option<f64>,
    /// Value at which pixels are saturated, in the frame's unit; from the header if omitted, or else the largest value
    /// of the frame if pixels pile up there
    #[cfg_attr(feature = "cli", arg(long, value_name = "COUNTS"))]
    pub saturation: Option<f64>,
    /// If true, the pixels along each track are returned, for pictures.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub cuts: bool,
}

/// Measurements of several frames.
#[derive(Clone, Debug)]
pub struct Measurements {
    /// Measured streaks and upper limits.
    pub passes: Vec<MeasuredPass>,
    /// Table of all measurements. For streaks of tables it has a row for each streak, also for those that are not
    /// measured.
    pub table: Table,
    /// Files of the frames, also of those that rows of tables name.
    pub frames: Vec<PathBuf>,
    /// Satellites whose positions cannot be computed, for each frame.
    pub left_out: Vec<LeftOut>,
    /// Site of the frames.
    pub site: Option<Site>,
    /// Provenance of the result.
    pub provenance: Provenance,
    /// Remarks about the site from the header and zero points from stars.
    pub remarks: Vec<String>,
    /// Those of the remarks that state a choice between values in headers.
    pub choices: Vec<String>,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl MeasureConfig {
    /// Opens the frames, predicts the satellites in them, and measures their streaks, or measures the streaks of
    /// tables.
    ///
    /// `sky` returns the sky of the night of a frame; by default it is prepared from the configuration for all frames.
    /// Streaks of tables need no satellites. Frames without an image, world coordinates, a time or a site are left out,
    /// with a warning; so are those whose pixels cannot be read, and those of another site than the first, if none is
    /// given.
    ///
    /// # Errors
    /// No frame is left, a table is invalid, or a value is out of range.
    pub fn measure(&self, config: &Config, sky: Option<SkyOf<'_>>, watch: &Watch) -> Result<Measurements, Error> {
        if self.stars.is_some() && (self.zero_point.is_some() || self.zero_point_1s.is_some()) {
            return Err(error::both("--stars", "--zero-point"));
        }
        let satellite_size_m = checked_size(self.satellite_size)?;
        let place_sigma = self.place_sigma.as_deref().map(|text| parse_angle_deg("place-sigma", text)).transpose()?;
        let table = self.star_table()?;
        let mut listed = MeasuredTables::read(&self.streaks, self.streaks_folder.as_deref(), &self.image)?;
        let overrides = self.overrides(config)?;
        let has_sky = self.streaks.is_empty() || sky.is_some() || config.has_satellites();
        let (mut frames, mut failed): (Vec<(TargetFrame, bool)>, Vec<FrameError>) = Default::default();
        for path in std::mem::take(&mut listed.frames) {
            let opened = self.open(&path, &overrides).and_then(|(frame, is_calibrated)| {
                if has_sky {
                    check_years(&frame)?;
                }
                Ok((frame, is_calibrated))
            });
            match opened {
                Ok(frame) => frames.push(frame),
                Err(error) => failed.push((path, error)),
            }
        }
        let (config, remark) =
            if has_sky { with_site(config, &mut frames, &mut failed)? } else { (config.clone(), None) };
        if frames.is_empty() {
            leave_out(std::mem::take(&mut failed), &self.image, &mut listed)?;
        }
        let (first, last) = (
            frames.iter().map(|(frame, _)| frame.opened).min(),
            frames.iter().map(|(frame, _)| seconds_after(frame.opened, frame.exposure_s)).max(),
        );
        let of_all = match (first.zip(last), sky) {
            (None, _) if self.streaks.is_empty() => {
                return Err(FRAMES.missing());
            }
            (None, _) => None,
            (Some(_), _) if !has_sky => None,
            (Some((first, _)), Some(sky)) => Some(sky(first)?),
            (Some((first, last)), None) => Some(Arc::new(config.prepare(first, last)?)),
        };
        // The warnings of a given sky are not repeated here.
        let mut warnings: Vec<String> =
            of_all.iter().filter(|_| sky.is_none()).flat_map(|all| all.warnings.clone()).collect();
        let mut remarks: Vec<String> = remark.into_iter().chain(std::mem::take(&mut listed.remarks)).collect();
        let run = FrameRun {
            config: &config,
            optics: &|frame| self.optics(&config, frame),
            has_streaks: !self.streaks.is_empty(),
            fit_width: self.fit_width,
            is_form_known: self.psf.is_some(),
            cuts: self.cuts,
            stars: table.as_ref(),
            place_sigma_deg: place_sigma,
            satellite_size_m,
            watch,
        };
        let (mut passes, mut left_out, mut rows, mut choices) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (frame, is_calibrated) in &frames {
            let prepared = match (&of_all, sky) {
                (None, _) => None,
                (Some(_), Some(sky)) => Some(sky(frame.opened)?),
                (Some(all), None) => Some(all.clone()),
            };
            let sky = prepared.as_ref().map(|prepared| prepared.sky.watched(watch));
            let path = frame.file.path();
            match run.measure(frame, *is_calibrated, sky.as_ref(), listed.streaks_of(path)) {
                Ok(done) => {
                    listed.frames.push(path.to_owned());
                    listed.invalid.extend(done.invalid);
                    rows.extend(done.rows);
                    remarks.extend(done.remarks);
                    choices.extend(done.choices);
                    warnings.extend(done.warnings);
                    passes.extend(done.measured.passes);
                    left_out.extend(done.measured.left_out);
                }
                Err(error) if error.kind() == ErrorKind::Cancelled => return Err(error),
                Err(error) => failed.push((path.to_owned(), error)),
            }
        }
        let unreadable = leave_out(failed, &self.image, &mut listed)?;
        if let Some(first) = listed.invalid.first().filter(|_| rows.is_empty()) {
            return Err(first.clone());
        }
        warnings.extend(rows_left_out(&listed.invalid));
        let left_out_frames = unreadable.into_iter().map(|(path, error)| {
            // Errors of a value in the frame, or of another file.
            let is_named = error.file() == Some(&path);
            let error = if is_named { error } else { error.within(path.display(), &path, None) };
            format!("{error}; the frame is left out")
        });
        warnings.extend(first_of(left_out_frames, "frames left out"));
        let has_distance = |row: &ListedMeasurement| {
            row.measured.as_ref().is_ok_and(|pass| {
                pass.prediction.satellite.range_km.is_some() && pass.prediction.image_fwhm_arcsec.is_none()
            })
        };
        let is_measured = rows.iter().any(|row| row.measured.is_ok());
        if satellite_size_m.is_some_and(|size_m| size_m > 0.0) && is_measured && !rows.iter().any(has_distance) {
            warnings.push(
                "--satellite-size has no effect: no streak has a distance, from range_km or from its satellite"
                    .to_owned(),
            );
        }
        // With --measured, predictions are corrected already.
        if config.measured.is_empty() {
            predict_within_passes(&mut passes);
            predict_within_passes(rows.iter_mut().filter_map(|row| row.measured.as_mut().ok().map(|pass| &mut **pass)));
        }
        let mut provenance = of_all.as_ref().map_or_else(Provenance::new, |all| all.provenance.clone());
        config.state_scales(&mut provenance, &config.photometry()?);
        let viewpoint = of_all.as_ref().and_then(|all| all.sky.viewpoint().site());
        let site = viewpoint.map(|observer| observer.site().clone());
        let table = if self.streaks.is_empty() { measurement_table(&passes) } else { listed_table(&rows) };
        Ok(Measurements {
            passes,
            table,
            frames: listed.frames,
            left_out,
            site,
            provenance,
            remarks,
            choices,
            warnings,
        })
    }

    /// Returns the table of stars, with the colours of `star_colours` if these are given.
    fn star_table(&self) -> Result<Option<StarTable>, Error> {
        let Some(colours) = &self.star_colours else {
            return self.stars.as_deref().map(StarTable::read).transpose();
        };
        let missing = Error::missing("table of stars for --star-colours", "--stars TABLE");
        let table = StarTable::read(self.stars.as_deref().ok_or(missing)?)?;
        let range = colours.split_once(',').and_then(|(bluest, reddest)| {
            let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            Some([number(bluest)?, number(reddest)?]).filter(|[bluest, reddest]| bluest <= reddest)
        });
        let range = range.ok_or_else(|| {
            Error::invalid(
                "star-colours",
                format_args!("'{colours}'"),
                "the bluest and the reddest colour, mag, for example 0.7,0.95",
            )
        })?;
        Ok(Some(table.in_colours(range)?))
    }

    /// Returns the given values that replace those of the headers.
    ///
    /// # Errors
    /// A value is invalid.
    pub(super) fn overrides(&self, config: &Config) -> Result<FrameOverrides, Error> {
        let scale = config.time_scale()?;
        if let Some(gain) = self.gain.filter(|gain| !(*gain > 0.0 && gain.is_finite())) {
            return Err(Error::invalid("gain", format_args!("{gain} e/count"), "above 0 e/count"));
        }
        if let Some(level) = self.saturation.filter(|level| !(*level > 0.0 && level.is_finite())) {
            return Err(Error::invalid("saturation", format_args!("{level}"), "above 0, in the unit of the frame"));
        }
        let zero_point = self.zero_point.map(|mag| (mag, CountBasis::Frame));
        Ok(FrameOverrides {
            start: self.start.as_deref().map(|start| parse_start(start, scale)).transpose()?,
            duration_s: self.exposure.as_deref().map(parse_exposure_s).transpose()?,
            hdus: self.hdu.clone(),
            zero_point: zero_point.or(self.zero_point_1s.map(|mag| (mag, CountBasis::Second))),
            gain_e_adu: self.gain,
            saturation: self.saturation,
            pixel_scale_arcsec: None,
        })
    }

    /// Opens a frame; returns it and whether it has a zero point.
    pub(super) fn open(&self, path: &Path, given: &FrameOverrides) -> Result<(TargetFrame, bool), Error> {
        let has_given = given.zero_point.is_some();
        let is_calibrated = self.stars.is_none() && (has_given || has_zero_point(path, &self.hdu)?);
        // Magnitude 0 for one count: -2.5 log10 of the counts.
        let zero_point = if is_calibrated { given.zero_point } else { Some((0.0, CountBasis::Frame)) };
        Ok((TargetFrame::open(path, &FrameOverrides { zero_point, ..given.clone() })?, is_calibrated))
    }

    /// Returns the optics, and whether their seeing is given.
    pub(super) fn optics(&self, config: &Config, frame: &TargetFrame) -> Result<(Optics, bool), Error> {
        let telescope = config.telescope()?;
        let given = self.seeing.as_deref().map(|text| parse_angle_deg("seeing", text)).transpose()?;
        let given = given.map(|deg| deg * 3600.0).or(telescope.as_ref().map(|telescope| telescope.seeing_arcsec));
        let scale_arcsec = frame.chips.first().map_or(1.0, |target| target.chip.pixel_scale_arcsec());
        let optics = Optics {
            form: seeing_form(self.psf.as_deref().unwrap_or("moffat"))?,
            seeing_arcsec: given.unwrap_or(SEEING_PIX * scale_arcsec),
            outer_radius_m: telescope.as_ref().map_or(0.0, |telescope| telescope.outer_radius_m),
            inner_radius_m: telescope.as_ref().map_or(0.0, |telescope| telescope.inner_radius_m),
        };
        Ok((optics, given.is_some()))
    }
}

/// Adds the rows of frames that cannot be used to the invalid ones, and returns those of the given frames.
///
/// # Errors
/// The reason of the first given frame, if no frame is measured.
fn leave_out(
    failed: Vec<FrameError>,
    given: &[PathBuf],
    listed: &mut MeasuredTables,
) -> Result<Vec<FrameError>, Error> {
    let (unusable, of_rows): (Vec<FrameError>, Vec<FrameError>) =
        failed.into_iter().partition(|(path, _)| given.contains(path));
    // The rows that name a frame which cannot be used are invalid, not the request.
    of_rows.iter().for_each(|(path, error)| listed.leave_out_rows_of(path, error));
    match unusable.first() {
        Some((_, first)) if listed.frames.is_empty() => Err(first.clone()),
        _ => Ok(unusable),
    }
}

/// Returns true if an image of the file, or its primary header, has a zero point.
fn has_zero_point(path: &Path, hdus: &[usize]) -> Result<bool, Error> {
    let file = FrameFile::open(path)?;
    let images = if hdus.is_empty() { file.frame_images()?.frames } else { hdus.to_vec() };
    for hdu in images {
        if Calibration::from_headers(&[file.header(hdu)?, file.header(0)?]).zero_point.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Checks that a frame is of the years of the ephemeris of Sun and Earth.
pub(super) fn check_years(frame: &TargetFrame) -> Result<(), Error> {
    let times = [frame.opened, seconds_after(frame.opened, frame.exposure_s)];
    match times.into_iter().find(|time| !is_covered(*time)) {
        Some(time) => Err(no_ephemeris(time.to_time_scale(TimeScale::UTC)).in_file("", frame.file.path())),
        None => Ok(()),
    }
}

/// Returns the configuration. If it has no site, sets that of the first header that has one, and also returns a remark
/// with that site. Frames whose headers have another site, or none, are moved to `failed`.
///
/// # Errors
/// There is no site.
pub(super) fn with_site(
    config: &Config,
    frames: &mut Vec<(TargetFrame, bool)>,
    failed: &mut Vec<FrameError>,
) -> Result<(Config, Option<String>), Error> {
    if !config.takes_site_of_frame() {
        return Ok((config.clone(), None));
    }
    let mut first: Option<(HeaderSite, PathBuf)> = None;
    let mut with_sites = Vec::new();
    for (frame, is_calibrated) in frames.drain(..) {
        let path = frame.file.path().to_owned();
        match frame.site() {
            Ok(site) => {
                first = first.or_else(|| site.clone().map(|site| (site, path)));
                with_sites.push(((frame, is_calibrated), site));
            }
            Err(error) => failed.push((path, error)),
        }
    }
    for (frame, own) in with_sites {
        let path = frame.0.file.path();
        match first.as_ref().and_then(|(site, of)| Some(other_site(own.as_ref(), site, of)?.in_file("", path))) {
            Some(error) => failed.push((path.to_owned(), error)),
            None => frames.push(frame),
        }
    }
    let path = match (&first, frames.first()) {
        (Some((_, path)), _) => path,
        (None, Some((frame, _))) => frame.file.path(),
        (None, None) => return Ok((config.clone(), None)),
    };
    let unused = frames.first().and_then(|(frame, _)| frame.unused_coordinates());
    config.at_site_of_header(first.as_ref().map(|(site, _)| site), unused, &path.display().to_string())
}

/// Returns the error of a site in a header that is not `site`, which is that of the frame `of`; `None` if it is the
/// same.
fn other_site(own: Option<&HeaderSite>, site: &HeaderSite, of: &Path) -> Option<Error> {
    let given = match own.map(|own| own.site.distance_km(&site.site)) {
        Some(distance_km) if distance_km <= ONE_SITE_KM => return None,
        Some(distance_km) => format!("{distance_km:.0} km from that of {}", of.display()),
        None => "missing".to_owned(),
    };
    Some(Error::invalid(
        "the site in the header",
        given,
        "one run for each site, or --site or --lat and --lon for all frames",
    ))
}
