//! `windows`: from when to when targets can be exposed without any satellite that matters.

use anyhow::anyhow;
use serde_json::json;
use streakcast::config::parse_duration_s;
use streakcast::output::{Section, format_utc};
use streakcast::schedule::{
    Blocking, FlagRequest, FoundWindows, ListedTarget, WindowReport, WindowRequest, WindowShape, WindowTarget,
    clear_windows, read_targets, window_table, window_target_table,
};

use super::judged::{begin, field_said, state_scales};
use super::passes::left_out_table;
use crate::failure::Outcome;
use crate::output::{Answer, FORMATS, Output};
use crate::screen::{Shown, Style, rounded, shown};
use crate::window_arguments::WindowsArguments;

const ON_SCREEN: &[Shown] = &[
    shown("name", "target"),
    rounded("first_start_utc", "first start (UTC)", 0),
    rounded("last_start_utc", "last start (UTC)", 0),
    rounded("length_s", "length s", 1),
    rounded("exposure_s", "exposure s", 1),
];

pub fn run(typed: WindowsArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(typed.rules.setup())?;
    let shape = typed.output.format.as_deref().and_then(WindowShape::by_name);
    let output = match shape {
        // A shape is a text of its own.
        Some(_) => Output::new(Some("json"), typed.output.output.clone())?,
        None => Output::new(typed.output.format.as_deref().or(setup.format.as_deref()), typed.output.output.clone())
            .map_err(|error| {
                anyhow!("{}", error.to_string().replace(FORMATS, &format!("{FORMATS}, lco, eso-p2, astroq")))
            })?,
    };
    let notices = begin(&setup)?;
    let (from, to) = super::night::range(typed.night.as_deref(), typed.start.as_deref(), typed.end.as_deref(), &setup)?;
    let (field, telescope, policy, photometry) =
        (setup.field_of_view()?, setup.telescope()?, setup.policy()?, setup.photometry()?);
    if policy.max_lost_fraction.is_some() {
        return Err(anyhow!(
            "the policy's max_lost_fraction makes no windows; allowed: limit_mag, saturation_mag, crosstalk_mag, min_probability, margin_s"
        ));
    }
    let min_altitude_deg = in_degrees("min-altitude", typed.min_altitude)?;
    let max_sun_altitude_deg = in_degrees("max-sun-altitude-deg", typed.max_sun_altitude_deg)?;
    let seconds = |what, text: &Option<String>| text.as_deref().map(|text| parse_duration_s(what, text)).transpose();
    let overhead_s = seconds("overhead", &typed.overhead)?.unwrap_or(0.0);
    let rotation_rad = setup.schedule_options()?.default_rotation_rad;
    let listed = read_targets(&typed.targets, seconds("exposure", &typed.exposure)?, rotation_rad)?;

    let mut prepared = setup.prepare(from, to)?;
    notices.warn(&prepared.warnings);
    let targets: Vec<WindowTarget> = listed.iter().filter_map(|one| one.target.clone().ok()).collect();
    let request = WindowRequest {
        against: FlagRequest {
            sky: &prepared.sky,
            field: &field,
            policy: &policy,
            telescope: telescope.as_ref(),
            photometry: &photometry,
        },
        blocking: Blocking::Limits,
        min_altitude_rad: min_altitude_deg.to_radians(),
        max_sun_altitude_rad: Some(max_sun_altitude_deg.to_radians()),
    };
    let report = clear_windows(&targets, from, to, &request)?;
    notices.warn(&prepared.left_out_warning(&report.left_out, from)?);
    let found = found(&listed, &report);
    for one in &found {
        if let Err(reason) = &one.listed.target {
            notices.warn(&[format!("target {}: {reason}", one.listed.name)]);
        }
    }
    let scale = setup.said_time_scale().unwrap_or("utc").to_ascii_lowercase();
    state_scales(&mut prepared.provenance, &scale, &photometry);
    prepared.provenance.state(
        "options",
        json!({
            "targets": typed.targets.display().to_string(),
            "from_utc": format_utc(from, 3),
            "to_utc": format_utc(to, 3),
            "field": field_said(&setup),
            "telescope": telescope.as_ref().map(|telescope| telescope.name.as_str()),
            "min_altitude_deg": min_altitude_deg,
            "max_sun_altitude_deg": max_sun_altitude_deg,
            "policy": policy,
        }),
    );
    if let Some(shape) = shape {
        let (text, left_out) = shape.text(&found, overhead_s);
        output.write_text(&text)?;
        if !left_out.is_empty() {
            let names: Vec<&str> = left_out.iter().map(|listed| listed.name.as_str()).collect();
            notices.warn(&[format!(
                "no window, and so not in the file, where none would mean any time: {}",
                names.join(", ")
            )]);
        }
    } else {
        let windows = window_table(&found);
        output.write(&Answer {
            sections: vec![
                Section { name: "windows", table: &windows },
                Section { name: "targets", table: &window_target_table(&found) },
                Section { name: "left_out", table: &left_out_table(&report.left_out) },
            ],
            main: &windows,
            provenance: &prepared.provenance,
            style: Style { columns: ON_SCREEN, bold_row: None },
        })?;
    }
    let count: usize = report.by_target.iter().map(|one| one.windows.len()).sum();
    notices.say(&format!("{} targets: {count} windows", listed.len()));
    Ok(Outcome::Done)
}

/// Every row of the list with what was found for it.
fn found<'a>(listed: &'a [ListedTarget], report: &'a WindowReport) -> Vec<FoundWindows<'a>> {
    let mut answers = report.by_target.iter();
    listed
        .iter()
        .map(|listed| FoundWindows { listed, found: listed.target.as_ref().ok().and_then(|_| answers.next()) })
        .collect()
}

fn in_degrees(what: &str, angle_deg: f64) -> anyhow::Result<f64> {
    if (-90.0..=90.0).contains(&angle_deg) {
        Ok(angle_deg)
    } else {
        Err(anyhow!("{what} {angle_deg} deg: allowed -90 to 90 deg"))
    }
}
