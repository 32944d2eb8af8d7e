//! Moving lights of a frame: satellites above a site, or random streaks.

use std::path::Path;

use serde_json::json;

use super::super::chip::{Chip, direction_on};
use super::super::drawn::{DrawnStreak, Shot, draw_image_on_chip, draw_on_chip};
use super::super::frame::TargetFrame;
use super::super::light::{
    ChosenLight, ChosenStreak, GivenStreak, GivenWidth, Modulation, RandomStreaks, SatelliteLight, SkyPoint, SkyTrack,
    Source, SourceName, SourcePart, StreakNumber, satellites,
};
use super::labels::file_name;
use super::plan::{InjectionPlan, RandomPlan};
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{Direction, EopTable, Gcrs};
use crate::images::StreakEnds;
use crate::message::listed;
use crate::output::{Provenance, counted, format_utc};
use crate::passes::{Exposure, Sky};
use crate::photometry::PhotometryOptions;
use crate::watch::Watch;

/// Diameter of random lights if none is given, m, which is that of a small satellite.
const RANDOM_SIZE_M: f64 = 2.0;

/// Satellites above the site of the frames, with their provenance.
#[derive(Copy, Clone, Debug)]
pub struct InjectionSky<'a> {
    /// Propagated satellites and their models.
    pub sky: &'a Sky,
    /// Table of Earth orientation parameters.
    pub eop: &'a EopTable,
    /// Provenance of the elements and models.
    pub provenance: &'a Provenance,
}

