//! `identify`: lists the candidates for a measured streak, in order of decreasing probability.

#[cfg(unix)]
use std::{collections::BTreeSet, path::PathBuf};

use crate::arguments::OutputArguments;
use anyhow::anyhow;
use clap::Args;
use serde_json::json;
#[cfg(unix)]
use streakcast::config::streaks_of_table;
use streakcast::config::{
    Config, IdentifyConfig, IdentifyPlan, Mark, PreparedSky, RequiredInput, SATELLITES, SITE, STREAK,
};
use streakcast::frames::seconds_after;
use streakcast::identify::{
    CandidateRow, Identified, IdentifyOptions, Offset, candidate_table, identify_streak, streak_table,
};
#[cfg(unix)]
use streakcast::output::{Column, Kind, Provenance, Table, Value, counted};

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
    check_required(&config, &typed.streak)?;
    let (at_site, remark) = typed.streak.with_site_of_frame(config)?;
    let plan = typed.streak.resolve(&at_site)?;
    let output = typed.output.clone().open(&at_site)?;
    let notices = begin(&at_site)?;
    remark.iter().chain(&plan.remarks).for_each(|remark| notices.info(remark));
    let mut prepared = prepared_for(&at_site, &plan, &notices)?;
    let done = identified(&typed, &at_site, &plan, &prepared)?;
    notices.warn(&done.found.unknown_observer);
    notices.list_left_out(done.left_out.clone(), &done.found.left_out);
    let found = &done.found;
    prepared.provenance.state(
        "options",
        json!({
            "streak": plan.source,
            "include_dark": done.options.include_dark,
            "top": typed.top,
            "candidates": found.candidates.len(),
            "unknown_probability": (found.unknown_probability * 1e6).round() / 1e6,
        }),
    );
    let candidates = done.table(&prepared, typed.top);
    output.write(
        &VerbResult::new("candidates", &candidates, ON_SCREEN, &prepared.provenance)
            .after("streak", &streak_table(&plan.streak))
            .with("left_out", &left_out_table(&done.found.left_out))
            .bold((!candidates.rows.is_empty()).then_some(0)),
        &notices,
    )?;
    summary(&notices, &done.found, &prepared.sky);
    Ok(if candidates.rows.is_empty() { Outcome::No } else { Outcome::Done })
}

/// Candidates of one streak.
struct Done {
    found: Identified,
    options: IdentifyOptions,
    /// Warning about satellites whose position cannot be computed.
    left_out: Option<String>,
}

impl Done {
    /// Returns the table of the first candidates. If no candidate fits, none is listed: all are far from the streak.
    fn table(&self, prepared: &PreparedSky, top: usize) -> Table {
        let top = if self.found.is_without_fit() { 0 } else { top };
        candidate_table(self.found.candidates.iter().take(top).map(|candidate| CandidateRow {
            candidate,
            elements: &prepared.sky.elements()[candidate.element_index],
            photometry: &self.options.photometry,
        }))
    }
}

/// Prepares the sky of a streak, and prints its warnings.
fn prepared_for(config: &Config, plan: &IdentifyPlan, notices: &Notices) -> anyhow::Result<PreparedSky> {
    let streak = &plan.streak;
    let mut prepared = config.prepare(streak.start(), seconds_after(streak.start(), streak.duration_s()))?;
    notices.warn(&prepared.warnings);
    config.state_scales(&mut prepared.provenance, &config.photometry()?);
    Ok(prepared)
}

/// Searches the candidates of one streak in its sky.
fn identified(
    typed: &IdentifyArguments,
    config: &Config,
    plan: &IdentifyPlan,
    prepared: &PreparedSky,
) -> anyhow::Result<Done> {
    let streak = &plan.streak;
    let options = IdentifyOptions {
        include_dark: typed.include_dark.or(config.include_dark).unwrap_or(false),
        photometry: config.photometry()?,
    };
    prepared.check_altitude("streak", &plan.exposure())?;
    let found = identify_streak(&prepared.sky, streak, &options)?;
    let left_out = prepared.left_out_warning(&found.left_out, streak.start())?;
    Ok(Done { found, options, left_out })
}

