//! Run of an injection: opens the frames, finds the lights, and draws and writes the streaks.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use hifitime::Epoch;
use rayon::prelude::*;

use super::super::chip::Chip;
use super::super::drawn::{DrawnStreak, Shot};
use super::super::frame::{InjectOptions, Injected, TargetFrame, inject};
use super::super::light::{ChosenStreaks, Source, SourceName};
use super::super::truth::{MaskPlanes, TruthRow, points_table, trail_table, truth_rows, truth_table};
use super::frames::Frames;
use super::labels::{LabelFile, LabelledImage, file_name, label_files, write_labels};
use super::lights::{InjectionSky, drawn, has_light, history, sources, state};
use super::plan::InjectionPlan;
use crate::error::Error;
use crate::frames::{Direction, seconds_after};
use crate::images::{HeaderSite, PixelPosition, PsfFile};
use crate::message::{Quoted, listed};
use crate::output::{AtomicFile, Column, Kind, Provenance, Table, Value, counted};
use crate::watch::Watch;

/// Largest distance of two positions of one observatory, km.
const ONE_SITE_KM: f64 = 1.0;

/// Line of a streak on a chip, used to mark the streak in pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// HDU of the chip.
    pub hdu: usize,
    /// Points along the streak, pixels.
    pub line: Vec<PixelPosition>,
    /// Half width of the marked area, pixels.
    pub half_width_pix: f64,
    /// Length of the streak, pixels.
    pub length_pix: f64,
}

/// Result of the injection into one frame.
#[derive(Clone, Debug)]
pub struct InjectedFrame {
    /// Path of the written file.
    pub output: PathBuf,
    /// Truth table, with one row for each streak on each chip.
    pub truth: Table,
    /// The same streaks as a catalogue for Rubin's `source_injection`.
    pub trails: Table,
    /// Table of points along the streaks.
    pub points: Table,
    /// Lines of the streaks, for pictures.
    pub marks: Vec<Mark>,
    /// Outlines of the streaks on each chip.
    pub labelled: Vec<LabelledImage>,
    /// Bits of the mask planes.
    pub planes: MaskPlanes,
    /// Summary in one line.
    pub summary: String,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Results of an injection into all frames.
#[derive(Clone, Debug)]
pub struct Injections {
    /// Results for each frame, in the order of the outputs.
    pub frames: Vec<InjectedFrame>,
    /// Remarks about values taken from headers.
    pub remarks: Vec<String>,
    /// Those of the remarks that state a choice between values in headers ([`TargetFrame::choices`]).
    pub choices: Vec<String>,
    /// Warnings about all frames.
    pub warnings: Vec<String>,
    /// Files of labels that were written.
    pub labels: Vec<LabelFile>,
    /// Provenance of the truth.
    pub provenance: Provenance,
}

/// Injection whose frames have been opened.
pub struct Injection<'a> {
    plan: &'a InjectionPlan,
    outputs: &'a [PathBuf],
    frames: Frames<'a>,
}

impl<'a> Injection<'a> {
    /// Checks the outputs and opens the frames. There is one output for each existing or synthetic frame.
    ///
    /// # Errors
    /// - An output cannot be written completely: its folder cannot be created, or it is a pipe, a device or a
    ///   compressed file.
    ///   No frame is read in this case.
    /// - A file of labels cannot be written, or is also an input.
    /// - A frame cannot be opened or created.
    pub fn open(plan: &'a InjectionPlan, outputs: &'a [PathBuf]) -> Result<Self, Error> {
        for output in outputs {
            reject_packed(output)?;
            AtomicFile::check(output).map_err(Error::io(output))?;
        }
        let frames = Frames::open(plan, outputs)?;
        frames.reject_untiled(outputs)?;
        check_labels(plan, outputs, frames.known())?;
        Ok(Self { plan, outputs, frames })
    }

    /// Returns the time of the first shutter opening and of the last shutter closing; `None` if there are no frames.
    pub fn span(&self) -> Option<(Epoch, Epoch)> {
        let frames = self.frames.known();
        let first = frames.iter().map(|frame| frame.opened).min();
        first.zip(frames.iter().map(|frame| seconds_after(frame.opened, frame.exposure_s)).max())
    }

    /// Returns the sites in the headers; of several sites within a kilometre of each other, only the first.
    ///
    /// # Errors
    /// A position that is not on the Earth.
    pub fn sites(&self) -> Result<Vec<HeaderSite>, Error> {
        let mut sites: Vec<HeaderSite> = Vec::new();
        for frame in self.frames.known() {
            let is_new = |found: &HeaderSite| {
                let distance_km = |known: &HeaderSite| (known.site.itrs() - found.site.itrs()).norm_km();
                !sites.iter().any(|known| distance_km(known) < ONE_SITE_KM)
            };
            sites.extend(frame.site()?.filter(is_new));
        }
        Ok(sites)
    }

