//! `reproduce lu2024`: tables, figures and tests of Lu (2024) on simulated or measured photometry, with a report.

use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::Args;
use hifitime::Epoch;
use streakcast::config::Config;
use streakcast::constants::EARTH_EQUATORIAL_RADIUS_KM;
use streakcast::elements::{Constellation, ElementSet, History};
use streakcast::fit::inference::check_walkers;
use streakcast::fit::measurements::{Measurements, Placement, RecordReader, ReduceOptions, Selection, measure};
use streakcast::fit::{
    COEFFICIENTS, Chain, FitSettings, LU2024_PARTS, Lu2024, Lu2024Data, Lu2024Row, Lu2024Truth, ModelDescription,
    Posterior, PosteriorSettings, Problem, Report, SimulationOptions, TwoPanelForm, draw, lu2024, lu2024_rows,
    lu2024_table, marginal_table, model_file, points_of_pixels, posterior, recovered_table, rms, simulate,
};
use streakcast::frames::seconds_after;
use streakcast::geometry::Site;
use streakcast::maps::{Earth, FigurePanel, Grid, PAPER_FIGURES, PaperFigure, SkyView};
use streakcast::output::{Provenance, counted};
use streakcast::photometry::{BrightnessModel, Coefficients, Earthshine, ModelFile, ModelLibrary, PhotometryOptions};
use streakcast::plot::{
    Corner, Picture, ResidualHistogram, blocking_picture, corner, paper_picture, residual_histogram,
};

use super::table_one;
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::{Output, VerbResult, check, write_bytes};
use crate::screen::{Shown, rounded, shown};
use crate::verbs::fit::arguments::{PhotometryArguments, TableArguments};
use crate::verbs::fit::{photometry, report as fit_report, run::this_month};

/// Model whose sizes and coefficients the simulated satellites have.
const BASE: &str = "starlink-v1.5";
/// Site of the photometry.
const SITE: &str = "MMT-9";
/// Days over which the simulated nights are distributed.
const SPAN_DAYS: u32 = 360;
/// Number of burn-in steps of the posterior in the paper.
const BURN_IN: usize = 200;
const WALKERS: usize = 32;
/// Layers of figure 4, by their lower ends, degrees: the layer of one degree below each printed latitude of the Sun.
const RESIDUAL_LAYERS_DEG: [i64; 3] = [-9, -15, -21];
/// Directions of Sun and observer in figure 1, degrees: Sun's latitude, observer's longitude and latitude.
const SKETCH_DEG: [f64; 3] = [-15.0, 30.0, -40.0];
/// Lowest altitude for the last lit satellite, degrees.
const LOW_DEG: f64 = 30.0;

/// Flags of `lu2024`.
#[derive(Args)]
pub struct Lu2024Arguments {
    /// MMT-9 tables for lu2024 instead of simulated photometry
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = "Lu2024")]
    pub photometry: Vec<PathBuf>,
    /// Element sets: for lu2024 geometry of --photometry and counts of table 1; for borlaff2026 the catalogue
    #[arg(long, value_name = "FILE", num_args = 1.., help_heading = "Lu2024")]
    pub elements: Vec<PathBuf>,
    /// Satellites of the tracks of --photometry: CSV with columns track and norad
    #[arg(long, value_name = "FILE", requires_all = ["photometry", "elements"], help_heading = "Lu2024")]
    pub identified: Option<PathBuf>,
    /// Height of the orbits of --photometry without --elements, km
    #[arg(long, value_name = "KM", requires = "photometry", conflicts_with = "elements", help_heading = "Lu2024")]
    pub height_km: Option<f64>,
    /// Satellite catalogue (CSV of CelesTrak's SATCAT) for the counts of table 1
    #[arg(long, value_name = "FILE", help_heading = "Lu2024")]
    pub satcat: Option<PathBuf>,
    /// Smallest number of points in a pixel of lu2024; 80 (as in the paper) if omitted
    #[arg(long, value_name = "N", help_heading = "Lu2024")]
    pub min_count: Option<u32>,
    /// Simulated nights of lu2024, 1 to 360; 48 if omitted
    #[arg(long, value_name = "N", conflicts_with = "photometry", help_heading = "Lu2024")]
    pub nights: Option<u32>,
    /// Steps of the posterior of lu2024, of which 200 are burn-in; 5000 (as in the paper) if omitted
    #[arg(long, value_name = "N", help_heading = "Lu2024")]
    pub steps: Option<usize>,
    /// Seed of the simulation and of the posterior of lu2024, and of the pointings of borlaff2026; 1 if omitted
    #[arg(long, value_name = "N", help_heading = "Lu2024")]
    pub seed: Option<u64>,
}