/// Returns the sources of light that may cross one frame, and warnings about satellites that are left out because their
/// positions are unknown, and about an unknown position of a telescope in orbit.
pub fn sources(
    plan: &InjectionPlan,
    sky: Option<InjectionSky<'_>>,
    frame: &TargetFrame,
    (shot, watch): (&Shot<'_>, &Watch),
    photometry: &PhotometryOptions,
    seed: u64,
    output: &Path,
) -> Result<(Vec<Source>, Vec<String>), Error> {
    let (exposure, radius_rad) = frame.exposure()?;
    if let Some(random) = &plan.random {
        return Ok((random_sources(random, plan, frame, (exposure.pointing, radius_rad), seed), Vec::new()));
    }
    if let Some(chosen) = &plan.chosen {
        let names = [file_name(frame.file.path()), file_name(output)];
        let of_frame = chosen.streaks.iter().filter(|streak| names.iter().any(|name| streak.given.is_of(name)));
        let sources =
            of_frame.map(|streak| chosen_source(streak, plan, frame, (shot, watch))).collect::<Result<_, _>>()?;
        return Ok((sources, Vec::new()));
    }
    let Some(sky) = sky else { return Ok((Vec::new(), Vec::new())) };
    let tracking = plan.tracking(frame.exposure_s);
    let light = SatelliteLight {
        photometry,
        modulation: &plan.modulation,
        resolve_panels: plan.resolve_panels,
        tracking: &tracking,
        size_m: plan.satellite_size_m,
    };
    let found = satellites(sky.sky, sky.eop, &exposure, radius_rad, &light)?;
    let (shown, unknown) = (output.display().to_string(), found.unknown.len());
    let left_out = (unknown > 0).then(|| {
        let numbers: Vec<String> = found.unknown.iter().map(NoradId::to_string).collect();
        format!(
            "{shown}: {} of unknown position left out, because the element sets are too old: {}",
            counted(unknown, "satellite", "satellites"),
            listed(numbers.iter().map(String::as_str))
        )
    });
    let exposure = Exposure { id: shown, ..exposure };
    let of_frame = sky.sky.frame_warnings(&exposure, radius_rad);
    Ok((found.sources, of_frame.into_iter().chain(left_out).collect()))
}

fn random_sources(
    random: &RandomPlan,
    plan: &InjectionPlan,
    frame: &TargetFrame,
    (centre, radius_rad): (Direction<Gcrs>, f64),
    seed: u64,
) -> Vec<Source> {
    let chips = || frame.chips.iter().map(|target| &target.chip);
    let number = match random.streaks.number {
        StreakNumber::OnAverage(mean) if random.is_per_square_degree => {
            StreakNumber::OnAverage(mean * chips().map(area_deg2).sum::<f64>())
        }
        number => number,
    };
    let streaks = RandomStreaks { number, ..random.streaks };
    // Tracks are drawn in the coordinates of the frame, so that with any tracking they extend across the whole frame.
    let tracks = streaks.tracks(seed, frame.exposure_s, 2.5 * radius_rad, |drawn, _| direction_on(chips(), drawn));
    let tracking = plan.tracking(frame.exposure_s);
    let radius_m = 0.5 * plan.satellite_size_m.unwrap_or(RANDOM_SIZE_M);
    let source = |(number, mut track): (usize, SkyTrack)| {
        let middle_s = track.closest_s(&centre, |point| point.direction).unwrap_or(0.0);
        for point in &mut track.points {
            point.direction = tracking.on_sky(&point.direction, point.time_s, &centre);
        }
        Source {
            name: SourceName::Random(number),
            mag_source: "random".to_owned(),
            element_age_days: None,
            hdu: None,
            image_fwhm_arcsec: None,
            parts: Source::parts(&track, &plan.modulation, middle_s, radius_m, None),
        }
    };
    (1..).zip(tracks).map(source).collect()
}

/// Returns the source of a chosen streak in a frame. For a peak the streak is drawn twice, because the brightest pixel
/// depends on its position.
fn chosen_source(
    streak: &ChosenStreak,
    plan: &InjectionPlan,
    frame: &TargetFrame,
    (shot, watch): (&Shot<'_>, &Watch),
) -> Result<Source, Error> {
    let chip = chip_of(&streak.given, frame)?;
    let given = &streak.given.in_frame(frame.file.header(chip.hdu)?);
    if !chip.is_on_sky && matches!(given.ends, StreakEnds::Sky(_)) {
        return Err(given.invalid("ends", "directions on the sky", "pixels in a frame without world coordinates"));
    }
    if plan.psf_file.is_some() && given.width != GivenWidth::Unknown {
        let allowed = "no fwhm_pix, fwhm_arcsec or range_km with a file of --psf, which gives the image of the light";
        return Err(given.invalid("width of the streak", "given", allowed));
    }
    // A light of this magnitude gives 1 in the unit of the frame.
    let unit_mag = chip.scale.zero_point_mag();
    let magnitude = if let ChosenLight::Magnitude(magnitude) = streak.light { magnitude } else { unit_mag };
    let time = (frame.opened, frame.exposure_s);
    let mut track = given.track(chip, time, (shot.tracking, &shot.centre), magnitude)?;
    let image_fwhm_arcsec = match given.width {
        GivenWidth::Unknown => Some(plan.optics.seeing_arcsec),
        GivenWidth::Distance { .. } => None,
        GivenWidth::Pixels(fwhm_pix) => Some(fwhm_pix * chip.pixel_scale_arcsec()),
        GivenWidth::Arcsec(fwhm_arcsec) => Some(fwhm_arcsec),
    };
    let radius_m = match given.width {
        GivenWidth::Distance { size_m, .. } => 0.5 * size_m.or(plan.satellite_size_m).unwrap_or(0.0),
        _ => 0.0,
    };
    let curve = streak.curve.clone().or_else(|| plan.modulation.curve.clone());
    let modulation = Modulation { curve, ..plan.modulation.clone() };
    let source = |track: &SkyTrack| {
        let seen = |point: &SkyPoint| shot.tracking.seen(&point.direction, point.time_s, &shot.centre);
        let middle_s = track.closest_s(&shot.centre, seen).unwrap_or(0.0);
        Source {
            name: SourceName::Chosen(given.id.as_str().into()),
            mag_source: "table".to_owned(),
            element_age_days: None,
            hdu: match given.ends {
                StreakEnds::Pixels(_) => Some(chip.hdu),
                StreakEnds::Sky(_) => given.hdu,
            },
            image_fwhm_arcsec,
            parts: Source::parts(track, &modulation, middle_s, radius_m, None),
        }
    };
    if let ChosenLight::Peak(peak) = streak.light {
        let stand_in = source(&track);
        let mut brightest = 0.0f64;
        for index in 0..frame.chips.len() {
            for drawn in drawn(&stand_in, frame, index, plan, shot, watch)? {
                let values = drawn.patch.iter().flat_map(|span| span.values.to_vec());
                brightest = values.map(f64::from).fold(brightest, f64::max);
            }
        }
        // Without light in the frame, no magnitude gives the peak.
        let magnitude = (brightest > 0.0).then(|| unit_mag - 2.5 * (peak / brightest).log10());
        track.points.iter_mut().for_each(|point| point.magnitude = magnitude);
    }
    Ok(source(&track))
}

/// Draws a source on a chip of a frame, with the point spread function of the plan.
pub fn drawn<'a>(
    source: &'a Source,
    frame: &'a TargetFrame,
    index: usize,
    plan: &InjectionPlan,
    shot: &Shot<'_>,
    watch: &Watch,
) -> Result<Vec<DrawnStreak<'a>>, Error> {
    let chip = &frame.chips[index].chip;
    match &plan.psf_file {
        Some(file) => {
            let chosen: Vec<usize> = frame.chips.iter().map(|target| target.chip.hdu).collect();
            if chip.is_on_sky {
                file.check_scale(chip.pixel_scale_arcsec())?;
            }
            draw_image_on_chip(source, chip, shot, file.of_chip(chip.hdu, &chosen, &frame.images.frames)?, watch)
        }
        None => draw_on_chip(source, chip, shot),
    }
}