    /// Returns a sentence about coordinates in the header of the first frame that do not give its site.
    pub fn unused_coordinates(&self) -> Option<String> {
        self.frames.known().first()?.unused_coordinates()
    }

    /// Injects streaks of satellites, or random streaks, into all frames, on all threads of the current pool. It stops
    /// after [`Watch::stop`].
    ///
    /// # Errors
    /// Errors of frames, detectors, passes and drawing. Each output is written completely or not at all. If one of
    /// several frames fails, others may have been written; the error contains their number.
    pub fn run(&self, sky: Option<InjectionSky<'_>>, watch: &Watch) -> Result<Injections, Error> {
        let (plan, known) = (self.plan, self.frames.known());
        if let (Some(chosen), true) = (&plan.chosen, plan.synthetic.is_some() || !plan.images.is_empty()) {
            check_images(chosen, known, self.outputs)?;
        }
        let left_out = known.iter().flat_map(|frame| {
            let shown = frame.file.path().display();
            frame.left_out.iter().map(move |(hdu, error)| format!("{shown}: HDU {hdu} is ignored: {error}"))
        });
        let of_psf = plan.psf_file.as_ref().and_then(PsfFile::border_warning);
        let warnings: Vec<String> = left_out.chain(of_psf).collect();
        let count = self.outputs.len();
        let written = AtomicUsize::new(0);
        let frames: Result<Vec<InjectedFrame>, Error> = self
            .outputs
            .par_iter()
            .enumerate()
            .map(|(index, output)| {
                watch.check()?;
                let seed = seed_of(plan.seed, index, count);
                let work = |frame: &TargetFrame| inject_frame(plan, sky, frame, output, seed, watch);
                let done = self.frames.with_frame(index, seed, watch, work);
                written.fetch_add(usize::from(done.is_ok()), Ordering::Relaxed);
                done
            })
            .collect();
        let frames = frames.map_err(|error| match written.into_inner() {
            0 => error,
            done => partly_written(error, done, count),
        })?;

        let labelled: Vec<(&Path, &[LabelledImage])> =
            frames.iter().map(|frame| (frame.output.as_path(), &frame.labelled[..])).collect();
        let labels = label_files(&plan.labels, &labelled);
        write_labels(&labels)?;
        let mut provenance = sky.map_or_else(Provenance::new, |sky| sky.provenance.clone());
        let synthetic = plan.synthetic.as_ref().map(|synthetic| &synthetic.path);
        if let (Some(first), Some(image)) = (known.first(), plan.images.first().or(synthetic)) {
            let (photometry, _) = plan.photometry_of(first);
            state(&mut provenance, first, image, plan, &photometry);
        }
        Ok(Injections {
            frames,
            remarks: plan
                .chosen
                .iter()
                .flat_map(|chosen| chosen.remarks.clone())
                .chain(known.iter().flat_map(|frame| frame.remarks().into_iter().chain(overscan(frame))))
                .collect(),
            choices: known.iter().flat_map(TargetFrame::choices).collect(),
            warnings,
            labels,
            provenance,
        })
    }
}

/// Checks that the files of labels, of which frames with several chips have one for each, can be written and are no
/// inputs.
fn check_labels(plan: &InjectionPlan, outputs: &[PathBuf], known: &[TargetFrame]) -> Result<(), Error> {
    let place = |path: &Path| std::fs::canonicalize(path).ok();
    let inputs: Vec<PathBuf> = plan.inputs.iter().filter_map(|input| place(input)).collect();
    for (index, output) in outputs.iter().enumerate() {
        let Some(frame) = known.get(index).or(known.first()) else { continue };
        let is_only = frame.chips.len() == 1;
        for (format, chip) in plan.labels.iter().flat_map(|format| frame.chips.iter().map(move |chip| (format, chip))) {
            let path = format.path(output, outputs.len(), (!is_only).then_some(chip.chip.hdu));
            if place(&path).is_some_and(|path| inputs.contains(&path)) {
                let allowed = "labels that replace no input: another name of the output or of the input";
                return Err(Error::about_file("", path, "is also an input").allowing(allowed));
            }
            AtomicFile::check(&path).map_err(Error::io(&path))?;
        }
    }
    Ok(())
}

