//! `annotate`: a lossless copy of the schedule file with verdicts and streaks.

use std::path::PathBuf;

use clap::Args;
use streakcast::config::{Config, RulesConfig};
use streakcast::output::AtomicFile;
use streakcast::schedule::Shard;
use streakcast::schedule::{Annotation, annotate, flag_table};

use super::judged::judge;
use crate::failure::Outcome;
use crate::output::cannot_write;

#[derive(Args)]
pub struct AnnotateArguments {
    /// Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON, VOTable or Parquet
    #[arg(long, value_name = "FILE")]
    pub schedule: PathBuf,
    #[command(flatten)]
    pub rules: RulesConfig,
    /// Output file; it may be the schedule itself
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// Only one share of the nights for batch jobs, for example 3/100; all shares together have every row
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
    // Checked before any work.
    AtomicFile::check(&typed.output).map_err(|error| cannot_write(&typed.output, &error))?;
    let judged = judge(&config, &typed.schedule, typed.shard)?;
    let annotation = Annotation {
        flags: &flag_table(&judged.report.flags),
        streaks: &judged.streaks,
        provenance: &judged.provenance,
        replace: typed.replace,
        keep: judged.keep.as_deref(),
    };
    let written = annotate(&typed.schedule, judged.schedule.format, &typed.output, &annotation)?;
    for path in written {
        judged.notices.info(&format!("wrote {}", path.display()));
    }
    Ok(Outcome::Done)
}
