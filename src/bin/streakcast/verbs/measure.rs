//! `measure`: forced photometry of the streaks of predicted satellites in frames.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use serde_json::json;
use streakcast::Watch;
use streakcast::config::{Config, FRAMES, Mark, MeasureConfig, Measurements, RequiredInput, SATELLITES, SITE};
use streakcast::measure::MeasuredPass;
use streakcast::measure::{ScoreObserver, score_table};
use streakcast::output::format_utc;
use streakcast::output::{Provenance, Table, counted};

use super::passes::left_out_table;
use crate::arguments::OutputArguments;
use crate::failure::Outcome;
use crate::help::{FIELD_FLAGS, VerbFlags, help};
use crate::notices::Notices;
use crate::output::write_bytes;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct MeasureArguments {
    #[command(flatten)]
    pub measure: MeasureConfig,
    /// Address of the observer, for --format score
    #[arg(long, value_name = "EMAIL", help_heading = "SCORE")]
    pub observer_email: Option<String>,
    /// ORCID of the observer, or several separated by commas, for --format score
    #[arg(long, value_name = "ORCID", help_heading = "SCORE")]
    pub observer_orcid: Option<String>,
    /// Telescope and instrument, for --format score
    #[arg(long, value_name = "TEXT", help_heading = "SCORE")]
    pub instrument: Option<String>,
    /// Picture of the frame along each track, with the profiles across the tracks, .png or .svg
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub picture: Option<PathBuf>,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Site for frames whose header has none.
pub const SITE_OF_FRAME: RequiredInput =
    RequiredInput { mark: Mark::Heading("Site", ", or the header"), is_given: |_| true, ..SITE };

help! {
    MeasureArguments, "measure", asks [FRAMES, SATELLITES, SITE_OF_FRAME],
    ignores [(FIELD_FLAGS, "has no effect on measure, where the frame is the field")],
    "frame.fits --elements active.tle --mpc X05 --seeing 1.2arcsec",
    "night/a.fits night/b.fits --elements active.tle --mpc X05 --zero-point 27.1 --format fit -o photometry.csv"
}

const ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("norad_id", "norad"),
    shown("hdu", "hdu"),
    shown("detected", "found"),
    rounded("mid_utc", "mid (UTC)", 2),
    rounded("magnitude", "mag", 2),
    rounded("magnitude_sigma", "sigma", 2),
    rounded("limit_magnitude", "limit", 2),
    rounded("predicted_magnitude", "model", 1),
    rounded("signal_to_noise", "S/N", 1),
    rounded("offset_arcsec", "offset arcsec", 1),
    rounded("late_s", "late s", 3),
    rounded("length_pix", "length pix", 0),
    rounded("seeing_arcsec", "seeing arcsec", 2),
    shown("flags", "flags"),
];

/// Columns on the screen for streaks of tables.
const OF_TABLES: &[Shown] = &[
    shown("streak", "streak"),
    shown("image", "image"),
    shown("hdu", "hdu"),
    shown("name", "name"),
    rounded("probability", "P", 3),
    shown("detected", "found"),
    rounded("magnitude", "mag", 2),
    rounded("magnitude_sigma", "sigma", 2),
    rounded("limit_magnitude", "limit", 2),
    rounded("predicted_magnitude", "model", 1),
    rounded("flux", "flux", 0),
    rounded("flux_sigma", "sigma", 0),
    rounded("offset_arcsec", "offset arcsec", 1),
    rounded("length_pix", "length pix", 0),
    rounded("seeing_arcsec", "width arcsec", 2),
    shown("flags", "flags"),
];

/// Tables in the columns of SCORE, the observation repository of the IAU CPS.
#[derive(Copy, Clone, PartialEq, Eq)]
enum Upload {
    /// With limits, for SCORE.
    Score,
    /// Without limits, for `fit`.
    Fit,
}