impl Lu2024Arguments {
    /// Returns the flags that are given.
    pub fn given(&self) -> impl Iterator<Item = &'static str> {
        [
            ("--photometry", !self.photometry.is_empty()),
            ("--elements", !self.elements.is_empty()),
            ("--satcat", self.satcat.is_some()),
            ("--min-count", self.min_count.is_some()),
            ("--nights", self.nights.is_some()),
            ("--steps", self.steps.is_some()),
            ("--seed", self.seed.is_some()),
        ]
        .into_iter()
        .filter_map(|(flag, is_given)| is_given.then_some(flag))
    }
}

const ON_SCREEN: &[Shown] = &[
    shown("section", "section"),
    shown("quantity", "quantity"),
    shown("unit", "unit"),
    rounded("paper", "paper", 4),
    rounded("ours", "ours", 4),
    rounded("ours_sigma", "+-", 4),
];

/// Photometry with its origin.
struct Source {
    measurements: Measurements,
    truth: Option<Lu2024Truth>,
    /// Description for the report.
    text: String,
}

/// Results, from which report and pictures are made.
struct Results<'a> {
    source: &'a Source,
    found: &'a Lu2024,
    chain: &'a Chain,
    posterior: &'a Posterior,
    model: &'a BrightnessModel,
    form: &'a TwoPanelForm,
}

/// Picture with the stem of its file name and its caption.
type Drawn = (String, String, Vec<u8>);

/// Computes everything, and then writes table, model, pictures and report to a folder.
pub fn run(
    typed: &Lu2024Arguments,
    folder: &Path,
    format: Option<&str>,
    config: &Config,
    notices: &Notices,
) -> anyhow::Result<Outcome> {
    let steps = typed.steps.unwrap_or(PosteriorSettings::default().steps);
    if steps <= BURN_IN {
        bail!("steps is {steps}; allowed: more than the {BURN_IN} steps of burn-in");
    }
    let output = Output::new(format, None)?;
    let mut rows = table_one::rows(typed.satcat.as_deref(), &typed.elements)?;
    ["report.md", "table.csv", "model.json"].iter().try_for_each(|name| check(&folder.join(name)))?;
    let base = base()?;
    let form = form(&base)?;
    let source = source(typed, config, &base, notices)?;
    notices.info(&source.text);
    let options = ReduceOptions { least_count: typed.min_count.unwrap_or(80), ..ReduceOptions::default() };
    let bar = notices.tasks(LU2024_PARTS, "fits");
    let found = lu2024(&form, &source.measurements, options, &|| bar.inc(1))?;
    bar.finish_and_clear();
    let points = points_of_pixels(&found.pixels);
    let problem = Problem::new(&form, &points, &FitSettings::free(&COEFFICIENTS))?;
    check_walkers(WALKERS, COEFFICIENTS.len())?;
    let settings = PosteriorSettings { steps, burn_in: BURN_IN, walkers: WALKERS, seed: typed.seed.unwrap_or(1) };
    let bar = notices.steps(steps);
    let chain = draw(&problem.objective(), &found.fit, &settings, None, |chain| {
        bar.set_position(chain.steps() as u64);
        Ok(())
    })?;
    bar.finish_and_clear();
    let posterior = posterior(&chain, &found.fit, BURN_IN);
    let file = fitted_file(&base, &found, &source, &problem)?;
    let model = BrightnessModel::from_file(file.clone(), "lu2024")?;
    let data = if source.truth.is_some() { Lu2024Data::Simulated } else { Lu2024Data::Measured };
    rows.extend(lu2024_rows(&found, Some(&posterior), data));
    let results =
        Results { source: &source, found: &found, chain: &chain, posterior: &posterior, model: &model, form: &form };
    for figure in &PAPER_FIGURES {
        rows.extend(sky_rows(figure, &model)?);
    }
    let pictures = pictures(&results, notices)?;
    let table = lu2024_table(&rows);
    let mut provenance = Provenance::new();
    provenance.state("paper", "Lu 2024, Universe 10, 215 (arXiv 2403.05831)");
    provenance.state("photometry", source.text.as_str());
    provenance.state("min_count", i64::from(options.least_count));
    provenance.state("posterior_steps", steps as i64);
    provenance.state("seed", settings.seed as i64);
    let parameters = recovered_table(&found, source.truth.as_ref());
    let result = VerbResult::new("reproduced", &table, ON_SCREEN, &provenance).with("parameters", &parameters);
    for (stem, _, bytes) in &pictures {
        write_bytes(&folder.join(format!("{stem}.png")), bytes, notices)?;
    }
    write_bytes(&folder.join("model.json"), (file.to_json() + "\n").as_bytes(), notices)?;
    Output::new(Some("csv"), Some(folder.join("table.csv")))?.write(&result, notices)?;
    write_bytes(&folder.join("report.md"), report(&results, &rows, &pictures).to_markdown().as_bytes(), notices)?;
    output.write(&result, notices)?;
    Ok(Outcome::Done)
}

