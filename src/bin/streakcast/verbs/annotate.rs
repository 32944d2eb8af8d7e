//! `annotate`: writes a copy of the schedule file with verdicts and streaks.

use std::path::PathBuf;

use clap::Args;
use streakcast::config::{Config, RulesConfig};
use streakcast::schedule::Shard;
use streakcast::schedule::{Annotation, annotate, flag_table};

use super::schedule_verdicts::PreparedSchedule;
use crate::failure::Outcome;
use crate::output::check_whole;
use crate::required::Required;

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

pub fn run(typed: AnnotateArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules, ..typed.config }.with_file()?;
    Required::new(&config)
        .input(typed.schedule.is_some(), "schedule", "--schedule FILE")
        .input(typed.output.is_some(), "output file", "-o FILE")
        .satellites()
        .site()
        .field()
        .check()?;
    let (schedule, output) = (typed.schedule.unwrap_or_default(), typed.output.unwrap_or_default());
    // The output is checked before the computation, which may be long.
    check_whole(&output)?;
    let prepared = PreparedSchedule::read(&config, &schedule, typed.shard, Some(&output))?;
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
