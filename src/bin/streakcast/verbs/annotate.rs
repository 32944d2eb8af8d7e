//! `annotate`: the schedule file again, lossless, with flags and streaks.

use anyhow::anyhow;
use streakcast::schedule::{AnnotateError, Annotation, Schedule, ScheduleFormat, annotate, flag_table};

use super::judged::judge;
use crate::arguments::AnnotateArguments;
use crate::failure::Outcome;

pub fn run(typed: AnnotateArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(typed.rules.setup())?;
    if typed.output.is_dir() {
        return Err(anyhow!("output {} is a directory; a file is needed", typed.output.display()));
    }
    let read = Schedule::read(&typed.rules.schedule, &setup.schedule_options()?)?;
    if !matches!(read.format, ScheduleFormat::Csv | ScheduleFormat::Opsim) {
        let (path, format) = (typed.rules.schedule.display().to_string(), read.format.to_string());
        return Err(AnnotateError::Format { path, format }.into());
    }
    let judged = judge(&setup, &typed.rules.schedule)?;
    let annotation = Annotation {
        flags: &flag_table(&judged.report.flags),
        streaks: &judged.streaks,
        provenance: &judged.prepared.provenance,
        replace: typed.replace,
    };
    let written = annotate(&typed.rules.schedule, judged.schedule.format, &typed.output, &annotation)?;
    for path in written {
        judged.notices.say(&format!("wrote {}", path.display()));
    }
    Ok(Outcome::Done)
}
