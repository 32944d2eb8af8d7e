//! `flag`: writes a verdict for each exposure of a schedule.

use std::path::{Path, PathBuf};

use crate::arguments::OutputArguments;
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use streakcast::config::{Config, RulesConfig};
use streakcast::output::{Section, counted};
use streakcast::schedule::Shard;
use streakcast::schedule::{FlagReport, Verdict, VerdictKind, flag_table_with_exposures};

use super::passes::left_out_table;
use super::schedule_verdicts::judge;
use crate::failure::Outcome;
use crate::output::VerbResult;
use crate::required::Required;
use crate::screen::{Shown, Style, rounded, shown};

#[derive(Args)]
pub struct FlagArguments {
    /// Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON or VOTable
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    #[command(flatten)]
    pub rules: RulesConfig,
    /// Process only one share of the nights, for batch jobs: 3/100 is the third of 100 shares
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Exit with code 1 if any exposure has this verdict: streaked (includes avoid) or avoid; with code 2 if none can
    /// be judged
    #[arg(long, value_name = "VERDICT")]
    pub fail_on: Option<FailOn>,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum FailOn {
    Streaked,
    Avoid,
}

/// Number of rows of the table that are in memory at the same time if it is written as CSV.
const ROWS_AT_A_TIME: usize = 10_000;

const ON_SCREEN: &[Shown] = &[
    shown("exposure_id", "exposure"),
    shown("verdict", "verdict"),
    shown("n_streaks", "streaks"),
    rounded("brightest_mag", "brightest", 1),
    rounded("expected_lost_pixel_fraction", "lost", 4),
    rounded("p_any", "P any", 2),
    rounded("p_crossing", "P crossing", 2),
    rounded("streak_length_deg", "length deg", 2),
    rounded("acceptable_delay_s", "wait for limits s", 1),
    rounded("delay_s", "wait for clear s", 1),
    rounded("elements_age_days", "age d", 1),
    rounded("late_s", "late s", 1),
    shown("reasons", "reasons"),
    rounded("start_utc", "start (UTC)", 0),
    rounded("duration_s", "exposure s", 1),
    rounded("ra_deg", "RA deg", 3),
    rounded("dec_deg", "Dec deg", 3),
    shown("band", "band"),
];

/// Returns an error if no exposure was judged: scripts must not take a schedule of only invalid rows as clear. A batch
/// share without rows is accepted.
fn check_judged(report: &FlagReport, schedule: &Path) -> anyhow::Result<()> {
    let (flags, is_judged) =
        (&report.flags, |flag: &Verdict| !matches!(flag.kind, VerdictKind::Unknown | VerdictKind::Invalid));
    match flags.first() {
        Some(first) if !flags.iter().any(is_judged) => Err(anyhow!(
            "schedule {}: --fail-on has no result, because none of {} can be judged; exposure {}: {}",
            schedule.display(),
            counted(flags.len(), "exposure", "exposures"),
            first.exposure_id,
            first.reasons.join("; ")
        )),
        _ => Ok(()),
    }
}

pub fn run(typed: FlagArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules, ..typed.config }.with_file()?;
    let has_schedule = typed.schedule.is_some();
    Required::of(&config).input(has_schedule, "schedule", "--schedule FILE").satellites().site().field().check()?;
    let schedule = typed.schedule.unwrap_or_default();
    let output = typed.output.open(&config)?;
    let judged = judge(&config, &schedule, typed.shard, None)?;
    let (flags, exposures) = (&judged.report.flags, &judged.schedule.exposures);
    if output.takes_parts() {
        let parts = flags.chunks(ROWS_AT_A_TIME).zip(exposures.chunks(ROWS_AT_A_TIME));
        let parts = parts.map(|(flags, exposures)| flag_table_with_exposures(flags, exposures));
        let empty = flag_table_with_exposures(&[], &[]);
        output.write_parts("flags", &empty, parts, &judged.provenance, &judged.notices)?;
    } else {
        let flags = flag_table_with_exposures(flags, exposures);
        let left_out = left_out_table(&judged.report.left_out);
        output.write(
            &VerbResult {
                sections: vec![
                    Section { name: "flags", table: &flags },
                    Section { name: "left_out", table: &left_out },
                ],
                main: &flags,
                provenance: &judged.provenance,
                style: Style { columns: ON_SCREEN, bold_row: None },
            },
            &judged.notices,
        )?;
    }
    if typed.fail_on.is_some() {
        check_judged(&judged.report, &schedule)?;
    }
    let fails = |verdict| match typed.fail_on {
        None => false,
        Some(FailOn::Streaked) => matches!(verdict, VerdictKind::Streaked | VerdictKind::Avoid),
        Some(FailOn::Avoid) => verdict == VerdictKind::Avoid,
    };
    let failed = judged.report.flags.iter().any(|flag| fails(flag.kind));
    Ok(if failed { Outcome::No } else { Outcome::Done })
}
