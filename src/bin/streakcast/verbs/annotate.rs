//! `annotate`: the schedule file again, lossless, with flags and streaks.

use streakcast::schedule::{AnnotateError, Annotation, Schedule, ScheduleFormat, annotate, flag_table};
use streakcast::table::check_target;

use super::judged::judge;
use crate::arguments::AnnotateArguments;
use crate::failure::Outcome;
use crate::output::cannot_write;

pub fn run(typed: AnnotateArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(typed.rules.setup())?;
    // Before any work: that a file can be made there.
    check_target(&typed.output).map_err(|error| cannot_write(&typed.output, &error))?;
    let read = Schedule::read(&typed.schedule, &setup.schedule_options()?)?;
    if !matches!(read.format, ScheduleFormat::Csv | ScheduleFormat::Opsim) {
        let (path, format) = (typed.schedule.display().to_string(), read.format.to_string());
        return Err(AnnotateError::Format { path, format }.into());
    }
    let judged = judge(&setup, &typed.schedule)?;
    let annotation = Annotation {
        flags: &flag_table(&judged.report.flags),
        streaks: &judged.streaks,
        provenance: &judged.provenance,
        replace: typed.replace,
    };
    let written = annotate(&typed.schedule, judged.schedule.format, &typed.output, &annotation)?;
    for path in written {
        judged.notices.say(&format!("wrote {}", path.display()));
    }
    Ok(Outcome::Done)
}
