//! Which plot.

use super::arguments::{PlotArguments, PlotVerb};
use crate::failure::Outcome;

use super::residuals::Chart;

pub fn run(typed: PlotArguments) -> anyhow::Result<Outcome> {
    match typed.verb {
        Some(PlotVerb::Night(typed)) => super::night::run(*typed),
        Some(PlotVerb::Field(typed)) => super::field::run(*typed),
        Some(PlotVerb::LightCurve(typed)) => super::light_curve::run(*typed),
        Some(PlotVerb::SkyChart(typed)) => super::sky_chart::run(*typed),
        Some(PlotVerb::SkyRate(typed)) => super::sky_rate::run(*typed),
        Some(PlotVerb::SunAltitude(typed)) => super::sun_altitude::run(*typed),
        Some(PlotVerb::Sky(typed)) => super::maps::sky(*typed),
        Some(PlotVerb::Body(typed)) => super::maps::body(*typed),
        #[cfg(feature = "fit")]
        Some(PlotVerb::Corner(typed)) => super::corner::corner_plot(*typed),
        Some(PlotVerb::Residuals(typed)) => super::residuals::residual_plot(*typed, Chart::Panels),
        Some(PlotVerb::Histogram(typed)) => super::residuals::residual_plot(*typed, Chart::Histogram),
        Some(PlotVerb::PhaseCurve(typed)) => super::residuals::residual_plot(*typed, Chart::PhaseCurve),
        None => super::list::list(),
    }
}