fn base() -> anyhow::Result<ModelFile> {
    let model = ModelLibrary::embedded().get(BASE).and_then(|model| model.file().cloned());
    model.ok_or_else(|| anyhow!("missing model {BASE}; allowed: a library that holds it"))
}

/// Returns the form of the final model: panel offset 0, with earthshine; the fits begin without reflected light.
fn form(base: &ModelFile) -> anyhow::Result<TwoPanelForm> {
    let (band, system) = BrightnessModel::from_file(base.clone(), BASE)?.band();
    let shape = base.shape.ok_or_else(|| anyhow!("model {BASE} has no two panels"))?;
    let coefficients = Coefficients { c1: 0.0, c2: 0.0, c3: 0.0, c4: 0.0, c5: 0.0, n_sail: 1.0, n_base: 1.0 };
    let sun_magnitude = band.sun_magnitude(system);
    Ok(TwoPanelForm { shape, coefficients, earthshine: Earthshine::Computed, blocking: true, sun_magnitude })
}

fn source(typed: &Lu2024Arguments, config: &Config, base: &ModelFile, notices: &Notices) -> anyhow::Result<Source> {
    if typed.photometry.is_empty() { simulated(typed, base, notices) } else { measured(typed, config) }
}

/// Simulates a campaign of MMT-9 with the 550 km shell of Starlink: tracks of 11 to 109 s with ten points per second,
/// as in public data.
fn simulated(typed: &Lu2024Arguments, base: &ModelFile, notices: &Notices) -> anyhow::Result<Source> {
    let nights = typed.nights.unwrap_or(48);
    if !(1..=SPAN_DAYS).contains(&nights) {
        bail!("nights is {nights}; allowed: 1 to {SPAN_DAYS}");
    }
    let truth = Lu2024Truth::new(base)?;
    let first = Epoch::from_gregorian_utc(2023, 1, 10, 20, 0, 0, 0);
    let middle = seconds_after(first, f64::from(SPAN_DAYS / 2) * streakcast::constants::DAY_S);
    let at_550 = |set: &ElementSet| (set.inclination_deg - 53.0).abs() < 0.1;
    let sets = Constellation::by_name("starlink-gen1")?.element_sets(middle);
    let history = History::new(sets.into_iter().filter(at_550).collect());
    let options = SimulationOptions {
        seed: typed.seed.unwrap_or(1),
        night_step_days: SPAN_DAYS / nights,
        tracks_per_night: 80,
        cadence_s: 0.1,
        track_s: [11.0, 109.0],
        point_scatter_mag: 0.1,
        track_scatter_mag: 0.15,
        ..SimulationOptions::mmt9(first, nights)
    };
    let site = Site::by_name(SITE)?;
    let bar = notices.tasks(nights as usize, "nights");
    let simulation = simulate(&|geometry| truth.magnitude(geometry), &site, &history, &options, &|| bar.inc(1))?;
    bar.finish_and_clear();
    // The element sets are those of the middle of the campaign.
    let placement = Placement { max_element_age_days: f64::from(SPAN_DAYS), ..Placement::elements(&history) };
    let measurements = measure(&mut simulation.records.source(), &placement, &Selection::default())?;
    let text = format!(
        "simulated photometry of {SITE}: {} in {} of {nights} nights, seed {}",
        counted(measurements.points.len(), "measurement", "measurements"),
        counted(measurements.groups.len(), "track", "tracks"),
        options.seed
    );
    Ok(Source { measurements, truth: Some(truth), text })
}

