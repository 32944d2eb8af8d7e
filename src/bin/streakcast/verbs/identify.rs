//! `identify`: which satellite a measured streak is of, as ranked candidates.

use anyhow::anyhow;
use serde_json::json;
use streakcast::config::Setup;
use streakcast::config::{StreakAsked, StreakSaid, above_the_horizon};
use streakcast::frames::seconds_after;
use streakcast::identify::{CandidateRow, Identified, IdentifyOptions, candidate_table, identify_streak, streak_table};
use streakcast::output::Section;

use super::judged::{begin, state_scales};
use super::passes::left_out_table;
use crate::failure::Outcome;
use crate::identify_arguments::IdentifyArguments;
use crate::notices::Notices;
use crate::output::Answer;
use crate::screen::{Shown, Style, rounded, shown};

const ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("norad_id", "norad"),
    rounded("probability", "P", 3),
    rounded("chi_square", "chi2", 1),
    rounded("along_track_offset_s", "late s", 2),
    rounded("along_track_sigma_s", "sigma s", 1),
    rounded("cross_track_offset_arcsec", "beside arcsec", 0),
    rounded("cross_track_sigma_arcsec", "sigma arcsec", 0),
    rounded("angle_difference_deg", "turned deg", 2),
    rounded("length_difference_deg", "too long deg", 3),
    rounded("angular_rate_deg_s", "deg/s", 3),
    rounded("passage_utc", "passage (UTC)", 1),
    rounded("range_km", "range km", 0),
    rounded("magnitude", "mag", 1),
    rounded("element_age_days", "age d", 1),
];

/// A candidate this probable is called likely.
const LIKELY: f64 = 0.5;

pub fn run(typed: IdentifyArguments) -> anyhow::Result<Outcome> {
    typed.shared.no_camera("what a streak is of")?;
    if typed.top == 0 {
        return Err(anyhow!("top 0; allowed: 1 or more"));
    }
    let setup = typed.shared.setup(Setup::default())?;
    let asked: StreakAsked = typed.said().asked(&setup)?;
    let output = typed.output.open(&setup)?;
    let notices = begin(&setup)?;
    let streak = &asked.streak;
    let options = IdentifyOptions {
        include_dark: typed.include_dark || setup.include_dark.unwrap_or(false),
        photometry: setup.photometry()?,
    };
    let mut prepared = setup.prepare(streak.start(), seconds_after(streak.start(), streak.duration_s()))?;
    notices.warn(&prepared.warnings);
    above_the_horizon("streak", &asked.exposure(), &prepared)?;
    let found = identify_streak(&prepared.sky, streak, &options)?;
    notices.warn(&prepared.left_out_warning(&found.left_out, streak.start())?);

    let scale = setup.said_time_scale().unwrap_or("utc").to_ascii_lowercase();
    state_scales(&mut prepared.provenance, &scale, &options.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "streak": asked.from,
            "include_dark": options.include_dark,
            "top": typed.top,
            "candidates": found.candidates.len(),
            "unknown_probability": (found.unknown_probability * 1e6).round() / 1e6,
        }),
    );
    let rows = found.candidates.iter().take(typed.top).map(|candidate| CandidateRow {
        candidate,
        elements: &prepared.sky.elements()[candidate.element_index],
        photometry: &options.photometry,
    });
    let candidates = candidate_table(rows);
    output.write(&Answer {
        sections: vec![
            Section { name: "streak", table: &streak_table(streak) },
            Section { name: "candidates", table: &candidates },
            Section { name: "left_out", table: &left_out_table(&found.left_out) },
        ],
        main: &candidates,
        provenance: &prepared.provenance,
        style: Style { columns: ON_SCREEN, bold_row: (!found.candidates.is_empty()).then_some(0) },
    })?;
    summary(&notices, &found, &prepared.sky);
    Ok(if found.candidates.is_empty() { Outcome::No } else { Outcome::Done })
}

impl IdentifyArguments {
    /// The streak as it was typed.
    fn said(&self) -> StreakSaid {
        let (streak, time) = (self.streak.clone(), self.time.clone());
        #[cfg_attr(not(feature = "fits"), expect(unused_mut))]
        let mut said = StreakSaid {
            end: streak.end,
            ra: streak.ra,
            dec: streak.dec,
            position_angle: streak.position_angle,
            length: streak.length,
            region: streak.region,
            place_sigma: streak.place_sigma,
            angle_sigma: streak.angle_sigma,
            times: time.times,
            start: time.start,
            exposure: time.exposure,
            whole_streak: time.whole_streak,
            time_sigma: time.time_sigma,
            ..StreakSaid::default()
        };
        #[cfg(feature = "fits")]
        {
            said.image = streak.image;
            said.from_pix = streak.from_pix;
            said.to_pix = streak.to_pix;
            said.hdu = streak.hdu;
        }
        said
    }
}

fn summary(notices: &Notices, found: &Identified, sky: &streakcast::passes::Sky) {
    let Some(best) = found.candidates.first() else {
        notices.say("no candidate: nothing in these elements comes near the streak at that time");
        return;
    };
    let elements = &sky.elements()[best.element_index];
    let name = if elements.name.is_empty() { best.norad_id.to_string() } else { elements.name.to_string() };
    let count = found.candidates.len();
    let near = if count == 1 { "1 candidate".to_owned() } else { format!("{count} candidates") };
    if best.probability >= LIKELY {
        notices.say(&format!("{near}: {name} with probability {:.3}", best.probability));
    } else {
        notices.say(&format!(
            "{near}, none likely: {name} with probability {:.3}, a satellite without elements here with {:.3}",
            best.probability, found.unknown_probability
        ));
    }
}
