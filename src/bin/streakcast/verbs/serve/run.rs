//! From what was typed to a server that listens.

use std::io::Write;

use anyhow::anyhow;
use serde_json::json;
use streakcast::config::{Config, state_scales};
use streakcast::output::{Provenance, format_utc};
use streakcast::passes::Viewpoint;
use streakcast::schedule::Schedule;

use super::super::judged;
use super::arguments::ServeArguments;
use super::house::{Caveats, House, nights_of, zone_h};
use super::server::{self, Settings};
use super::token::Token;
use crate::failure::Outcome;

/// More rows than this are a survey, not a schedule to look at.
const MOST_ROWS: usize = 100_000;

pub fn run(typed: ServeArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules.clone(), ..typed.config.clone() }.with_file()?;
    let token = Token::of(&typed)?;
    let notices = judged::begin(&config)?;
    let asked = config.observation()?;
    // Before the work: an address that is taken is told at once.
    let listener =
        std::net::TcpListener::bind(typed.bind).map_err(|error| anyhow!("cannot listen at {}: {error}", typed.bind))?;
    let address = listener.local_addr()?;

    let schedule = Schedule::read(&typed.schedule, &config.schedule_options()?)?;
    let rows = schedule.exposures.len();
    if rows > MOST_ROWS {
        return Err(anyhow!("schedule {}: {rows} exposures; allowed: {MOST_ROWS} at most", typed.schedule.display()));
    }
    let (first, last) =
        judged::span(&schedule).ok_or_else(|| anyhow!(judged::none_judged(&schedule, &typed.schedule)))?;
    let prepared = config.prepare(first, last)?;
    let site = match prepared.sky.viewpoint() {
        Viewpoint::Site(observer) => observer.site().clone(),
        Viewpoint::Orbit(observer) => {
            let name = observer.name();
            return Err(anyhow!(
                "the observer {name} is in orbit: the page draws the sky of a site (--site, --mpc or --lat, --lon, --height)"
            ));
        }
    };
    notices.warn(&prepared.warnings);
    let report = judged::flag_rows(&prepared, &schedule, first, &asked, &notices)?;
    let of_schedule = judged::schedule_warnings(&schedule, &asked.policy, asked.telescope.as_ref());
    notices.warn(&of_schedule);
    let left_out = prepared.left_out_warning(&report.left_out, first)?;
    let warnings = prepared.warnings.iter().cloned().chain(left_out).chain(of_schedule).collect();
    judged::summary(&notices, &report);

    let mut provenance = without_lists(&prepared.provenance);
    state_scales(&mut provenance, &schedule.time_scale.to_string().to_ascii_lowercase(), &asked.photometry);
    let file = typed.schedule.file_name().unwrap_or_default().to_string_lossy().into_owned();
    provenance.state(
        "schedule",
        json!({
            "file": file,
            "format": schedule.format.to_string(),
            "exposures": rows,
            "start_column": schedule.start_column,
            "first_start_utc": format_utc(first, 3),
        }),
    );
    let telescope = asked.telescope.as_ref().map(|telescope| telescope.name.clone());
    provenance.state("options", judged::options_json(&config, &asked.policy, telescope.as_deref()));
    let house = House {
        library: config.model_library()?,
        caveats: Caveats { warnings, left_out_count: report.left_out.len() },
        nights: nights_of(&schedule, &site),
        utc_offset_h: typed.utc_offset.unwrap_or_else(|| zone_h(&site)),
        flags: report.flags,
        config,
        prepared,
        site,
        asked,
        schedule,
        provenance,
    };

    let settings = Settings {
        rate: typed.rate,
        token,
        is_loopback: address.ip().to_canonical().is_loopback(),
        workers: rayon::current_num_threads(),
    };
    let mut out = std::io::stdout().lock();
    // Who started it waits for this line; who closed the pipe does not.
    let _ = writeln!(out, "http://{address}/").and_then(|()| out.flush());
    drop(out);
    server::serve(listener, house, settings)?;
    notices.say("stopped");
    Ok(Outcome::Done)
}

/// The statements without the long lists beside them.
fn without_lists(provenance: &Provenance) -> Provenance {
    let mut short = Provenance::default();
    for (name, value) in provenance.entries() {
        short.state(name, value.clone());
    }
    short
}