/// Reads MMT-9 tables with the selection of the paper.
fn measured(typed: &Lu2024Arguments, config: &Config) -> anyhow::Result<Source> {
    let arguments = PhotometryArguments {
        tables: TableArguments {
            photometry: typed.photometry.clone(),
            format_name: Some("mmt".to_owned()),
            columns: None,
            filter: Vec::new(),
            keep_duplicates: false,
            site: config.site.clone(),
            threads: None,
            quiet: false,
        },
        elements: typed.elements.clone(),
        identified: typed.identified.clone(),
        fit_offset_s: None,
        elements_radius: false,
        max_element_age_days: 14.0,
        height_km: typed.height_km,
        on_station: !typed.elements.is_empty(),
        station_height_km: 530.0,
        station_rate_m_day: 100.0,
        least_grazing_km: 100.0,
        least_altitude_deg: 0.0,
        max_range_difference_km: 100.0,
        max_phase_difference_deg: None,
        keep_penumbra_flag: false,
        sun_distance: false,
    };
    let history = photometry::history(&arguments)?;
    let placement = photometry::placement(&arguments, history.as_ref())?;
    let options = photometry::read_options(&arguments.tables, config)?;
    let mut reader = RecordReader::open(&typed.photometry, &options)?;
    let measurements = measure(&mut reader, &placement, &photometry::selection(&arguments))?;
    if measurements.points.is_empty() {
        let reasons: Vec<String> =
            measurements.dropped.iter().map(|(reason, count, _)| format!("{count} {}", reason.name())).collect();
        bail!("no measurement remains; rows left out: {}", reasons.join(", "));
    }
    let text = format!(
        "photometry {}: {} in {}, {} rows left out",
        photometry::names(&typed.photometry),
        counted(measurements.points.len(), "measurement", "measurements"),
        counted(measurements.groups.len(), "track", "tracks"),
        measurements.dropped.total()
    );
    Ok(Source { measurements, truth: None, text })
}

/// Returns the model file of the final fit.
fn fitted_file(base: &ModelFile, found: &Lu2024, source: &Source, problem: &Problem) -> anyhow::Result<ModelFile> {
    let description = ModelDescription {
        name: "lu2024".to_owned(),
        title: "Form of Lu (2024) fitted by reproduce lu2024".to_owned(),
        source: format!("streakcast {} reproduce lu2024", env!("CARGO_PKG_VERSION")),
        data: source.text.clone(),
        date: this_month(),
        provisional: source.truth.is_some(),
        notes: Vec::new(),
        sigma_origin: "holds 68.3 % of the single measurements, in sample".to_owned(),
    };
    let rms_mag = rms(&found.fit.residuals_mag);
    let singles: Vec<(f64, f64)> = found.single_mag.iter().map(|residual| (*residual, 1.0)).collect();
    Ok(model_file(base, &found.fit, problem.points(), rms_mag, &singles, &description)?)
}

/// Returns rows of a figure of the sky: the range of magnitudes over its panels, and the Sun's altitude at which the
/// last lit satellite is in the sky. Empty for figure 6.
fn sky_rows(figure: &PaperFigure, model: &BrightnessModel) -> anyhow::Result<Vec<Lu2024Row>> {
    let (Some(stated), Some(last_deg)) = (figure.stated_range_mag, figure.stated_last_sun_deg) else {
        return Ok(Vec::new());
    };
    let section = ["figure 7", "figure 8", "figure 9"][usize::from(figure.number - 7).min(2)];
    let mut lit = Vec::new();
    let mut height_km = 0.0;
    for panel in figure.panels {
        let FigurePanel::Sky { sun_altitude_deg, height_km: height } = panel else { continue };
        height_km = height;
        let sun_rad = sun_altitude_deg.to_radians();
        let view = SkyView::new(model, Earth::Sphere, height, 0.0, sun_rad, PhotometryOptions::default())?;
        let points = view.map(Grid::regular(2.0)?)?.points;
        lit.extend(points.iter().filter_map(|point| Some((point.magnitude?.0, point.altitude_rad.cos()))));
    }
    lit.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = lit.iter().map(|(_, area)| area).sum();
    let at = |share: f64| {
        let mut sum = 0.0;
        let found = lit.iter().find(|(_, area)| {
            sum += area;
            sum >= share * total
        });
        found.map(|(magnitude, _)| *magnitude)
    };
    let row = |quantity: String, unit, paper, ours, reason: &str| Lu2024Row {
        section,
        quantity,
        unit,
        paper: Some(paper),
        ours,
        ours_sigma: None,
        reason: reason.to_owned(),
    };
    let ends = "other coefficients than those of the paper, whose captions give the ends of colour bars";
    let last = "the caption states no lowest altitude of satellites";
    Ok(vec![
        row("5 % of the lit sky are brighter than".to_owned(), "mag", stated[0], at(0.05), ends),
        row("5 % of the lit sky are fainter than".to_owned(), "mag", stated[1], at(0.95), ends),
        row(
            format!("Sun's altitude with the last lit satellite above {} deg", LOW_DEG),
            "deg",
            last_deg,
            Some(last_sun_deg(height_km, LOW_DEG)),
            last,
        ),
    ])
}

