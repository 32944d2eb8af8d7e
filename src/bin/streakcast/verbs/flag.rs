//! `flag`: writes a verdict for each exposure of a schedule.

use std::path::{Path, PathBuf};

use crate::arguments::OutputArguments;
use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use streakcast::config::{Config, FIELD, RequiredInput, RulesConfig, SATELLITES, SITE};
use streakcast::output::counted;
use streakcast::schedule::Shard;
use streakcast::schedule::{FlagTotals, VerdictKind, flag_table_with_exposures};

use super::passes::left_out_table;
use super::schedule_verdicts::PreparedSchedule;
use crate::failure::Outcome;
use crate::help::{VerbFlags, help};
use crate::output::VerbResult;
use crate::screen::{Shown, rounded, shown};

#[derive(Args)]
pub struct FlagArguments {
    /// Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON or VOTable
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    #[command(flatten)]
    pub rules: RulesConfig,
    /// For a telescope in orbit, crossings in the Earth's shadow count too, for example in the infrared
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub include_dark: Option<bool>,
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

/// Schedule of exposures.
pub const SCHEDULE: RequiredInput = RequiredInput::new("schedule", &[&["--schedule FILE"]]);

help! {
    FlagArguments, "flag", asks [SCHEDULE, SATELLITES, SITE, FIELD],
    "--schedule night.csv --elements active.tle --mpc X05 --telescope rubin --limit-mag 7",
    "--schedule night.csv --shells starlink-gen1 --site Paranal --fov 1deg --fail-on avoid"
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum FailOn {
    Streaked,
    Avoid,
}

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
    rounded("streak_cost_s", "cost s", 2),
    shown("reasons", "reasons"),
    rounded("start_utc", "start (UTC)", 0),
    rounded("duration_s", "exposure s", 1),
    rounded("ra_deg", "RA deg", 3),
    rounded("dec_deg", "Dec deg", 3),
    shown("band", "band"),
];

/// Returns an error if no exposure was judged: scripts must not take a schedule of only invalid rows as clear. A batch
/// share without rows is accepted.
fn check_judged(totals: &FlagTotals, schedule: &Path) -> anyhow::Result<()> {
    let not_judged = [VerdictKind::Unknown, VerdictKind::Invalid];
    let first = not_judged.into_iter().find_map(|kind| totals.first(kind));
    match first {
        Some(first) if not_judged.map(|kind| totals.count(kind)).iter().sum::<usize>() == totals.exposures() => {
            Err(anyhow!(
                "schedule {}: --fail-on has no result, because none of {} can be judged; exposure {}: {}",
                schedule.display(),
                counted(totals.exposures(), "exposure", "exposures"),
                first.exposure_id,
                first.reasons.join("; ")
            ))
        }
        _ => Ok(()),
    }
}

pub fn run(typed: FlagArguments) -> anyhow::Result<Outcome> {
    let include_dark = typed.include_dark;
    let config = Config { rules: typed.rules, include_dark, ..typed.config }.with_file()?;
    if include_dark == Some(true) && config.has_viewpoint() && !config.is_in_orbit() {
        bail!(
            "--include-dark is for a telescope in orbit (--observer-elements): at a site a satellite in shadow is not visible"
        );
    }
    FlagArguments::HELP.check(&config, &[(&SCHEDULE, typed.schedule.is_some())])?;
    let schedule = typed.schedule.unwrap_or_default();
    let output = typed.output.open(&config)?;
    let prepared = PreparedSchedule::read(&config, &schedule, typed.shard, None)?;
    let PreparedSchedule { provenance, notices, .. } = &prepared;
    let totals = if output.takes_parts() {
        let empty = flag_table_with_exposures(&[], &[]);
        let mut totals = FlagTotals::default();
        output.write_parts("flags", &empty, provenance, notices, |write| {
            totals = prepared.judge_in_parts(&mut |rows, flags| Ok(write(&flag_table_with_exposures(flags, rows))?))?;
            Ok(())
        })?;
        totals
    } else {
        let (flags, totals) = prepared.judge()?;
        let flags = flag_table_with_exposures(&flags, &prepared.schedule.exposures);
        let left_out = left_out_table(totals.left_out());
        output.write(&VerbResult::new("flags", &flags, ON_SCREEN, provenance).with("left_out", &left_out), notices)?;
        totals
    };
    if typed.fail_on.is_some() {
        check_judged(&totals, &schedule)?;
    }
    let avoided = totals.count(VerdictKind::Avoid);
    let failed = match typed.fail_on {
        None => 0,
        Some(FailOn::Streaked) => totals.count(VerdictKind::Streaked) + avoided,
        Some(FailOn::Avoid) => avoided,
    };
    Ok(if failed > 0 { Outcome::No } else { Outcome::Done })
}
