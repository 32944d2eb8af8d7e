//! Start of the server: reads the inputs, judges the schedule, and opens the port.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use anyhow::anyhow;
use hifitime::TimeScale;
use serde_json::json;
use streakcast::config::{Config, state_scales};
use streakcast::output::{Provenance, format_utc};
use streakcast::passes::Viewpoint;
use streakcast::schedule::{FlagReport, Schedule};

use super::arguments::ServeArguments;
use super::filter::{RateLimiter, RequestFilter, Token};
use super::router::{App, router};
use super::server;
use super::state::{Caveats, ServerState, nights_of};
use super::workers::WorkerPool;
use crate::clock;
use crate::failure::Outcome;
use crate::required::Required;
use crate::start::begin;
use crate::verbs::schedule_verdicts;

/// Largest number of exposures that the page can show.
const MAX_EXPOSURES: usize = 100_000;

pub fn run(typed: ServeArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules.clone(), ..typed.config.clone() }.with_file()?;
    let token = Token::of(&typed)?;
    Required::of(&config).satellites().site().field().check()?;
    let notices = begin(&config)?;
    let plan = config.observation()?;
    // The port is opened before the computation, so that an error such as an address in use is reported at once.
    let listener =
        std::net::TcpListener::bind(typed.bind).map_err(|error| anyhow!("cannot listen at {}: {error}", typed.bind))?;
    let address = listener.local_addr()?;

    let started = clock::now();
    let schedule = typed.schedule.as_deref().map(|path| read_schedule(path, &config)).transpose()?;
    let (first, last) = match &schedule {
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
    let report = match &schedule {
        Some((_, schedule)) => schedule_verdicts::flag_rows(&prepared, schedule, first, &plan, &notices)?,
        None => FlagReport::default(),
    };
    let left_out = prepared.left_out_warning(&report.left_out, first)?;
    let mut warnings: Vec<String> = prepared.warnings.iter().cloned().chain(left_out).collect();
    let mut provenance = without_lists(&prepared.provenance);
    let scale = schedule.as_ref().map_or(TimeScale::UTC, |(_, schedule)| schedule.time_scale);
    state_scales(&mut provenance, &scale.to_string().to_ascii_lowercase(), &plan.photometry);
    if let Some((path, schedule)) = &schedule {
        let of_schedule = schedule_verdicts::schedule_warnings(schedule, &plan.policy, plan.telescope.as_ref());
        notices.warn(&of_schedule);
        warnings.extend(of_schedule);
        schedule_verdicts::summary(&notices, &report);
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
    provenance.state("options", schedule_verdicts::options_json(&config, &plan.policy, telescope.as_deref()));
    let exposures = schedule.map(|(_, schedule)| schedule.exposures).unwrap_or_default();
    let state = ServerState {
        library: config.model_library()?,
        caveats: Caveats { warnings, left_out_count: report.left_out.len() },
        nights: nights_of(&exposures, &site),
        local_time: typed.time_zone,
        flags: report.flags,
        config,
        prepared,
        site,
        plan,
        exposures,
        started,
        provenance,
    };

    let workers = rayon::current_num_threads();
    let is_loopback = address.ip().to_canonical().is_loopback();
    let app = App {
        state: Arc::new(state),
        filter: RequestFilter { limiter: RateLimiter::new(typed.rate), is_loopback },
        token,
        workers: WorkerPool::new(workers),
    };
    let mut out = std::io::stdout().lock();
    // This line can be read by programs that start the server. A closed pipe is ignored.
    let _ = writeln!(out, "http://{address}/").and_then(|()| out.flush());
    drop(out);
    server::serve(listener, router(app), workers)?;
    notices.info("stopped");
    Ok(Outcome::Done)
}

/// Returns the schedule of a file, with its path.
fn read_schedule<'a>(path: &'a Path, config: &Config) -> anyhow::Result<(&'a Path, Schedule)> {
    let schedule = Schedule::read(path, &config.schedule_options()?)?;
    let rows = schedule.exposures.len();
    if rows > MAX_EXPOSURES {
        return Err(anyhow!("the schedule {} has {rows} exposures; allowed: at most {MAX_EXPOSURES}", path.display()));
    }
    Ok((path, schedule))
}

/// Returns the provenance without attached lists.
fn without_lists(provenance: &Provenance) -> Provenance {
    let mut short = Provenance::default();
    for (name, value) in provenance.entries() {
        short.state(name, value.clone());
    }
    short
}
