//! Options of masks of the streaks in frames, and their execution.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use serde_json::json;

use super::document::Config;
use super::error::request;
use super::injection_plan::SkyOf;
use super::measure::{MeasureConfig, check_years, with_site};
use super::measure_frame::{frame_warnings, photometry};
use super::prepared::PreparedSky;
use super::required::FRAMES;
use super::values::parse_angle_deg;
use super::warnings::first_of;
use crate::error::Error;
use crate::frames::seconds_after;
use crate::output::{Provenance, Table, counted};
use crate::streaks::{
    ChosenPlanes, FrameMask, FrameOverrides, LeftOutReason, MaskBit, MaskOptions, MaskedStreak, MeasuredStreak,
    PlaneChoice, StreakOrigin, TargetFrame, UnusedReason, corridor_table, is_same_file_name, left_out_table,
    mask_frame, mask_history, missing_zero_point, read_measured_streaks, region_file, write_mask_file,
    write_mask_planes,
};
use crate::watch::Watch;

/// Smallest probability of a crossing with which satellites are masked, if none is given.
const MIN_PROBABILITY: f64 = 0.01;
/// Largest share of a chip that is masked without a warning.
const LARGE_SHARE: f64 = 0.5;
/// Share of the requested coverage below which there is a warning.
const LEAST_COVERED: f64 = 0.9;

/// Frames and options of masks, in addition to [`Config`].
///
/// ```
/// let mask: streakcast::config::MaskConfig = serde_json::from_str(r#"{"image": ["a.fits"], "seeing": "1arcsec"}"#)?;
/// assert_eq!((mask.image.len(), mask.threshold), (1, None));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct MaskConfig {
    /// Frames (FITS) with world coordinates, including mosaics and tile-compressed .fz
    #[cfg_attr(feature = "cli", arg(value_name = "FRAME"))]
    pub image: Vec<PathBuf>,
    /// HDUs to use, counted from 0; all images with world coordinates if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", num_args = 1.., value_delimiter = ','))]
    pub hdu: Vec<usize>,
    /// Shutter opening, for example 2020-03-06T00:04:15.410Z; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub start: Option<String>,
    /// Exposure time with its unit, for example 30s or 2min; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub exposure: Option<String>,
    /// Probability that the streak of a satellite is in its mask, 0.5 to 0.999: the mask covers the errors of the
    /// position with this probability, and the width of a streak that is brighter with the remaining probability; 0.95
    /// if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "P", help_heading = "Width"))]
    pub coverage: Option<f64>,
    /// Mask the light down to this multiple of the local noise of a pixel, 0.01 to 100; fainter satellites are left
    /// out; 1 if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", help_heading = "Width"))]
    pub threshold: Option<f64>,
    /// Full width of the light of all streaks with its unit, instead of the width from brightness, seeing and noise; no
    /// satellite is left out as too faint
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", help_heading = "Width"))]
    pub width: Option<String>,
    /// Seeing: FWHM of a star's image with its unit, for example 1.2arcsec; that of --telescope if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", help_heading = "Width"))]
    pub seeing: Option<String>,
    /// Point spread function: gaussian, moffat (β 3.5), moffat:BETA, double; moffat if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "FORM", help_heading = "Width"))]
    pub psf: Option<String>,
    /// Zero point: magnitude of a star with a total of 1 in the frame's unit; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Width"))]
    pub zero_point: Option<f64>,
    /// Zero point for 1 count per second, instead of --zero-point
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Width"))]
    pub zero_point_1s: Option<f64>,
    /// Mask planes of the frame, by the number or the name of their HDUs: write a copy of the frame in which a bit of
    /// these planes is set, instead of a file of masks
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "HDU", num_args = 1.., value_delimiter = ',', requires = "output", help_heading = "Output")
    )]
    pub into: Vec<String>,
    /// Bit of --into: the name of a plane in the MP_ keywords of the mask (a free bit if it is new), or a number;
    /// STREAK if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME", help_heading = "Output"))]
    pub bit: Option<String>,
}

const COVERAGE: f64 = 0.95;
const THRESHOLD: f64 = 1.0;

