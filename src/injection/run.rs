//! The way of the data: frames opened, light found, drawn and written.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::asked::Asked;
use super::error::InjectionError;
use super::frames::Frames;
use super::light::{Lights, SkyOf, history, is_seen, photometry_of, state};
use super::said::InjectionSaid;
use crate::config::Setup;
use crate::frames::Direction;
use crate::images::{FrameError, PixelPosition};
use crate::output::{AtomicFile, Column, Kind, Provenance, Table, Value};
use crate::streaks::{
    Chip, DrawnStreak, InjectOptions, Injected, MaskPlanes, Shot, Source, SourceName, TargetFrame, TruthRow,
    draw_on_chip, inject, points_table, trail_table, truth_rows, truth_table,
};

/// A streak's line on a chip, for pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The chip's HDU.
    pub hdu: usize,
    /// Points along it.
    pub line: Vec<PixelPosition>,
    /// What is marked on either side, pixels.
    pub half_width_pix: f64,
    /// Its length, pixels.
    pub length_pix: f64,
}

/// What was done to one frame.
#[derive(Clone, Debug)]
pub struct FrameDone {
    /// The file that was written.
    pub output: PathBuf,
    /// One row a streak and chip.
    pub truth: Table,
    /// The same as rows for Rubin's `source_injection`.
    pub trails: Table,
    /// Points along the streaks.
    pub points: Table,
    /// Where the streaks are.
    pub marks: Vec<Mark>,
    /// Bits of its masks.
    pub planes: MaskPlanes,
    /// In one line.
    pub words: String,
    /// What may be wrong.
    pub warnings: Vec<String>,
}

/// What was done.
#[derive(Clone, Debug)]
pub struct Injections {
    /// Frame by frame, in the order of the outputs.
    pub frames: Vec<FrameDone>,
    /// What was taken from where.
    pub remarks: Vec<String>,
    /// What may be wrong with all of them.
    pub warnings: Vec<String>,
    /// What they rest on.
    pub provenance: Provenance,
}

/// Puts streaks into frames: one output for each image, or for each synthetic frame.
///
/// `sky` makes that of the frames' night where the caller has one; else it is made of the setup, or of the observatory in the headers where the setup has no
/// site. Frames are worked on in the caller's pool of threads.
///
/// # Errors
/// [`InjectionError`]; each output is written whole or not at all. Where one cannot be (no folder, a pipe, a device, a packed one) nothing is read; where one frame of
/// several fails, others may stand already, and the error counts them.
pub fn inject_frames(
    said: &InjectionSaid,
    setup: &Setup,
    sky: Option<SkyOf<'_>>,
    outputs: &[PathBuf],
) -> Result<Injections, InjectionError> {
    for output in outputs {
        refuse_packed(output)?;
        AtomicFile::check(output).map_err(|source| FrameError::Io { path: output.clone(), source })?;
    }
    let asked = Asked::new(said, setup)?;
    let frames = Frames::open(said, setup, &asked, outputs)?;
    frames.refuse_plain(outputs)?;
    let known = frames.known();
    let left_out = known.iter().flat_map(|frame| {
        let shown = frame.file.path().display();
        frame.left_out.iter().map(move |(hdu, error)| format!("{shown}: HDU {hdu} is left out: {error}"))
    });
    let mut warnings: Vec<String> = left_out.collect();
    let (lights, notes) = Lights::prepare(setup, &asked, known, sky)?;
    warnings.extend(notes.warnings);

    let count = outputs.len();
    let whole = AtomicUsize::new(0);
    let done: Result<Vec<FrameDone>, InjectionError> = outputs
        .par_iter()
        .enumerate()
        .map(|(index, output)| {
            let seed = seed_of(said.seed, index, count);
            let done = frames.with(index, seed, |frame| one(said, setup, &asked, &lights, frame, output, seed));
            whole.fetch_add(usize::from(done.is_ok()), Ordering::Relaxed);
            done.map_err(|error| error.of_file(said.image.get(index).unwrap_or(output)))
        })
        .collect();
    let done = done.map_err(|error| error.of_batch(whole.into_inner(), count))?;

    let mut provenance = lights.provenance();
    if let Some(first) = known.first() {
        let (photometry, _) = photometry_of(setup, first)?;
        let image = said.image.first().or(said.synthetic.as_ref()).or(outputs.first());
        if let Some(image) = image {
            state(&mut provenance, first, image, &asked, &photometry, said.seed);
        }
    }
    let remarks = notes.remarks.into_iter().chain(known.iter().filter_map(overscan)).collect();
    Ok(Injections { frames: done, remarks, warnings, provenance })
}

/// Refuses names of what is not made: frames are never packed as a whole.
fn refuse_packed(output: &Path) -> Result<(), InjectionError> {
    let end = output.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    if ["gz", "bz2", "xz", "zip", "z"].contains(&end.as_str()) {
        let shown = output.display();
        return Err(InjectionError::said(format!(
            "{shown}: packed frames are not written; allowed: a name without .{end}, as .fits"
        )));
    }
    Ok(())
}

/// Which of a frame's pixels get no light.
fn overscan(frame: &TargetFrame) -> Option<String> {
    let is_cut = |chip: &&Chip| chip.light_area.pixels() < chip.rows * chip.columns;
    let cut: Vec<&Chip> = frame.chips.iter().map(|target| &target.chip).filter(is_cut).collect();
    let (first, area) = cut.first().map(|chip| (chip.hdu, chip.light_area.section()))?;
    let others = if cut.len() > 1 { format!(", {} others likewise", cut.len() - 1) } else { String::new() };
    let shown = frame.file.path().display();
    Some(format!("{shown}: HDU {first}: light falls on {area} alone, as the header says; overscan gets none{others}"))
}

