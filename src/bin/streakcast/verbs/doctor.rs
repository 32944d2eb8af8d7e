//! `doctor`: setup check with remedies.

use crate::arguments::OutputArguments;
use clap::{Args, Command};
use std::path::Path;
use std::path::PathBuf;
use streakcast::config::{Config, RulesConfig, RunConfig};

use anyhow::anyhow;
use hifitime::Epoch;
use serde_json::json;
use streakcast::config::{AgeBin, ElementState, Finding, Health, MomentSource, Severity, finding_table};
use streakcast::frames::parse_moment;
use streakcast::frames::seconds_between;
use streakcast::input::{is_stream, read_to_string};
use streakcast::output::{Column, Kind, Provenance, Table, Value, counted, format_utc};
use streakcast::schedule::{AgeEffect, VerdictKind};

use super::schedule_verdicts::PreparedSchedule;
use crate::cache::{FetchRecord, cache_folder, records_in};
use crate::failure::Outcome;
use crate::help::help;
use crate::output::{Output, VerbResult};
use crate::start::begin;
use crate::verb_tables::value_errors;
use streakcast::message::printable;

#[derive(Args)]
pub struct DoctorArguments {
    /// Folder of fetched elements; the cache folder of the system if omitted
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
    /// Time to check, for example 2024-08-14T00:30:00Z; now if omitted
    #[arg(long, value_name = "TIME")]
    pub now: Option<String>,
    /// Schedule whose visits are checked for invalid rows and the effect of old elements; other inputs as for flag
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// Exit with code 1 on a warning, or if elements or site are not given
    #[arg(long)]
    pub strict: bool,
    #[command(flatten)]
    pub rules: RulesConfig,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    DoctorArguments, "doctor",
    "--shells oneweb --mpc X05 --now 2026-11-25T00:00:00Z",
    "--elements active.tle --mpc X05 --telescope rubin --strict"
}

/// Length of the longest bar of the histogram, characters.
const BAR: usize = 40;
/// Age above which a cached file is reported, days.
const STALE_DAYS: f64 = 3.0;

pub fn run(typed: DoctorArguments, command: &Command) -> anyhow::Result<Outcome> {
    let flags = Config { rules: typed.rules, ..typed.config };
    let settings = settings_findings(&flags, command)?;
    let config = flags.with_file()?;
    let format = typed.output.format.as_deref().or(config.format.as_deref());
    // The default format is text, also if standard output is not a terminal.
    let is_text = format.is_none_or(|format| format == "table" || format == "text");
    let output = Output::new(if is_text { Some("table") } else { format }, typed.output.output.clone())?;
    let notices = begin(&config)?;
    let (now, source) = match &typed.now {
        Some(now) => (parse_moment(now, config.time_scale()?)?, MomentSource::Given),
        None => (crate::clock::now(), MomentSource::Clock),
    };
    let mut health = config.health(now, source);
    if let Some(schedule) = &typed.schedule {
        health.findings.push(schedule_finding(&config, schedule));
    }
    health.findings.extend(settings);
    let folder = cache_folder(typed.cache.as_deref()).ok();
    let cached = folder.as_deref().map(records_in).unwrap_or_default();
    health.findings.extend(cache_findings(folder.as_deref(), typed.cache.is_some(), &cached, now));
    health.findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let findings = finding_table(&health.findings);
    if is_text {
        output.write_text(&printable(&page(&health, &cached, now)), &notices)?;
    } else {
        let mut provenance = Provenance::new();
        provenance.state("now_utc", format_utc(now, 0));
        provenance.state("worst", health.worst().name());
        provenance.state("config_file", config.run.file.as_ref().map(|file| file.display().to_string()));
        provenance.state("home_file", config.home.file.as_ref().map(|file| file.display().to_string()));
        provenance.state(
            "elements",
            health
                .sources
                .iter()
                .map(|source| json!({"file": source.name.as_ref(), "sha256": source.sha256, "format": source.format.to_string()}))
                .collect::<Vec<_>>(),
        );
        let state = health.elements.clone().unwrap_or_default();
        output.write(
            &VerbResult::new("findings", &findings, &[], &provenance)
                .with("element_ages", &age_table(&state))
                .with("models", &kind_table(&state))
                .with("unmatched", &unmatched_table(&state))
                .with("cache", &cache_table(&cached)),
            &notices,
        )?;
    }
    let count = |severity| health.findings.iter().filter(|finding| finding.severity == severity).count();
    match health.worst() {
        Severity::Error => Err(anyhow!("{} of {} findings are errors", count(Severity::Error), health.findings.len())),
        Severity::Warning | Severity::Unchecked if typed.strict => Ok(Outcome::No),
        _ => Ok(Outcome::Done),
    }
}

