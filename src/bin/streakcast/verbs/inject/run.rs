//! The run of `inject`.

use std::path::PathBuf;

use streakcast::config::{Config, inject_frames};
#[cfg(feature = "plot")]
use streakcast::streaks::Injections;

use super::arguments::InjectArguments;
use super::outputs::Outputs;
use crate::failure::Outcome;
#[cfg(feature = "plot")]
use crate::output::write_bytes;

pub fn run(typed: InjectArguments) -> anyhow::Result<Outcome> {
    let config = typed.config.clone().with_file()?;
    let notices = super::super::judged::begin(&config)?;
    let outputs = Outputs::new(&typed, &inputs(&typed, &config))?;
    reject_idle(&typed)?;
    let done = inject_frames(&typed.injection, &config, None, &outputs.frames)?;
    for remark in &done.remarks {
        notices.say(remark);
    }
    notices.warn(&done.warnings);
    for frame in &done.frames {
        notices.warn(&frame.warnings);
        notices.say(&format!("{}: {}", frame.output.display(), frame.summary));
    }
    #[cfg(feature = "plot")]
    pictures(&typed, &done)?;
    outputs.write_tables(&done)?;
    Ok(Outcome::Done)
}

/// Returns the files that are read: no output may replace one of them.
fn inputs(typed: &InjectArguments, config: &Config) -> Vec<PathBuf> {
    typed.injection.files().into_iter().chain(config.files()).chain(config.run.file.clone()).collect()
}

/// Rejects flags without effect: those of fields, and those of satellites with random streaks. The configuration file may
/// have such keys for other verbs.
fn reject_idle(typed: &InjectArguments) -> anyhow::Result<()> {
    let (flags, site) = (&typed.config, &typed.config.site);
    let of_fields = [
        ("--fov", flags.fov.is_some()),
        ("--field", flags.field.is_some()),
        ("--rotation", flags.rotation.is_some()),
        ("--min-probability", flags.min_probability.is_some()),
    ];
    let of_satellites = [
        ("--extinction", flags.extinction.is_some()),
        ("--sun-distance", flags.sun_distance.is_some()),
        ("--no-earthshine", flags.light.earthshine.is_some()),
        ("--shadow", flags.shadow.is_some()),
        ("--qs-mag", flags.qs_mag.is_some()),
        ("--accept-bad-checksums", flags.accept_bad_checksums.is_some()),
        ("--eop", flags.eop.is_some()),
        ("--site", site.named.is_some()),
        ("--mpc", site.mpc.is_some()),
        ("--lat", site.lat.is_some()),
        ("--lon", site.lon.is_some()),
        ("--height", site.height.is_some()),
        ("--observer-elements", flags.observer_elements.is_some()),
        ("--observer-norad", flags.observer_norad.is_some()),
        ("--limb-height-km", flags.limb_height_km.is_some()),
    ];
    let given =
        |options: &[(&'static str, bool)]| options.iter().find(|(_, is_given)| *is_given).map(|(name, _)| *name);
    if let Some(option) = given(&of_fields) {
        return Err(anyhow::anyhow!(
            "{option} is for verbs that ask about a field; the field of inject is the frame itself"
        ));
    }
    match given(&of_satellites).filter(|_| typed.injection.is_random()) {
        Some(option) => Err(anyhow::anyhow!(
            "{option} is for satellites; random streaks have their magnitude and speed from the command line"
        )),
        None => Ok(()),
    }
}

/// Writes pictures of the chip with the longest streak, or of the first one without a streak.
#[cfg(feature = "plot")]
fn pictures(typed: &InjectArguments, done: &Injections) -> anyhow::Result<()> {
    use streakcast::images::{FrameFile, Overlay, preview_png};
    let wanted = [(&typed.preview, false), (&typed.preview_marked, true)];
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
