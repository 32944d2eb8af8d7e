//! What was typed to the library's question; its answer to files, pictures and lines on the screen.

use std::path::PathBuf;

use streakcast::config::Setup;
use streakcast::injection::{InjectionSaid, Injections, inject_frames};

use super::outputs::Outputs;
use crate::failure::Outcome;
use crate::inject_arguments::{InjectArguments, Numbers};
#[cfg(feature = "plot")]
use crate::output::write_bytes;

pub fn run(typed: InjectArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(Setup::default())?;
    let notices = super::super::judged::begin(&setup)?;
    let said = said(&typed);
    let outputs = Outputs::new(&typed, &inputs(&typed, &said, &setup))?;
    refuse_idle(&typed)?;
    let done = inject_frames(&said, &setup, None, &outputs.frames)?;
    for remark in &done.remarks {
        notices.say(remark);
    }
    notices.warn(&done.warnings);
    for frame in &done.frames {
        notices.warn(&frame.warnings);
        notices.say(&format!("{}: {}", frame.output.display(), frame.words));
    }
    #[cfg(feature = "plot")]
    pictures(&typed, &done)?;
    outputs.write_tables(&done)?;
    Ok(Outcome::Done)
}

fn said(typed: &InjectArguments) -> InjectionSaid {
    let numbers = |numbers: &Option<Numbers>| numbers.as_ref().map_or(Vec::new(), |numbers| numbers.0.clone());
    let (exposure, streaks, counts, truth) = (&typed.exposure, &typed.streaks, &typed.counts, &typed.truth);
    InjectionSaid {
        image: typed.image.clone(),
        synthetic: typed.synthetic.clone(),
        frames: typed.frames,
        start: exposure.start.clone(),
        exposure: exposure.exposure.clone(),
        schedule: exposure.schedule.clone(),
        row: exposure.row.clone(),
        ra: exposure.ra.clone(),
        dec: exposure.dec.clone(),
        pixel_scale: exposure.pixel_scale.clone(),
        hdu: exposure.hdu.clone(),
        track_rate: numbers(&exposure.track_rate),
        random_streaks: streaks.random_streaks,
        streak_density: streaks.streak_density,
        magnitude: numbers(&streaks.magnitude),
        streak_rate_deg_s: numbers(&streaks.streak_rate_deg_s),
        tumbling: numbers(&streaks.tumbling),
        glint: streaks.glint.iter().map(|glint| glint.0.clone()).collect(),
        light_curve: streaks.light_curve.clone(),
        resolve_panels: streaks.resolve_panels,
        seeing: streaks.seeing.clone(),
        psf: streaks.psf.clone(),
        zero_point: counts.zero_point,
        zero_point_1s: counts.zero_point_1s,
        gain: counts.gain,
        detector: counts.detector.clone(),
        no_noise: counts.no_noise,
        seed: counts.seed,
        truth_points: truth.truth_points,
        mask_bits: truth.mask_bits.clone(),
        pixels_only: truth.pixels_only,
    }
}

/// Files that are read: no output may take their place.
fn inputs(typed: &InjectArguments, said: &InjectionSaid, setup: &Setup) -> Vec<PathBuf> {
    let elements = setup.elements.as_ref().map_or(&[][..], |elements| elements.as_slice());
    let one = [&typed.shared.config, &typed.shared.eop, &typed.shared.qs_mag, &typed.shared.observer_elements];
    said.files().into_iter().chain(elements.iter().chain(one.into_iter().flatten()).cloned()).collect()
}

/// Refuses options that would do nothing: those of fields, and those of satellites where streaks are random. What a configuration file says for other verbs
/// may stay in it.
fn refuse_idle(typed: &InjectArguments) -> anyhow::Result<()> {
    let (shared, place) = (&typed.shared, &typed.shared.place);
    let of_fields = [
        ("--fov", shared.fov.is_some()),
        ("--field", shared.field.is_some()),
        ("--rotation", shared.rotation.is_some()),
        ("--min-probability", shared.min_probability.is_some()),
    ];
    let of_satellites = [
        ("--extinction", shared.extinction.is_some()),
        ("--sun-distance", shared.sun_distance),
        ("--no-earthshine", shared.magnitudes.no_earthshine),
        ("--shadow", shared.shadow.is_some()),
        ("--qs-mag", shared.qs_mag.is_some()),
        ("--accept-bad-checksums", shared.accept_bad_checksums),
        ("--eop", shared.eop.is_some()),
        ("--site", place.site.is_some()),
        ("--mpc", place.mpc.is_some()),
        ("--lat", place.lat.is_some()),
        ("--lon", place.lon.is_some()),
        ("--height", place.height.is_some()),
        ("--observer-elements", shared.observer_elements.is_some()),
        ("--observer-norad", shared.observer_norad.is_some()),
        ("--limb-height-km", shared.limb_height_km.is_some()),
    ];
    let is_random = typed.streaks.random_streaks.is_some() || typed.streaks.streak_density.is_some();
    let typed_of =
        |options: &[(&'static str, bool)]| options.iter().find(|(_, is_said)| *is_said).map(|(name, _)| *name);
    if let Some(option) = typed_of(&of_fields) {
        return Err(anyhow::anyhow!(
            "{option} is for verbs that ask about a field; the field of inject is the frame itself"
        ));
    }
    match typed_of(&of_satellites).filter(|_| is_random) {
        Some(option) => Err(anyhow::anyhow!(
            "{option} is for satellites; random streaks have their magnitude and speed from the command line"
        )),
        None => Ok(()),
    }
}

/// Pictures of the chip with the longest streak; of the first one where there is none.
#[cfg(feature = "plot")]
fn pictures(typed: &InjectArguments, done: &Injections) -> anyhow::Result<()> {
    use streakcast::images::{FrameFile, Overlay, preview_png};
    let wanted = [(&typed.truth.preview, false), (&typed.truth.preview_marked, true)];
    // Pictures are for one frame.
    let Some(frame) = done.frames.first().filter(|_| wanted.iter().any(|(path, _)| path.is_some())) else {
        return Ok(());
    };
    let file = FrameFile::open(&frame.output)?;
    let longest = frame.marks.iter().max_by(|a, b| a.length_pix.total_cmp(&b.length_pix)).map(|mark| mark.hdu);
    let Some(hdu) = longest.or_else(|| file.images().first().copied()) else { return Ok(()) };
    let plane = file.read_plane(hdu)?;
    for (path, is_marked) in wanted {
        let Some(path) = path else { continue };
        let marks = frame.marks.iter().filter(|mark| is_marked && mark.hdu == hdu);
        let overlays: Vec<Overlay> =
            marks.map(|mark| Overlay { line: mark.line.clone(), half_width_pix: mark.half_width_pix }).collect();
        write_bytes(path, &preview_png(&plane, &overlays)?)?;
    }
    Ok(())
}
