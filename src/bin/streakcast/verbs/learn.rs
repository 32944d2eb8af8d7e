//! `learn`: offsets of satellites and kinds from their brightness models, and errors along the track.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use streakcast::Watch;
use streakcast::config::{Config, ModelAssignment};
use streakcast::elements::{Generation, GenerationTable, History, NoradId};
use streakcast::learn::{
    MeasuredDelay, Pass, kind_table, learn, leave_out_table, leave_passes_out, passes_of, read_delays,
};
use streakcast::output::{Provenance, counted};
use streakcast::passes::ModelChoice;
use streakcast::photometry::Earthshine;

use super::fit::{PhotometryArguments, config_of, history_of_flags, measured, state_photometry};
use crate::failure::Outcome;
use crate::help::help;
use crate::notices::Notices;
use crate::output::{Output, VerbResult, check, write_bytes};
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

/// Photometry, with the kinds and models of its satellites.
#[derive(Args)]
pub struct ResidualArguments {
    #[command(flatten)]
    pub photometry: PhotometryArguments,
    /// Kind of all satellites (starlink-v1.5, oneweb, ...); from the element sets of --elements if omitted
    #[arg(long, value_name = "KIND", help_heading = "Model")]
    pub kind: Option<String>,
    /// Brightness model for one kind of satellite as KIND=MODEL, as for other verbs; the default models if omitted
    #[arg(long, value_name = "[KIND=]MODEL", help_heading = "Model")]
    pub model: Vec<ModelAssignment>,
    /// Only sunlight on the panels of models: ignore earthshine and the diffuse body
    #[arg(long, help_heading = "Model")]
    pub no_earthshine: bool,
}

#[derive(Args)]
pub struct LearnArguments {
    #[command(flatten)]
    pub residuals: ResidualArguments,
    /// Tables of streakcast measure (CSV), from which errors along the track are learned
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = "Photometry")]
    pub measured: Vec<PathBuf>,
    /// Predict each pass from the other satellites and this number of other passes of its satellite, and print the
    /// residuals
    #[arg(long, value_name = "N", value_delimiter = ',', help_heading = "Output")]
    pub leave_pass_out: Vec<usize>,
    /// Format of the table on standard output: table, csv, ecsv, json, jsonl, votable
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub format: Option<String>,
    /// Learned file (JSON), for --learned
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: PathBuf,
}

help! {
    LearnArguments, "learn",
    "--photometry photometry.csv --elements history.tle -o learned.json",
    "--photometry mmt.csv --height-km 1200 --kind oneweb -o learned.json --leave-pass-out 0,1,2"
}

const KINDS_ON_SCREEN: &[Shown] = &[
    shown("kind", "kind"),
    shown("model", "model"),
    shown("satellites", "satellites"),
    shown("passes", "passes"),
    rounded("offset_mag", "offset", 2),
    rounded("offset_sigma_mag", "+-", 2),
    rounded("satellite_sigma_mag", "satellites", 2),
    rounded("pass_scale_mag", "passes", 2),
    rounded("point_sigma_mag", "points", 2),
    rounded("sigma_mag", "sigma", 2),
    rounded("lateness_factor", "lateness", 2),
];

const LEAVE_OUT_ON_SCREEN: &[Shown] = &[
    shown("kind", "kind"),
    shown("seen_passes", "seen"),
    shown("passes", "passes"),
    rounded("model_rms_mag", "rms model", 2),
    rounded("learned_rms_mag", "rms learned", 2),
    rounded("model_half_width_mag", "68 % model", 2),
    rounded("learned_half_width_mag", "68 % learned", 2),
    rounded("model_within_one_sigma", "in 1 sigma model", 2),
    rounded("learned_within_one_sigma", "in 1 sigma learned", 2),
];

/// Passes with the models of their satellites.
pub struct Residuals {
    pub passes: Vec<Pass>,
    pub models: ModelChoice,
    /// Files, options and thresholds.
    pub provenance: Provenance,
    /// Kind of all satellites, or element sets that determine the kinds.
    kind: Option<Generation>,
    history: Option<History>,
}

impl Residuals {
    /// Returns the kind of a satellite; `None` if it is unknown.
    pub fn kind_of(&self, norad_id: NoradId) -> Option<Generation> {
        kind_of(self.kind, self.history.as_ref(), norad_id)
    }
}

fn kind_of(kind: Option<Generation>, history: Option<&History>, norad_id: NoradId) -> Option<Generation> {
    let table = GenerationTable::embedded();
    kind.or_else(|| history?.sets_of(norad_id).last().map(|set| table.generation(set)))
}

