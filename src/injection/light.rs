//! Whose light goes into a frame: satellites of a sky, or random streaks.

use std::path::Path;
use std::sync::Arc;

use crate::config::{Prepared, Setup, SetupError, SiteSetup, state_scales};
use crate::frames::{Direction, Gcrs, seconds_after};
use crate::geometry::Site;
use crate::output::{Provenance, format_utc};
use crate::passes::Exposure;
use crate::photometry::{Band, PhotometryOptions};
use crate::streaks::{
    Chip, DrawnStreak, RandomStreaks, SatelliteLight, SkyTrack, Source, SourceName, SourcePart, StreakNumber,
    TargetFrame, direction_on, satellites,
};
use hifitime::Epoch;
use serde_json::json;

use super::asked::{Asked, Random};
use super::error::InjectionError;

/// Random streaks are as large as a small satellite, m.
const RANDOM_RADIUS_M: f64 = 1.0;

/// What the user should know.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// What was taken from where.
    pub remarks: Vec<String>,
    /// What may be wrong.
    pub warnings: Vec<String>,
}

/// The sky of the night that holds a moment, of a caller that has skies.
pub type SkyOf<'a> = &'a (dyn Fn(Epoch) -> Result<Arc<Prepared>, SetupError> + Sync);

/// Where sources come from.
pub enum Lights {
    Sky(Arc<Prepared>),
    Random,
}

impl Lights {
    /// The sky over all frames (`sky`, where the caller has one), or nothing where streaks are random; and what the user should know.
    pub fn prepare(
        setup: &Setup,
        asked: &Asked,
        frames: &[TargetFrame],
        sky: Option<SkyOf<'_>>,
    ) -> Result<(Self, Notes), InjectionError> {
        let mut notes = Notes::default();
        if asked.random.is_some() {
            return Ok((Self::Random, notes));
        }
        if let (Some(sky), Some(first)) = (sky, frames.iter().map(|frame| frame.opened).min()) {
            return Ok((Self::Sky(sky(first)?), notes));
        }
        let setup = with_site(setup, frames, &mut notes)?;
        let ends = frames.iter().map(|frame| seconds_after(frame.opened, frame.exposure_s));
        let (Some(first), Some(last)) = (frames.iter().map(|frame| frame.opened).min(), ends.max()) else {
            return Err(InjectionError::said("no frame"));
        };
        let prepared = setup.prepare(first, last)?;
        notes.warnings.extend(prepared.warnings.iter().cloned());
        Ok((Self::Sky(Arc::new(prepared)), notes))
    }

    /// What they rest on.
    pub fn provenance(&self) -> Provenance {
        match self {
            Self::Sky(prepared) => prepared.provenance.clone(),
            Self::Random => Provenance::new(),
        }
    }

    /// The sources of one frame.
    pub fn of(
        &self,
        asked: &Asked,
        frame: &TargetFrame,
        photometry: &PhotometryOptions,
        resolve_panels: bool,
        seed: u64,
    ) -> Result<Vec<Source>, InjectionError> {
        let (centre, radius_rad) = frame.circle().ok_or_else(|| {
            let shown = frame.file.path().display();
            InjectionError::said(format!("{shown}: its world coordinates give its corners no place"))
        })?;
        match (self, &asked.random) {
            (Self::Sky(prepared), _) => {
                let exposure = Exposure {
                    id: frame.file.path().display().to_string(),
                    start: frame.opened,
                    duration_s: frame.exposure_s,
                    pointing: centre,
                    rotation_rad: 0.0,
                };
                let tracking = asked.tracking(frame.exposure_s);
                let light =
                    SatelliteLight { photometry, modulation: &asked.modulation, resolve_panels, tracking: &tracking };
                Ok(satellites(&prepared.sky, &prepared.eop, &exposure, radius_rad, &light)?.sources)
            }
            (Self::Random, Some(random)) => Ok(random_sources(random, asked, frame, (centre, radius_rad), seed)),
            (Self::Random, None) => Ok(Vec::new()),
        }
    }
}

/// Where no site is said, that of the observatory that the headers name.
fn with_site(setup: &Setup, frames: &[TargetFrame], notes: &mut Notes) -> Result<Setup, InjectionError> {
    if setup.site.is_some() || setup.mpc.is_some() || setup.lat.is_some() || setup.observer_elements.is_some() {
        return Ok(setup.clone());
    }
    let mut sites: Vec<Site> = Vec::new();
    for frame in frames {
        if let Some(site) = frame.observatory.iter().find_map(|named| Site::by_name(named).ok())
            && !sites.iter().any(|known| known.name == site.name)
        {
            sites.push(site);
        }
    }
    match &sites[..] {
        [] => Ok(setup.clone()),
        [site] => {
            let code = site.mpc_code.as_deref().unwrap_or("no code");
            notes.remarks.push(format!("site {} ({code}) from the header", site.name));
            Ok(Setup { site: Some(SiteSetup::Name(site.name.clone())), ..setup.clone() })
        }
        [first, second, ..] => Err(InjectionError::said(format!(
            "frames of two observatories ({}, {}); inject into those of each apart",
            first.name, second.name
        ))),
    }
}

