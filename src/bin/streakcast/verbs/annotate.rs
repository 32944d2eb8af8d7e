//! `annotate`: the schedule file again, lossless, with flags and streaks.

use streakcast::output::AtomicFile;
use streakcast::schedule::{Annotation, annotate, flag_table};

use super::judged::judge;
use crate::arguments::AnnotateArguments;
use crate::failure::Outcome;
use crate::output::cannot_write;

pub fn run(typed: AnnotateArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(typed.rules.setup())?;
    // Before any work: that a file can be made there.
    AtomicFile::check(&typed.output).map_err(|error| cannot_write(&typed.output, &error))?;
    let judged = judge(&setup, &typed.schedule, typed.shard)?;
    let annotation = Annotation {
        flags: &flag_table(&judged.report.flags),
        streaks: &judged.streaks,
        provenance: &judged.provenance,
        replace: typed.replace,
        keep: judged.keep.as_deref(),
    };
    let written = annotate(&typed.schedule, judged.schedule.format, &typed.output, &annotation)?;
    for path in written {
        judged.notices.say(&format!("wrote {}", path.display()));
    }
    Ok(Outcome::Done)
}
