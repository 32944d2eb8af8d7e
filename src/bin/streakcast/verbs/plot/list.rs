//! `plot --list`: every plot, what it shows and what it needs.

use streakcast::output::{Column, Kind, Provenance, Section, Table};

use crate::failure::Outcome;
use crate::output::{Answer, Output};
use crate::screen::{Style, shown};

const PLOTS: &[[&str; 3]] = &[
    [
        "night",
        "timeline of a night",
        "--schedule and satellites, site, field; or --from its data, or flags with --schedule",
    ],
    [
        "field",
        "a field with its streaks",
        "--ra --dec --start --exposure and satellites, site, field; or --from a table of passes",
    ],
    [
        "light-curve",
        "magnitude along a track",
        "--ra --dec --start --exposure and satellites, site, field; or --from its data, or what forecast wrote",
    ],
    [
        "sky-chart",
        "passes over the sky of a site",
        "--from what forecast wrote by --light-curves, or as JSON with --samples",
    ],
    ["sky-rate", "expected streaks over the sky", "--start --exposure and satellites, site, field; or --from its data"],
    [
        "sun-altitude",
        "trails against the Sun's altitude",
        "--schedule, or --start --exposure, and satellites, site, field; or --from its data",
    ],
    ["sky", "magnitudes over a site's sky", "--model --sun-altitude-deg"],
    ["body", "magnitudes over a satellite's own sky", "--model --sun-latitude-deg"],
    ["corner", "posterior of a fit", "--chains of fit run --mcmc"],
    ["residuals", "O-C against the geometry", "--from a table of fit reduce, and --model"],
    ["histogram", "O-C as a histogram", "--from a table of fit reduce, and --model"],
    ["phase-curve", "magnitudes against the phase angle", "--from a table of fit reduce, and --model"],
];

pub fn list() -> anyhow::Result<Outcome> {
    let table = Table {
        columns: vec![
            Column::new("plot", Kind::Text, "Name after streakcast plot."),
            Column::new("shows", Kind::Text, "What is to be seen."),
            Column::new("needs", Kind::Text, "What must be said, beside -o."),
        ],
        rows: PLOTS.iter().map(|row| row.iter().map(|words| (*words).into()).collect()).collect(),
    };
    Output::new(None, None)?.write(&Answer {
        sections: vec![Section { name: "plots", table: &table }],
        main: &table,
        provenance: &Provenance::new(),
        style: Style {
            columns: &[shown("plot", "plot"), shown("shows", "shows"), shown("needs", "needs")],
            bold_row: None,
        },
    })?;
    Ok(Outcome::Done)
}
