//! Options of masks of the streaks in frames, and their execution.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use serde_json::json;

use super::document::Config;
use super::error::ConfigError;
use super::injection_plan::SkyOf;
use super::measure::{MeasureConfig, photometry, with_site};
use super::prepared::{PreparedSky, state_scales};
use super::values::parse_angle_deg;
use crate::frames::seconds_after;
use crate::images::{Header, ImageValues};
use crate::output::{Provenance, Table, counted};
use crate::streaks::{
    ArrayFrame, FrameMask, MaskBit, MaskOptions, MaskedStreak, MeasuredStreak, NotMasked, Omitted, PlaneChoice,
    StreakOrigin, TargetFrame, corridor_table, mask_frame, mask_history, omitted_table, read_measured_streaks,
    region_file, write_mask_file, write_mask_planes,
};
use crate::watch::Watch;

/// Smallest probability of a crossing with which satellites are masked, if none is given.
const MIN_PROBABILITY: f64 = 0.01;
/// Largest share of a chip that is masked without a warning.
const LARGE_SHARE: f64 = 0.5;
/// Share of the requested coverage below which there is a warning.
const LEAST_COVERED: f64 = 0.9;
/// Number of satellites of one kind that a message names.
const NAMED: usize = 3;

/// Frames and options of masks, in addition to [`Config`].
///
/// ```
/// let mask: streakcast::config::MaskConfig = serde_json::from_str(r#"{"image": ["a.fits"], "seeing": "1arcsec"}"#)?;
/// assert_eq!((mask.coverage, mask.threshold), (0.95, 1.0));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
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
    /// position with this probability, and the width of a streak that is brighter with the remaining probability
    #[cfg_attr(feature = "cli", arg(long, value_name = "P", default_value_t = COVERAGE, help_heading = "Width"))]
    pub coverage: f64,
    /// Mask the light down to this multiple of the local noise of a pixel, 0.01 to 100; fainter satellites are left out
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", default_value_t = THRESHOLD, help_heading = "Width"))]
    pub threshold: f64,
    /// Full width of the light of all streaks with its unit, instead of the width from brightness, seeing and noise; no
    /// satellite is left out as too faint
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "ANGLE",
            conflicts_with_all = ["threshold", "seeing", "psf", "zero_point", "zero_point_1s"],
            help_heading = "Width"
        )
    )]
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
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "MAG",
            allow_hyphen_values = true,
            conflicts_with = "zero_point",
            help_heading = "Width"
        )
    )]
    pub zero_point_1s: Option<f64>,
    /// Mask planes of the frame, by the number or the name of their HDUs: write a copy of the frame in which a bit of
    /// these planes is set, instead of a file of masks
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "HDU", num_args = 1.., value_delimiter = ',', requires = "output", help_heading = "Output")
    )]
    pub into: Vec<String>,
    /// Bit of --into: the name of a plane in the MP_ keywords of the mask (a free bit if it is new), or a number; STREAK
    /// if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME", requires = "into", help_heading = "Output"))]
    pub bit: Option<String>,
}

const COVERAGE: f64 = 0.95;
const THRESHOLD: f64 = 1.0;

impl Default for MaskConfig {
    fn default() -> Self {
        Self {
            image: Vec::new(),
            hdu: Vec::new(),
            start: None,
            exposure: None,
            coverage: COVERAGE,
            threshold: THRESHOLD,
            width: None,
            seeing: None,
            psf: None,
            zero_point: None,
            zero_point_1s: None,
            into: Vec::new(),
            bit: None,
        }
    }
}

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
    /// Warnings.
    pub warnings: Vec<String>,
}

impl Masks {
    /// Returns the corridors of all frames, one row for each polygon.
    pub fn corridors(&self) -> Table {
        let of = |one: &MaskedFrame| corridor_table(&one.frame, &one.image, &one.mask);
        joined(self.frames.iter().map(of))
    }

    /// Returns the satellites that are left out, with the reasons.
    pub fn left_out(&self) -> Table {
        joined(self.frames.iter().map(|one| omitted_table(&one.image, &one.mask.omitted)))
    }

