//! `inject`: adds streaks of satellites, or random streaks, to frames.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use streakcast::Watch;
use streakcast::config::{Config, INJECTED_STREAKS, InjectionConfig, RequiredInput, SEEING, inject_frames};
use streakcast::output::Table;
use streakcast::streaks::{InjectedFrame, Injections};

use super::annotate::OUTPUT;
use crate::failure::Outcome;
use crate::files::check_distinct;
use crate::help::{FIELD_FLAGS, VerbFlags, help};
use crate::notices::Notices;
use crate::output::{Format, Output, VerbResult, check_whole};
use crate::output::{check, write_bytes};

#[derive(Args)]
pub struct InjectArguments {
    #[command(flatten)]
    pub injection: InjectionConfig,
    /// Output file; a folder for several frames
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Truth table: a file with the extension .csv, .ecsv, .json or .jsonl
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub truth: Option<PathBuf>,
    /// Trails for Rubin's source_injection: a CSV or ECSV file
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub trails: Option<PathBuf>,
    /// Picture of the frame, or of the chip with the longest streak: a .png file
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub preview: Option<PathBuf>,
    /// Picture as --preview, with the streaks marked
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub preview_marked: Option<PathBuf>,
    #[command(flatten)]
    pub config: Config,
}

const FRAMES: RequiredInput = RequiredInput::new("frames", &[&["--image FILE..."], &["--synthetic FILE"]]);

help! {
    InjectArguments, "inject", asks [OUTPUT, FRAMES],
    ignores [(FIELD_FLAGS, "has no effect on inject, where the frame is the field")],
    "--image frame.fits --random-streaks 3 --magnitude 5,8 --seeing 1.2arcsec -o streaks.fits --truth streaks.csv",
    "--image frame.fits --elements active.tle --mpc X05 --telescope rubin -o streaks.fits"
}

/// Paths of all output files.
pub struct Outputs {
    /// Output files of the frames.
    pub frames: Vec<PathBuf>,
    truth: Option<Output>,
    trails: Option<Output>,
}

impl Outputs {
    /// Returns the paths of all outputs, after checking them. No output may be one of `inputs`.
    pub fn new(typed: &InjectArguments, inputs: &[PathBuf]) -> anyhow::Result<Self> {
        let frames = frames(typed)?;
        frames.iter().try_for_each(|path| check_whole(path))?;
        let table_output = |path: &Option<PathBuf>| -> anyhow::Result<Option<Output>> {
            path.as_ref().map(|path| Output::new(text_format(path)?, Some(path.clone()))).transpose()
        };
        let outputs = Self { truth: table_output(&typed.truth)?, trails: table_output(&typed.trails)?, frames };
        let pictures = picture_names(typed)?;
        if outputs.frames.len() > 1 && !pictures.is_empty() {
            return Err(anyhow!(
                "--preview or --preview-marked is given for {} frames; allowed: with one frame",
                outputs.frames.len()
            ));
        }
        let tables = typed.truth.iter().chain(&typed.trails);
        let labels = typed.injection.label_paths(&outputs.frames)?;
        let all: Vec<&PathBuf> = outputs.frames.iter().chain(tables).chain(pictures).chain(&labels).collect();
        check_distinct(inputs, &all)?;
        Ok(outputs)
    }

    /// Writes the truth table and the table of trails, with the rows of all frames.
    pub fn write_tables(&self, done: &Injections, notices: &Notices) -> anyhow::Result<()> {
        type Choice = fn(&InjectedFrame) -> &Table;
        let truth: Choice = |frame| &frame.truth;
        let trails: Choice = |frame| &frame.trails;
        for (output, of, name) in [(&self.truth, truth, "streaks"), (&self.trails, trails, "trails")] {
            let mut frames = done.frames.iter().map(of);
            let (Some(output), Some(first)) = (output, frames.next()) else { continue };
            let mut table = first.clone();
            frames.for_each(|other| table.rows.extend(other.rows.iter().cloned()));
            output.write(&VerbResult::new(name, &table, &[], &done.provenance), notices)?;
        }
        Ok(())
    }
}

/// Returns the paths of the pictures, after checking their names.
fn picture_names(typed: &InjectArguments) -> anyhow::Result<Vec<&PathBuf>> {
    let pictures: Vec<&PathBuf> = typed.preview.iter().chain(&typed.preview_marked).collect();
    for picture in &pictures {
        if !picture.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            return Err(anyhow!("invalid picture {}; allowed: a file with the extension .png", picture.display()));
        }
        check(picture)?;
    }
    Ok(pictures)
}

/// Largest number of frames of one run.
const MOST_FRAMES: usize = 100_000;

/// Returns the format of a table by its extension, or an error if it is not a text format.
fn text_format(path: &Path) -> anyhow::Result<Option<&'static str>> {
    let end = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    match Format::by_name(&end) {
        Some(Format::Table) | None if end != "csv" => Err(anyhow!(
            "invalid table {}; allowed: a file with the extension .csv, .ecsv, .json or .jsonl",
            path.display()
        )),
        _ => Ok(None),
    }
}

fn frames(typed: &InjectArguments) -> anyhow::Result<Vec<PathBuf>> {
    let output = typed.output.clone().unwrap_or_default();
    let count = if typed.injection.synthetic.is_some() {
        typed.injection.frames.unwrap_or(1)
    } else {
        typed.injection.image.len()
    };
    if !(1..=MOST_FRAMES).contains(&count) {
        return Err(anyhow!("frames is {count}; allowed: 1 to {MOST_FRAMES}"));
    }
    frame_outputs(&output, &typed.injection.image, count)
}

