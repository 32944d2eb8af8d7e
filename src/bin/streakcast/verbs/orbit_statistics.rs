//! `statistics` for a telescope in orbit: trails in random exposures within the limits of the telescope.

use clap::Args;
use serde_json::json;
use streakcast::config::{
    Config, EXPOSURE, FIELD, Quantity, RequiredInput, SATELLITES, TimeRangeConfig, parse_exposure_s,
};
use streakcast::forecast::{
    TrailRequest, TrailStatistics, trail_angle_table, trail_histogram_table, trail_statistics, trail_table,
};
use streakcast::output::format_utc;

use super::passes::left_out_table;
use crate::arguments::OutputArguments;
use crate::failure::Outcome;
use crate::help::check;
use crate::output::VerbResult;
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct OrbitStatisticsArguments {
    /// Start of the span in which random exposures of a telescope in orbit begin
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub start: Option<String>,
    /// End of this span, at most 31 days later
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub end: Option<String>,
    /// Number of random pointings of a telescope in orbit; 1000 if omitted
    #[arg(long, value_name = "N")]
    pub pointings: Option<usize>,
    /// Seed of the random pointings; 1 if omitted
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// For a telescope in orbit, also count satellites in the Earth's shadow
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub include_dark: Option<bool>,
}

impl OrbitStatisticsArguments {
    /// Returns the first flag that is given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            ("--start", self.start.is_some()),
            ("--end", self.end.is_some()),
            ("--pointings", self.pointings.is_some()),
            ("--seed", self.seed.is_some()),
            ("--include-dark", self.include_dark.is_some()),
        ];
        given.into_iter().find_map(|(flag, is_given)| is_given.then_some(flag))
    }
}

const SPAN: RequiredInput = RequiredInput::new("span of the exposures", &[&["--start TIME", "--end TIME"]]);

/// Default number of pointings.
const POINTINGS: usize = 1000;
/// Default seed.
const SEED: u64 = 1;
/// Largest number of trails in the summary of the histogram.
const MOST_LISTED: usize = 5;

const ON_SCREEN: &[Shown] = &[
    shown("orbits", "orbits"),
    shown("satellites", "satellites"),
    rounded("trails_per_exposure", "trails", 3),
    rounded("trails_sigma", "+-", 3),
    rounded("streaked_share", "streaked", 3),
    rounded("streaked_sigma", "+-", 3),
    rounded("trails_with_dark", "trails with dark", 3),
    rounded("trails_with_dark_sigma", "+-", 3),
    rounded("streaked_with_dark", "streaked with dark", 3),
    rounded("streaked_with_dark_sigma", "+-", 3),
    rounded("limit_mag", "limit", 1),
    rounded("trails_brighter_than_limit", "trails < limit", 3),
    rounded("brighter_sigma", "+-", 3),
];

/// Runs `statistics` for the telescope in orbit of a configuration.
pub fn run(typed: &OrbitStatisticsArguments, output: OutputArguments, config: &Config) -> anyhow::Result<Outcome> {
    let has_span = typed.start.is_some() && typed.end.is_some();
    check(config, &[&EXPOSURE, &SATELLITES, &FIELD], &[(&SPAN, has_span)])?;
    let output = output.open(config)?;
    let range = TimeRangeConfig { night: None, start: typed.start.clone(), end: typed.end.clone() };
    let (start, end) = range.resolve(config)?;
    let exposure_s = parse_exposure_s(config.exposure.duration.as_ref().map_or("", Quantity::as_str))?;
    let (field, photometry) = (config.field_of_view()?, config.photometry()?);
    let notices = begin(config)?;
    let mut prepared = config.prepare(start, end)?;
    notices.warn(&prepared.warnings);
    notices.warn(&config.limit_warnings()?);
    let request = TrailRequest {
        start,
        end,
        pointings: typed.pointings.unwrap_or(POINTINGS),
        seed: typed.seed.unwrap_or(SEED),
        exposure_s,
        field: &field,
        limit_mag: config.limit_mag()?,
        include_dark: typed.include_dark.or(config.include_dark).unwrap_or(false),
        photometry,
    };
    let found = trail_statistics(&prepared.sky, &request)?;
    notices.warn_left_out(&prepared, &found.left_out, start)?;
    config.state_scales(&mut prepared.provenance, &photometry);
    prepared.provenance.state(
        "options",
        json!({
            "from_utc": format_utc(start, 3),
            "to_utc": format_utc(end, 3),
            "field": config.stated_field(),
            "exposure_s": exposure_s,
            "pointings": request.pointings,
            "seed": request.seed,
            "include_dark": request.include_dark,
            "limit_mag": request.limit_mag,
            "allowed_share": found.allowed_share,
        }),
    );
    let table = trail_table(&found, &request);
    let (histogram, angles) = (trail_histogram_table(&found, &request), trail_angle_table(&found, &request));
    output.write(
        &VerbResult::new("statistics", &table, ON_SCREEN, &prepared.provenance)
            .with("histogram", &histogram)
            .with("position_angles", &angles)
            .with("left_out", &left_out_table(&found.left_out)),
        &notices,
    )?;
    notices.info(&summary(&found));
    Ok(Outcome::Done)
}

/// Returns the shares of exposures with few trails, and the share of the sky that the limits allow.
fn summary(found: &TrailStatistics) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let all = found.trails.len() as f64;
    let histogram = found.histogram(false);
    let listed: Vec<String> = histogram
        .iter()
        .take(MOST_LISTED)
        .enumerate()
        .map(|(trails, exposures)| format!("{trails}: {}", percent(*exposures as f64 / all)))
        .collect();
    format!(
        "{all} exposures, drawn from {} of the times and directions; exposures with trails of lit satellites {}",
        percent(found.allowed_share),
        listed.join(", ")
    )
}
