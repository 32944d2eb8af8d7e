//! `identify`: lists the candidates for a measured streak, in order of decreasing probability.

use crate::arguments::OutputArguments;
use anyhow::anyhow;
use clap::Args;
use serde_json::json;
use streakcast::config::{Config, IdentifyConfig, STREAK_FORMS, state_scales};
use streakcast::frames::seconds_after;
use streakcast::identify::{
    CandidateRow, Identified, IdentifyOptions, Offset, candidate_table, identify_streak, streak_table,
};
use streakcast::output::{Section, counted};

use super::passes::left_out_table;
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::VerbResult;
use crate::required::Required;
use crate::screen::{Shown, Style, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct IdentifyArguments {
    #[command(flatten)]
    pub streak: IdentifyConfig,
    /// Include satellites in the Earth's shadow
    #[arg(long)]
    pub include_dark: bool,
    /// Largest number of candidates in the output
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub top: usize,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

const ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("norad_id", "norad"),
    rounded("probability", "P", 3),
    rounded("chi_square", "chi2", 1),
    rounded("along_track_offset_s", "delay s", 2),
    rounded("along_track_sigma_s", "sigma s", 1),
    rounded("cross_track_offset_arcsec", "cross-track arcsec", 0),
    rounded("cross_track_sigma_arcsec", "sigma arcsec", 0),
    rounded("angle_difference_deg", "angle diff. deg", 2),
    rounded("length_difference_deg", "length diff. deg", 3),
    rounded("angular_rate_deg_s", "deg/s", 3),
    rounded("passage_utc", "passage (UTC)", 1),
    rounded("range_km", "range km", 0),
    rounded("magnitude", "mag", 1),
    rounded("element_age_days", "age d", 1),
];

/// Smallest probability for which a candidate is reported as likely.
const LIKELY: f64 = 0.5;

pub fn run(typed: IdentifyArguments) -> anyhow::Result<Outcome> {
    if typed.top == 0 {
        return Err(anyhow!("top is 0; allowed: 1 or more"));
    }
    let config = typed.config.with_file()?;
    check_required(&config, &typed.streak)?;
    let (config, remark) = typed.streak.with_site_of_frame(config)?;
    let plan = typed.streak.resolve(&config)?;
    let output = typed.output.open(&config)?;
    let notices = begin(&config)?;
    remark.iter().for_each(|remark| notices.info(remark));
    let streak = &plan.streak;
    let options = IdentifyOptions {
        include_dark: typed.include_dark || config.include_dark.unwrap_or(false),
        photometry: config.photometry()?,
    };
    let mut prepared = config.prepare(streak.start(), seconds_after(streak.start(), streak.duration_s()))?;
    notices.warn(&prepared.warnings);
    prepared.check_altitude("streak", &plan.exposure())?;
    let found = identify_streak(&prepared.sky, streak, &options)?;
    notices.warn_left_out(&prepared, &found.left_out, streak.start())?;

    let scale = config.given_time_scale().unwrap_or("utc").to_ascii_lowercase();
    state_scales(&mut prepared.provenance, &scale, &options.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "streak": plan.source,
            "include_dark": options.include_dark,
            "top": typed.top,
            "candidates": found.candidates.len(),
            "unknown_probability": (found.unknown_probability * 1e6).round() / 1e6,
        }),
    );
    // If no candidate fits, none is listed: all are far from the streak.
    let top = if found.is_without_fit() { 0 } else { typed.top };
    let rows = found.candidates.iter().take(top).map(|candidate| CandidateRow {
        candidate,
        elements: &prepared.sky.elements()[candidate.element_index],
        photometry: &options.photometry,
    });
    let candidates = candidate_table(rows);
    output.write(
        &VerbResult {
            sections: vec![
                Section { name: "streak", table: &streak_table(streak) },
                Section { name: "candidates", table: &candidates },
                Section { name: "left_out", table: &left_out_table(&found.left_out) },
            ],
            main: &candidates,
            provenance: &prepared.provenance,
            style: Style { columns: ON_SCREEN, bold_row: (!candidates.rows.is_empty()).then_some(0) },
        },
        &notices,
    )?;
    summary(&notices, &found, &prepared.sky);
    Ok(if candidates.rows.is_empty() { Outcome::No } else { Outcome::Done })
}

/// Checks that streak, times, satellites and site are given.
fn check_required(config: &Config, streak: &IdentifyConfig) -> anyhow::Result<()> {
    let has_position = streak.ra.is_some() || streak.dec.is_some() || streak.position_angle.is_some();
    let has_pixels = streak.from_pix.is_some() || streak.to_pix.is_some();
    let has_streak = has_position || has_pixels || !streak.end.is_empty() || streak.region.is_some();
    // The header of a frame may contain the times.
    let has_times = !streak.times.is_empty() || streak.image.is_some();
    let has_start = has_times || streak.start.is_some() || config.exposure.start.is_some();
    let has_duration = has_times || streak.exposure.is_some() || config.exposure.duration.is_some();
    let required = Required::of(config)
        .input(has_streak, "streak", STREAK_FORMS)
        .input(has_start, "start of the exposure", "--start TIME, for example 2024-08-14T00:30:00Z, or --times")
        .input(has_duration, "exposure time", "--exposure TIME, for example 30s, or --times")
        .satellites();
    if streak.image.is_some() { required.check() } else { required.site().check() }
}

fn summary(notices: &Notices, found: &Identified, sky: &streakcast::passes::Sky) {
    let Some(best) = found.candidates.first() else {
        notices.info("no candidate: no satellite of these elements is close to the streak at that time");
        return;
    };
    let elements = &sky.elements()[best.element_index];
    let name = if elements.name.is_empty() { best.norad_id.to_string() } else { elements.name.to_string() };
    let counted = counted(found.candidates.len(), "candidate", "candidates");
    if found.is_without_fit() {
        let Offset { value: delay_s, sigma } = best.along_track_s;
        notices.info(&format!(
            "no candidate fits: a satellite outside of these elements has probability {:.4}; the most probable of {counted} is {name}, {:.1} s {} \
             (sigma {sigma:.1} s) and {:.0} arcsec from the streak (sigma {:.0} arcsec)",
            found.unknown_probability,
            delay_s.abs(),
            if delay_s < 0.0 { "early" } else { "late" },
            best.cross_track_rad.value.abs().to_degrees() * 3600.0,
            best.cross_track_rad.sigma.to_degrees() * 3600.0
        ));
    } else if best.probability >= LIKELY {
        notices.info(&format!("{counted}: {name} with probability {:.3}", best.probability));
    } else {
        notices.info(&format!(
            "{counted}, none likely: {name} with probability {:.3}; a satellite outside of these elements with {:.3}",
            best.probability, found.unknown_probability
        ));
    }
}
