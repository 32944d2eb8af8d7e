//! `passes`: lists the satellites that cross the field during one exposure.

use crate::arguments::OutputArguments;
use clap::Args;
use serde_json::json;
use streakcast::config::{
    Config, EXPOSURE, ExposureConfig, FIELD, ObservationPlan, POINTING, PreparedSky, RulesConfig, SATELLITES, SITE,
    START, state_scales,
};
use streakcast::frames::parse_moment;
use streakcast::frames::seconds_after;
use streakcast::output::{Column, Kind, Table, counted, format_utc};
use streakcast::passes::{Exposure, Pass, PassOptions, Passes};
use streakcast::schedule::MagnitudeLimit;
use streakcast::schedule::{FlagRequest, StreakColumns, exposure_table, streak_table};

use crate::failure::Outcome;
use crate::help::{VerbFlags, help};
use crate::notices::Notices;
use crate::output::VerbResult;
use crate::screen::{Shown, known_to, rounded, shown};

#[derive(Args)]
pub struct PassesArguments {
    #[command(flatten)]
    pub exposure: ExposureConfig,
    /// Include crossings of satellites in the Earth's shadow
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub include_dark: Option<bool>,
    /// Report the probability of each crossing to be brighter than this, in the band of --band; all crossings are
    /// listed
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<MagnitudeLimit>,
    /// Report the probability of each streak to have a higher surface brightness than this, mag/arcsec2 (with
    /// --telescope); with --limit-mag, that of either
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_surface_brightness: Option<MagnitudeLimit>,
    /// Number of points along each track, 0 to 100000; none if omitted
    #[arg(long, value_name = "N")]
    pub samples: Option<usize>,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    PassesArguments, "passes", asks [START, EXPOSURE, POINTING, SATELLITES, SITE, FIELD],
    "--start 2024-08-14T03:30:00Z --exposure 30s --ra 280 --dec=-30 --shells oneweb --mpc X05 --fov 3.5deg",
    "--start 2024-08-14T03:30:00Z --exposure 2min --ra 18h40m --dec=-30d --elements active.tle --site Paranal --telescope vst"
}

const ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("norad_id", "norad"),
    known_to("enter_utc", "enter (UTC)", 2, "along_track_sigma_s"),
    known_to("exit_utc", "exit (UTC)", 2, "along_track_sigma_s"),
    rounded("magnitude_peak", "peak mag", 1),
    rounded("magnitude_peak_sigma", "sigma", 1),
    shown("mag_source", "source"),
    shown("illumination", "light at mid"),
    rounded("effective_magnitude", "eff. mag", 1),
    rounded("streak_length_deg", "length deg", 3),
    rounded("min_separation_deg", "off centre deg", 3),
    rounded("position_angle_deg", "PA deg", 0),
    rounded("angular_rate_deg_s", "deg/s", 3),
    rounded("altitude_deg", "alt deg", 0),
    rounded("azimuth_deg", "az deg", 0),
    rounded("range_km", "range km", 0),
    rounded("element_age_days", "age d", 1),
    rounded("along_track_sigma_s", "late s", 1),
    rounded("probability", "P", 2),
    rounded("p_brighter", "P brighter", 2),
    rounded("streak_cost_s", "cost s", 2),
];

pub fn run(typed: PassesArguments) -> anyhow::Result<Outcome> {
    let flags = Config {
        exposure: typed.exposure,
        include_dark: typed.include_dark,
        rules: RulesConfig {
            limit_mag: typed.limit_mag,
            limit_surface_brightness: typed.limit_surface_brightness,
            ..RulesConfig::default()
        },
        samples: typed.samples,
        ..typed.config
    };
    let config = flags.with_file()?;
    let output = typed.output.open(&config)?;
    let prediction = predict(&config)?;
    let passes = prediction.table(output.is_json());
    let left_out = left_out_table(&prediction.crossings.left_out);
    let exposures = exposure_table([&prediction.exposure]);
    let found = prediction.found();
    let brightest = |pass: &Pass| {
        pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref()).map(|brightness| brightness.magnitude.0)
    };
    let bold_row = (0..found.len())
        .filter(|&row| brightest(&found[row]).is_some())
        .min_by(|&a, &b| brightest(&found[a]).partial_cmp(&brightest(&found[b])).unwrap_or(std::cmp::Ordering::Equal));
    output.write(
        &VerbResult::new("passes", &passes, ON_SCREEN, &prediction.prepared.provenance)
            .after("exposures", &exposures)
            .with("left_out", &left_out)
            .bold(bold_row),
        &prediction.notices,
    )?;
    summary(&prediction, found);
    Ok(if found.is_empty() { Outcome::No } else { Outcome::Done })
}

/// Passes of one exposure.
pub struct Prediction {
    pub exposure: Exposure,
    pub plan: ObservationPlan,
    pub options: PassOptions,
    /// Magnitude limit in the band of the prediction.
    pub limit_mag: Option<f64>,
    /// Sky with provenance and warnings.
    pub prepared: PreparedSky,
    pub crossings: Passes,
    pub notices: Notices,
}