/// Mask of one frame.
#[derive(Clone, Debug)]
pub struct MaskedFrame {
    /// The frame.
    pub frame: TargetFrame,
    /// Name of the frame in tables.
    pub image: String,
    /// Corridors, and satellites that are left out.
    pub mask: FrameMask,
    /// Summary in one line.
    pub summary: String,
}

/// Masks of several frames.
#[derive(Clone, Debug)]
pub struct Masks {
    /// Masks, in the order of the frames.
    pub frames: Vec<MaskedFrame>,
    /// Provenance of the result.
    pub provenance: Provenance,
    /// Remarks about the site and the planes of the frames.
    pub remarks: Vec<String>,
    /// Those of the remarks that state a choice between values in headers.
    pub choices: Vec<String>,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl Masks {
    /// Returns the corridors of all frames, one row for each polygon.
    pub fn corridors(&self) -> Table {
        let of = |masked: &MaskedFrame| corridor_table(&masked.frame, &masked.image, &masked.mask);
        joined(self.frames.iter().map(of))
    }

    /// Returns the satellites that are left out, with the reasons.
    pub fn left_out(&self) -> Table {
        joined(self.frames.iter().map(|masked| left_out_table(&masked.image, &masked.mask.left_out)))
    }

    /// Returns a region file of SAOImage DS9 with all corridors.
    pub fn regions(&self) -> String {
        region_file(self.frames.iter().map(|masked| (&masked.frame, masked.image.as_str(), &masked.mask)))
    }
}

fn joined(tables: impl Iterator<Item = Table>) -> Table {
    let mut all = Table { columns: Vec::new(), rows: Vec::new() };
    for table in tables {
        all.columns = table.columns;
        all.rows.extend(table.rows);
    }
    all
}

impl MaskConfig {
    /// Opens the frames and computes the masks of the streaks in them. `outputs`, if not empty, has a file for the mask
    /// of each frame, or with `into` for its copy.
    ///
    /// `sky` returns the sky of the night of a frame; by default it is prepared from the configuration for all frames.
    ///
    /// # Errors
    /// A frame has no image, world coordinates, time or site, or no zero point for a predicted streak; no site is
    /// given, and frames are of several; a value is out of range; or a file cannot be read or written.
    pub fn mask(
        &self,
        config: &Config,
        sky: Option<SkyOf<'_>>,
        outputs: &[PathBuf],
        watch: &Watch,
    ) -> Result<Masks, Error> {
        self.check()?;
        let (planes, bit) = (self.planes(), self.bit()?);
        let frame_config = self.frame_config();
        let overrides = frame_config.overrides(config)?;
        let frames = self.image.iter().map(|path| self.open(&frame_config, &overrides, path, config));
        let mut frames: Vec<(TargetFrame, bool)> = frames.collect::<Result<_, _>>()?;
        let mut other_sites = Vec::new();
        let (config, remark) = with_site(config, &mut frames, &mut other_sites)?;
        if let Some((_, error)) = other_sites.into_iter().next() {
            return Err(error);
        }
        let count = frames.len();
        // Planes of all frames are checked before a mask is computed and written.
        let planes_of = |(frame, _): &(TargetFrame, bool)| {
            (!planes.is_empty()).then(|| ChosenPlanes::new(frame, &planes, &bit)).transpose()
        };
        let planes: Vec<Option<ChosenPlanes>> = frames.iter().map(planes_of).collect::<Result<_, _>>()?;
        let (Some(first), Some(last)) = (
            frames.iter().map(|(frame, _)| frame.opened).min(),
            frames.iter().map(|(frame, _)| seconds_after(frame.opened, frame.exposure_s)).max(),
        ) else {
            return Err(FRAMES.missing());
        };
        let tables = config.measured.iter().map(|path| read_measured_streaks(path)).collect::<Result<Vec<_>, _>>()?;
        let measured: Vec<MeasuredStreak> = tables.iter().flat_map(|table| table.streaks.iter().cloned()).collect();
        let shared_sky: Arc<PreparedSky> = match sky {
            Some(sky) => sky(first)?,
            None => Arc::new(config.prepare(first, last)?),
        };
        // The warnings of a given sky are not repeated here.
        let mut warnings = if sky.is_some() { Vec::new() } else { shared_sky.warnings.clone() };
        let (mut remarks, mut choices): (Vec<String>, Vec<String>) = (remark.into_iter().collect(), Vec::new());
        let batch = |error: Error, done: usize| match done {
            1.. if !outputs.is_empty() => crate::streaks::partly_written(error, done, count),
            _ => error,
        };
        let mut done = Vec::new();
        for (index, (frame, is_calibrated)) in frames.into_iter().enumerate() {
            let prepared = sky.map_or_else(|| Ok(shared_sky.clone()), |sky| sky(frame.opened))?;
            let options = MaskOptions { is_calibrated, ..self.options(&config, &frame_config, &frame)? };
            let own: Vec<MeasuredStreak> =
                measured.iter().filter(|streak| streak.is_of(frame.file.path())).cloned().collect();
            let mask = mask_frame(&prepared.sky.watched(watch), &frame, &own, &options)
                .map_err(|error| batch(error, index))?;
            let shown = frame.file.path().display().to_string();
            let ignored = frame.left_out.iter().map(|(hdu, error)| format!("{shown}: HDU {hdu} is ignored: {error}"));
            warnings.extend(ignored);
            remarks.extend(frame.remarks());
            choices.extend(frame.choices());
            warnings.extend(mask_warnings(&shown, &frame, &mask, &options));
            warnings.extend(frame_warnings(&prepared.sky, &frame));
            warnings.extend(
                prepared.sky.predictability(frame.opened, None).reason().map(|reason| {
                    format!("{shown}: {reason}: the mask is incomplete; specify element sets of that time")
                }),
            );
            let mut summary = summary(&frame, &mask);
            if let Some(output) = outputs.get(index) {
                let history = mask_history(&prepared.provenance, &mask, &options);
                let written = match &planes[index] {
                    None => write_mask_file(&frame, &mask, &history, output),
                    Some(planes) => {
                        summary += &format!("; bit {}", planes.bit());
                        write_mask_planes(&frame, &mask, planes, &history, output)
                    }
                };
                written.map_err(|error| batch(error, index))?;
            }
            done.push(MaskedFrame { summary, image: shown, frame, mask });
        }
        let not_used =
            measured.iter().filter(|streak| !done.iter().any(|masked| streak.is_of(masked.frame.file.path()))).count();
        if not_used > 0 {
            let streaks = counted(not_used, "measured streak is", "measured streaks are");
            warnings.push(format!("{streaks} of other frames"));
        }
        for (path, table) in config.measured.iter().zip(&tables) {
            let of_frames = table
                .without_satellite
                .iter()
                .filter(|[image, _]| done.iter().any(|masked| is_same_file_name(image, masked.frame.file.path())));
            let names: Vec<String> = of_frames.map(|[_, name]| name.clone()).collect();
            if !names.is_empty() {
                warnings.push(format!(
                    "{}: {} without a norad_id and therefore not masked: {}; complete norad_id (measure with --elements identifies streaks); trails of other objects need another mask",
                    path.display(),
                    counted(names.len(), "measured streak is", "measured streaks are"),
                    first_of(&names)
                ));
            }
        }
        let mut provenance = shared_sky.provenance.clone();
        config.state_scales(&mut provenance, &config.photometry()?);
        provenance.state(
            "options",
            json!({
                "frames": done.iter().map(|masked| masked.image.clone()).collect::<Vec<_>>(),
                "coverage": self.coverage(),
                "threshold": self.threshold(),
                "width": self.width,
                "min_probability": config.min_probability.unwrap_or(MIN_PROBABILITY),
            }),
        );
        Ok(Masks { frames: done, provenance, remarks, choices, warnings })
    }