pub fn run(typed: MeasureArguments) -> anyhow::Result<Outcome> {
    let config = typed.config.clone().with_file()?;
    let has_tables = !typed.measure.streaks.is_empty();
    // Rows of a table may name their frames.
    if !has_tables {
        MeasureArguments::HELP.check(&config, &[(&FRAMES, !typed.measure.image.is_empty())])?;
    }
    let upload = match typed.output.format.as_deref() {
        Some("score") => Some(Upload::Score),
        Some("fit") => Some(Upload::Fit),
        _ => None,
    };
    let observer = observer(&typed, upload)?;
    let output = match upload {
        Some(_) => Output::new(Some("csv"), typed.output.output.clone())?,
        None => typed.output.clone().open_or(&config, "score, fit")?,
    };
    let cuts = typed.picture.is_some();
    if let Some(path) = &typed.picture {
        streakcast::plot::PictureFormat::from_extension(path)?;
        crate::output::check(path)?;
    }
    let notices = begin(&config)?;
    let mut done = MeasureConfig { cuts, ..typed.measure.clone() }.measure(&config, None, &Watch::default())?;
    done.remarks.iter().for_each(|remark| notices.info(remark));
    notices.warn(&done.warnings);
    summary(&notices, &done, has_tables);
    if let Some(path) = &typed.picture {
        picture(path, &done, &notices)?;
    }
    let table = match upload {
        Some(upload) => upload_table(&done, &observer, upload)?,
        None => done.table.clone(),
    };
    let shown = |paths: &[PathBuf]| paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>();
    let mut options = json!({
        "frames": shown(&done.frames),
        "satellite_size_m": typed.measure.satellite_size,
        "seeing": typed.measure.seeing,
        "psf": typed.measure.psf,
        "fit_width": typed.measure.fit_width,
        "star_colours": typed.measure.star_colours,
    });
    if has_tables {
        options["streaks"] = shown(&typed.measure.streaks).into();
        options["place_sigma"] = typed.measure.place_sigma.clone().into();
    }
    done.provenance.state("options", options);
    // Uploads must begin with the line of column names, so no provenance is written.
    let none = Provenance::default();
    let left_out = left_out_table(&done.left_out);
    output.write(
        &VerbResult::new(
            "measurements",
            &table,
            if has_tables { OF_TABLES } else { ON_SCREEN },
            if upload.is_some() { &none } else { &done.provenance },
        )
        .with("left_out", &left_out),
        &notices,
    )?;
    Ok(if done.table.rows.is_empty() { Outcome::No } else { Outcome::Done })
}

/// Draws the frame along each track.
fn picture(path: &Path, done: &Measurements, notices: &Notices) -> anyhow::Result<()> {
    use streakcast::plot::{CutPanel, PictureFormat, streak_cuts};
    let title = |pass: &MeasuredPass| {
        let satellite = &pass.prediction.satellite;
        let name = match (&*pass.prediction.id, &*satellite.name) {
            ("", "") => "satellite".to_owned(),
            ("", name) => name.to_owned(),
            (id, "") => format!("streak {id}"),
            (id, name) => format!("streak {id}: {name}"),
        };
        let number = satellite.norad_id.map_or_else(String::new, |id| format!(" ({id})"));
        let light = match (&pass.magnitude, pass.limit_mag) {
            (Some(light), _) => format!("{:.3} +- {:.3} mag", light.value, light.sigma),
            (None, _) if pass.measured.is_detected => "found, magnitude unknown".to_owned(),
            (None, Some(limit)) => format!("not found, fainter than {limit:.2} mag"),
            (None, None) => "not found".to_owned(),
        };
        let system = if pass.is_calibrated { "" } else { " (instrumental)" };
        let time = format_utc(pass.epoch, 1);
        format!("{name}{number}, HDU {}, {time}: {light}{system}", pass.hdu)
    };
    let titles: Vec<String> = done.passes.iter().map(title).collect();
    let panels = titles.iter().zip(&done.passes).filter_map(|(title, pass)| {
        let cut = pass.cut.as_ref()?;
        Some(CutPanel {
            title,
            columns: cut.columns,
            length_pix: cut.length_pix,
            across_pix: &cut.across_pix,
            values: &cut.values,
            profile: &cut.profile,
            profile_sigma: &cut.profile_sigma,
            model: &cut.model,
            predicted_pix: -pass.measured.offset_pix.value,
        })
    });
    let panels: Vec<CutPanel<'_>> = panels.collect();
    if panels.is_empty() {
        return Err(anyhow!("no track for --picture; allowed: frames with predicted tracks or streaks of a table"));
    }
    let chart = streak_cuts("Measured streaks", &panels)?;
    let chart = match &done.site {
        Some(site) => chart.with_subtitle(&site.name),
        None => chart,
    };
    write_bytes(path, &chart.to_bytes(PictureFormat::from_extension(path)?)?, notices)
}