    /// Returns a region file of SAOImage DS9 with all corridors.
    pub fn regions(&self) -> String {
        region_file(self.frames.iter().map(|one| (&one.frame, one.image.as_str(), &one.mask)))
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
    /// A frame has no image, world coordinates, time, site or zero point, a value is out of range, or a file cannot be
    /// read or written.
    pub fn mask(
        &self,
        config: &Config,
        sky: Option<SkyOf<'_>>,
        outputs: &[PathBuf],
        watch: &Watch,
    ) -> Result<Masks, ConfigError> {
        self.check()?;
        let (planes, bit) = (self.planes(), self.bit()?);
        let of_frames = self.of_frames();
        let frames = self.image.iter().map(|path| self.open(&of_frames, path, config));
        let frames: Vec<(TargetFrame, bool)> = frames.collect::<Result<_, _>>()?;
        let (Some(first), Some(last)) = (
            frames.iter().map(|(frame, _)| frame.opened).min(),
            frames.iter().map(|(frame, _)| seconds_after(frame.opened, frame.exposure_s)).max(),
        ) else {
            return Err(ConfigError::invalid("missing frames; specify FRAME..., FITS files"));
        };
        let measured = config.measured.iter().map(|path| read_measured_streaks(path)).collect::<Result<Vec<_>, _>>()?;
        let measured: Vec<MeasuredStreak> = measured.concat();
        let (config, remark) = with_site(config, &frames)?;
        let of_all: Arc<PreparedSky> = match sky {
            Some(sky) => sky(first)?,
            None => Arc::new(config.prepare(first, last)?),
        };
        // The warnings of a given sky are not repeated here.
        let mut warnings = if sky.is_some() { Vec::new() } else { of_all.warnings.clone() };
        let mut remarks: Vec<String> = remark.into_iter().collect();
        let mut done = Vec::new();
        for (index, (frame, _)) in frames.into_iter().enumerate() {
            let prepared = sky.map_or_else(|| Ok(of_all.clone()), |sky| sky(frame.opened))?;
            let options = self.options(&config, &of_frames, &frame)?;
            let own: Vec<MeasuredStreak> =
                measured.iter().filter(|streak| streak.is_of(frame.file.path())).cloned().collect();
            let mask = mask_frame(&prepared.sky.watched(watch), &frame, &own, &options)?;
            let shown = frame.file.path().display().to_string();
            let ignored = frame.left_out.iter().map(|(hdu, error)| format!("{shown}: HDU {hdu} is ignored: {error}"));
            warnings.extend(ignored);
            remarks.extend(frame.images.summary().map(|summary| format!("{shown}: {summary}")));
            warnings.extend(doubts(&shown, &frame, &mask, &options));
            warnings.extend(
                prepared.sky.predictability(frame.opened).reason().map(|reason| {
                    format!("{shown}: {reason}: the mask is incomplete; specify element sets of that time")
                }),
            );
            if let Some(output) = outputs.get(index) {
                let history = mask_history(&prepared.provenance, &mask, &options);
                if planes.is_empty() {
                    write_mask_file(&frame, &mask, &history, output)?;
                } else {
                    write_mask_planes(&frame, &mask, (&planes, &bit), &history, output)?;
                }
            }
            done.push(MaskedFrame { summary: summary(&frame, &mask), image: shown, frame, mask });
        }
        let not_used =
            measured.iter().filter(|streak| !done.iter().any(|one| streak.is_of(one.frame.file.path()))).count();
        if not_used > 0 {
            let streaks = counted(not_used, "measured streak is", "measured streaks are");
            warnings.push(format!("{streaks} of other frames"));
        }
        let scale = config.given_time_scale().unwrap_or("utc").to_ascii_lowercase();
        let mut provenance = of_all.provenance.clone();
        state_scales(&mut provenance, &scale, &config.photometry()?);
        provenance.state(
            "options",
            json!({
                "frames": done.iter().map(|one| one.image.clone()).collect::<Vec<_>>(),
                "coverage": self.coverage,
                "threshold": self.threshold,
                "width": self.width,
                "min_probability": config.min_probability.unwrap_or(MIN_PROBABILITY),
            }),
        );
        Ok(Masks { frames: done, provenance, remarks, warnings })
    }

    /// Returns the masks of an image in memory, which is named `frame` in tables. `cards` are its header; `scratch` is a
    /// folder for temporary files.
    ///
    /// # Errors
    /// The errors of [`mask`](Self::mask).
    pub fn mask_array(
        &self,
        config: &Config,
        sky: Option<SkyOf<'_>>,
        (image, cards): (&ImageValues, &Header),
        scratch: &Path,
        watch: &Watch,
    ) -> Result<Masks, ConfigError> {
        let file = ArrayFrame::new(image, cards, scratch)?;
        let mut masks = Self { image: vec![file.input()], ..self.clone() }.mask(config, sky, &[], watch)?;
        masks.frames.iter_mut().for_each(|one| one.image = "frame".to_owned());
        Ok(masks)
    }

    fn check(&self) -> Result<(), ConfigError> {
        let limits = [("coverage", self.coverage, 0.5..=0.999), ("threshold", self.threshold, 0.01..=100.0)];
        for (what, given, allowed) in limits {
            if !allowed.contains(&given) {
                let (least, most) = (allowed.start(), allowed.end());
                return Err(ConfigError::invalid(format!("{what} is {given}; allowed: {least} to {most}")));
            }
        }
        if self.bit.is_some() && self.into.is_empty() {
            return Err(ConfigError::invalid("--bit is given without --into; allowed: with --into"));
        }
        Ok(())
    }

    fn planes(&self) -> Vec<PlaneChoice> {
        let choice = |text: &String| text.parse().map_or_else(|_| PlaneChoice::Name(text.clone()), PlaneChoice::Number);
        self.into.iter().map(choice).collect()
    }

    fn bit(&self) -> Result<MaskBit, ConfigError> {
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
            return Err(ConfigError::invalid(format!(
                "bit is '{given}'; allowed: a number, or a name of letters, digits and underscores, for example STREAK"
            )));
        }
        Ok(MaskBit::Named(name))
    }

