//! The way of the data: frames opened, light found, drawn and written.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use streakcast::camera::PixelPosition;
use streakcast::frames::Direction;
use streakcast::setup::Setup;
use streakcast::streak::{
    DrawnStreak, InjectOptions, Injected, Shot, Source, SourceName, TargetFrame, draw_on_chip, inject,
};

use super::asked::Asked;
use super::frames::Frames;
use super::light::{Lights, history, is_seen, photometry_of, state};
use super::outputs::{Outputs, Told};
use crate::failure::Outcome;
use crate::inject_arguments::InjectArguments;
use crate::notices::Notices;
#[cfg(feature = "plot")]
use crate::output::write_bytes;

pub fn run(typed: InjectArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(Setup::default())?;
    let notices = super::super::judged::begin(&setup)?;
    let outputs = Outputs::new(&typed, &inputs(&typed, &setup))?;
    let asked = Asked::new(&typed, &setup)?;
    let frames = Frames::open(&typed, &setup, &asked, &outputs.frames)?;
    let known = frames.known();
    for frame in known {
        let left_out = frame
            .left_out
            .iter()
            .map(|(hdu, error)| format!("{}: HDU {hdu} is left out: {error}", frame.file.path().display()));
        notices.warn(&left_out.collect::<Vec<_>>());
    }
    let lights = Lights::prepare(&setup, &asked, known, &notices)?;

    let count = outputs.frames.len();
    let all: Vec<Done> = outputs
        .frames
        .par_iter()
        .enumerate()
        .map(|(index, output)| {
            let seed = seed_of(typed.counts.seed, index, count);
            frames.with(index, seed, |frame| one(&typed, &setup, &asked, &lights, frame, output, seed, &notices))
        })
        .collect::<anyhow::Result<_>>()?;

    let mut told = Told::default();
    for (done, output) in all.into_iter().zip(&outputs.frames) {
        notices.warn(&done.warnings);
        notices.say(&format!("{}: {}", output.display(), done.words));
        told.append(done.told);
    }
    let mut provenance = lights.provenance();
    if let Some(first) = known.first() {
        let photometry = photometry_of(&setup, first, &Notices::new(true))?;
        let image = typed.image.first().or(typed.synthetic.as_ref()).unwrap_or(&typed.output);
        state(&mut provenance, first, image, &asked, &photometry, typed.counts.seed);
    }
    outputs.write_tables(&told, &provenance)?;
    Ok(Outcome::Done)
}

/// What was done to one frame.
struct Done {
    told: Told,
    words: String,
    warnings: Vec<String>,
}

#[expect(clippy::too_many_arguments)]
fn one(
    typed: &InjectArguments,
    setup: &Setup,
    asked: &Asked,
    lights: &Lights,
    frame: &TargetFrame,
    output: &Path,
    seed: u64,
    notices: &Notices,
) -> anyhow::Result<Done> {
    let photometry = photometry_of(setup, frame, notices)?;
    let sources = lights.of(asked, frame, &photometry, typed.streaks.resolve_panels, seed)?;
    let tracking = asked.tracking(frame.exposure_s);
    let (centre, _) = frame.circle().unwrap_or((Direction::from_lon_lat_rad(0.0, 0.0), 0.0));
    let shot = Shot {
        opened: frame.opened,
        exposure_s: frame.exposure_s,
        centre,
        tracking: &tracking,
        optics: &asked.optics,
        truth_points: typed.truth.truth_points,
    };
    let seen: Vec<&Source> = sources.iter().filter(|source| source.parts.iter().any(is_seen)).collect();
    let streaks: Vec<DrawnStreak<'_>> = frame
        .chips
        .par_iter()
        .map(|target| {
            let drawn = seen.iter().map(|source| draw_on_chip(source, &target.chip, &shot));
            Ok(drawn.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
        })
        .collect::<anyhow::Result<Vec<Vec<_>>>>()?
        .into_iter()
        .flatten()
        .collect();
    let drawn = drawn_sources(&streaks);
    let options = InjectOptions {
        noise: !typed.counts.no_noise,
        detector: asked.detector.clone().or(asked.synthetic.as_ref().map(|synthetic| synthetic.detector.clone())),
        seed,
        planes: asked.preset.planes(&frame.mask_planes)?,
        tell: !typed.truth.pixels_only,
        history: history(&lights.provenance(), &drawn, seed),
    };
    let injected = inject(frame, &streaks, &options, output)?;
    #[cfg(feature = "plot")]
    pictures(typed, &streaks, output)?;
    Ok(Done {
        told: Told::of(output, &streaks, frame.exposure_s, seed),
        words: words(&streaks, &drawn, &injected),
        warnings: warnings(frame, &injected),
    })
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

/// Files that are read: no output may take their place.
fn inputs(typed: &InjectArguments, setup: &Setup) -> Vec<PathBuf> {
    let elements = setup.elements.as_ref().map_or(&[][..], |elements| elements.as_slice());
    let one = [
        &typed.synthetic,
        &typed.exposure.schedule,
        &typed.streaks.light_curve,
        &typed.counts.detector,
        &typed.shared.config,
        &typed.shared.eop,
        &typed.shared.qs_mag,
        &typed.shared.observer_elements,
    ];
    typed.image.iter().chain(elements).chain(one.into_iter().flatten()).cloned().collect()
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

/// Pictures of the chip with the longest streak; of the first one where there is none.
#[cfg(feature = "plot")]
fn pictures(typed: &InjectArguments, streaks: &[DrawnStreak<'_>], output: &Path) -> anyhow::Result<()> {
    use streakcast::camera::{FrameFile, Overlay, preview_png};
    let wanted = [(&typed.truth.preview, false), (&typed.truth.preview_marked, true)];
    if wanted.iter().all(|(path, _)| path.is_none()) {
        return Ok(());
    }
    let file = FrameFile::open(output)?;
    let longest = streaks.iter().max_by(|a, b| a.length_pix.total_cmp(&b.length_pix)).map(|streak| streak.hdu);
    let Some(hdu) = longest.or_else(|| file.images().first().copied()) else { return Ok(()) };
    let plane = file.read_plane(hdu)?;
    let overlay = |streak: &DrawnStreak<'_>| Overlay {
        line: streak.points.iter().map(|point| point.at).collect::<Vec<PixelPosition>>(),
        half_width_pix: 2.0 * streak.width_pix,
    };
    for (path, is_marked) in wanted {
        let Some(path) = path else { continue };
        let overlays: Vec<Overlay> = if is_marked {
            streaks.iter().filter(|streak| streak.hdu == hdu).map(overlay).collect()
        } else {
            Vec::new()
        };
        write_bytes(path, &preview_png(&plane, &overlays)?)?;
    }
    Ok(())
}