/// Returns a finding for each file of settings: the keys at its top that are used, those whose questions a layer above
/// answers, and its tables of verbs; and one for each invalid value in these tables.
fn settings_findings(flags: &Config, command: &Command) -> anyhow::Result<Vec<Finding>> {
    const SUBJECT: &str = "settings";
    let mut above = flags.given();
    let mut findings = Vec::new();
    for (what, path) in [("configuration", &flags.run.file), ("home file", &flags.home.file)] {
        // A stream can only be read once, by the verb.
        let Some(path) = path.as_ref().filter(|path| !is_stream(path)) else { continue };
        let given = Config::read(path)?.given();
        let is_hidden = |key: &&str| {
            let question = Config::QUESTIONS.iter().find(|question| question.keys.contains(key));
            question.is_some_and(|question| question.is_answered_by(&above))
        };
        let (hidden, used): (Vec<&str>, Vec<&str>) = given.iter().partition(|key| is_hidden(key));
        let text = read_to_string(path).unwrap_or_default();
        let keys: toml::Table = text.parse().unwrap_or_default();
        let tables = keys.keys().filter(|key| !Config::keys().any(|known| known == key.replace('-', "_")));
        let tables: Vec<String> = tables.map(|verb| format!("[{verb}]")).collect();
        let mut finding = format!("{what} {}", path.display());
        for (what, names) in
            [("used: ", used.join(", ")), ("tables: ", tables.join(", ")), ("replaced: ", hidden.join(", "))]
        {
            if !names.is_empty() {
                finding += &format!("; {what}{names}");
            }
        }
        findings.push(Finding::fine(SUBJECT, finding));
        let errors = value_errors(command, path)?;
        findings.extend(errors.into_iter().map(|error| Finding::error(SUBJECT, error, "correct the value")));
        above.extend(given);
    }
    Ok(findings)
}

/// Returns the finding on visits of a schedule that cannot be judged, and on how old elements affect its verdicts.
fn schedule_finding(config: &Config, schedule: &Path) -> Finding {
    const SUBJECT: &str = "schedule";
    // The thread pool exists already, and warnings about inputs are reported as findings.
    let run = RunConfig { threads: None, quiet: Some(true), ..config.run.clone() };
    let prepared = PreparedSchedule::read(&Config { run, ..config.clone() }, schedule, None, None);
    let totals = match prepared.and_then(|prepared| prepared.judge_in_parts(&mut |_, _| Ok(()))) {
        Ok(totals) => totals,
        Err(error) => {
            let remedy = "specify the inputs of streakcast flag";
            return Finding::error(SUBJECT, error, remedy);
        }
    };
    let all = totals.exposures();
    let invalid = totals.count(VerdictKind::Unknown) + totals.count(VerdictKind::Invalid);
    let visits = match invalid {
        0 => counted(all, "visit", "visits"),
        _ => format!("{invalid} of {} cannot be judged", counted(all, "visit", "visits")),
    };
    const SEE_REASONS: &str = "streakcast flag lists the reasons";
    if invalid == all {
        return Finding::error(SUBJECT, visits, SEE_REASONS);
    }
    let effect = totals.age_effect();
    let is_large = effect.as_ref().is_some_and(|effect| effect.changed_share >= AgeEffect::LARGE_SHARE);
    let effect = effect.map_or("no satellite crosses".to_owned(), |effect| effect.to_string());
    let finding = format!("{visits}; {effect}");
    if is_large {
        let remedy = "use elements closer to the visits (streakcast fetch), or --min-probability";
        Finding::warning(SUBJECT, finding, remedy)
    } else if invalid > 0 {
        Finding::warning(SUBJECT, finding, SEE_REASONS)
    } else {
        Finding::fine(SUBJECT, finding)
    }
}

