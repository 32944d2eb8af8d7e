//! Runs the verb of each plot, prints the list of plots (`plot --list`), and draws the plots that `map` also draws.

use streakcast::output::{Column, Kind, Provenance, Table};

use super::arguments::{PictureArguments, PlotArguments, PlotBodyArguments, PlotSkyArguments, PlotVerb};
use super::residuals::Chart;
use super::target::{Target, data_path, only};
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::{Output, VerbResult};
use crate::screen::shown;
use crate::verbs::map::{MapBodyArguments, MapOutputArguments, MapSkyArguments};

pub fn run(typed: PlotArguments) -> anyhow::Result<Outcome> {
    match typed.verb {
        Some(PlotVerb::Night(typed)) => typed.run(super::night::run),
        Some(PlotVerb::Field(typed)) => typed.run(super::field::run),
        Some(PlotVerb::LightCurve(typed)) => typed.run(super::light_curve::run),
        Some(PlotVerb::SkyChart(typed)) => typed.run(super::sky_chart::run),
        Some(PlotVerb::SkyRate(typed)) => typed.run(super::sky_rate::run),
        Some(PlotVerb::SunAltitude(typed)) => typed.run(super::sun_altitude::run),
        Some(PlotVerb::Sky(typed)) => typed.run(sky),
        Some(PlotVerb::Body(typed)) => typed.run(body),
        Some(PlotVerb::Corner(typed)) => typed.run(super::corner::corner_plot),
        Some(PlotVerb::Residuals(typed)) => typed.run(|typed| super::residuals::residual_plot(typed, Chart::Panels)),
        Some(PlotVerb::Histogram(typed)) => typed.run(|typed| super::residuals::residual_plot(typed, Chart::Histogram)),
        Some(PlotVerb::PhaseCurve(typed)) => {
            typed.run(|typed| super::residuals::residual_plot(typed, Chart::PhaseCurve))
        }
        None => list(),
    }
}

const PLOTS: &[[&str; 3]] = &[
    [
        "night",
        "timeline of a night",
        "--schedule and satellites, site, field; or --from data of this plot, or --from output of flag with --schedule",
    ],
    [
        "field",
        "field with its streaks",
        "--ra --dec --start --exposure and satellites, site, field; or --from output of passes",
    ],
    [
        "light-curve",
        "magnitude along a track",
        "--ra --dec --start --exposure and satellites, site, field; or --from data of this plot or output of forecast",
    ],
    [
        "sky-chart",
        "passes over the sky of a site",
        "--from output of forecast with --light-curves, or as JSON with --samples",
    ],
    [
        "sky-rate",
        "expected streaks over the sky",
        "--start --exposure and satellites, site, field; or --from data of this plot",
    ],
    [
        "sun-altitude",
        "trails against the Sun's altitude",
        "--schedule, or --start --exposure, and satellites, site, field; or --from data of this plot",
    ],
    ["sky", "magnitudes over the sky of a site", "--model --sun-altitude-deg"],
    ["body", "magnitudes over the directions around a satellite", "--model --sun-latitude-deg"],
    ["corner", "posterior of a fit", "--chains of fit run --mcmc"],
    ["residuals", "O-C against the geometry", "--from output of fit reduce, and --model"],
    ["histogram", "O-C as a histogram", "--from output of fit reduce, and --model"],
    ["phase-curve", "magnitudes against the phase angle", "--from output of fit reduce, and --model"],
];

pub fn list() -> anyhow::Result<Outcome> {
    let table = Table {
        columns: vec![
            Column::new("plot", Kind::Text, "Name of the plot."),
            Column::new("shows", Kind::Text, "Content of the plot."),
            Column::new("needs", Kind::Text, "Required flags, in addition to -o."),
        ],
        rows: PLOTS.iter().map(|row| row.iter().map(|text| (*text).into()).collect()).collect(),
    };
    Output::new(None, None)?.write(
        &VerbResult::new(
            "plots",
            &table,
            &[shown("plot", "plot"), shown("shows", "shows"), shown("needs", "needs")],
            &Provenance::new(),
        ),
        &Notices::new(false),
    )?;
    Ok(Outcome::Done)
}

pub fn sky(typed: PlotSkyArguments) -> anyhow::Result<Outcome> {
    crate::verbs::map::sky(MapSkyArguments { view: typed.view, output: map_outputs(&typed.picture)? })
}

pub fn body(typed: PlotBodyArguments) -> anyhow::Result<Outcome> {
    crate::verbs::map::body(MapBodyArguments { view: typed.view, output: map_outputs(&typed.picture)? })
}

/// Returns the output flags of `map` for a picture and its data file.
fn map_outputs(typed: &PictureArguments) -> anyhow::Result<MapOutputArguments> {
    let picture = only(typed)?;
    Target::new(typed)?;
    let data = typed.data.clone().or_else(|| (!typed.no_data).then(|| data_path(&picture)));
    let file_options = typed.file_options()?;
    Ok(MapOutputArguments {
        step_deg: None,
        nside: None,
        format: None,
        output: data,
        picture: Some(picture),
        file_options,
    })
}