/// Returns the Sun's altitude, degrees, below which no satellite at `height_km` is lit above `least_altitude_deg`.
fn last_sun_deg(height_km: f64, least_altitude_deg: f64) -> f64 {
    let ratio = EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + height_km);
    let altitude = least_altitude_deg.to_radians();
    // Angle at the Earth's centre from the observer to the satellite: ψ = acos(R cos e / (R + h)) - e. At the edge of
    // the shadow the Sun is acos(R / (R + h)) below the satellite's horizontal plane, and ψ more below the observer's.
    let away = (ratio * altitude.cos()).acos() - altitude;
    -(ratio.acos() + away).to_degrees()
}

/// Draws all figures.
fn pictures(results: &Results, notices: &Notices) -> anyhow::Result<Vec<Drawn>> {
    let Results { found, form, .. } = results;
    let bar = notices.tasks(10, "figures");
    let mut drawn: Vec<Drawn> = Vec::new();
    let mut add = |name: &str, caption: &str, picture: Picture| -> anyhow::Result<()> {
        drawn.push((name.to_owned(), caption.to_owned(), picture.to_png()?));
        bar.inc(1);
        Ok(())
    };
    let [sun, longitude, latitude] = SKETCH_DEG.map(f64::to_radians);
    add(
        "figure-1",
        "Figure 1: blocking of the solar array by the chassis",
        blocking_picture(&form.shape, sun, [longitude, latitude])?,
    )?;
    if let Some(slice) = &found.slice {
        add("figure-2", "Figure 2: pixels with the Sun at -19 to -18 deg", fit_report::slice(slice, -18.5)?)?;
    }
    add("figure-3", "Figure 3: number of points and spread of the pixels", fit_report::of_counts(&found.pixels)?)?;
    let points = points_of_pixels(&found.pixels);
    let kept: Vec<_> = found.fit.kept.iter().map(|&index| points[index]).collect();
    let residuals = &found.fit.residuals_mag;
    let nside = found.pixels.options.nside;
    let maps =
        fit_report::residual_maps("Observed minus computed", &kept, residuals, nside, Some(&RESIDUAL_LAYERS_DEG))?;
    if let Some(picture) = maps {
        add("figure-4", "Figure 4: residuals at three latitudes of the Sun", picture)?;
    }
    let sigma_mag = rms(residuals).max(1e-3);
    let histogram = ResidualHistogram { title: "Residuals of the final model", residuals_mag: residuals, sigma_mag };
    add("figure-5", "Figure 5: residuals of all pixels", residual_histogram(&histogram)?)?;
    for figure in &PAPER_FIGURES {
        let caption = match figure.number {
            6 => "Figure 6: magnitudes at 1000 km below the satellite".to_owned(),
            number => format!("Figure {number}: magnitudes over the sky of a site"),
        };
        let picture = paper_picture(figure, results.model, PhotometryOptions::default())?;
        add(&format!("figure-{}", figure.number), &caption, picture)?;
    }
    let names: Vec<String> = results.posterior.marginals.iter().map(|marginal| marginal.name.clone()).collect();
    let samples: Vec<Vec<f64>> = (0..names.len()).map(|k| results.chain.column(k, BURN_IN)).collect();
    let bounds: Vec<[f64; 2]> = found.fit.parameters[..names.len()].iter().map(|p| [p.least, p.greatest]).collect();
    let input = Corner {
        title: "Posterior of the final model",
        names: &names,
        samples: &samples,
        truths: None,
        bounds: Some(&bounds),
    };
    add("posterior", "Posterior of the final model", corner(&input)?)?;
    bar.finish_and_clear();
    Ok(drawn)
}