/// Returns the output of each frame: the file of a single frame, or files in an existing folder (a new one may be meant
/// as a file) with the names of the input `images`, or with numbers if there are none.
pub fn frame_outputs(output: &Path, images: &[PathBuf], count: usize) -> anyhow::Result<Vec<PathBuf>> {
    if count == 1 && !output.is_dir() {
        return Ok(vec![output.to_owned()]);
    }
    if !output.is_dir() {
        return Err(anyhow!(
            "--output {} is not a folder; allowed for {count} frames: an existing folder",
            output.display()
        ));
    }
    let width = count.to_string().len().max(4);
    let name = |index: usize| match images.get(index) {
        Some(image) => image.file_name().map(OsStr::to_owned).unwrap_or_default(),
        None => format!("frame-{:0width$}.fits", index + 1).into(),
    };
    Ok((0..count).map(|index| output.join(name(index))).collect())
}

pub fn run(typed: InjectArguments) -> anyhow::Result<Outcome> {
    let config = typed.config.clone().with_file()?;
    let injection = &typed.injection;
    let has_streaks = injection.is_without_satellites() || config.has_satellites() || injection.magnitude.is_some();
    let has_seeing = injection.seeing.is_some() || config.telescope.is_some() || injection.has_psf_file();
    let answers = [
        (&FRAMES, !injection.image.is_empty() || injection.synthetic.is_some()),
        (&OUTPUT, typed.output.is_some()),
        (&INJECTED_STREAKS, has_streaks),
        (&SEEING, has_seeing),
    ];
    InjectArguments::HELP.check(&config, &answers)?;
    let notices = crate::start::begin(&config)?;
    let outputs = Outputs::new(&typed, &inputs(&typed, &config))?;
    reject_unused(&typed)?;
    let done = inject_frames(&typed.injection, &config, None, &outputs.frames, &Watch::default())?;
    for remark in &done.remarks {
        notices.info(remark);
    }
    notices.warn(&done.warnings);
    notices.warn_first(done.frames.iter().flat_map(|frame| frame.warnings.clone()), "warnings about frames");
    for frame in &done.frames {
        notices.info(&format!("wrote {}: {}", frame.output.display(), frame.summary));
    }
    for file in &done.labels {
        notices.wrote(&file.path);
    }
    pictures(&typed, &done, &notices)?;
    outputs.write_tables(&done, &notices)?;
    Ok(Outcome::Done)
}

/// Returns the paths of the input files, which outputs must not replace.
fn inputs(typed: &InjectArguments, config: &Config) -> Vec<PathBuf> {
    typed.injection.files().into_iter().chain(config.files()).chain(config.run.file.clone()).collect()
}

/// Shared settings without effect on streaks that are not of satellites.
#[rustfmt::skip]
const OF_SATELLITES: [&str; 18] = [
    "extinction", "sun_distance", "earthshine", "shadow", "qs_mag", "accept_bad_checksums", "eop", "site", "mpc", "lat",
    "lon", "height", "observer_elements", "observer_norad", "limb_height_km", "max_zenith_angle", "min_sun_angle",
    "min_limb_angle",
];

/// Rejects flags about satellites if random or chosen streaks are injected, because they have no effect then. The same
/// keys in a configuration file are accepted, because other verbs use them.
fn reject_unused(typed: &InjectArguments) -> anyhow::Result<()> {
    if typed.injection.has_psf_file() && typed.config.telescope.is_some() {
        return Err(anyhow!(
            "--telescope has no effect with a file of --psf; allowed: --psf gaussian, moffat or double"
        ));
    }
    if typed.injection.is_without_satellites()
        && let Some(key) = typed.config.given().into_iter().find(|key| OF_SATELLITES.contains(key))
    {
        let flag = if key == "earthshine" { "no-earthshine".to_owned() } else { key.replace('_', "-") };
        let streaks = if typed.injection.streaks.is_some() { "streaks of a table" } else { "random streaks" };
        return Err(anyhow!("--{flag} has no effect on {streaks}; allowed: with streaks of satellites"));
    }
    Ok(())
}

/// Writes pictures of the chip with the longest streak, or of the first chip if there is no streak.
fn pictures(typed: &InjectArguments, done: &Injections, notices: &Notices) -> anyhow::Result<()> {
    use streakcast::images::{FrameFile, Overlay, preview_png};
    let pictures = [(&typed.preview, false), (&typed.preview_marked, true)];
    // Pictures are only written for a single frame.
    let Some(frame) = done.frames.first().filter(|_| pictures.iter().any(|(path, _)| path.is_some())) else {
        return Ok(());
    };
    let file = FrameFile::open(&frame.output)?;
    let longest = frame.marks.iter().max_by(|a, b| a.length_pix.total_cmp(&b.length_pix)).map(|mark| mark.hdu);
    let Some(hdu) = longest.or_else(|| file.images().first().copied()) else { return Ok(()) };
    let plane = file.read_plane(hdu)?;
    for (path, is_marked) in pictures {
        let Some(path) = path else { continue };
        let marks = frame.marks.iter().filter(|mark| is_marked && mark.hdu == hdu);
        let overlays: Vec<Overlay> =
            marks.map(|mark| Overlay { line: mark.line.clone(), half_width_pix: mark.half_width_pix }).collect();
        write_bytes(path, &preview_png(&plane, &overlays)?, notices)?;
    }
    Ok(())
}