fn random_sources(
    random: &Random,
    asked: &Asked,
    frame: &TargetFrame,
    (centre, radius_rad): (Direction<Gcrs>, f64),
    seed: u64,
) -> Vec<Source> {
    let chips = || frame.chips.iter().map(|target| &target.chip);
    let number = match random.streaks.number {
        StreakNumber::OnAverage(mean) if random.a_square_degree => {
            StreakNumber::OnAverage(mean * chips().map(area_deg2).sum::<f64>())
        }
        number => number,
    };
    let streaks = RandomStreaks { number, ..random.streaks };
    // Drawn in the frame's own sky, so that streaks cross it whatever the telescope follows; tracks reach across the whole frame wherever they pass.
    let tracks = streaks.tracks(seed, frame.exposure_s, 2.5 * radius_rad, |drawn, _| direction_on(chips(), drawn));
    let tracking = asked.tracking(frame.exposure_s);
    let source = |(number, mut track): (usize, SkyTrack)| {
        let middle_s = track.closest_s(&centre, |point| point.direction).unwrap_or(0.0);
        for point in &mut track.points {
            point.direction = tracking.stood(&point.direction, point.time_s, &centre);
        }
        Source {
            name: SourceName::Random(number),
            mag_source: "random".to_owned(),
            element_age_days: None,
            parts: Source::parts(&track, &asked.modulation, middle_s, RANDOM_RADIUS_M, None),
        }
    };
    (1..).zip(tracks).map(source).collect()
}

fn area_deg2(chip: &Chip) -> f64 {
    let side_deg = chip.pixel_scale_arcsec() / 3600.0;
    side_deg * side_deg * chip.light_area.pixels() as f64
}

/// Band and system of a frame: as said, else by the first word of its filter; with a warning where that is no band.
pub fn photometry_of(
    setup: &Setup,
    frame: &TargetFrame,
) -> Result<(PhotometryOptions, Option<String>), InjectionError> {
    if setup.band.is_some() {
        return Ok((setup.photometry()?, None));
    }
    let word = frame.filter.as_deref().and_then(|filter| filter.split_whitespace().next());
    let name = word.map(|word| word.trim_end_matches('\'').to_owned());
    match name.as_deref().map(str::parse::<Band>) {
        Some(Ok(_)) => Ok((Setup { band: name, ..setup.clone() }.photometry()?, None)),
        // Random streaks have a magnitude and no band.
        Some(Err(_)) if setup.elements.is_some() || setup.shells.is_some() => {
            let filter = frame.filter.as_deref().unwrap_or_default();
            let warning = format!("filter {filter:?} is no band that magnitudes are known in: V is taken; say --band");
            Ok((setup.photometry()?, Some(warning)))
        }
        _ => Ok((setup.photometry()?, None)),
    }
}

/// Lines of HISTORY: what was put in, and from what.
pub fn history(
    provenance: &Provenance,
    asked: &Asked,
    psf: &str,
    sources: &[&Source],
    streaks: &[DrawnStreak<'_>],
    seed: u64,
) -> Vec<String> {
    let version = env!("CARGO_PKG_VERSION");
    let mut lines = vec![format!("streakcast {version} inject: {} sources, seed {seed}", sources.len())];
    let optics = &asked.optics;
    let telescope = asked.telescope.as_ref().map_or_else(String::new, |telescope| format!(", {}", telescope.name));
    lines.push(format!("streakcast image of a star: {psf}, FWHM {} arcsec{telescope}", optics.seeing_arcsec));
    let magnitudes = span(streaks.iter().filter_map(|streak| streak.peak_magnitude));
    let zero_points = span(streaks.iter().map(|streak| streak.zero_point_mag));
    if let (Some(magnitudes), Some(zero_points)) = (magnitudes, zero_points) {
        lines.push(format!("streakcast light: magnitude {magnitudes} where brightest, zero point {zero_points} mag"));
    }
    for key in ["elements", "shells", "site", "models", "earth_orientation"] {
        if let Some(value) = provenance.get(key) {
            lines.push(format!("streakcast {key}: {}", shortened(value)));
        }
    }
    lines
}

/// The least and the greatest of some numbers, to a thousandth.
fn span(numbers: impl Iterator<Item = f64> + Clone) -> Option<String> {
    let [least, greatest] = [numbers.clone().min_by(f64::total_cmp)?, numbers.max_by(f64::total_cmp)?];
    let [least, greatest] = [least, greatest].map(|number| format!("{number:.3}"));
    Some(if least == greatest { least } else { format!("{least} to {greatest}") })
}

/// A statement on few cards.
fn shortened(value: &serde_json::Value) -> String {
    const LONGEST: usize = 600;
    let text = value.to_string();
    if text.chars().count() <= LONGEST { text } else { text.chars().take(LONGEST).chain("...".chars()).collect() }
}

/// What the frame was and how light became counts, for the truth's provenance.
pub fn state(
    provenance: &mut Provenance,
    frame: &TargetFrame,
    image: &Path,
    asked: &Asked,
    photometry: &PhotometryOptions,
    seed: u64,
) {
    state_scales(provenance, "utc", photometry);
    provenance.state(
        "options",
        json!({
            "image": image.display().to_string(),
            "start_utc": format_utc(frame.opened, 6),
            "exposure_s": frame.exposure_s,
            "seeing_arcsec": asked.optics.seeing_arcsec,
            "psf": format!("{:?}", asked.optics.form),
            "outer_radius_m": asked.optics.outer_radius_m,
            "inner_radius_m": asked.optics.inner_radius_m,
            "telescope": asked.telescope.as_ref().map(|telescope| telescope.name.as_str()),
            "seed": seed,
        }),
    );
}

/// The parts of a source that shine, for the summary.
pub fn is_seen(part: &SourcePart) -> bool {
    part.track.points.iter().any(|point| point.magnitude.is_some())
}
