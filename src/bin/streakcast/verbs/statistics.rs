//! `statistics`: counts sunlit satellites over a site, their magnitudes, and trails per exposure; for a telescope in
//! orbit, trails in random exposures.

use crate::arguments::OutputArguments;
use crate::clock::{date_line_remark, set_tonight};
use anyhow::bail;
use clap::Args;
use serde_json::{Value, json};
use streakcast::config::{
    Config, ExposureConfig, Quantity, RequiredInput, RulesConfig, SATELLITES, SITE, SiteConfig, parse_duration_s,
    parse_exposure_s, parse_night, parse_size_deg, time_range,
};
use streakcast::forecast::{SkyCount, StatisticsRequest, sky_counts, statistics_table};
use streakcast::output::{Provenance, format_utc};
use streakcast::schedule::MagnitudeLimit;

use super::orbit_statistics::{self, OrbitStatisticsArguments};
use super::passes::left_out_table;
use crate::failure::Outcome;
use crate::help::{VerbFlags, help};
use crate::notices::WarningsOfNights;
use crate::output::VerbResult;
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct StatisticsArguments {
    /// Nights at a site by the local date of their evening, for example 2024-03-20 2024-06-21; or tonight
    #[arg(long, value_name = "DATE", num_args = 1.., value_delimiter = ',', value_parser = parse_night)]
    pub night: Vec<String>,
    /// Altitudes of the Sun at a site for the counts, degrees; 0 to -48 in steps of 6 if omitted
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', allow_hyphen_values = true)]
    pub sun_altitude_deg: Vec<f64>,
    /// Lowest altitudes of satellites at a site, degrees, with one row each; 20 and 30 if omitted
    #[arg(long, value_name = "DEG", num_args = 1.., value_delimiter = ',')]
    pub min_altitude: Vec<f64>,
    /// Latitudes to use instead of that of the site, degrees north
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', allow_hyphen_values = true)]
    pub latitudes: Vec<f64>,
    /// Exposure time with its unit; 30s if omitted
    #[arg(long, value_name = "TIME")]
    pub exposure: Option<Quantity>,
    /// Limiting magnitude: also count satellites brighter than this, and their trails
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<MagnitudeLimit>,
    /// Number of times at a site over which each count is averaged; 11 if omitted
    #[arg(long, value_name = "N")]
    pub moments: Option<usize>,
    /// Time range over which the times of --moments are spread, with its unit; 10min if omitted
    #[arg(long, value_name = "TIME")]
    pub spread: Option<String>,
    #[command(flatten)]
    pub orbit: OrbitStatisticsArguments,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

const NIGHT: RequiredInput = RequiredInput::new("night", &[&["--night DATE"]]);

help! {
    StatisticsArguments, "statistics", asks [NIGHT, SATELLITES, SITE],
    ignores [(&["rotation", "min_probability"], "has no effect on statistics")],
    "--night 2024-06-21 --shells oneweb --mpc X05 --sun-altitude-deg=-12,-18 --moments 3",
    "--night 2024-03-20 2024-06-21 --elements active.tle --site Paranal --fov 1deg --exposure 60s"
}

/// Default field of view: that of Rubin Observatory.
const FIELD: &str = "3.5deg";
/// Default exposure time: that of Rubin Observatory.
const EXPOSURE: &str = "30s";
/// Default altitudes of the Sun, degrees.
const SUN_ALTITUDES_DEG: [f64; 9] = [0.0, -6.0, -12.0, -18.0, -24.0, -30.0, -36.0, -42.0, -48.0];
/// Default lowest altitudes of satellites, degrees.
const MIN_ALTITUDES_DEG: [f64; 2] = [20.0, 30.0];
/// Default number of times of a count.
const MOMENTS: usize = 11;
/// Default time range of these times.
const SPREAD: &str = "10min";

const ON_SCREEN: &[Shown] = &[
    rounded("utc", "time (UTC)", 0),
    shown("twilight", "twilight"),
    rounded("latitude_deg", "latitude", 1),
    rounded("sun_altitude_deg", "Sun deg", 0),
    rounded("min_altitude_deg", "above deg", 0),
    rounded("above", "satellites", 1),
    rounded("lit", "lit", 1),
    rounded("brighter_than_4", "< 4 mag", 1),
    rounded("brighter_than_5", "< 5", 1),
    rounded("brighter_than_6", "< 6", 1),
    rounded("brighter_than_7", "< 7", 1),
    rounded("brighter_than_8", "< 8", 1),
    rounded("trails_per_exposure", "trails", 4),
    rounded("streaked_share", "streaked", 4),
    rounded("limit_mag", "limit", 1),
    rounded("brighter_than_limit", "< limit", 1),
    rounded("trails_brighter_than_limit", "trails < limit", 4),
];

pub fn run(mut typed: StatisticsArguments) -> anyhow::Result<Outcome> {
    let flags = Config {
        exposure: ExposureConfig { duration: typed.exposure, ..ExposureConfig::default() },
        rules: RulesConfig { limit_mag: typed.limit_mag, ..RulesConfig::default() },
        ..typed.config
    };
    let config = flags.with_file()?;
    if config.is_in_orbit() {
        let of_a_site = [
            ("--night", !typed.night.is_empty()),
            ("--sun-altitude-deg", !typed.sun_altitude_deg.is_empty()),
            ("--min-altitude", !typed.min_altitude.is_empty()),
            ("--latitudes", !typed.latitudes.is_empty()),
            ("--moments", typed.moments.is_some()),
            ("--spread", typed.spread.is_some()),
        ];
        if let Some((flag, _)) = of_a_site.iter().find(|(_, is_given)| *is_given) {
            bail!(
                "{flag} is for a site; allowed for a telescope in orbit: --start, --end, --pointings, --seed, --include-dark"
            );
        }
        return orbit_statistics::run(&typed.orbit, typed.output, &config);
    }
    if let Some(flag) = typed.orbit.given() {
        bail!(
            "{flag} is for a telescope in orbit (--observer-elements); allowed for a site: --night, --moments, --spread"
        );
    }
    StatisticsArguments::HELP.check(&config, &[(&NIGHT, !typed.night.is_empty())])?;
    let output = typed.output.open(&config)?;
    let has_shape = config.field.is_some() || config.telescope.is_some();
    let fov = config.fov.as_ref().map(Quantity::as_str).or((!has_shape).then_some(FIELD));
    let (field_rad, field_sr) = field_size(fov, &config)?;
    let exposure = config.exposure.duration.as_ref().map_or(EXPOSURE, Quantity::as_str);
    let exposure_s = parse_exposure_s(exposure)?;
    let spread_s = parse_duration_s("spread", typed.spread.as_deref().unwrap_or(SPREAD))?;
    let moments = typed.moments.unwrap_or(MOMENTS);
    let or_default = |given: Vec<f64>, default: &[f64]| if given.is_empty() { default.to_vec() } else { given };
    let sun_altitudes_deg = or_default(typed.sun_altitude_deg, &SUN_ALTITUDES_DEG);
    let min_altitudes_deg = or_default(typed.min_altitude, &MIN_ALTITUDES_DEG);
    let photometry = config.photometry()?;
    let limit_mag = config.limit_mag()?;
    let notices = begin(&config)?;
    notices.warn(&config.limit_warnings()?);
    set_tonight(&mut typed.night, &config)?;
    if let Some(remark) = date_line_remark(typed.night.first().map(String::as_str), &config) {
        notices.info(&remark);
    }
    let site = config.site()?;
    let radians = |angles: &[f64]| angles.iter().map(|angle| angle.to_radians()).collect::<Vec<_>>();
    let latitudes_deg = if typed.latitudes.is_empty() {
        vec![None]
    } else {
        typed.latitudes.iter().map(|latitude_deg| Some(*latitude_deg)).collect()
    };
    let mut found: Vec<(f64, StatisticsRequest, Vec<SkyCount>)> = Vec::new();
    let mut provenance = Provenance::new();
    let (mut of_nights, mut left_out, mut without_position) = (WarningsOfNights::default(), Vec::new(), Vec::new());
    let mut periods: Vec<Value> = Vec::new();
    for night in &typed.night {
        for latitude_deg in &latitudes_deg {
            let at_latitude = match latitude_deg {
                Some(latitude_deg) => Config {
                    site: SiteConfig {
                        lat: Some(*latitude_deg),
                        lon: Some(site.longitude_rad.to_degrees()),
                        height: Some(site.height_m),
                        ..SiteConfig::default()
                    },
                    ..config.clone()
                },
                None => config.clone(),
            };
            let (start, end) = time_range(Some(night), None, None, &at_latitude)?;
            let prepared = at_latitude.prepare(start, end)?;
            let request = StatisticsRequest {
                start,
                end,
                sun_altitudes_rad: radians(&sun_altitudes_deg),
                min_altitudes_rad: radians(&min_altitudes_deg),
                field_rad,
                field_sr,
                exposure_s,
                moments,
                spread_s,
                limit_mag,
                photometry,
            };
            let (counts, missed, without) = sky_counts(&prepared.sky, &request)?;
            let latitude_rad = at_latitude.site()?.latitude_rad;
            if !missed.is_empty() {
                let missed: Vec<String> = missed.iter().map(|sun_rad| format!("{:.0}", sun_rad.to_degrees())).collect();
                let warning = format!(
                    "in the night of {night} at latitude {:.1} deg the Sun does not reach altitude {} deg",
                    latitude_rad.to_degrees(),
                    missed.join(", ")
                );
                notices.warn([&warning].into_iter().filter(|warning| of_nights.is_first(warning)));
            }
            found.push((latitude_rad, request, counts));
            if found.len() == 1 {
                provenance = prepared.provenance.clone();
            }
            // Constellations that grow have other satellites in another night.
            prepared.add_period(start, &mut periods);
            notices.warn(prepared.warnings.iter().filter(|warning| of_nights.is_first(warning)));
            let warning = prepared.left_out_warning(&without, start)?;
            without_position.extend(warning.filter(|warning| of_nights.is_first(warning)));
            left_out.extend(without);
        }
    }
    of_nights.print_last(&notices);
    left_out.sort_by_key(|satellite| satellite.norad_id);
    left_out.dedup_by_key(|satellite| satellite.norad_id);
    notices.list_left_out(without_position, &left_out);
    if periods.len() > 1 {
        provenance.state("periods", periods);
    }
    config.state_scales(&mut provenance, &photometry);
    provenance.state(
        "options",
        json!({
            "nights": typed.night,
            "latitudes_deg": typed.latitudes,
            "field": fov.map_or_else(|| config.stated_field(), |fov| json!(fov)),
            "exposure_s": exposure_s,
            "moments": moments,
            "spread_s": spread_s,
            "limit_mag": limit_mag,
            "first_utc": found.first().map(|(_, request, _)| format_utc(request.start, 0)),
        }),
    );
    let table =
        statistics_table(found.iter().flat_map(|(latitude_rad, request, counts)| {
            counts.iter().map(move |count| (*latitude_rad, request, count))
        }));
    output.write(
        &VerbResult::new("statistics", &table, ON_SCREEN, &provenance).with("left_out", &left_out_table(&left_out)),
        &notices,
    )?;
    Ok(Outcome::Done)
}

/// Returns the mean width of the field, radians, and its area, steradians; `None` for the area of a circle.
fn field_size(fov: Option<&str>, config: &Config) -> anyhow::Result<(f64, Option<f64>)> {
    if let Some((diameter_deg, None)) = fov.map(|fov| parse_size_deg("fov", fov)).transpose()? {
        return Ok((diameter_deg.to_radians(), None));
    }
    let field = config.field_of_view()?;
    Ok((field.mean_width_deg().to_radians(), Some(field.area_deg2() * 1f64.to_radians().powi(2))))
}
