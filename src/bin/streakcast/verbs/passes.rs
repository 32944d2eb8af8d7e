//! `passes`: every satellite that crosses the field during one exposure.

use serde_json::json;
use streakcast::config::above_the_horizon;
use streakcast::config::{Prepared, Setup, parse_moment};
use streakcast::frames::seconds_after;
use streakcast::images::Telescope;
use streakcast::output::{Column, Kind, Section, Table, format_utc};
use streakcast::passes::{Exposure, FieldPass, PassOptions, Passes};
use streakcast::schedule::{StreakRow, exposure_table, streak_table};

use crate::arguments::PassesArguments;
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::Answer;
use crate::screen::{Shown, Style, rounded, shown};

const ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("norad_id", "norad"),
    rounded("enter_utc", "enter (UTC)", 2),
    rounded("exit_utc", "exit (UTC)", 2),
    rounded("magnitude_peak", "peak mag", 1),
    rounded("magnitude_sigma", "sigma", 1),
    shown("mag_source", "source"),
    shown("illumination", "light"),
    rounded("effective_magnitude", "eff. mag", 1),
    rounded("streak_length_deg", "length deg", 3),
    rounded("min_separation_deg", "off centre deg", 3),
    rounded("position_angle_deg", "PA deg", 0),
    rounded("angular_rate_deg_s", "deg/s", 3),
    rounded("altitude_deg", "alt deg", 0),
    rounded("azimuth_deg", "az deg", 0),
    rounded("range_km", "range km", 0),
    rounded("element_age_days", "age d", 1),
    rounded("probability", "P", 2),
];

pub fn run(typed: PassesArguments) -> anyhow::Result<Outcome> {
    let setup = typed.shared.setup(Setup {
        include_dark: typed.include_dark.then_some(true),
        limit_mag: typed.limit_mag,
        samples: typed.samples,
        ..typed.exposure.setup()
    })?;
    let output = typed.output.open(&setup)?;
    let asked = ask(&setup)?;
    let passes = asked.table(output.is_json());
    let left_out = left_out_table(&asked.answer.left_out);
    let exposures = exposure_table([&asked.exposure]);
    let found = asked.found();
    let brightest = |pass: &FieldPass| {
        pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref()).map(|brightness| brightness.magnitude.0)
    };
    let bold_row = (0..found.len())
        .filter(|&row| brightest(&found[row]).is_some())
        .min_by(|&a, &b| brightest(&found[a]).partial_cmp(&brightest(&found[b])).unwrap_or(std::cmp::Ordering::Equal));
    output.write(&Answer {
        sections: vec![
            Section { name: "exposures", table: &exposures },
            Section { name: "passes", table: &passes },
            Section { name: "left_out", table: &left_out },
        ],
        main: &passes,
        provenance: &asked.prepared.provenance,
        style: Style { columns: ON_SCREEN, bold_row },
    })?;
    summary(&asked.notices, &setup, found.len(), found.iter().filter_map(brightest));
    Ok(if found.is_empty() { Outcome::No } else { Outcome::Done })
}

/// One exposure asked.
pub struct Asked {
    pub exposure: Exposure,
    pub telescope: Option<Telescope>,
    pub options: PassOptions,
    /// The sky that was asked, with what the answer rests on.
    pub prepared: Prepared,
    pub answer: Passes,
    pub notices: Notices,
}

/// Which satellites cross the exposure that a setup says.
pub fn ask(setup: &Setup) -> anyhow::Result<Asked> {
    let notices = super::judged::begin(setup)?;
    let exposure = setup.one_exposure()?;
    let field = setup.field_of_view()?;
    let telescope = setup.telescope()?;
    let options = PassOptions {
        include_dark: setup.include_dark.unwrap_or(false),
        min_probability: setup.policy()?.min_probability,
        samples: setup.samples()?,
        photometry: setup.photometry()?,
        ..PassOptions::default()
    };
    let mut prepared = setup.prepare(exposure.start, seconds_after(exposure.start, exposure.duration_s))?;
    above_the_horizon("pointing", &exposure, &prepared)?;
    notices.warn(&prepared.warnings);

    let answer = prepared.sky.field_passes(std::slice::from_ref(&exposure), &field, &options)?;
    notices.warn(&prepared.left_out_warning(&answer.left_out, exposure.start)?);
    state(&mut prepared, setup, &exposure, &options, telescope.as_ref().map(|telescope| telescope.name.as_str()));
    Ok(Asked { exposure, telescope, options, prepared, answer, notices })
}

impl Asked {
    /// The passes of the one exposure.
    pub fn found(&self) -> &[FieldPass] {
        self.answer.by_exposure.first().map_or(&[], Vec::as_slice)
    }

    /// The passes as a table; with what nests tables in tables where that is wanted.
    pub fn table(&self, is_nested: bool) -> Table {
        let rows = self.found().iter().map(|pass| StreakRow {
            exposure: &self.exposure,
            pass,
            elements: &self.prepared.sky.elements()[pass.element_index],
            satellite_size_m: self.prepared.sky.model(pass.element_index).size_m(),
            telescope: self.telescope.as_ref(),
            photometry: &self.options.photometry,
        });
        streak_table(rows, is_nested, self.options.samples > 0)
    }
}

fn state(prepared: &mut Prepared, setup: &Setup, exposure: &Exposure, options: &PassOptions, telescope: Option<&str>) {
    // A start that ends in Z says its scale itself.
    let names_its_own = setup.start.as_ref().is_some_and(|start| parse_moment(&start.text(), None).is_ok());
    let scale = setup.said_time_scale().filter(|_| !names_its_own).unwrap_or("utc").to_ascii_lowercase();
    super::judged::state_scales(&mut prepared.provenance, &scale, &options.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "start_utc": format_utc(exposure.start, 6),
            "exposure_s": exposure.duration_s,
            "ra_deg": round_deg(exposure.pointing.longitude_rad()),
            "dec_deg": round_deg(exposure.pointing.latitude_rad()),
            "rotation_deg": round_deg(exposure.rotation_rad),
            "field": super::judged::field_said(setup),
            "telescope": telescope,
            "include_dark": options.include_dark,
            "min_probability": options.min_probability,
            "samples": options.samples,
        }),
    );
}

/// Degrees without the rounding of the way through radians.
fn round_deg(radians: f64) -> f64 {
    (radians.to_degrees() * 1e9).round() / 1e9
}

/// Satellites left out, as a table.
pub fn left_out_table(left_out: &[streakcast::orbit::LeftOut]) -> Table {
    Table {
        columns: vec![
            Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
            Column::new("reason", Kind::Text, "Why the satellite was left out."),
        ],
        rows: left_out
            .iter()
            .map(|one| vec![i64::from(one.norad_id.0).into(), one.reason.to_string().into()])
            .collect(),
    }
}

fn summary(notices: &Notices, setup: &Setup, count: usize, magnitudes: impl Iterator<Item = f64>) {
    let crossings = if count == 1 { "1 pass".to_owned() } else { format!("{count} passes") };
    let limit = setup.limit_mag.as_ref().and_then(|limit| limit.of(Some(setup.band.as_deref().unwrap_or("V"))));
    match limit {
        Some(limit) => {
            let bright = magnitudes.filter(|magnitude| *magnitude < limit).count();
            notices.say(&format!("{crossings}, {bright} brighter than mag {limit}"));
        }
        None if count == 0 => notices.say("no passes"),
        None => {}
    }
}