    fn check(&self) -> Result<(), Error> {
        let limits = [("coverage", self.coverage(), 0.5..=0.999), ("threshold", self.threshold(), 0.01..=100.0)];
        for (what, given, allowed) in limits {
            if !allowed.contains(&given) {
                let (least, most) = (allowed.start(), allowed.end());
                return Err(request(format!("{what} is {given}")).allowing(format!("{least} to {most}")));
            }
        }
        if self.bit.is_some() && self.into.is_empty() {
            return Err(Error::invalid("--bit", "given without --into", "with --into"));
        }
        let of_light = [
            ("--threshold", self.threshold.is_some()),
            ("--seeing", self.seeing.is_some()),
            ("--psf", self.psf.is_some()),
            ("--zero-point", self.zero_point.is_some()),
            ("--zero-point-1s", self.zero_point_1s.is_some()),
        ];
        let mut given = of_light.into_iter().filter(|(_, is_given)| *is_given).map(|(flag, _)| flag);
        match given.next() {
            Some(flag) if self.width.is_some() => {
                Err(request(format!("{flag} has no effect with --width")).allowing("one of them"))
            }
            _ if self.zero_point.is_some() && self.zero_point_1s.is_some() => {
                Err(request("--zero-point and --zero-point-1s exclude each other").allowing("one of them"))
            }
            _ => Ok(()),
        }
    }

