//! `plot residuals`, `plot histogram` and `plot phase-curve`: compare measured with computed magnitudes.

use anyhow::anyhow;
use streakcast::config::{Config, RunConfig};
use streakcast::geometry::ViewingGeometry;
use streakcast::maps::BodyView;
use streakcast::output::{Column, Provenance, Table, Value, counted};
use streakcast::plot::{
    PhaseCurve, Picture, ResidualHistogram, ResidualPanels, phase_curve, residual_histogram, residual_panels,
};

use super::arguments::PlotResidualsArguments;
use crate::failure::Outcome;
use crate::start::begin;
use crate::verbs::map::model_of;

use super::columns::Columns;
use super::target::Target;

/// Kind of plot.
#[derive(Copy, Clone)]
pub enum Chart {
    Panels,
    Histogram,
    PhaseCurve,
}

const COLUMNS: [Column; 7] = [
    Column::real("observed_mag", "mag", 4, "Measured magnitude at 1000 km."),
    Column::real("computed_mag", "mag", 4, "Magnitude of the model in the same geometry."),
    Column::real("residual_mag", "mag", 4, "Observed minus computed magnitude."),
    Column::real("sun_latitude_deg", "deg", 5, "Latitude of the Sun above the plane of the chassis."),
    Column::real(
        "observer_longitude_deg",
        "deg",
        5,
        "Longitude of the observer in the satellite's frame, from the azimuth of the Sun.",
    ),
    Column::real("observer_latitude_deg", "deg", 5, "Latitude of the observer above the plane of the chassis."),
    Column::real("phase_angle_deg", "deg", 5, "Phase angle, between Sun and observer at the satellite."),
];

/// Measured and computed magnitudes with their geometry, angles in radians.
#[derive(Default)]
struct Residuals {
    observed: Vec<f64>,
    computed: Vec<f64>,
    residual: Vec<f64>,
    sun: Vec<f64>,
    longitude: Vec<f64>,
    latitude: Vec<f64>,
    phase: Vec<f64>,
    dark: usize,
}

pub fn residual_plot(typed: PlotResidualsArguments, chart: Chart) -> anyhow::Result<Outcome> {
    let run = RunConfig { file: typed.config.clone(), ..RunConfig::default() };
    let config = Config { light: typed.magnitudes.clone(), run, ..Config::default() }.with_file()?;
    let notices = begin(&config)?;
    let target = Target::new(&typed.picture)?;
    let found = residuals(&typed, &config)?;
    if found.dark > 0 {
        let points = counted(found.dark, "point", "points");
        notices.info(&format!("warning: {points} omitted, without sunlit surfaces in the model"));
    }
    let of = match chart {
        Chart::Panels | Chart::Histogram => "observed minus computed",
        Chart::PhaseCurve => "observed and computed",
    };
    let default_title = format!("{}: {of}", typed.model);
    let title = typed.title.title.as_deref().unwrap_or(&default_title);
    let picture = found.picture(chart, title)?;
    let mut provenance = Provenance::new();
    provenance.state("measurements", typed.from.display().to_string());
    provenance.state("model", typed.model.as_str());
    let photometry = config.photometry()?;
    provenance.state("band", photometry.band.name());
    provenance.state("mag_system", photometry.system.to_string());
    if model_of(&config.model_library()?, &typed.model)?.is_of_panels() {
        provenance.state("earthshine", photometry.earthshine.name());
    }
    target.write(&picture, "residuals", &found.table(), &provenance, &notices)?;
    Ok(Outcome::Done)
}

/// Reads single points, or pixels that were kept, and computes their magnitudes.
fn residuals(typed: &PlotResidualsArguments, config: &Config) -> anyhow::Result<Residuals> {
    let model = model_of(&config.model_library()?, &typed.model)?;
    let photometry = config.photometry()?;
    let pixels = Columns::read(&typed.from, "pixels");
    let columns = if pixels.is_ok() { pixels? } else { Columns::read(&typed.from, "measurements")? };
    let observed = columns.numbers(if columns.has("mode_mag") { "mode_mag" } else { "standard_magnitude" })?;
    let kept = if columns.has("kept") { columns.numbers("kept")? } else { vec![1.0; observed.len()] };
    let radians =
        |name| Ok::<_, anyhow::Error>(columns.numbers(name)?.into_iter().map(f64::to_radians).collect::<Vec<_>>());
    let (sun, longitude, latitude) =
        (radians("sun_latitude_deg")?, radians("observer_longitude_deg")?, radians("observer_latitude_deg")?);
    let height = columns.numbers("height_km")?;
    let mut found = Residuals::default();
    for k in (0..observed.len()).filter(|&k| kept[k] > 0.0 && observed[k].is_finite()) {
        // Measured magnitudes are standard magnitudes at 1000 km.
        let geometry = ViewingGeometry::from_angles(sun[k], longitude[k], latitude[k], 1000.0, height[k]);
        let geometry =
            geometry.ok_or_else(|| anyhow!("table {}: row {} has an invalid geometry", typed.from.display(), k + 1))?;
        let view = BodyView::new(&model, sun[k], height[k], photometry)?;
        let Some(computed) = view.at(longitude[k], latitude[k]) else {
            found.dark += 1;
            continue;
        };
        found.observed.push(observed[k]);
        found.computed.push(computed.0);
        found.residual.push(observed[k] - computed.0);
        found.sun.push(sun[k]);
        found.longitude.push(longitude[k]);
        found.latitude.push(latitude[k]);
        found.phase.push(geometry.phase_angle_rad());
    }
    Ok(found)
}

impl Residuals {
    fn picture(&self, chart: Chart, title: &str) -> anyhow::Result<Picture> {
        Ok(match chart {
            Chart::Panels => residual_panels(&ResidualPanels {
                title,
                residuals_mag: &self.residual,
                sun_latitude_rad: &self.sun,
                observer_longitude_rad: &self.longitude,
                observer_latitude_rad: &self.latitude,
                phase_angle_rad: &self.phase,
            })?,
            Chart::Histogram => {
                // The standard deviation of the normal curve in the plot is the RMS of the residuals.
                let squares: f64 = self.residual.iter().map(|residual| residual * residual).sum();
                let sigma_mag = (squares / self.residual.len().max(1) as f64).sqrt().max(1e-3);
                residual_histogram(&ResidualHistogram { title, residuals_mag: &self.residual, sigma_mag })?
            }
            Chart::PhaseCurve => phase_curve(&PhaseCurve {
                title,
                magnitude_name: "magnitude at 1000 km",
                phase_angle_rad: &self.phase,
                measured_mag: &self.observed,
                model_mag: &self.computed,
            })?,
        })
    }

    fn table(&self) -> Table {
        let row = |k: usize| -> Vec<Value> {
            let angles = [self.sun[k], self.longitude[k], self.latitude[k], self.phase[k]].map(f64::to_degrees);
            let magnitudes = [self.observed[k], self.computed[k], self.residual[k]];
            magnitudes.into_iter().chain(angles).map(Into::into).collect()
        };
        Table { columns: COLUMNS.to_vec(), rows: (0..self.residual.len()).map(row).collect() }
    }
}
