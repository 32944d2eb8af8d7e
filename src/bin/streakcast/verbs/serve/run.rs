//! Start of the server: reads the inputs, judges the schedule, and opens the port.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, RwLock};

use anyhow::anyhow;
use hifitime::{Epoch, TimeScale};
use serde_json::json;
use streakcast::config::{Config, ObservationPlan, PreparedSky, state_scales};
use streakcast::output::{Provenance, format_utc};
use streakcast::passes::Viewpoint;
use streakcast::photometry::Band;
use streakcast::schedule::{FlagTotals, MagnitudeLimit, Schedule, ScheduledExposure, Verdict, evening_mjd};

use super::arguments::ServeArguments;
use super::filter::{RateLimiter, RequestFilter, Token};
use super::reload::Reload;
use super::router::{App, router};
use super::server;
use super::state::{Caveats, GrowingSkies, ServerState, Skies, nights_of};
use super::workers::{ResponseCache, WorkerPool};
use crate::clock;
use crate::failure::Outcome;
use crate::files::readable_by_others;
use crate::help::VerbFlags;
use crate::local_time::LocalTime;
use crate::notices::Notices;
use crate::start::begin;
use crate::verbs::schedule_verdicts::{self, Part, RowJudge};

/// Largest number of exposures that the page can show.
const MAX_EXPOSURES: usize = 100_000;

pub fn run(typed: ServeArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules.clone(), ..typed.config.clone() }.with_file()?;
    let time_zone = typed.zone.or_of(&config)?;
    let token = Token::from_arguments(&typed)?;
    ServeArguments::HELP.check(&config, &[])?;
    let notices = begin(&config)?;
    notices.warn(&typed.token_file.as_deref().and_then(|path| readable_by_others("token", path)));
    let plan = config.observation()?;
    // The port is opened before the computation, so that an error such as an address in use is reported at once.
    let listener =
        std::net::TcpListener::bind(typed.bind).map_err(|error| anyhow!("cannot listen at {}: {error}", typed.bind))?;
    let address = listener.local_addr()?;

    let started = clock::now();
    let schedule = typed.schedule.as_deref().map(|path| read_schedule(path, &config)).transpose()?;
    let reload = Reload::new(config.element_files()?.into_iter().collect());
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
    let satellites = |state: &ServerState| state.skies.first().sky.elements().len();
    reload.start(current, load, satellites, notices);
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
    let (parts, skies) = skies_of(config, schedule.map(|(_, schedule)| schedule), (first, last))?;
    let prepared = skies.first();
    let site = match prepared.sky.viewpoint() {
        Viewpoint::Site(observer) => observer.site().clone(),
        Viewpoint::Orbit(observer) => {
            let name = observer.name();
            return Err(anyhow!(
                "invalid observer {name}, which is in orbit; allowed: a site (--site, --mpc, or --lat and --lon)"
            ));
        }
    };
    let mut flags = Vec::new();
    let (mut warnings, mut without_position) = (Vec::<String>::new(), Vec::<String>::new());
    let totals = match schedule {
        Some((_, schedule)) => {
            let mut judge = RowJudge::new(schedule, plan, notices);
            for (part, sky) in &parts {
                let mut keep = |_: &[ScheduledExposure], verdicts: &[Verdict]| {
                    flags.extend_from_slice(verdicts);
                    Ok(())
                };
                without_position.extend(judge.judge(sky, part, &mut |_, _, _| {}, &mut keep)?);
                warnings.extend(sky.warnings.iter().cloned());
            }
            judge.finish()
        }
        None => {
            warnings.extend(prepared.warnings.iter().cloned());
            FlagTotals::default()
        }
    };
    let mut told = BTreeSet::new();
    warnings.retain(|warning| told.insert(warning.clone()));
    notices.warn(&warnings);
    notices.list_left_out(without_position.iter().cloned(), totals.left_out());
    notices.warn(&totals.warnings());
    warnings.extend(without_position);
    let mut provenance = without_lists(&prepared.provenance);
    let scale = schedule.map_or(TimeScale::UTC, |(_, schedule)| schedule.time_scale);
    state_scales(&mut provenance, &scale.to_string().to_ascii_lowercase(), &plan.photometry);
    if let Skies::Growing(growing) = &skies {
        let starts = parts.iter().map(|(part, _)| part.span.0);
        schedule_verdicts::state_periods(&mut provenance, &growing.inputs, starts)?;
    }
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
        skies,
        site,
        plan: plan.clone(),
        exposures,
        started,
        provenance,
    })
}

/// Parts of a schedule with the same satellites, each with its sky.
type SkiesOfParts = Vec<(Part, Arc<PreparedSky>)>;

/// Returns the parts of a schedule with their skies, and the skies of the server.
fn skies_of(
    config: &Config,
    schedule: Option<&Schedule>,
    (first, last): (Epoch, Epoch),
) -> anyhow::Result<(SkiesOfParts, Skies)> {
    let deployment = config.deployment()?;
    let parts = schedule.map(|schedule| schedule_verdicts::parts(config, schedule, (first, last))).transpose()?;
    let parts = parts.unwrap_or_default();
    if deployment.periods().next().is_none() {
        let sky = Arc::new(config.prepare(first, last)?);
        return Ok((parts.into_iter().map(|part| (part, Arc::clone(&sky))).collect(), Skies::One(sky)));
    }
    let inputs = config.load()?;
    let longitude_rad = config.viewpoint_longitude_rad(Some(first))?;
    let period = |epoch| deployment.periods_begun(evening_mjd(epoch, longitude_rad));
    let mut of_schedule = BTreeMap::new();
    let mut with_skies = Vec::new();
    for part in parts {
        let sky = Arc::new(inputs.prepare(part.span.0, part.span.1)?);
        of_schedule.insert(period(part.span.0), Arc::clone(&sky));
        with_skies.push((part, sky));
    }
    let first_sky = match with_skies.first() {
        Some((_, sky)) => Arc::clone(sky),
        None => Arc::new(inputs.prepare(first, last)?),
    };
    of_schedule.entry(period(first)).or_insert_with(|| Arc::clone(&first_sky));
    let growing = GrowingSkies { deployment, inputs, first: first_sky, of_schedule, others: Mutex::default() };
    Ok((with_skies, Skies::Growing(Box::new(growing))))
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
