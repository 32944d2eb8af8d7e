//! Whose light goes into a frame: satellites of a sky, or random streaks.

use std::path::Path;

use anyhow::anyhow;
use serde_json::json;
use streakcast::frames::{Direction, Gcrs, seconds_after};
use streakcast::geometry::Site;
use streakcast::passes::Exposure;
use streakcast::photometry::{Band, PhotometryOptions};
use streakcast::setup::{Prepared, Setup, SiteSetup};
use streakcast::streak::{
    Chip, RandomStreaks, SatelliteLight, SkyTrack, Source, SourceName, SourcePart, StreakNumber, TargetFrame,
    direction_on, satellites,
};
use streakcast::table::Provenance;

use super::asked::{Asked, Random};
use crate::notices::Notices;

/// Random streaks are as large as a small satellite, m.
const RANDOM_RADIUS_M: f64 = 1.0;

/// Where sources come from.
pub enum Lights {
    Sky(Box<Prepared>),
    Random,
}

impl Lights {
    /// The sky over all frames, or nothing where streaks are random.
    pub fn prepare(setup: &Setup, asked: &Asked, frames: &[TargetFrame], notices: &Notices) -> anyhow::Result<Self> {
        if asked.random.is_some() {
            return Ok(Self::Random);
        }
        let setup = with_site(setup, frames, notices)?;
        let ends = frames.iter().map(|frame| seconds_after(frame.opened, frame.exposure_s));
        let (Some(first), Some(last)) = (frames.iter().map(|frame| frame.opened).min(), ends.max()) else {
            return Err(anyhow!("no frame"));
        };
        let prepared = setup.prepare(first, last)?;
        notices.warn(&prepared.warnings);
        Ok(Self::Sky(Box::new(prepared)))
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
    ) -> anyhow::Result<Vec<Source>> {
        let (centre, radius_rad) = frame.circle().ok_or_else(|| {
            anyhow!("{}: its world coordinates give its corners no place", frame.file.path().display())
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
fn with_site(setup: &Setup, frames: &[TargetFrame], notices: &Notices) -> anyhow::Result<Setup> {
    if setup.site.is_some() || setup.mpc.is_some() || setup.lat.is_some() || setup.observer_elements.is_some() {
        return Ok(setup.clone());
    }
    let mut sites: Vec<Site> = Vec::new();
    for named in frames.iter().filter_map(|frame| frame.observatory.as_deref()) {
        if let Ok(site) = Site::by_name(named)
            && !sites.iter().any(|known| known.name == site.name)
        {
            sites.push(site);
        }
    }
    match &sites[..] {
        [] => Ok(setup.clone()),
        [site] => {
            notices.say(&format!(
                "site {} ({}) from the header",
                site.name,
                site.mpc_code.as_deref().unwrap_or("no code")
            ));
            Ok(Setup { site: Some(SiteSetup::Name(site.name.clone())), ..setup.clone() })
        }
        [first, second, ..] => Err(anyhow!(
            "frames of two observatories ({}, {}); inject into those of each apart",
            first.name,
            second.name
        )),
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
    side_deg * side_deg * chip.rows as f64 * chip.columns as f64
}

/// Band and system of a frame: as said, else by the first word of its filter.
pub fn photometry_of(setup: &Setup, frame: &TargetFrame, notices: &Notices) -> anyhow::Result<PhotometryOptions> {
    if setup.band.is_some() {
        return Ok(setup.photometry()?);
    }
    let word = frame.filter.as_deref().and_then(|filter| filter.split_whitespace().next());
    let name = word.map(|word| word.trim_end_matches('\'').to_owned());
    match name.as_deref().map(str::parse::<Band>) {
        Some(Ok(_)) => Ok(Setup { band: name, ..setup.clone() }.photometry()?),
        // Random streaks have a magnitude and no band.
        Some(Err(_)) if setup.elements.is_some() || setup.shells.is_some() => {
            let filter = frame.filter.as_deref().unwrap_or_default();
            notices
                .warn(&[format!("filter {filter:?} is no band that magnitudes are known in: V is taken; say --band")]);
            Ok(setup.photometry()?)
        }
        _ => Ok(setup.photometry()?),
    }
}

/// Lines of HISTORY: what was put in, and from what.
pub fn history(provenance: &Provenance, sources: &[&Source], seed: u64) -> Vec<String> {
    let version = env!("CARGO_PKG_VERSION");
    let mut lines = vec![format!("streakcast {version} inject: {} sources, seed {seed}", sources.len())];
    for key in ["elements", "shells", "site", "models", "earth_orientation"] {
        if let Some(value) = provenance.get(key) {
            lines.push(format!("streakcast {key}: {}", shortened(value)));
        }
    }
    lines
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
    super::super::judged::state_scales(provenance, "utc", photometry);
    provenance.state(
        "options",
        json!({
            "image": image.display().to_string(),
            "start_utc": streakcast::table::format_utc(frame.opened, 6),
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