/// Rejects names of compressed files, because the program does not compress whole files.
pub fn reject_packed(output: &Path) -> Result<(), Error> {
    let end = output.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    if ["gz", "bz2", "xz", "zip", "z"].contains(&end.as_str()) {
        let allowed = format!("a name without .{end}, for example .fits");
        return Err(Error::about_file("", output, "is the name of a compressed file").allowing(allowed));
    }
    Ok(())
}

/// Returns a remark about pixels of the frame that are not illuminated, to which no light is added.
fn overscan(frame: &TargetFrame) -> Option<String> {
    let is_cut = |chip: &&Chip| chip.light_area.pixels() < chip.rows * chip.columns;
    let cut: Vec<&Chip> = frame.chips.iter().map(|target| &target.chip).filter(is_cut).collect();
    let (first, area) = cut.first().map(|chip| (chip.hdu, chip.light_area.section()))?;
    let others = if cut.len() > 1 { format!(", {} others likewise", cut.len() - 1) } else { String::new() };
    let shown = frame.file.path().display();
    Some(format!(
        "{shown}: HDU {first}: only {area} is illuminated according to the header; no light is added to the overscan{others}"
    ))
}

fn inject_frame(
    plan: &InjectionPlan,
    sky: Option<InjectionSky<'_>>,
    frame: &TargetFrame,
    output: &Path,
    seed: u64,
    watch: &Watch,
) -> Result<InjectedFrame, Error> {
    let (photometry, unknown_filter) = plan.photometry_of(frame);
    let tracking = plan.tracking(frame.exposure_s);
    let (centre, _) = frame.circle().unwrap_or((Direction::from_lon_lat_rad(0.0, 0.0), 0.0));
    let shot = Shot {
        opened: frame.opened,
        exposure_s: frame.exposure_s,
        centre,
        tracking: &tracking,
        optics: &plan.optics,
        truth_points: plan.truth_points,
    };
    let (sources, of_sources) = sources(plan, sky, frame, (&shot, watch), &photometry, seed, output)?;
    // A synthetic frame is a temporary file, so errors name the output file instead.
    let shown = if plan.synthetic.is_some() { output } else { frame.file.path() };
    let seen: Vec<&Source> = sources.iter().filter(|source| source.parts.iter().any(has_light)).collect();
    let streaks: Vec<DrawnStreak<'_>> = frame
        .chips
        .par_iter()
        .enumerate()
        .map(|(index, _)| {
            let of_chip = seen.par_iter().map(|source| {
                watch.check()?;
                drawn(source, frame, index, plan, &shot, watch)
            });
            let drawn = of_chip.collect::<Result<Vec<_>, _>>().map_err(|error| error.in_file("", shown))?;
            Ok(drawn.into_iter().flatten().collect())
        })
        .collect::<Result<Vec<Vec<_>>, Error>>()?
        .into_iter()
        .flatten()
        .collect();
    let lit = drawn_sources(&streaks);
    let planes = plan.mask_preset.planes(&frame.mask_planes).map_err(|error| error.in_file("", shown))?;
    let options = InjectOptions {
        noise: plan.noise,
        detector: plan.detector.clone(),
        seed,
        planes,
        write_truth: !plan.pixels_only,
        history: history(sky.map_or(&Provenance::new(), |sky| sky.provenance), plan, &lit, &streaks, seed),
    };
    let injected = inject(frame, &streaks, &options, output, watch)?;
    let rows: Vec<TruthRow<'_>> = truth_rows(&streaks, &injected.clipped_counts, frame.exposure_s, seed);
    let mark = |streak: &DrawnStreak<'_>| Mark {
        hdu: streak.hdu,
        line: streak.points.iter().map(|point| point.at).collect(),
        half_width_pix: 2.0 * streak.width_pix,
        length_pix: streak.length_pix,
    };
    Ok(InjectedFrame {
        output: output.to_owned(),
        truth: with_file_name(truth_table(&rows), output),
        trails: trail_table(&rows),
        points: points_table(&rows),
        marks: streaks.iter().map(mark).collect(),
        labelled: frame
            .chips
            .iter()
            .map(|target| LabelledImage::new(&target.chip, frame.chips.len() == 1, &streaks))
            .collect(),
        planes,
        summary: summary(&streaks, &lit, &injected),
        warnings: unknown_filter
            .into_iter()
            .chain(of_sources)
            .chain(warnings(frame, &injected))
            .chain(outside(plan, &sources, &lit, shown))
            .collect(),
    })
}