    /// Returns the options that masks and measurements have in common.
    fn of_frames(&self) -> MeasureConfig {
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
        of_frames: &MeasureConfig,
        path: &Path,
        config: &Config,
    ) -> Result<(TargetFrame, bool), ConfigError> {
        let (frame, is_calibrated) = of_frames.open(path, config)?;
        if !is_calibrated && self.width.is_none() {
            return Err(ConfigError::invalid(format!(
                "{}: missing zero point, which relates magnitudes to counts; specify --zero-point, --zero-point-1s, or \
                 --width to mask all streaks with one width",
                path.display()
            )));
        }
        Ok((frame, is_calibrated))
    }

    fn options(
        &self,
        config: &Config,
        of_frames: &MeasureConfig,
        frame: &TargetFrame,
    ) -> Result<MaskOptions, ConfigError> {
        let width_arcsec = self.width.as_deref().map(|text| parse_angle_deg("width", text)).transpose()?;
        let (optics, is_known) = of_frames.optics(config, frame)?;
        if !is_known && width_arcsec.is_none() {
            return Err(ConfigError::invalid(
                "missing seeing; specify --seeing 1.2arcsec, --telescope NAME, which also sets the defocus, or --width to \
                 mask all streaks with one width",
            ));
        }
        let min_probability = config.min_probability.unwrap_or(MIN_PROBABILITY);
        if !(min_probability > 0.0 && min_probability <= 1.0) {
            return Err(ConfigError::invalid(format!(
                "min-probability is {min_probability}; allowed: above 0, at most 1"
            )));
        }
        Ok(MaskOptions {
            coverage: self.coverage,
            threshold: self.threshold,
            min_probability,
            width_arcsec: width_arcsec.map(|deg| 3600.0 * deg),
            optics,
            photometry: photometry(config, frame)?,
        })
    }
}

/// Returns warnings about corridors that cover less than requested, and about large masks.
fn doubts(shown: &str, frame: &TargetFrame, mask: &FrameMask, options: &MaskOptions) -> Vec<String> {
    let mut doubts = Vec::new();
    let least = LEAST_COVERED * options.coverage;
    let less: Vec<&str> =
        mask.streaks.iter().filter(|streak| streak.coverage < least).map(|streak| &*streak.name).collect();
    if let Some(lowest) = mask.streaks.iter().map(|streak| streak.coverage).min_by(f64::total_cmp)
        && !less.is_empty()
    {
        doubts.push(format!(
            "{shown}: the masks of {} contain the streak with a probability below {least:.2}, the lowest is {lowest:.2}: \
             these satellites may have manoeuvred, or be more than 300 s early or late",
            named(&less),
        ));
    }
    let large = frame.chips.iter().enumerate().filter(|(index, target)| {
        mask.area(*index).pixels() as f64 > LARGE_SHARE * target.chip.light_area.pixels() as f64
    });
    let hdus: Vec<usize> = large.map(|(_, target)| target.chip.hdu).collect();
    if let Some(first) = hdus.first() {
        let others = if hdus.len() > 1 { format!(" and of {} other HDUs", hdus.len() - 1) } else { String::new() };
        let of = |value: fn(&MaskedStreak) -> f64| mask.streaks.iter().map(value).fold(0.0, f64::max);
        let (late_s, across_arcsec) = (of(|one| one.late_s[1]), of(|one| one.across_rad.to_degrees() * 3600.0));
        doubts.push(format!(
            "{shown}: more than half of the pixels of HDU {first}{others} are masked, with delays up to {late_s:.0} s and \
             distances from the track up to {across_arcsec:.0} arcsec; specify newer element sets, a larger \
             --min-probability or a smaller --coverage"
        ));
    }
    doubts
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
    type IsKind = fn(&NotMasked) -> bool;
    let kinds: [(&str, IsKind); 4] = [
        ("too faint", |reason| matches!(reason, NotMasked::Faint { .. })),
        ("of unknown magnitude", |reason| *reason == NotMasked::UnknownMagnitude),
        ("of unknown position", |reason| matches!(reason, NotMasked::UnknownPosition(_))),
        ("measured without an element set", |reason| *reason == NotMasked::NoElements),
    ];
    for (what, is_kind) in kinds {
        let of_kind: Vec<&Omitted> = mask.omitted.iter().filter(|one| is_kind(&one.reason)).collect();
        if !of_kind.is_empty() {
            let names: Vec<String> = of_kind
                .iter()
                .take(NAMED)
                .map(|one| if one.name.is_empty() { one.norad_id.to_string() } else { one.name.to_string() })
                .collect();
            let more = if of_kind.len() > NAMED { ", ..." } else { "" };
            parts.push(format!("{} {what} left out: {}{more}", of_kind.len(), names.join(", ")));
        }
    }
    parts.join("; ")
}

fn named(names: &[&str]) -> String {
    let more = if names.len() > NAMED { ", ..." } else { "" };
    let shown: Vec<&str> = names.iter().take(NAMED).copied().collect();
    format!("{} ({}{more})", counted(names.len(), "streak", "streaks"), shown.join(", "))
}