/// Identifies the streaks of tables. The table of candidates has the name and the frame of each streak in front.
#[cfg(unix)]
fn run_tables(typed: &IdentifyArguments, config: &Config) -> anyhow::Result<Outcome> {
    check(config, &[&SATELLITES], &[])?;
    let output = typed.output.clone().open(config)?;
    let notices = begin(config)?;
    let mut candidates = candidate_table(std::iter::empty());
    let named = [
        Column::new("streak", Kind::Text, "Name of the streak in its table."),
        Column::new("image", Kind::Text, "File of the frame; empty for a streak without a frame."),
    ];
    candidates.columns.splice(0..0, named);
    let mut left_out = left_out_table(&[]);
    // Sky of the last streak, and its frame and times.
    let mut sky: Option<(_, PreparedSky)> = None;
    let (mut count, mut without) = (0, Vec::new());
    let mut failed = Vec::new();
    let (mut of_observer, mut stated) = (Vec::new(), BTreeSet::new());
    for path in &typed.streaks {
        let (rows, remarks) = streaks_of_table(path, &typed.streak)?;
        remarks.iter().for_each(|remark| notices.info(remark));
        for row in rows {
            let at_row = |error: &dyn std::fmt::Display| anyhow!("{}: {error}", row.origin);
            let (at_site, remark) = row.streak.with_site_of_frame(config.clone()).map_err(|error| at_row(&error))?;
            let plan = match row.streak.resolve(&at_site) {
                Ok(plan) => plan,
                Err(error) => {
                    failed.push(at_row(&error));
                    continue;
                }
            };
            // Streaks of one frame have the same sky.
            let key = (row.streak.image.clone(), plan.streak.start(), plan.streak.duration_s().to_bits());
            let same = sky.take_if(|(of, _)| *of != key).is_none() && sky.is_some();
            if !same {
                remark.iter().for_each(|remark| notices.info(remark));
            }
            let (_, prepared) = match &mut sky {
                Some(sky) => sky,
                None => sky.insert((key, prepared_for(&at_site, &plan, &notices)?)),
            };
            let done = match identified(typed, &at_site, &plan, prepared) {
                Ok(done) => done,
                Err(error) => {
                    failed.push(at_row(&error));
                    continue;
                }
            };
            of_observer.extend(done.found.unknown_observer.iter().map(|warning| format!("{}: {warning}", row.origin)));
            // The streaks of a night have the same warning.
            if stated.insert(done.left_out.clone()) {
                notices.list_left_out(done.left_out.clone(), &done.found.left_out);
            }
            let image = row.streak.image.as_ref().map(|image| image.display().to_string());
            let table = done.table(prepared, typed.top);
            if table.rows.is_empty() {
                without.push(row.id.clone());
            }
            candidates.rows.extend(table.rows.into_iter().map(|mut cells| {
                cells.splice(0..0, [Value::Text(row.id.clone()), image.clone().into()]);
                cells
            }));
            if !same {
                left_out.rows.extend(left_out_table(&done.found.left_out).rows);
            }
            count += 1;
        }
    }
    notices.warn_first(of_observer, "streaks with such a telescope");
    if !failed.is_empty() {
        if count == 0 {
            return Err(failed.swap_remove(0));
        }
        let warnings = failed.iter().map(|error| format!("{error}; the streak is left out"));
        notices.warn_first(warnings, "streaks left out");
    }
    // A detector may have found no streak.
    let mut provenance = sky.map_or_else(Provenance::new, |(_, prepared)| prepared.provenance);
    let include_dark = typed.include_dark.or(config.include_dark).unwrap_or(false);
    let tables: Vec<String> = typed.streaks.iter().map(|path| path.display().to_string()).collect();
    provenance.state("options", json!({ "streaks": tables, "include_dark": include_dark, "top": typed.top }));
    output.write(
        &VerbResult::new("candidates", &candidates, OF_TABLES, &provenance).with("left_out", &left_out),
        &notices,
    )?;
    notices.info(&format!("{}: {} with candidates", counted(count, "streak", "streaks"), count - without.len()));
    if !without.is_empty() {
        notices.info(&format!("no satellite of these elements fits: {}", without.join(", ")));
    }
    Ok(if candidates.rows.is_empty() { Outcome::No } else { Outcome::Done })
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