/// Checks that each row of a table of streaks belongs to a frame.
fn check_images(chosen: &ChosenStreaks, frames: &[TargetFrame], outputs: &[PathBuf]) -> Result<(), Error> {
    let paths = frames.iter().map(|frame| frame.file.path()).chain(outputs.iter().map(PathBuf::as_path));
    let names: Vec<String> = paths.map(file_name).collect();
    for streak in &chosen.streaks {
        if let Some(image) = &streak.given.image
            && !names.contains(image)
        {
            let names = listed(names.iter().map(String::as_str));
            return Err(streak.given.invalid(
                "image",
                format!("'{}'", Quoted::new(image)),
                format!("a frame: {names}"),
            ));
        }
    }
    Ok(())
}

/// Returns a warning that names the chosen streaks without light in the frame.
fn outside(plan: &InjectionPlan, sources: &[Source], drawn: &[&Source], shown: &Path) -> Option<String> {
    plan.chosen.as_ref()?;
    let without: Vec<String> = sources
        .iter()
        .filter(|source| !drawn.iter().any(|drawn| std::ptr::eq(*drawn, *source)))
        .map(|source| source.name.to_string())
        .collect();
    (!without.is_empty()).then(|| {
        let count = counted(without.len(), "streak of the table is", "streaks of the table are");
        format!("{}: {count} outside of the frame: {}", shown.display(), listed(without.iter().map(String::as_str)))
    })
}

/// Returns the truth of one frame with the name of its file as the first column.
fn with_file_name(mut truth: Table, frame: &Path) -> Table {
    let name = file_name(frame);
    truth.columns.insert(0, Column::new("image", Kind::Text, "File of the frame."));
    truth.rows.iter_mut().for_each(|row| row.insert(0, Value::Text(name.clone())));
    truth
}

/// Returns the sources of the streaks, without repetition.
fn drawn_sources<'a>(streaks: &[DrawnStreak<'a>]) -> Vec<&'a Source> {
    let mut sources: Vec<&Source> = Vec::new();
    for streak in streaks {
        if !sources.iter().any(|source| std::ptr::eq(*source, streak.source)) {
            sources.push(streak.source);
        }
    }
    sources
}

fn summary(streaks: &[DrawnStreak<'_>], sources: &[&Source], injected: &Injected) -> String {
    let brightest = streaks.iter().filter_map(|streak| streak.peak_magnitude).min_by(f64::total_cmp);
    let number = counted(sources.len(), "streak", "streaks");
    let number = match sources {
        [] => return "no streak crosses the frame; the output is a copy".to_owned(),
        [Source { name: SourceName::Chosen(_), .. }, ..] => {
            counted(sources.len(), "streak of the table", "streaks of the table")
        }
        [Source { name: SourceName::Random(_), .. }, ..] => counted(sources.len(), "random streak", "random streaks"),
        [source] => format!("{number} of {}", source.name),
        _ => format!("{number} of {} satellites", sources.len()),
    };
    // A streak on several detectors, or of separate panels, has several rows in the truth table.
    let pieces = match streaks.len() {
        pieces if pieces > sources.len() => format!(" in {pieces} pieces"),
        _ => String::new(),
    };
    let brightest = brightest.map_or_else(String::new, |magnitude| format!(", brightest {magnitude:.1} mag"));
    let clipped = match injected.changed.clipped {
        0 => String::new(),
        clipped => format!(", {clipped} of them limited to the range of their type"),
    };
    format!("{number}{pieces}{brightest}; {} pixels changed{clipped}", injected.changed.pixels)
}

fn warnings(frame: &TargetFrame, injected: &Injected) -> Vec<String> {
    let hdus: Vec<String> = injected.without_gain.iter().map(usize::to_string).collect();
    let doubt = frame.doubtful_gain.as_ref().map(|doubt| format!(" ({doubt})")).unwrap_or_default();
    let without_gain = format!(
        "{}: the gain of HDU {} is unknown{doubt}: light was added without photon noise; specify --gain",
        frame.file.path().display(),
        hdus.join(", ")
    );
    if hdus.is_empty() { Vec::new() } else { vec![without_gain] }
}

/// Returns the seed of one frame. A single frame uses the given seed. For several frames the seed is mixed with the
/// number of the frame, so that two runs with adjacent seeds have no frame in common.
fn seed_of(seed: u64, index: usize, count: usize) -> u64 {
    if count == 1 {
        return seed;
    }
    // The finalizer of SplitMix64, reduced to 53 bits, because all table formats can represent integers of 53 bits.
    let mut z =
        seed.wrapping_mul(0xd1b5_4a32_d192_ed03).wrapping_add((index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) >> 11
}

/// Returns the error in one of several frames with the number of frames that were written completely.
pub(crate) fn partly_written(error: Error, done: usize, count: usize) -> Error {
    error.with_remark(format!("{done} of {count} frames have already been written, without tables"))
}
