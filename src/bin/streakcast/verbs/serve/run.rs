//! Start of the server: reads the inputs, judges the schedule, and opens the port.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, RwLock};

use anyhow::anyhow;
use hifitime::{Epoch, TimeScale};
use serde_json::json;
use streakcast::config::{Config, ObservationPlan, state_scales};
use streakcast::output::{Provenance, format_utc};
use streakcast::passes::Viewpoint;
use streakcast::photometry::Band;
use streakcast::schedule::{FlagTotals, MagnitudeLimit, Schedule, ScheduledExposure};

use super::arguments::ServeArguments;
use super::filter::{RateLimiter, RequestFilter, Token};
use super::reload::Reload;
use super::router::{App, router};
use super::server;
use super::state::{Caveats, ServerState, nights_of};
use super::workers::{ResponseCache, WorkerPool};
use crate::clock;
use crate::failure::Outcome;
use crate::files::readable_by_others;
use crate::local_time::LocalTime;
use crate::notices::Notices;
use crate::required::Required;
use crate::start::begin;
use crate::verbs::schedule_verdicts::{self, RowJudge};

/// Largest number of exposures that the page can show.
const MAX_EXPOSURES: usize = 100_000;

pub fn run(typed: ServeArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules.clone(), ..typed.config.clone() }.with_file()?;
    let time_zone = typed.zone.or_of(&config)?;
    let token = Token::from_arguments(&typed)?;
    Required::new(&config).satellites().site().field().check()?;
    let notices = begin(&config)?;
    notices.warn(&typed.token_file.as_deref().and_then(|path| readable_by_others("token", path)));
    let plan = config.observation()?;
    // The port is opened before the computation, so that an error such as an address in use is reported at once.
    let listener =
        std::net::TcpListener::bind(typed.bind).map_err(|error| anyhow!("cannot listen at {}: {error}", typed.bind))?;
    let address = listener.local_addr()?;

    let started = clock::now();
    let schedule = typed.schedule.as_deref().map(|path| read_schedule(path, &config)).transpose()?;
    let reload = Reload::new(config.elements.clone());
    let load = move |notices: &Notices| load(&config, &plan, schedule.as_ref(), started, time_zone.clone(), notices);
    let current = Arc::new(RwLock::new(Arc::new(load(&notices)?)));

    let workers = rayon::current_num_threads();
    let is_loopback = address.ip().to_canonical().is_loopback();
    let app = App {
        state: Arc::clone(&current),
        filter: RequestFilter { limiter: RateLimiter::new(typed.rate), is_loopback },
        token,
        workers: WorkerPool::new(workers)?,
    };
    let mut out = std::io::stdout().lock();
    // This line can be read by programs that start the server. A closed pipe is ignored.
    let _ = writeln!(out, "http://{address}/").and_then(|()| out.flush());
    drop(out);
    reload.start(current, load, notices);
    server::serve(listener, router(app), workers)?;
    notices.info("stopped");
    Ok(Outcome::Done)
}