/// Computes the passes of the exposure in the configuration.
pub fn predict(config: &Config) -> anyhow::Result<Prediction> {
    PassesArguments::HELP.check(config, &[])?;
    let notices = crate::start::begin(config)?;
    let exposure = config.one_exposure()?;
    let plan = config.observation()?;
    let options = PassOptions {
        include_dark: config.include_dark.unwrap_or(false),
        min_probability: plan.policy.min_probability,
        samples: config.samples()?,
        photometry: plan.photometry,
        ..PassOptions::default()
    };
    let mut prepared = config.prepare(exposure.start, seconds_after(exposure.start, exposure.duration_s))?;
    prepared.check_altitude("pointing", &exposure)?;
    if let Some(reason) = prepared.sky.broken_limit(&exposure)? {
        anyhow::bail!("{reason}");
    }
    notices.warn(&prepared.warnings);
    let end = seconds_after(exposure.start, exposure.duration_s);
    prepared.check_known(exposure.start, end, Some(&plan.field))?;

    let crossings = prepared.sky.field_passes(std::slice::from_ref(&exposure), &plan.field, &options)?;
    notices.warn_left_out(&prepared, &crossings.left_out, exposure.start)?;
    state(&mut prepared, config, &exposure, &options, plan.telescope.as_ref().map(|telescope| telescope.name.as_str()));
    let band = options.photometry.band.name();
    let limit_mag = plan.policy.limit_mag.as_ref().and_then(|limit| limit.limit_in(Some(band)));
    Ok(Prediction { exposure, plan, options, limit_mag, prepared, crossings, notices })
}

impl Prediction {
    /// Returns the passes.
    pub fn found(&self) -> &[Pass] {
        self.crossings.by_exposure.first().map_or(&[], Vec::as_slice)
    }

    /// Returns the passes as a table; with nested tables if `is_nested`.
    pub fn table(&self, is_nested: bool) -> Table {
        let band = self.options.photometry.band.name();
        let request = FlagRequest { photometry: &self.options.photometry, ..self.plan.request(&self.prepared.sky) };
        let row = |pass| request.streak_row((&self.exposure, None), pass, Some(band), self.limit_mag);
        let rows = self.found().iter().map(row);
        let columns = StreakColumns {
            p_brighter: self.limit_mag.is_some() || self.plan.policy.has_limit_in(Some(band)),
            chords: is_nested,
            samples: self.options.samples > 0,
        };
        streak_table(rows, columns)
    }
}

fn state(
    prepared: &mut PreparedSky,
    config: &Config,
    exposure: &Exposure,
    options: &PassOptions,
    telescope: Option<&str>,
) {
    // A start such as 2024-08-14T00:30:00Z states its time scale, which overrides `--time-scale`.
    let has_scale = config.exposure.start.as_ref().is_some_and(|start| parse_moment(start.as_str(), None).is_ok());
    let scale = config.given_time_scale().filter(|_| !has_scale).unwrap_or("utc").to_ascii_lowercase();
    state_scales(&mut prepared.provenance, &scale, &options.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "start_utc": format_utc(exposure.start, 6),
            "exposure_s": exposure.duration_s,
            "ra_deg": round_deg(exposure.pointing.longitude_rad()),
            "dec_deg": round_deg(exposure.pointing.latitude_rad()),
            "rotation_deg": round_deg(exposure.rotation_rad),
            "field": config.stated_field(),
            "telescope": telescope,
            "include_dark": options.include_dark,
            "min_probability": options.min_probability,
            "samples": options.samples,
        }),
    );
}

/// Returns degrees, rounded so that the conversion from radians adds no digits.
fn round_deg(radians: f64) -> f64 {
    (radians.to_degrees() * 1e9).round() / 1e9
}

/// Returns the satellites whose position cannot be computed as a table.
pub fn left_out_table(left_out: &[streakcast::orbit::LeftOut]) -> Table {
    Table {
        columns: vec![
            Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
            Column::new("reason", Kind::Text, "Reason why the satellite is left out."),
        ],
        rows: left_out
            .iter()
            .map(|satellite| vec![i64::from(satellite.norad_id.0).into(), satellite.reason.to_string().into()])
            .collect(),
    }
}

fn summary(prediction: &Prediction, found: &[Pass]) {
    let Prediction { exposure, plan, options, limit_mag, prepared, notices, .. } = prediction;
    let band = Some(options.photometry.band.name());
    let surface = plan.policy.limit_surface_brightness.as_ref().and_then(|limit| limit.limit_in(band));
    let limits = [limit_mag.map(|limit| format!("mag {limit}")), surface.map(|limit| format!("{limit} mag/arcsec2"))];
    let limits: Vec<String> = limits.into_iter().flatten().collect();
    if limits.is_empty() {
        if found.is_empty() {
            notices.info("no passes");
        }
        return;
    }
    let request = FlagRequest { photometry: &options.photometry, ..plan.request(&prepared.sky) };
    // The limit of a row is that which the satellite exceeds first.
    let brighter = |pass: &Pass| {
        let limit_mag = request.streak_row((exposure, None), pass, band, *limit_mag).limit_mag;
        limit_mag.map_or(0.0, |limit_mag| pass.probability_brighter_than(limit_mag))
    };
    let bright = found.iter().map(brighter).fold(0.0, |sum, share| sum + share);
    let of = if bright < 0.05 && !found.is_empty() { format!("{bright:.2}") } else { format!("{bright:.1}") };
    let crossings = counted(found.len(), "pass", "passes");
    notices.info(&format!("{crossings}, {of} of them expected to be brighter than {}", limits.join(" or ")));
}