/// Returns the observer of a SCORE upload, in which all fields are required.
fn observer(typed: &MeasureArguments, upload: Option<Upload>) -> anyhow::Result<ScoreObserver> {
    let fields = [
        ("--observer-email", &typed.observer_email),
        ("--observer-orcid", &typed.observer_orcid),
        ("--instrument", &typed.instrument),
    ];
    if upload == Some(Upload::Score)
        && let Some((flag, _)) = fields.iter().find(|(_, value)| value.is_none())
    {
        return Err(anyhow!("missing {flag}; SCORE requires --observer-email, --observer-orcid and --instrument"));
    }
    if upload.is_none()
        && let Some((flag, _)) = fields.iter().find(|(_, value)| value.is_some())
    {
        return Err(anyhow!("{flag} has no effect without --format score; allowed: with --format score"));
    }
    let text = |value: &Option<String>| value.clone().unwrap_or_default();
    Ok(ScoreObserver {
        email: text(&typed.observer_email),
        orcid: text(&typed.observer_orcid),
        instrument: text(&typed.instrument),
    })
}

fn upload_table(done: &Measurements, observer: &ScoreObserver, upload: Upload) -> anyhow::Result<Table> {
    let without = if done.provenance.get("elements").is_some() {
        "the observer is in orbit; allowed with --format score: a site"
    } else {
        "streaks without --elements have no satellites; allowed with --format score: --elements and a site"
    };
    let site = done.site.as_ref().ok_or_else(|| anyhow!(without))?;
    if let Some(bare) = done.passes.iter().find(|pass| !pass.is_calibrated) {
        return Err(anyhow!("{} has no zero point; specify --zero-point or --zero-point-1s", bare.image));
    }
    let mut table = score_table(&done.passes, site, observer);
    if upload == Upload::Fit {
        let magnitude = table.columns.iter().position(|column| column.name == "apparent_magnitude").unwrap_or_default();
        table.rows.retain(|row| row[magnitude] != streakcast::output::Value::Null);
    }
    Ok(table)
}

fn summary(notices: &Notices, done: &Measurements, has_tables: bool) {
    let found = done.passes.iter().filter(|pass| pass.measured.is_detected).count();
    let missed = done.passes.len() - found;
    if has_tables {
        let all = counted(done.table.rows.len(), "row", "rows");
        let outside = done.table.rows.len() - done.passes.len();
        let named = done.passes.iter().filter(|pass| pass.prediction.satellite.norad_id.is_some()).count();
        let streaks = counted(found, "streak", "streaks");
        notices.info(&format!(
            "{all}: {streaks} found, {missed} not found, {outside} not measured; {named} with a satellite"
        ));
        return;
    }
    let all = counted(done.passes.len(), "predicted track", "predicted tracks");
    notices.info(&format!("{all}: {} measured, {missed} not found", counted(found, "streak", "streaks")));
}
