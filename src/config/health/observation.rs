//! Checks of clock, Earth orientation, leap seconds, site, camera, policy and models.

use std::sync::Arc;

use hifitime::Epoch;

use super::super::doubtful_site::doubtful_site;
use super::elements::ElementState;
use super::finding::{Finding, MomentSource, Severity};
use crate::config::document::Config;
use crate::constants::DAY_S;
use crate::elements::Ephemeris;
use crate::frames::{EopStatus, EopTable, leap_seconds_known_until, seconds_between};
use crate::output::format_utc;
use crate::passes::Viewpoint;

/// Remaining time below which a table should be replaced, days.
const SOON_DAYS: f64 = 60.0;

/// Checks that the tables of UT1 and leap seconds cover the time of the request.
pub(super) fn earth_orientation(config: &Config, now: Epoch) -> Vec<Finding> {
    const SUBJECT: &str = "Earth orientation";
    let remedy = "specify a newer table with --eop finals2000A.all (https://datacenter.iers.org)";
    let table = match config.eop_table() {
        Ok(table) => table,
        Err(error) => return vec![Finding::error(SUBJECT, error, remedy)],
    };
    let mut found = vec![status(&table, now, SUBJECT, remedy)];
    let until = leap_seconds_known_until();
    let left_days = seconds_between(now, until) / DAY_S;
    let known = format!("known until {} (IERS Bulletin C 72)", day(until));
    found.push(if left_days < 0.0 {
        let finding = format!("{known}: a leap second inserted since then makes all times wrong by 1 s");
        Finding::warning("leap seconds", finding, "update streakcast")
    } else if left_days < SOON_DAYS {
        Finding::note("leap seconds", known, "update streakcast")
    } else {
        Finding::fine("leap seconds", known)
    });
    found
}

fn status(table: &EopTable, now: Epoch, subject: &'static str, remedy: &str) -> Finding {
    let left_days = table.last().map_or(0.0, |last| seconds_between(now, last) / DAY_S);
    match table.status(now) {
        EopStatus::Measured => {
            Finding::fine(subject, format!("measured at this time; the table ends in {left_days:.0} days"))
        }
        EopStatus::Predicted if left_days > SOON_DAYS => {
            Finding::fine(subject, format!("predicted, accurate to metres; the table ends in {left_days:.0} days"))
        }
        EopStatus::Predicted => Finding::note(subject, format!("the table ends in {left_days:.0} days"), remedy),
        EopStatus::Expired { last } => {
            let finding = format!("the table ended {}: UT1 = UTC is used, an error of up to 0.9 s (400 m)", day(last));
            Finding::warning(subject, finding, remedy)
        }
        EopStatus::TooEarly { first } => {
            let finding =
                format!("the table begins {}: UT1 = UTC is used, an error of up to 0.9 s (400 m)", day(first));
            Finding::warning(subject, finding, remedy)
        }
        EopStatus::NoTable => Finding::warning(subject, "no table: UT1 = UTC is used", remedy),
    }
}

/// Checks that the system clock is plausible.
pub(super) fn clock(now: Epoch, source: MomentSource, elements: Option<&ElementState>) -> Finding {
    let time = format_utc(now, 0);
    if source == MomentSource::Given {
        return Finding::fine("time", format!("{time}, as given; the clock of this machine is not checked"));
    }
    const SUBJECT: &str = "clock";
    // The measured part of the bundled table ends before this release. A machine without a battery clock starts in
    // 1970.
    if matches!(EopTable::embedded().status(now), EopStatus::Measured | EopStatus::TooEarly { .. }) {
        let finding = format!("{time}, which is before the release of this version of streakcast");
        let remedy = "correct the clock (chrony, w32time); for a time in the past specify --now TIME";
        Finding::warning(SUBJECT, finding, remedy)
    } else if elements.is_some_and(ElementState::is_mostly_ahead) {
        let finding = format!("{time}, which is days before most epochs of the elements");
        Finding::warning(SUBJECT, finding, "check the clock (chrony, w32time)")
    } else {
        Finding::fine(SUBJECT, time)
    }
}