fn one(
    said: &InjectionSaid,
    setup: &Setup,
    asked: &Asked,
    lights: &Lights,
    frame: &TargetFrame,
    output: &Path,
    seed: u64,
) -> Result<FrameDone, InjectionError> {
    let (photometry, unknown_filter) = photometry_of(setup, frame)?;
    let sources = lights.of(asked, frame, &photometry, said.resolve_panels, seed)?;
    let tracking = asked.tracking(frame.exposure_s);
    let (centre, _) = frame.circle().unwrap_or((Direction::from_lon_lat_rad(0.0, 0.0), 0.0));
    let shot = Shot {
        opened: frame.opened,
        exposure_s: frame.exposure_s,
        centre,
        tracking: &tracking,
        optics: &asked.optics,
        truth_points: said.truth_points,
    };
    let seen: Vec<&Source> = sources.iter().filter(|source| source.parts.iter().any(is_seen)).collect();
    let streaks: Vec<DrawnStreak<'_>> = frame
        .chips
        .par_iter()
        .map(|target| {
            let drawn = seen.par_iter().map(|source| draw_on_chip(source, &target.chip, &shot));
            Ok(drawn.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
        })
        .collect::<Result<Vec<Vec<_>>, InjectionError>>()?
        .into_iter()
        .flatten()
        .collect();
    let drawn = drawn_sources(&streaks);
    let planes = asked.preset.planes(&frame.mask_planes)?;
    let options = InjectOptions {
        noise: !said.no_noise,
        detector: asked.detector.clone().or(asked.synthetic.as_ref().map(|synthetic| synthetic.detector.clone())),
        seed,
        planes,
        tell: !said.pixels_only,
        history: history(&lights.provenance(), asked, &said.psf, &drawn, &streaks, seed),
    };
    let injected = inject(frame, &streaks, &options, output)?;
    let rows: Vec<TruthRow<'_>> = truth_rows(&streaks, frame.exposure_s, seed);
    let mark = |streak: &DrawnStreak<'_>| Mark {
        hdu: streak.hdu,
        line: streak.points.iter().map(|point| point.at).collect(),
        half_width_pix: 2.0 * streak.width_pix,
        length_pix: streak.length_pix,
    };
    Ok(FrameDone {
        output: output.to_owned(),
        truth: named(truth_table(&rows), output),
        trails: trail_table(&rows),
        points: points_table(&rows),
        marks: streaks.iter().map(mark).collect(),
        planes,
        words: words(&streaks, &drawn, &injected),
        warnings: unknown_filter.into_iter().chain(warnings(frame, &injected)).collect(),
    })
}

/// The truth of one frame; its file's name stands before each row.
fn named(mut truth: Table, frame: &Path) -> Table {
    let name = frame.file_name().unwrap_or_default().to_string_lossy().into_owned();
    truth.columns.insert(0, Column::new("image", Kind::Text, "File of the frame."));
    truth.rows.iter_mut().for_each(|row| row.insert(0, Value::Text(name.clone())));
    truth
}

/// The sources that left anything, each once.
fn drawn_sources<'a>(streaks: &[DrawnStreak<'a>]) -> Vec<&'a Source> {
    let mut sources: Vec<&Source> = Vec::new();
    for streak in streaks {
        if !sources.iter().any(|source| std::ptr::eq(*source, streak.source)) {
            sources.push(streak.source);
        }
    }
    sources
}

fn words(streaks: &[DrawnStreak<'_>], sources: &[&Source], injected: &Injected) -> String {
    let brightest = streaks.iter().filter_map(|streak| streak.peak_magnitude).min_by(f64::total_cmp);
    let of = match sources {
        [] => return "no streak: nothing that shines crosses the frame; the output is a copy".to_owned(),
        [Source { name: SourceName::Random(_), .. }, ..] => "random lights".to_owned(),
        [one] => format!("{}", one.name),
        _ => format!("{} satellites", sources.len()),
    };
    let number = match streaks.len() {
        1 => "1 streak".to_owned(),
        number => format!("{number} streaks"),
    };
    let brightest = brightest.map_or_else(String::new, |magnitude| format!(", brightest {magnitude:.1} mag"));
    let clipped = match injected.changed.clipped {
        0 => String::new(),
        clipped => format!(", {clipped} of them at the end of their type's range"),
    };
    format!("{number} of {of}{brightest}; {} pixels changed{clipped}", injected.changed.pixels)
}

fn warnings(frame: &TargetFrame, injected: &Injected) -> Vec<String> {
    let hdus: Vec<String> = injected.without_gain.iter().map(usize::to_string).collect();
    let without_gain = format!(
        "{}: the gain of HDU {} is not known: light was added without the noise of its electrons; say --gain",
        frame.file.path().display(),
        hdus.join(", ")
    );
    if hdus.is_empty() { Vec::new() } else { vec![without_gain] }
}

/// The seed of one frame: as it was said where there is one frame, else mixed with the frame's number, so that neighbouring seeds share no frame.
fn seed_of(seed: u64, index: usize, count: usize) -> u64 {
    if count == 1 {
        return seed;
    }
    // SplitMix64's finalizer; below 2^53, so that a table of any kind holds it.
    let mut z =
        seed.wrapping_mul(0xd1b5_4a32_d192_ed03).wrapping_add((index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) >> 11
}
