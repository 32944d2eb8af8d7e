//! The way of the data: frames opened, light found, drawn and written.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use hifitime::Epoch;
use rayon::prelude::*;
use streakcast::camera::PixelPosition;
use streakcast::frames::Direction;
use streakcast::setup::Setup;
use streakcast::streak::{
    DrawnStreak, FrameSaid, InjectOptions, Injected, Shot, Source, SourceName, SyntheticShot, TargetFrame,
    draw_on_chip, inject,
};
use streakcast::table::ScratchFolder;

use super::asked::Asked;
use super::light::{Lights, history, is_seen, photometry_of, state};
use super::outputs::{Outputs, Told};
use crate::failure::Outcome;
use crate::inject_arguments::InjectArguments;
use crate::notices::Notices;
#[cfg(feature = "plot")]
use crate::output::write_bytes;

/// When synthetic frames with random streaks are taken where nobody says: it changes nothing but the header.
const SOME_DAY: &str = "2000-01-01T12:00:00Z";

pub fn run(typed: InjectArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(Setup::default())?;
    let notices = super::super::judged::begin(&setup)?;
    let outputs = Outputs::new(&typed)?;
    let mut asked = Asked::new(&typed, &setup)?;
    let folder = outputs.frames[0].parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let scratch = asked.synthetic.is_some().then(|| ScratchFolder::new(folder)).transpose()?;
    let images = match &scratch {
        Some(scratch) => synthetic_frames(&mut asked, &typed, &setup, outputs.frames.len(), scratch)?,
        None => typed.image.clone(),
    };
    let frames =
        images.iter().map(|path| Ok(TargetFrame::open(path, &asked.said)?)).collect::<anyhow::Result<Vec<_>>>()?;
    for frame in &frames {
        let left_out = frame
            .left_out
            .iter()
            .map(|(hdu, error)| format!("{}: HDU {hdu} is left out: {error}", frame.file.path().display()));
        notices.warn(&left_out.collect::<Vec<_>>());
    }
    let lights = Lights::prepare(&setup, &asked, &frames, &notices)?;

    let all: Vec<Done> = frames
        .par_iter()
        .zip(&outputs.frames)
        .enumerate()
        .map(|(index, (frame, output))| {
            let seed = typed.counts.seed.wrapping_add(index as u64);
            one(&typed, &setup, &asked, &lights, frame, output, seed, &notices)
        })
        .collect::<anyhow::Result<_>>()?;

    let mut told = Told::default();
    for (done, output) in all.into_iter().zip(&outputs.frames) {
        notices.warn(&done.warnings);
        notices.say(&format!("{}: {}", output.display(), done.words));
        told.append(done.told);
    }
    let mut provenance = lights.provenance();
    let photometry = photometry_of(&setup, &frames[0], &Notices::new(true))?;
    state(
        &mut provenance,
        &frames[0],
        &asked,
        &photometry,
        typed.counts.seed,
        (frames[0].opened, frames[0].exposure_s),
    );
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
    let brightest = streaks.iter().filter_map(DrawnStreak::peak_magnitude).min_by(f64::total_cmp);
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

/// Makes the synthetic frames, each from a seed of its own, and says what they hold to those who read them.
fn synthetic_frames(
    asked: &mut Asked,
    typed: &InjectArguments,
    setup: &Setup,
    count: usize,
    scratch: &ScratchFolder,
) -> anyhow::Result<Vec<PathBuf>> {
    let Some(synthetic) = asked.synthetic.clone() else { return Ok(Vec::new()) };
    let is_random = asked.random.is_some();
    let opened: Epoch = match asked.said.start {
        Some(start) => start,
        None if is_random => streakcast::setup::parse_moment(SOME_DAY, None)?,
        None => {
            return Err(anyhow!(
                "no start of the exposure; say --start 2024-08-14T00:30:00.000Z or --schedule FILE --row ID"
            ));
        }
    };
    let exposure_s = asked
        .said
        .duration_s
        .ok_or_else(|| anyhow!("no length of the exposure; say --exposure 30s or --schedule FILE --row ID"))?;
    let centre = match (&asked.scheduled, &typed.exposure.ra, &typed.exposure.dec) {
        (_, Some(ra), Some(dec)) => Direction::from_lon_lat_rad(
            streakcast::frames::parse_right_ascension_deg(ra)?.to_radians(),
            streakcast::frames::parse_declination_deg(dec)?.to_radians(),
        ),
        (Some(exposure), None, None) => exposure.pointing,
        (None, None, None) if is_random => Direction::from_lon_lat_rad(0.0, 0.0),
        _ => return Err(anyhow!("no centre of the frame; say --ra 188.5 --dec=-30.5 or --schedule FILE --row ID")),
    };
    let photometry = setup.photometry()?;
    let paths: Vec<PathBuf> = (0..count).map(|index| scratch.path().join(format!("{index}.fits"))).collect();
    paths.par_iter().enumerate().try_for_each(|(index, path)| {
        let seed = typed.counts.seed.wrapping_add(index as u64);
        let shot =
            SyntheticShot { opened, exposure_s, centre, optics: &asked.optics, filter: photometry.band.name(), seed };
        synthetic.write(&shot, path)
    })?;
    asked.said = FrameSaid { start: None, duration_s: None, ..asked.said.clone() };
    Ok(paths)
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