/// Checks the policy.
pub(super) fn policy(config: &Config) -> Finding {
    const SUBJECT: &str = "policy";
    let policy = match config.policy() {
        Ok(policy) => policy,
        Err(error) => {
            return Finding::error(SUBJECT, error, "see docs/reference/configuration.md");
        }
    };
    // The keys and values of the policy file on one line.
    let keys: Vec<String> = match serde_json::to_value(&policy) {
        Ok(serde_json::Value::Object(keys)) => keys
            .into_iter()
            .filter(|(_, value)| !value.is_null())
            .map(|(key, value)| format!("{key} {}", value.to_string().replace('"', "")))
            .collect(),
        _ => Vec::new(),
    };
    let has_limit = keys
        .iter()
        .any(|words| ["limit_mag", "limit_surface_brightness", "max_cost_s"].iter().any(|key| words.starts_with(key)));
    let without = "no magnitude limit is set: no exposure has the verdict avoid".to_owned();
    let is_default =
        config.rules.policy.is_none() && config.rules.max_delay.is_none() && config.rules.blocking.is_none();
    match has_limit {
        true => Finding::fine(SUBJECT, keys.join(", ")),
        false if is_default => Finding::fine(SUBJECT, without),
        false => Finding::fine(SUBJECT, format!("{without}; {}", keys.join(", "))),
    }
}

/// Checks the site, or the orbit of the telescope.
pub(super) fn site(config: &Config, now: Epoch) -> Vec<Finding> {
    const SUBJECT: &str = "site";
    if !config.has_viewpoint() {
        let remedy = "specify --site, --mpc, or --lat and --lon";
        let finding = "not given: the site is not checked";
        return vec![Finding::new(Severity::Unchecked, SUBJECT, finding, remedy)];
    }
    let site = match config.viewpoint(now) {
        Ok(Viewpoint::Site(observer)) => observer.site().clone(),
        Ok(Viewpoint::Orbit(observer)) => {
            let source = match (observer.elements_epoch(), observer.ephemerides()) {
                (Some(epoch), _) => format!("elements of {}", format_utc(epoch, 0)),
                (None, spans) => {
                    let span = |ephemeris: &Arc<Ephemeris>| {
                        let (first, last) = ephemeris.interval();
                        format!("ephemeris of {} to {}", format_utc(first, 0), format_utc(last, 0))
                    };
                    spans.iter().map(span).collect::<Vec<_>>().join(", ")
                }
            };
            return vec![Finding::fine(SUBJECT, format!("{} in orbit, {source}", observer.name()))];
        }
        Err(error) => return vec![Finding::error(SUBJECT, error, "specify another site")],
    };
    let (latitude_deg, longitude_deg) = (site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees());
    let signed_deg = if longitude_deg > 180.0 { longitude_deg - 360.0 } else { longitude_deg };
    let mut found = vec![Finding::fine(
        SUBJECT,
        format!("{}: {latitude_deg:.4} deg north, {signed_deg:.4} deg east, {:.0} m", site.name, site.height_m),
    )];
    if config.site.lat.is_some() && config.site.height.is_none() {
        let finding = "no height is given: 0 m is used; 2000 m shift a satellite at 550 km by 0.2 deg";
        found.push(Finding::note(SUBJECT, finding, "specify --height in metres"));
    }
    if let Some((finding, remedy)) = doubtful_site(&site) {
        found.push(Finding::warning(SUBJECT, finding, remedy));
    }
    found
}

/// Checks telescope, field, band and models.
pub(super) fn camera(config: &Config) -> Vec<Finding> {
    let mut found = Vec::new();
    match config.telescope() {
        Ok(Some(telescope)) => found.push(Finding::fine("telescope", telescope.name)),
        Ok(None) => {
            let remedy = "specify --telescope NAME to compute widths and lost pixels";
            found.push(Finding::note("telescope", "not given: widths and lost pixels are not computed", remedy));
        }
        Err(error) => found.push(Finding::error("telescope", error, "see streakcast flag --help")),
    }
    if (config.fov.is_some() || config.field.is_some())
        && let Err(error) = config.field_of_view()
    {
        found.push(Finding::error("field", error, "see examples/field.json"));
    }
    for (subject, result) in
        [("photometry", config.photometry().map(drop)), ("models", config.model_choice().map(drop))]
    {
        if let Err(error) = result {
            found.push(Finding::error(subject, error, "see docs/reference/model-files.md"));
        }
    }
    found
}

fn day(epoch: Epoch) -> String {
    format_utc(epoch, 0).chars().take(10).collect()
}