fn cache_findings(
    folder: Option<&Path>,
    is_given: bool,
    cached: &[(std::path::PathBuf, FetchRecord)],
    now: Epoch,
) -> Vec<Finding> {
    const SUBJECT: &str = "cache";
    let Some(folder) = folder else {
        let finding = "this system has no cache folder";
        return vec![Finding::note(SUBJECT, finding, "specify --cache FOLDER")];
    };
    if cached.is_empty() {
        let finding = format!("no fetched files in {}", folder.display());
        let severity = if is_given { Severity::Note } else { Severity::Fine };
        return vec![Finding::new(severity, SUBJECT, finding, "streakcast fetch celestrak --group active")];
    }
    let mut found = Vec::new();
    for (file, record) in cached {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let answer = record.answer.as_deref().unwrap_or_default();
        let time = record.asked_utc.as_deref().unwrap_or("an unknown time");
        if !(answer == "200 OK" || answer.starts_with("304")) {
            let remedy = "read the response; streakcast fetch sends a new request after the waiting time";
            let finding = format!("{name}: response of {} at {time}: {answer}", record.source);
            found.push(Finding::warning(SUBJECT, finding, remedy));
        }
        match (file.is_file(), record.fetched_utc.as_deref().and_then(|time| parse_moment(time, None).ok())) {
            (false, Some(_)) => {
                let finding = format!("{name} was fetched, but the file is missing");
                found.push(Finding::warning(SUBJECT, finding, "fetch it again"));
            }
            (true, Some(fetched)) => {
                let days = seconds_between(fetched, now) / 86_400.0;
                let finding = format!("{name}: {} records, fetched {days:.1} days ago", record.records.unwrap_or(0));
                found.push(if days > STALE_DAYS {
                    Finding::note(SUBJECT, finding, "fetch it again before the night")
                } else {
                    Finding::fine(SUBJECT, finding)
                });
            }
            _ => {}
        }
    }
    found
}

/// Returns the text of the check: findings by severity, age histogram, number of satellites by model, and cached files.
fn page(health: &Health, cached: &[(std::path::PathBuf, FetchRecord)], now: Epoch) -> String {
    let mut page = format!("Setup check for {}\n\n", format_utc(now, 0));
    for finding in &health.findings {
        page += &format!("{:<9} {}: {}\n", finding.severity.name(), finding.subject, finding.finding);
        if !finding.remedy.is_empty() && finding.severity > Severity::Fine {
            page += &format!("          -> {}\n", finding.remedy);
        }
    }
    if let Some(state) = &health.elements {
        page += "\nAge of the element sets\n";
        let most = state.ages.iter().map(|bin| bin.count).max().unwrap_or(0).max(1);
        for bin in &state.ages {
            // A bar of a non-empty bin has at least one character.
            let length = (bin.count * BAR).div_ceil(most);
            page += format!("{:>17} {:>7} {}\n", label(bin), bin.count, "#".repeat(length)).as_str();
        }
        page += "\nSatellites by model\n";
        for (kind, count) in &state.kinds {
            page += &format!("{:>24} {count:>7}\n", kind.name());
        }
        for group in state.unmatched.iter().take(10) {
            let name = if group.prefix.is_empty() { "(no name)" } else { &group.prefix };
            page += &format!("{name:>24} {:>7}  default model\n", group.count);
        }
        let rest: usize = state.unmatched.iter().skip(10).map(|group| group.count).sum();
        if rest > 0 {
            page += &format!("{:>24} {rest:>7}  default model\n", "others");
        }
    }
    if !cached.is_empty() {
        page += "\nFetched\n";
        for (file, record) in cached {
            let fetched = record.fetched_utc.as_deref().unwrap_or("never");
            page += &format!(
                "{}  fetched {fetched}, next request allowed from {}\n",
                file.display(),
                record.not_before_utc.as_deref().unwrap_or("now")
            );
        }
    }
    page.lines().map(|line| line.trim_end().to_owned() + "\n").collect()
}

