//! `reproduce`: compares published numbers of satellites with computed ones.

use std::path::PathBuf;

use crate::arguments::OutputArguments;
use anyhow::{anyhow, bail};
use clap::Args;
use clap::ValueEnum;
use hifitime::Epoch;
use serde_json::json;
use streakcast::config::{Config, RunConfig, SiteConfig};
use streakcast::elements::{Constellation, ReadOptions, Satellites};
use streakcast::forecast::{
    HU2022, Night, Reproduced, bassa2022, borlaff2026, hu2022, lu2024b, lu2024b_constellations, reproduced_table,
};
use streakcast::frames::parse_instant;
use streakcast::frames::{EopTable, mjd_utc, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::output::{Provenance, counted, format_utc};
use streakcast::passes::{Exposure, Field, ModelChoice, Sky};
use streakcast::photometry::ModelLibrary;
use streakcast::schedule::{Schedule, night_of};

use super::lu2024::{self, Lu2024Arguments};

use crate::failure::Outcome;
use crate::help::help;
use crate::notices::Notices;
use crate::output::VerbResult;
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum Paper {
    /// LSST visits with streaks: Hu et al. 2022
    Hu2022,
    /// Model, tests and figures on simulated or MMT-9 photometry: Lu 2024 (arXiv 2403.05831); -o names a folder
    Lu2024,
    /// Satellites brighter than 7 mag: Lu 2024 (arXiv 2403.11118)
    Lu2024b,
    /// Trails in the exposures of SPHEREx, Hubble, Xuntian and a telescope at 800 km: Borlaff et al. 2025, 2026
    Borlaff2026,
    /// Satellites above an altitude from the density of shells: Bassa et al. 2022
    Bassa2022,
}

#[derive(Args)]
pub struct ReproduceArguments {
    /// Paper to reproduce
    pub paper: Paper,
    /// Schedule of LSST visits for hu2022, for example thirteen nights of a baseline (any format of flag)
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// Time scale of times that have none: utc, tai or tt
    #[arg(long, value_name = "SCALE")]
    pub time_scale: Option<String>,
    /// Number of threads, 1 to 1024; all cores if omitted
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Suppress warnings, summaries and progress
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub lu2024: Lu2024Arguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! { ReproduceArguments, "reproduce", "bassa2022", "hu2022 --schedule baseline.db --time-scale utc" }

const ON_SCREEN: &[Shown] = &[
    shown("quantity", "quantity"),
    shown("unit", "unit"),
    rounded("published", "published", 2),
    rounded("ours", "ours", 2),
    rounded("ours_sigma", "+-", 2),
    rounded("difference_percent", "difference %", 1),
    shown("agrees", "within 20 %"),
];

/// Columns for papers without printed numbers; the formula of the paper is evaluated instead.
const METHOD_ON_SCREEN: &[Shown] = &[
    shown("quantity", "quantity"),
    rounded("by_method", "by their formula", 2),
    rounded("ours", "ours", 2),
    rounded("difference_percent", "difference %", 1),
    shown("agrees", "within 20 %"),
];

/// Dates (MJD) of the first ten thousand visits, for which Hu et al. released counts: 2023-10-01 to 13.
const FIRST_VISITS_MJD: [f64; 2] = [60_218.0, 60_231.0];
/// Accepted number of visits in these nights. It differs slightly between baseline simulations.
const FIRST_VISITS: std::ops::RangeInclusive<usize> = 9_000..=11_000;

/// Diameter of Rubin's field of view, degrees.
const RUBIN_FIELD_DEG: f64 = 3.5;
/// Highest altitude of the Sun for the counts of Lu (2024, arXiv 2403.11118), degrees.
const LU_SUN_DEG: f64 = -12.0;
/// Interval between two of these counts in a night, seconds.
const LU_STEP_S: f64 = 1200.0;

pub fn run(typed: ReproduceArguments) -> anyhow::Result<Outcome> {
    let config = Config {
        time_scale: typed.time_scale.clone(),
        run: RunConfig { threads: typed.threads, quiet: Some(typed.quiet), ..RunConfig::default() },
        site: SiteConfig { mpc: Some("X05".to_owned()), ..SiteConfig::default() },
        ..Config::default()
    };
    if typed.paper != Paper::Hu2022 {
        for (flag, is_given) in [("--schedule", typed.schedule.is_some()), ("--time-scale", typed.time_scale.is_some())]
        {
            if is_given {
                let paper =
                    typed.paper.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
                bail!("{flag} has no effect on reproduce {paper}; allowed: --threads, --quiet, --format, --output");
            }
        }
    }
    let allowed: &[&str] = if typed.paper == Paper::Borlaff2026 { &["--elements", "--seed"] } else { &[] };
    match (typed.paper, typed.lu2024.given().find(|flag| !allowed.contains(flag))) {
        (Paper::Lu2024, _) => {
            let folder = typed.output.output.as_deref().ok_or_else(|| {
                anyhow!("missing folder for the report and its pictures; specify -o DIR, for example -o lu2024")
            })?;
            let notices = begin(&config)?;
            let config = Config { site: SiteConfig::default(), ..config };
            return lu2024::run(&typed.lu2024, folder, typed.output.format.as_deref(), &config, &notices);
        }
        (Paper::Borlaff2026, Some(flag)) => {
            bail!("{flag} has no effect on reproduce borlaff2026; allowed: --elements, --seed")
        }
        (_, Some(flag)) => bail!("{flag} has no effect on this paper; allowed: reproduce lu2024"),
        _ => {}
    }
    let output = typed.output.open(&config)?;
    let notices = begin(&config)?;
    let mut provenance = Provenance::new();
    provenance.state("synthetic", true);
    let rows = match typed.paper {
        Paper::Hu2022 => {
            let path = typed.schedule.as_ref().ok_or_else(|| {
                anyhow!(
                    "missing visits of LSST; specify --schedule FILE (opsim SQLite of a baseline) and --time-scale utc"
                )
            })?;
            let schedule = Schedule::read(path, &config.schedule_options()?)?;
            let exposures: Vec<Exposure> = schedule.valid_exposures().map(|(_, exposure)| exposure.clone()).collect();
            provenance.state("schedule", json!({ "file": path.display().to_string(), "visits": exposures.len() }));
            of_hu(&config, &exposures, &notices)?
        }
        Paper::Lu2024 => Vec::new(),
        Paper::Lu2024b => of_lu()?,
        Paper::Bassa2022 => of_bassa()?,
        Paper::Borlaff2026 => {
            let Lu2024Arguments { elements, seed, .. } = &typed.lu2024;
            let (rows, angles) = of_borlaff(elements, seed.unwrap_or(1), &notices)?;
            provenance.state("synthetic", false);
            provenance.state("elements", elements.iter().map(|path| path.display().to_string()).collect::<Vec<_>>());
            provenance.attach("spherex_position_angles", angles);
            rows
        }
    };
    let table = reproduced_table(&rows);
    output.write(
        &VerbResult::new(
            "reproduced",
            &table,
            if typed.paper == Paper::Bassa2022 { METHOD_ON_SCREEN } else { ON_SCREEN },
            &provenance,
        ),
        &notices,
    )?;
    let mut printed: Vec<String> = Vec::new();
    for row in &rows {
        let reason =
            if row.reason.is_empty() { String::new() } else { format!("reason for the difference: {}", row.reason) };
        for words in [row.source.to_owned(), row.assumed.clone(), reason] {
            if !words.is_empty() && !printed.contains(&words) {
                notices.info(&words);
                printed.push(words);
            }
        }
    }
    Ok(Outcome::Done)
}

fn of_hu(config: &Config, exposures: &[Exposure], notices: &Notices) -> anyhow::Result<Vec<Reproduced>> {
    let span = exposures
        .iter()
        .map(|exposure| exposure.start)
        .min()
        .zip(exposures.iter().map(|exposure| exposure.start).max());
    let (first, last) = span.ok_or_else(|| anyhow!("the schedule has no valid visit; allowed: one or more"))?;
    let is_within = FIRST_VISITS_MJD[0] <= mjd_utc(first) && mjd_utc(last) < FIRST_VISITS_MJD[1];
    let is_first_visits = is_within && FIRST_VISITS.contains(&exposures.len());
    let visits = counted(exposures.len(), "visit", "visits");
    if !is_first_visits {
        notices.warn(&[format!(
            "the schedule ({visits} from {} to {}) is not that of the first 10,000 of the paper (2023-10-01 to 13): it is compared \
             with the whole year, and season, field and schedule make differences of more than 20 %",
            format_utc(first, 0),
            format_utc(last, 0)
        )]);
    }
    let field = Field::circle(RUBIN_FIELD_DEG.to_radians())?;
    let assumed = format!(
        "computed: {visits} from {} to {}, a circular field of {RUBIN_FIELD_DEG} deg, lit satellites of any magnitude, shells of \
         this library; published: the visits of a year",
        format_utc(first, 0),
        format_utc(last, 0)
    );
    let rows: Vec<Vec<Reproduced>> = HU2022
        .iter()
        .map(|(name, _)| {
            let with_shells = Config { shells: vec![(*name).to_owned().into()], ..config.clone() };
            let prepared = with_shells.prepare(first, last)?;
            Ok(hu2022(name, &prepared.sky, exposures, &field, is_first_visits, &assumed)?)
        })
        .collect::<anyhow::Result<_>>()?;
    Ok(rows.concat())
}

/// Number of random pointings of each space telescope.
const POINTINGS: usize = 1000;

/// Returns the rows, and the numbers of trails of SPHEREx by position angle in bins of 10 deg from -90 deg.
fn of_borlaff(elements: &[PathBuf], seed: u64, notices: &Notices) -> anyhow::Result<(Vec<Reproduced>, [usize; 18])> {
    if elements.is_empty() {
        bail!("missing satellites; specify --elements FILE, a catalogue of April 2025 or later with SPHEREx (63182)");
    }
    let mut sets = Satellites::read(elements, &ReadOptions::default())?.element_sets;
    // The catalogue of the paper has satellites and rocket bodies, and debris only if its size is known.
    let count = sets.len();
    sets.retain(|set| !set.name.split_whitespace().any(|word| word == "DEB"));
    let debris = count - sets.len();
    let mut epochs: Vec<Epoch> = sets.iter().map(|set| set.epoch).collect();
    epochs.sort();
    let middle = *epochs.get(epochs.len() / 2).ok_or_else(|| anyhow!("the elements have no element set"))?;
    // The day around the median epoch, at which most elements are recent.
    let start = seconds_after(middle, -43_200.0);
    let choice = ModelChoice::new(&ModelLibrary::embedded())?;
    let site = Observer::new(Site::from_mpc("X05")?);
    let sky = Sky::with_models(sets, site, EopTable::embedded(), &choice);
    let (rows, of_spherex) = borlaff2026(&sky, start, POINTINGS, seed)?;
    notices.info(&format!(
        "catalogue: {} with a median epoch of {}, without {debris} of debris; published for 15,000 to 16,656 objects of 2025",
        counted(sky.elements().len(), "object", "objects"),
        format_utc(middle, 0)
    ));
    Ok((rows, of_spherex.position_angles(false)))
}

fn sky_of(constellations: &[Constellation], site: Site, epoch: Epoch) -> anyhow::Result<Sky> {
    let elements = constellations.iter().flat_map(|constellation| constellation.element_sets(epoch)).collect();
    let choice = ModelChoice::new(&ModelLibrary::embedded())?;
    Ok(Sky::with_models(elements, Observer::new(site), EopTable::embedded().without_polar_motion(), &choice))
}

fn of_lu() -> anyhow::Result<Vec<Reproduced>> {
    let constellations = lu2024b_constellations()?;
    let site = Site::from_mpc("X05")?;
    let assumed = format!(
        "computed: Rubin Observatory, the 15th of each month of 2025 every {:.0} min with the Sun below {LU_SUN_DEG} deg, all lit \
         satellites above the altitude, a model of V1.5 fitted to other photometry than that of the paper; the abstract of the \
         paper has neither altitude nor hours",
        LU_STEP_S / 60.0
    );
    let mut sums: Option<Vec<Reproduced>> = None;
    let mut moments = Vec::new();
    let mut sky = None;
    for month in 1..=12 {
        let evening = parse_instant(&format!("2025-{month:02}-15T12:00:00Z"), None)?;
        let (from, to) = night_of(evening, site.longitude_rad);
        if sky.is_none() {
            sky = Some(sky_of(&constellations, site.clone(), from)?);
        }
        let Some(sky) = &sky else { continue };
        for (from, until) in Night::over(sky, from, to, Some(LU_SUN_DEG.to_radians()))?.dark {
            let mut moment = from;
            while moment < until {
                moments.push(moment);
                moment = seconds_after(moment, LU_STEP_S);
            }
        }
    }
    if let Some(sky) = &sky {
        let rows = [(20.0_f64, true), (0.0, false), (30.0, false)]
            .iter()
            .map(|&(altitude_deg, is_theirs)| lu2024b(sky, &moments, altitude_deg.to_radians(), is_theirs, &assumed))
            .collect::<Result<_, _>>()?;
        sums = Some(rows);
    }
    Ok(sums.unwrap_or_default())
}

fn of_bassa() -> anyhow::Result<Vec<Reproduced>> {
    let start = parse_instant("2025-03-20T00:00:00Z", None)?;
    let assumed = "computed: SGP4 with the shells of this library over Paranal, the mean of 144 moments of a day; compared with the method of \
                   the paper, which has no printed counts";
    let mut rows = Vec::new();
    for name in ["starlink-gen1", "starlink-gen2", "oneweb", "kuiper", "guowang"] {
        let constellation = Constellation::by_name(name)?;
        let sky = sky_of(std::slice::from_ref(&constellation), Site::by_name("Paranal")?, start)?;
        for altitude_deg in [0.0_f64, 20.0, 30.0] {
            rows.push(bassa2022(&constellation, &sky, start, altitude_deg.to_radians(), assumed)?);
        }
    }
    Ok(rows)
}