    fn coverage(&self) -> f64 {
        self.coverage.unwrap_or(COVERAGE)
    }

    fn threshold(&self) -> f64 {
        self.threshold.unwrap_or(THRESHOLD)
    }

    fn planes(&self) -> Vec<PlaneChoice> {
        let choice = |text: &String| text.parse().map_or_else(|_| PlaneChoice::Name(text.clone()), PlaneChoice::Number);
        self.into.iter().map(choice).collect()
    }

    fn bit(&self) -> Result<MaskBit, Error> {
        /// Longest name of a bit, so that its keyword has at most 40 characters.
        const LONGEST_NAME: usize = 32;
        let given = self.bit.as_deref().unwrap_or("STREAK").trim();
        if let Ok(number) = given.parse() {
            return Ok(MaskBit::Number(number));
        }
        let name = given.to_ascii_uppercase();
        let name = name.strip_prefix("MP_").unwrap_or(&name).to_owned();
        let is_word = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if name.is_empty() || name.len() > LONGEST_NAME || !is_word {
            return Err(Error::invalid(
                "bit",
                format_args!("'{given}'"),
                "a number, or a name of letters, digits and underscores, for example STREAK",
            ));
        }
        Ok(MaskBit::Named(name))
    }

    /// Returns the options that masks and measurements have in common.
    fn frame_config(&self) -> MeasureConfig {
        MeasureConfig {
            image: self.image.clone(),
            hdu: self.hdu.clone(),
            start: self.start.clone(),
            exposure: self.exposure.clone(),
            seeing: self.seeing.clone(),
            psf: self.psf.clone(),
            zero_point: self.zero_point,
            zero_point_1s: self.zero_point_1s,
            ..MeasureConfig::default()
        }
    }

    fn open(
        &self,
        frame_config: &MeasureConfig,
        overrides: &FrameOverrides,
        path: &Path,
        config: &Config,
    ) -> Result<(TargetFrame, bool), Error> {
        let (frame, is_calibrated) = frame_config.open(path, overrides)?;
        check_years(&frame)?;
        // Measured streaks can be masked without a zero point.
        if !is_calibrated && self.width.is_none() && config.measured.is_empty() {
            return Err(missing_zero_point(&frame, ""));
        }
        Ok((frame, is_calibrated))
    }