/// Reads photometry and computes residuals.
pub fn residuals(typed: &ResidualArguments) -> anyhow::Result<(Residuals, Notices)> {
    let config = Config { model: typed.model.clone(), ..config_of(&typed.photometry.tables) };
    let notices = begin(&config)?;
    let kind = match &typed.kind {
        Some(name) => Some(Generation::by_name(name).ok_or_else(|| {
            anyhow!("unknown kind of satellite '{name}'; allowed: {}", Generation::ALL.map(Generation::name).join(", "))
        })?),
        None if typed.photometry.elements.is_empty() => {
            return Err(anyhow!("missing kind of the satellites; specify --kind KIND, or --elements FILE..."));
        }
        None => None,
    };
    let models = config.model_choice()?;
    let history = history_of_flags(&typed.photometry)?;
    let (measurements, filters) = measured(&typed.photometry, &config, history.as_ref(), &notices)?;
    let earthshine = if typed.no_earthshine { Earthshine::Off } else { Earthshine::Computed };
    let (passes, left_out) = passes_of(&measurements, |id| kind_of(kind, history.as_ref(), id), &models, earthshine);
    let reasons: Vec<String> = left_out.reasons().map(|(reason, count)| format!("{count} {reason}")).collect();
    if passes.is_empty() {
        return Err(anyhow!(
            "no measurement can be used: {}; allowed: times, satellite numbers (or --identified), and kinds with a model",
            reasons.join(", ")
        ));
    }
    if !reasons.is_empty() {
        notices.info(&format!("measurements left out: {}", reasons.join(", ")));
    }
    for kind in Generation::ALL.into_iter().filter(|kind| passes.iter().any(|pass| pass.kind() == *kind)) {
        let band = models.of_kind(kind).map(|model| model.band().0);
        if let Some(mismatch) = band.and_then(|band| filters.mismatch(band)) {
            notices.warn(&[mismatch.to_string()]);
            break;
        }
    }
    let mut provenance = Provenance::new();
    state_photometry(&typed.photometry, &mut provenance);
    provenance.state("earthshine", earthshine.name());
    if let Some(kind) = kind {
        provenance.state("kind", kind.name());
    }
    Ok((Residuals { passes, models, provenance, kind, history }, notices))
}

pub fn run(typed: LearnArguments) -> anyhow::Result<Outcome> {
    check(&typed.output)?;
    let output = Output::new(typed.format.as_deref(), None)?;
    let (mut found, notices) = residuals(&typed.residuals)?;
    let mut delays: BTreeMap<Generation, Vec<MeasuredDelay>> = BTreeMap::new();
    let (mut without_kind, mut not_searched) = (0, 0);
    for path in &typed.measured {
        for delay in read_delays(path)? {
            match found.kind_of(delay.norad_id) {
                None => without_kind += 1,
                Some(_) if !delay.is_range_searched() => not_searched += 1,
                Some(kind) => delays.entry(kind).or_default().push(delay),
            }
        }
    }
    if without_kind > 0 {
        notices.info(&format!("{} left out, of satellites without a kind", counted(without_kind, "delay", "delays")));
    }
    if not_searched > 0 {
        notices.info(&format!(
            "{} left out: three sigmas of the prediction exceed the 5 s that measure searches",
            counted(not_searched, "delay", "delays")
        ));
    }
    if !typed.measured.is_empty() {
        found.provenance.state("measured", super::fit::names(&typed.measured));
    }
    let stated = found.provenance.entries().map(|(name, value)| (name.to_owned(), value.clone())).collect();
    let learned = learn(&found.passes, &delays, &found.models, stated, &Watch::default())?;
    for kind in &learned.without_satellites {
        notices.info(&format!(
            "offsets of single satellites of {kind} are not written: they do not improve the predictions of other passes"
        ));
    }
    write_bytes(&typed.output, learned.file.to_json().as_bytes(), &notices)?;
    notices.info(&format!(
        "{} in {} of {}",
        counted(found.passes.iter().map(|pass| pass.points().len()).sum(), "measurement", "measurements"),
        counted(found.passes.len(), "pass", "passes"),
        counted(learned.file.satellites.len(), "satellite", "satellites"),
    ));
    let (name, table, columns) = if typed.leave_pass_out.is_empty() {
        ("kinds", kind_table(&learned.file), KINDS_ON_SCREEN)
    } else {
        let rows = leave_passes_out(&found.passes, &found.models, &typed.leave_pass_out);
        ("leave_pass_out", leave_out_table(&rows), LEAVE_OUT_ON_SCREEN)
    };
    output.write(&VerbResult::new(name, &table, columns, &found.provenance), &notices)?;
    Ok(Outcome::Done)
}