fn label(bin: &AgeBin) -> String {
    if bin.from_days.is_infinite() {
        format!("from {} d ahead", -bin.to_days)
    } else if bin.from_days < 0.0 {
        format!("up to {} d ahead", -bin.from_days)
    } else if bin.to_days.is_infinite() {
        format!("{} d or more", bin.from_days)
    } else {
        format!("{} to {} d", bin.from_days, bin.to_days)
    }
}

fn age_table(state: &ElementState) -> Table {
    let border = |days: f64| Some(days).filter(|days| days.is_finite());
    Table {
        columns: vec![
            Column::real(
                "from_days",
                "d",
                1,
                "Lower border of the age, negative for epochs after the time of the check; empty for the first bin.",
            ),
            Column::real("to_days", "d", 1, "Upper border of the age; empty for the last bin."),
            Column::new("count", Kind::Integer, "Number of element sets."),
        ],
        rows: state
            .ages
            .iter()
            .map(|bin| vec![border(bin.from_days).into(), border(bin.to_days).into(), bin.count.into()])
            .collect(),
    }
}

fn kind_table(state: &ElementState) -> Table {
    Table {
        columns: vec![
            Column::new("generation", Kind::Text, "Generation of satellites."),
            Column::new("count", Kind::Integer, "Number of satellites."),
        ],
        rows: state.kinds.iter().map(|(kind, count)| vec![kind.name().into(), (*count).into()]).collect(),
    }
}

fn unmatched_table(state: &ElementState) -> Table {
    Table {
        columns: vec![
            Column::new(
                "prefix",
                Kind::Text,
                "Common beginning of the satellites' names; empty for satellites without a name.",
            ),
            Column::new("count", Kind::Integer, "Number of satellites with the default model."),
        ],
        rows: state.unmatched.iter().map(|group| vec![group.prefix.as_str().into(), group.count.into()]).collect(),
    }
}

fn cache_table(cached: &[(std::path::PathBuf, FetchRecord)]) -> Table {
    let text = |text: &Option<String>| -> Value { text.as_deref().into() };
    Table {
        columns: vec![
            Column::new("file", Kind::Text, "Cached file."),
            Column::new("source", Kind::Text, "Source of the file."),
            Column::new("url", Kind::Text, "Address of the file."),
            Column::new("fetched_utc", Kind::Text, "Time of the download."),
            Column::new("sha256", Kind::Text, "SHA-256 of the file."),
            Column::new("records", Kind::Integer, "Number of valid records."),
            Column::new("answer", Kind::Text, "Last response of the source."),
            Column::new("not_before_utc", Kind::Text, "Earliest time of the next request."),
        ],
        rows: cached
            .iter()
            .map(|(file, record)| {
                vec![
                    file.display().to_string().into(),
                    record.source.as_str().into(),
                    record.url.as_str().into(),
                    text(&record.fetched_utc),
                    text(&record.sha256),
                    record.records.map_or(Value::Null, Into::into),
                    text(&record.answer),
                    text(&record.not_before_utc),
                ]
            })
            .collect(),
    }
}