    fn options(
        &self,
        config: &Config,
        frame_config: &MeasureConfig,
        frame: &TargetFrame,
    ) -> Result<MaskOptions, Error> {
        let width_arcsec = self.width.as_deref().map(|text| parse_angle_deg("width", text)).transpose()?;
        let (optics, is_known) = frame_config.optics(config, frame)?;
        if !is_known && width_arcsec.is_none() {
            return Err(Error::missing(
                "seeing",
                "--seeing 1.2arcsec, --telescope NAME, which also sets the defocus, or --width to mask all streaks with one width",
            ));
        }
        let min_probability = config.min_probability.unwrap_or(MIN_PROBABILITY);
        if !(min_probability > 0.0 && min_probability <= 1.0) {
            return Err(Error::invalid("min-probability", min_probability, "above 0, at most 1"));
        }
        Ok(MaskOptions {
            coverage: self.coverage(),
            threshold: self.threshold(),
            min_probability,
            is_calibrated: true,
            width_arcsec: width_arcsec.map(|deg| 3600.0 * deg),
            optics,
            photometry: photometry(config, frame)?,
        })
    }
}

/// Returns warnings about corridors that cover less than requested, and about large masks.
fn mask_warnings(shown: &str, frame: &TargetFrame, mask: &FrameMask, options: &MaskOptions) -> Vec<String> {
    let mut warnings = unused_streaks(shown, mask);
    let least = LEAST_COVERED * options.coverage;
    let less = mask.streaks.iter().filter(|streak| streak.coverage < least);
    let less: Vec<String> = less.map(|streak| streak.norad_id.or_name(&streak.name)).collect();
    if let Some(lowest) = mask.streaks.iter().map(|streak| streak.coverage).min_by(f64::total_cmp)
        && !less.is_empty()
    {
        warnings.push(format!(
            "{shown}: the masks of {} contain the streak with a probability below {least:.2}, the lowest is {lowest:.2}: \
             these satellites may have manoeuvred, or be more than 300 s early or late",
            format_args!("{} ({})", counted(less.len(), "streak", "streaks"), first_of(&less)),
        ));
    }
    let large = frame.chips.iter().enumerate().filter(|(index, target)| {
        mask.area(*index).pixels() as f64 > LARGE_SHARE * target.chip.light_area.pixels() as f64
    });
    let hdus: Vec<usize> = large.map(|(_, target)| target.chip.hdu).collect();
    if let Some(first) = hdus.first() {
        let others = if hdus.len() > 1 { format!(" and of {} other HDUs", hdus.len() - 1) } else { String::new() };
        let of = |value: fn(&MaskedStreak) -> f64| mask.streaks.iter().map(value).fold(0.0, f64::max);
        let (late_s, across_arcsec) =
            (of(|streak| streak.late_s[1]), of(|streak| streak.across_rad.to_degrees() * 3600.0));
        warnings.push(format!(
            "{shown}: more than half of the pixels of HDU {first}{others} are masked, with delays up to {late_s:.1} s and \
             distances from the track up to {across_arcsec:.0} arcsec; specify --measured, newer element sets, a larger \
             --min-probability or a smaller --coverage"
        ));
    }
    warnings
}

fn summary(frame: &TargetFrame, mask: &FrameMask) -> String {
    let mut ids: Vec<u32> = mask.streaks.iter().map(|streak| streak.norad_id.0).collect();
    ids.sort_unstable();
    ids.dedup();
    let measured = mask.streaks.iter().filter(|streak| streak.origin == StreakOrigin::Measured).count();
    let areas = (0..frame.chips.len()).map(|index| mask.area(index).pixels());
    let (masked, all) =
        (areas.sum::<usize>(), frame.chips.iter().map(|target| target.chip.light_area.pixels()).sum::<usize>());
    let mut parts = vec![format!(
        "{}{} masked, {masked} pixels ({:.2} %)",
        counted(ids.len(), "satellite", "satellites"),
        if measured > 0 { format!(" ({measured} measured)") } else { String::new() },
        100.0 * masked as f64 / all.max(1) as f64
    )];
    type IsKind = fn(&LeftOutReason) -> bool;
    let kinds: [(&str, IsKind); 4] = [
        ("too faint", |reason| matches!(reason, LeftOutReason::Faint { .. })),
        ("of unknown magnitude", |reason| *reason == LeftOutReason::UnknownMagnitude),
        ("of unknown position", |reason| matches!(reason, LeftOutReason::UnknownPosition(_))),
        ("measured without an element set", |reason| *reason == LeftOutReason::NoElements),
    ];
    for (what, is_kind) in kinds {
        let of_kind = mask.left_out.iter().filter(|satellite| is_kind(&satellite.reason));
        let names: Vec<String> = of_kind.map(|satellite| satellite.norad_id.or_name(&satellite.name)).collect();
        if !names.is_empty() {
            parts.push(format!("{} {what} left out: {}", names.len(), first_of(&names)));
        }
    }
    parts.join("; ")
}

/// Returns warnings about measured streaks that are not used, one for each reason.
fn unused_streaks(shown: &str, mask: &FrameMask) -> Vec<String> {
    let mut by_reason: BTreeMap<UnusedReason, Vec<String>> = BTreeMap::new();
    for (streak, reason) in &mask.unused {
        by_reason.entry(*reason).or_default().push(streak.norad_id.or_name(&streak.name));
    }
    let warning = |(reason, names): (UnusedReason, Vec<String>)| {
        let streaks = counted(names.len(), "measured streak is", "measured streaks are");
        format!("{shown}: {streaks} not used, because {reason}: {}", first_of(&names))
    };
    by_reason.into_iter().map(warning).collect()
}