/// Returns the chip of a streak; the first one for ends on the sky without an HDU.
fn chip_of<'a>(streak: &GivenStreak, frame: &'a TargetFrame) -> Result<&'a Chip, Error> {
    let hdus: Vec<usize> = frame.chips.iter().map(|target| target.chip.hdu).collect();
    let index = streak.chip_index(&hdus, frame.file.path())?;
    Ok(&frame.chips[index.unwrap_or(0)].chip)
}

fn area_deg2(chip: &Chip) -> f64 {
    let side_deg = chip.pixel_scale_arcsec() / 3600.0;
    side_deg * side_deg * chip.light_area.pixels() as f64
}

/// Returns the HISTORY lines of a frame: the sources and their provenance.
pub fn history(
    provenance: &Provenance,
    plan: &InjectionPlan,
    sources: &[&Source],
    streaks: &[DrawnStreak<'_>],
    seed: u64,
) -> Vec<String> {
    let version = env!("CARGO_PKG_VERSION");
    let mut lines = vec![format!("streakcast {version} inject: {} sources, seed {seed}", sources.len())];
    let (optics, psf) = (&plan.optics, &plan.psf_name);
    let telescope = plan.telescope.as_ref().map_or_else(String::new, |name| format!(", {name}"));
    lines.push(match &plan.psf_file {
        Some(file) => {
            format!("streakcast image of a star: {}, a sample every {} pixels", file.path.display(), file.step_pix())
        }
        None => format!("streakcast image of a star: {psf}, FWHM {} arcsec{telescope}", optics.seeing_arcsec),
    });
    let magnitudes = span(streaks.iter().filter_map(|streak| streak.peak_magnitude));
    let zero_points = span(streaks.iter().map(|streak| streak.zero_point_mag));
    if let (Some(magnitudes), Some(zero_points)) = (magnitudes, zero_points) {
        lines.push(format!("streakcast light: magnitude {magnitudes} where brightest, zero point {zero_points} mag"));
    }
    lines.extend(provenance_lines(provenance));
    lines
}

/// Returns the provenance of satellites as HISTORY lines.
pub fn provenance_lines(provenance: &Provenance) -> Vec<String> {
    let keys = ["elements", "shells", "site", "models", "earth_orientation"];
    keys.iter().filter_map(|key| Some(format!("streakcast {key}: {}", shortened(provenance.get(key)?)))).collect()
}

/// Returns the least and the greatest of some numbers as text, with three decimals.
fn span(numbers: impl Iterator<Item = f64> + Clone) -> Option<String> {
    let [least, greatest] = [numbers.clone().min_by(f64::total_cmp)?, numbers.max_by(f64::total_cmp)?];
    let [least, greatest] = [least, greatest].map(|number| format!("{number:.3}"));
    Some(if least == greatest { least } else { format!("{least} to {greatest}") })
}

/// Returns a value as text, truncated to the length of a few header cards.
fn shortened(value: &serde_json::Value) -> String {
    const LONGEST: usize = 600;
    let text = value.to_string();
    if text.chars().count() <= LONGEST { text } else { text.chars().take(LONGEST).chain("...".chars()).collect() }
}

/// Adds properties of the frame, the optics and the photometry to the provenance of the truth.
pub fn state(
    provenance: &mut Provenance,
    frame: &TargetFrame,
    image: &Path,
    plan: &InjectionPlan,
    photometry: &PhotometryOptions,
) {
    provenance.state("time_scale", "utc");
    provenance.state_all(photometry.statements());
    provenance.state(
        "options",
        json!({
            "image": image.display().to_string(),
            "start_utc": format_utc(frame.opened, 6),
            "exposure_s": frame.exposure_s,
            "seeing_arcsec": plan.psf_file.is_none().then_some(plan.optics.seeing_arcsec),
            "psf": match &plan.psf_file {
                Some(file) => file.path.display().to_string(),
                None => plan.optics.form.to_string(),
            },
            "outer_radius_m": plan.optics.outer_radius_m,
            "inner_radius_m": plan.optics.inner_radius_m,
            "telescope": plan.telescope,
            "streaks": plan.chosen.as_ref().map(|chosen| chosen.path.display().to_string()),
            "satellite_size_m": plan.satellite_size_m.or(plan.random.map(|_| RANDOM_SIZE_M)),
            "seed": plan.seed,
        }),
    );
}

/// Returns true if a part of a source is lit at some time.
pub fn has_light(part: &SourcePart) -> bool {
    part.track.points.iter().any(|point| point.magnitude.is_some())
}
