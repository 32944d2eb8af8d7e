//! `flag`: one verdict for each exposure of a schedule.

use streakcast::output::Section;
use streakcast::schedule::{Verdict, flag_table};

use super::judged::judge;
use super::passes::left_out_table;
use crate::arguments::{FailOn, FlagArguments};
use crate::failure::Outcome;
use crate::output::Answer;
use crate::screen::{Shown, Style, rounded, shown};

const ON_SCREEN: &[Shown] = &[
    shown("exposure_id", "exposure"),
    shown("verdict", "verdict"),
    shown("n_streaks", "streaks"),
    rounded("brightest_mag", "brightest", 1),
    rounded("expected_lost_pixel_fraction", "lost", 4),
    rounded("p_any", "P any", 2),
    rounded("streak_length_deg", "length deg", 2),
    rounded("delay_s", "wait s", 1),
    shown("reasons", "reasons"),
];

pub fn run(typed: FlagArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(typed.rules.setup())?;
    let output = typed.output.open(&setup)?;
    let judged = judge(&setup, &typed.schedule, typed.shard)?;
    let flags = flag_table(&judged.report.flags);
    let left_out = left_out_table(&judged.report.left_out);
    output.write(&Answer {
        sections: vec![Section { name: "flags", table: &flags }, Section { name: "left_out", table: &left_out }],
        main: &flags,
        provenance: &judged.provenance,
        style: Style { columns: ON_SCREEN, bold_row: None },
    })?;
    let fails = |verdict| match typed.fail_on {
        None => false,
        Some(FailOn::Streaked) => matches!(verdict, Verdict::Streaked | Verdict::Avoid),
        Some(FailOn::Avoid) => verdict == Verdict::Avoid,
    };
    let failed = judged.report.flags.iter().any(|flag| fails(flag.verdict));
    Ok(if failed { Outcome::No } else { Outcome::Done })
}