/// Differences that concern all numbers.
const DIFFERENCES: [&str; 6] = [
    "The paper fits four million public measurements of Starlink V1.5 by MMT-9 (mmt.favor2.info), which are not part of \
     this program. `--photometry FILE... --elements FILE...` runs the same computation on such tables.",
    "The paper prints no coefficients and no numbers of its posterior, so that these can only be compared with the \
     simulated satellite.",
    "Eq. 17 of the paper prints the Sun's latitude where the projection of the chassis has the observer's (figure 1). \
     This program uses the observer's; the printed form is wrong by up to 0.74 in the blocked fraction of the solar array.",
    "Section 4.3 of the paper states that earthshine is not included in the final model, section 4.4 that it is. Here it \
     is included.",
    "Errors are those of a jackknife over 24 sets of tracks, because the pixels of a track share its errors. The \
     posterior assumes independent pixels, as in the paper, and is too narrow.",
    "Figures have the numbers of the labels in the manuscript, in which the posterior has no number. In the order of \
     print the posterior is figure 4, and later figures have the next higher number.",
];

fn report(results: &Results, rows: &[Lu2024Row], pictures: &[Drawn]) -> Report {
    let Results { source, found, posterior, .. } = results;
    let mut report = Report::new("Lu (2024) reproduced");
    report.paragraph(
        "Yao Lu, BRDF-Based Photometric Modeling of LEO Constellation Satellite from Massive Observations, Universe 10, \
         215 (2024), arXiv 2403.05831.",
    );
    let mut text = source.text.clone();
    if let Some(first) = text.get(..1).map(str::to_uppercase) {
        text.replace_range(..1, &first);
    }
    report.paragraph(&format!("{text}."));
    if source.truth.is_some() {
        report.paragraph(&format!(
            "The simulated satellites have the sizes of the paper, in each layer of the Sun's latitude the panel offset of \
             table 2 (outside of these layers their mean), the coefficients of {BASE}, and an assumed gloss of the solar \
             array. Magnitudes include earthshine, 0.1 mag of photometric noise, 0.1 mag of scatter between points and \
             0.15 mag between tracks; 5 % of tracks and points are in another attitude, and 3 % of the tracks are \
             misidentified."
        ));
    }
    report.section("Numbers of the paper and of this program");
    report.table(&lu2024_table(rows));
    report.section("Parameters");
    report.paragraph("Fits of all kept pixels with least squares, as in the paper.");
    report.table(&recovered_table(found, source.truth.as_ref()));
    report.section("Posterior");
    report.paragraph(&format!(
        "{} steps of {WALKERS} walkers after {BURN_IN} steps of burn-in, {:.0} % of the proposals accepted.",
        posterior.steps,
        100.0 * posterior.acceptance
    ));
    report.table(&marginal_table(posterior, &found.fit));
    report.section("Differences");
    report.list(DIFFERENCES.iter().map(|difference| (*difference).to_owned()));
    report.section("Figures");
    pictures.iter().for_each(|(stem, caption, _)| report.picture(caption, &format!("{stem}.png")));
    let is_missing = |name: &&str| pictures.iter().all(|(stem, ..)| stem != name);
    for name in ["figure-2", "figure-4"].iter().filter(|name| is_missing(name)) {
        report.paragraph(&format!("{name} is missing: no pixel lies in its layers of the Sun's latitude."));
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    /// When the last lit satellite is at the zenith, the Sun's depression is the dip of the horizon at the satellite's
    /// height; when it is on the horizon, twice that dip.
    #[test]
    fn verif_last_lit_satellite_at_the_zenith_and_on_the_horizon() {
        let dip_deg = (6378.137_f64 / 6928.137).acos().to_degrees();
        assert!((last_sun_deg(550.0, 90.0) + dip_deg).abs() < 1e-9);
        assert!((last_sun_deg(550.0, 0.0) + 2.0 * dip_deg).abs() < 1e-9);
    }
}