/// Reads the element sets, and judges the schedule, if there is one (its path is given with it).
fn load(
    config: &Config,
    plan: &ObservationPlan,
    schedule: Option<&(PathBuf, Schedule)>,
    started: Epoch,
    local_time: Option<LocalTime>,
    notices: &Notices,
) -> anyhow::Result<ServerState> {
    let (first, last) = match schedule {
        Some((path, schedule)) => {
            schedule_verdicts::span(schedule).ok_or_else(|| anyhow!(schedule_verdicts::none_judged(schedule, path)))?
        }
        None => (started, started),
    };
    let prepared = config.prepare(first, last)?;
    let site = match prepared.sky.viewpoint() {
        Viewpoint::Site(observer) => observer.site().clone(),
        Viewpoint::Orbit(observer) => {
            let name = observer.name();
            return Err(anyhow!(
                "invalid observer {name}, which is in orbit; allowed: a site (--site, --mpc, or --lat and --lon)"
            ));
        }
    };
    notices.warn(&prepared.warnings);
    let mut flags = Vec::new();
    let totals = match schedule {
        Some((_, schedule)) => {
            let mut judge = RowJudge::new(schedule, plan, notices);
            let all = 0..schedule.exposures.len();
            judge.judge(&prepared, all, &mut |_, _, verdicts| flags.extend_from_slice(verdicts), &mut |_, _| Ok(()))?;
            let totals = judge.finish();
            notices.warn_left_out(&prepared, totals.left_out(), first)?;
            notices.warn(&totals.warnings());
            totals
        }
        None => FlagTotals::default(),
    };
    let left_out = prepared.left_out_warning(totals.left_out(), first)?;
    let mut warnings: Vec<String> = prepared.warnings.iter().cloned().chain(left_out).collect();
    let mut provenance = without_lists(&prepared.provenance);
    let scale = schedule.map_or(TimeScale::UTC, |(_, schedule)| schedule.time_scale);
    state_scales(&mut provenance, &scale.to_string().to_ascii_lowercase(), &plan.photometry);
    if let Some((path, schedule)) = schedule {
        let of_schedule = schedule.warnings(&plan.policy);
        notices.warn(&of_schedule);
        warnings.extend(of_schedule);
        schedule_verdicts::summary(notices, &totals, schedule, path);
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        provenance.state(
            "schedule",
            json!({
                "file": file,
                "format": schedule.format.to_string(),
                "exposures": schedule.exposures.len(),
                "start_column": schedule.start_column,
                "first_start_utc": format_utc(first, 3),
            }),
        );
    }
    let telescope = plan.telescope.as_ref().map(|telescope| telescope.name.clone());
    provenance.state("options", config.flag_options(&plan.policy, telescope.as_deref()));
    let exposures = schedule.map(|(_, schedule)| schedule.exposures.clone()).unwrap_or_default();
    Ok(ServerState {
        cache: ResponseCache::default(),
        bands: bands_of(&exposures, plan),
        library: config.model_library()?,
        caveats: Caveats { warnings, left_out_count: totals.left_out().len() },
        nights: nights_of(&exposures, &site),
        local_time,
        flags,
        config: config.clone(),
        prepared,
        site,
        plan: plan.clone(),
        exposures,
        started,
        provenance,
    })
}

/// Returns the bands that an exposure may have: those of magnitudes, of the limits and of the schedule.
fn bands_of(exposures: &[ScheduledExposure], plan: &ObservationPlan) -> BTreeSet<String> {
    let policy = &plan.policy;
    let bright_mag = plan.telescope.as_ref().map(|telescope| &telescope.bright_mag);
    let of_limits = [policy.limit_mag.as_ref(), policy.limit_surface_brightness.as_ref(), bright_mag];
    let of_limits = of_limits.into_iter().flatten().flat_map(|limit| match limit {
        MagnitudeLimit::PerBand(limits) => limits.keys().filter(|band| *band != "default").cloned().collect(),
        MagnitudeLimit::All(_) => Vec::new(),
    });
    let of_schedule = exposures.iter().filter_map(|row| row.band.clone());
    let all = Band::ALL.into_iter().map(|band| band.name().to_owned());
    all.chain(of_limits).chain(of_schedule).collect()
}

/// Returns the schedule of a file, with its path.
fn read_schedule(path: &Path, config: &Config) -> anyhow::Result<(PathBuf, Schedule)> {
    let schedule = Schedule::read(path, &config.schedule_options()?)?;
    let rows = schedule.exposures.len();
    if rows > MAX_EXPOSURES {
        return Err(anyhow!("the schedule {} has {rows} exposures; allowed: at most {MAX_EXPOSURES}", path.display()));
    }
    Ok((path.to_owned(), schedule))
}

/// Returns the provenance without attached lists.
fn without_lists(provenance: &Provenance) -> Provenance {
    let mut short = Provenance::default();
    for (name, value) in provenance.entries() {
        short.state(name, value.clone());
    }
    short
}
