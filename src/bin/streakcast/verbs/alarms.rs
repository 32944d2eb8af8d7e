//! `alarms`: improbable brightness of satellites, compared with a learned file.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use streakcast::learn::{alarm_table, find_alarms};
use streakcast::output::counted;
use streakcast::passes::LearnedFile;

use super::learn::{ResidualArguments, residuals};
use crate::arguments::OutputArguments;
use crate::failure::Outcome;
use crate::help::help;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};

#[derive(Args)]
pub struct AlarmsArguments {
    #[command(flatten)]
    pub residuals: ResidualArguments,
    /// Learned file of earlier measurements, by streakcast learn
    #[arg(long, value_name = "FILE", help_heading = "Model")]
    pub learned: PathBuf,
    /// Largest probability of an alarm, multiplied by the number of tests (column looks)
    #[arg(long, value_name = "P", default_value_t = 1e-4, help_heading = "Alarms")]
    pub probability: f64,
    /// Picture of the differences against time, .png or .svg
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub picture: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    AlarmsArguments, "alarms",
    "--photometry tonight.csv --elements history.tle --learned learned.json",
    "--photometry mmt.csv --height-km 1200 --kind oneweb --learned learned.json --picture alarms.png"
}

const ON_SCREEN: &[Shown] = &[
    shown("alarm", "alarm"),
    shown("norad_id", "norad"),
    shown("kind", "kind"),
    rounded("first_utc", "first (UTC)", 0),
    shown("passes", "passes"),
    rounded("difference_mag", "difference", 2),
    rounded("trend_mag_day", "mag/day", 3),
    rounded("amplitude_mag", "amplitude", 2),
    rounded("period_s", "period s", 2),
    shown("p_after_looks", "p"),
];

pub fn run(typed: AlarmsArguments) -> anyhow::Result<Outcome> {
    if !(typed.probability > 0.0 && typed.probability <= 1.0) {
        return Err(anyhow!("probability is {}; allowed: above 0, at most 1", typed.probability));
    }
    if let Some(path) = &typed.picture {
        streakcast::plot::PictureFormat::from_extension(path)?;
        crate::output::check(path)?;
    }
    let output = Output::new(typed.output.format.as_deref(), typed.output.output.clone())?;
    let name = typed.learned.display().to_string();
    let learned = LearnedFile::read(&typed.learned)?;
    let (mut found, notices) = residuals(&typed.residuals)?;
    // Checks that the models are those of the file.
    found.models.clone().with_learned(learned.clone(), &name)?;
    let alarms = find_alarms(&found.passes, &learned, typed.probability);
    if alarms.not_learned > 0 {
        let passes = counted(alarms.not_learned, "pass", "passes");
        notices.warn(&[format!("the brightness of {passes} is not tested: {name} lacks the kinds of the satellites")]);
    }
    notices.info(&format!(
        "{} tested, trends of {}, periods in {}: {}",
        counted(alarms.passes, "pass", "passes"),
        counted(alarms.trends, "satellite", "satellites"),
        counted(alarms.searched, "pass", "passes"),
        counted(alarms.alarms.len(), "alarm", "alarms")
    ));
    if let Some(path) = &typed.picture {
        picture(path, &found.passes, &learned, &alarms.alarms, &notices)?;
    }
    found.provenance.state("learned", learned.summary(&name));
    found.provenance.state("probability", typed.probability);
    found.provenance.state("passes_tested", alarms.passes);
    found.provenance.state("trends_tested", alarms.trends);
    found.provenance.state("passes_searched_for_periods", alarms.searched);
    let table = alarm_table(&alarms.alarms);
    output.write(&VerbResult::new("alarms", &table, ON_SCREEN, &found.provenance), &notices)?;
    Ok(Outcome::Done)
}

/// Draws the differences of all passes and the alarms.
fn picture(
    path: &std::path::Path,
    passes: &[streakcast::learn::Pass],
    learned: &LearnedFile,
    alarms: &[streakcast::learn::Alarm],
    notices: &crate::notices::Notices,
) -> anyhow::Result<()> {
    use streakcast::learn::AlarmKind;
    use streakcast::plot::{AlarmChart, AlarmMark, alarm_chart};
    let differences = streakcast::learn::pass_differences(passes, learned);
    let Some(first) = differences.iter().map(|(epoch, ..)| *epoch).min() else {
        return Err(anyhow!("no pass for --picture; allowed: passes of kinds in the learned file"));
    };
    let day = |epoch: hifitime::Epoch| streakcast::frames::seconds_between(first, epoch) / 86_400.0;
    let column = |value: fn(&(hifitime::Epoch, f64, f64)) -> f64| differences.iter().map(value).collect::<Vec<f64>>();
    let marks: Vec<AlarmMark> = alarms
        .iter()
        .map(|alarm| AlarmMark {
            day: day(alarm.first),
            difference_mag: if alarm.alarm == AlarmKind::Brightness { alarm.value } else { 0.0 },
            label: match (alarm.alarm, alarm.period_s) {
                (AlarmKind::Trend, _) => format!("{}: {:+.3} mag/day", alarm.norad_id, alarm.value),
                (_, Some(period_s)) => format!("{}: {period_s:.2} s", alarm.norad_id),
                _ => format!("{}: {:+.1} mag", alarm.norad_id, alarm.value),
            },
        })
        .collect();
    let chart = alarm_chart(&AlarmChart {
        title: "Differences from learned magnitudes",
        origin: &streakcast::output::format_utc(first, 0),
        days: &differences.iter().map(|(epoch, ..)| day(*epoch)).collect::<Vec<f64>>(),
        differences_mag: &column(|(_, mag, _)| *mag),
        sigmas_mag: &column(|(_, _, sigma)| *sigma),
        alarms: &marks,
    })?;
    crate::output::write_bytes(path, &chart.to_bytes(streakcast::plot::PictureFormat::from_extension(path)?)?, notices)
}
