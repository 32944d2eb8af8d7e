//! `annotate`: writes a copy of the schedule file with verdicts and streaks.

use std::path::PathBuf;

use clap::Args;
use streakcast::config::{Config, FIELD, RequiredInput, RulesConfig, SATELLITES, SITE};
use streakcast::schedule::Shard;
use streakcast::schedule::{Annotation, annotate, check_not_annotated, flag_table};

use super::flag::SCHEDULE;
use super::schedule_verdicts::PreparedSchedule;
use crate::failure::Outcome;
use crate::help::{VerbFlags, help};
use crate::output::check_whole;

#[derive(Args)]
pub struct AnnotateArguments {
    /// Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON or VOTable
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    #[command(flatten)]
    pub rules: RulesConfig,
    /// Output file; it may be the schedule itself
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Process only one share of the nights, for batch jobs: 3/100 is the third of 100 shares
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Replace an earlier annotation in the file
    #[arg(long)]
    pub replace: bool,
    #[command(flatten)]
    pub config: Config,
}

/// Annotated schedule, or frame with streaks.
pub const OUTPUT: RequiredInput = RequiredInput::new("output file", &[&["-o FILE"]]);

help! {
    AnnotateArguments, "annotate", asks [SCHEDULE, OUTPUT, SATELLITES, SITE, FIELD],
    "--schedule baseline.db --elements active.tle --mpc X05 --telescope rubin -o annotated.db",
    "--schedule night.ecsv --shells oneweb --mpc X05 --fov 3.5deg -o annotated.ecsv"
}

pub fn run(typed: AnnotateArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules, ..typed.config }.with_file()?;
    let answers = [(&SCHEDULE, typed.schedule.is_some()), (&OUTPUT, typed.output.is_some())];
    AnnotateArguments::HELP.check(&config, &answers)?;
    let (schedule, output) = (typed.schedule.unwrap_or_default(), typed.output.unwrap_or_default());
    // Files are checked before the computation, which may be long.
    check_whole(&output)?;
    let prepared = PreparedSchedule::read(&config, &schedule, typed.shard, Some(&output))?;
    if !typed.replace {
        check_not_annotated(&schedule, prepared.schedule.format)?;
    }
    let (flags, streaks) = prepared.judge_with_streaks()?;
    let annotation = Annotation {
        flags: &flag_table(&flags),
        streaks: &streaks,
        provenance: &prepared.provenance,
        replace: typed.replace,
        keep: prepared.keep.as_deref(),
    };
    let written = annotate(&schedule, prepared.schedule.format, &output, &annotation)?;
    for path in written {
        prepared.notices.wrote(&path);
    }
    Ok(Outcome::Done)
}
