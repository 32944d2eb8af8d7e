//! `identify`: lists the candidates for a measured streak, in order of decreasing probability.

#[cfg(unix)]
use std::path::PathBuf;

use crate::arguments::OutputArguments;
use anyhow::anyhow;
use clap::Args;
use serde_json::json;
use streakcast::config::{Config, IdentifyConfig, IdentifySettings, Mark, RequiredInput, SATELLITES, SITE, STREAK};
use streakcast::identify::{Identified, Offset, streak_table};
use streakcast::output::counted;
#[cfg(unix)]
use streakcast::{
    Watch,
    config::{StreakTables, identify_streaks},
    message::listed,
    orbit::LeftOut,
};

use super::passes::left_out_table;
use crate::failure::Outcome;
#[cfg(unix)]
use crate::help::check;
use crate::help::{CAMERA_FLAGS, VerbFlags, help};
use crate::notices::Notices;
use crate::output::VerbResult;
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct IdentifyArguments {
    #[command(flatten)]
    pub streak: IdentifyConfig,
    /// Tables of streaks, instead of one streak: CSV or ECSV with their ends, streaks.txt of ASTRiDE, the catalog of
    /// acstools.findsat_mrt, or regions of DS9; the frame of each is its column image, or --image
    #[cfg(unix)]
    #[arg(long, value_name = "TABLE", num_args = 1..)]
    pub streaks: Vec<PathBuf>,
    /// Include satellites in the Earth's shadow
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub include_dark: Option<bool>,
    /// Largest number of candidates in the output
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub top: usize,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

const STREAK_TIMES: RequiredInput = RequiredInput {
    example: "--start 2024-08-14T00:30:00Z --exposure 30s",
    mark: Mark::Usage,
    ..RequiredInput::new("times of the streak", &[&["--start TIME", "--exposure TIME"], &["--times TIME TIME"]])
};
const SITE_OR_FRAME: RequiredInput =
    RequiredInput { mark: Mark::Heading("Site", "; with --image also from the header"), ..SITE };

help! {
    IdentifyArguments, "identify", asks [STREAK, STREAK_TIMES, SATELLITES, SITE_OR_FRAME],
    ignores [(CAMERA_FLAGS, "has no effect on the identification of a streak")],
    "--end 280,-30 --end 280.5,-30.3 --start 2024-08-14T03:30:00Z --exposure 30s --shells oneweb --mpc X05",
    "--image frame.fits --from-pix 12,940 --to-pix 2030,1105 --elements active.tle --mpc X05"
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

/// Columns on the screen for streaks of tables.
#[cfg(unix)]
const OF_TABLES: &[Shown] = &[
    shown("streak", "streak"),
    shown("image", "image"),
    shown("name", "name"),
    shown("norad_id", "norad"),
    rounded("probability", "P", 3),
    rounded("along_track_offset_s", "delay s", 2),
    rounded("cross_track_offset_arcsec", "cross-track arcsec", 0),
    rounded("cross_track_sigma_arcsec", "sigma arcsec", 0),
    rounded("angle_difference_deg", "angle diff. deg", 2),
    rounded("range_km", "range km", 0),
    rounded("magnitude", "mag", 1),
];

/// Smallest probability for which a candidate is reported as likely.
const LIKELY: f64 = 0.5;

pub fn run(typed: IdentifyArguments) -> anyhow::Result<Outcome> {
    if typed.top == 0 {
        return Err(anyhow!("top is 0; allowed: 1 or more"));
    }
    let config = typed.config.clone().with_file()?;
    #[cfg(unix)]
    if !typed.streaks.is_empty() {
        return run_tables(&typed, &config);
    }
    if typed.streak.hdu.is_some() && typed.streak.image.is_none() {
        return Err(anyhow!("missing frame of --hdu; specify --image FILE, or --streaks TABLE that names its frames"));
    }
    check_required(&config, &typed.streak)?;
    let (at_site, remark) = typed.streak.with_site_of_frame(config)?;
    let plan = typed.streak.resolve(&at_site)?;
    let output = typed.output.clone().open(&at_site)?;
    let notices = begin(&at_site)?;
    remark.iter().chain(&plan.remarks).for_each(|remark| notices.info(remark));
    let (first, last) = plan.span();
    let mut prepared = at_site.prepare(first, last)?;
    notices.warn(&prepared.warnings);
    at_site.state_scales(&mut prepared.provenance, &at_site.photometry()?);
    let settings = settings(&typed);
    let done = plan.identify(&at_site, &prepared, &settings)?;
    notices.warn(&done.found.unknown_observer);
    notices.list_left_out(done.left_out.clone(), &done.found.left_out);
    let found = &done.found;
    prepared.provenance.state(
        "options",
        json!({
            "streak": plan.source,
            "include_dark": settings.includes_dark(&at_site),
            "top": typed.top,
            "candidates": found.candidates.len(),
            "unknown_probability": (found.unknown_probability * 1e6).round() / 1e6,
        }),
    );
    let candidates = &done.candidates;
    output.write(
        &VerbResult::new("candidates", candidates, ON_SCREEN, &prepared.provenance)
            .after("streak", &streak_table([&plan.streak]))
            .with("left_out", &left_out_table(&done.found.left_out))
            .bold((!candidates.rows.is_empty()).then_some(0)),
        &notices,
    )?;
    summary(&notices, &done.found, &prepared.sky);
    Ok(if candidates.rows.is_empty() { Outcome::No } else { Outcome::Done })
}

fn settings(typed: &IdentifyArguments) -> IdentifySettings {
    IdentifySettings { include_dark: typed.include_dark, top: typed.top }
}

/// Identifies the streaks of tables.
#[cfg(unix)]
fn run_tables(typed: &IdentifyArguments, config: &Config) -> anyhow::Result<Outcome> {
    check(config, &[&SATELLITES], &[])?;
    let output = typed.output.clone().open(config)?;
    let notices = begin(config)?;
    let tables = StreakTables { paths: &typed.streaks, folder: None };
    let settings = settings(typed);
    let mut done = identify_streaks(tables, &typed.streak, config, &settings, None, &Watch::default())?;
    done.remarks.iter().for_each(|remark| notices.info(remark));
    notices.warn(&done.warnings);
    done.left_out.iter().for_each(|(warning, satellites)| {
        if let Some(warning) = warning {
            notices.list_left_out([warning.clone()], satellites);
        }
    });
    let tables: Vec<String> = typed.streaks.iter().map(|path| path.display().to_string()).collect();
    let options = json!({ "streaks": tables, "include_dark": settings.includes_dark(config), "top": typed.top });
    done.provenance.state("options", options);
    let left_out: Vec<LeftOut> = done.left_out.iter().flat_map(|(_, satellites)| satellites.clone()).collect();
    output.write(
        &VerbResult::new("candidates", &done.candidates, OF_TABLES, &done.provenance)
            .after("streaks", &done.streaks)
            .with("left_out", &left_out_table(&left_out)),
        &notices,
    )?;
    let (count, without) = (done.streaks.rows.len(), &done.without_candidate);
    notices.info(&format!("{}: {} with candidates", counted(count, "streak", "streaks"), count - without.len()));
    if !without.is_empty() {
        let names = listed(without.iter().map(String::as_str));
        notices.info(&format!("no satellite of these elements fits: {names}"));
    }
    Ok(if done.candidates.rows.is_empty() { Outcome::No } else { Outcome::Done })
}

/// Checks that streak, times, satellites and site are given.
fn check_required(config: &Config, streak: &IdentifyConfig) -> anyhow::Result<()> {
    let has_position = streak.ra.is_some() || streak.dec.is_some() || streak.position_angle.is_some();
    let has_pixels = streak.from_pix.is_some() || streak.to_pix.is_some();
    let has_streak = has_position || has_pixels || !streak.end.is_empty() || streak.region.is_some();
    // The header of a frame may contain the times.
    let has_times = !streak.times.is_empty() || streak.image.is_some();
    let has_start = streak.start.is_some() || config.exposure.start.is_some();
    let has_duration = streak.exposure.is_some() || config.exposure.duration.is_some();
    let answers = [
        (&STREAK, has_streak),
        // One without the other is another error.
        (&STREAK_TIMES, has_times || has_start || has_duration),
        (&SITE, streak.image.is_some() || config.has_viewpoint()),
    ];
    IdentifyArguments::HELP.check(config, &answers)
}

fn summary(notices: &Notices, found: &Identified, sky: &streakcast::passes::Sky) {
    let Some(best) = found.candidates.first() else {
        notices.info("no candidate: no satellite of these elements is close to the streak at that time");
        return;
    };
    let elements = &sky.elements()[best.element_index];
    let name = best.norad_id.or_name(&elements.name);
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
