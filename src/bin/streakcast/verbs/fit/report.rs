//! Report of a fit: data, parameters, problems and pictures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use streakcast::fit::{
    Chain, Fault, Fit, FormScore, Loss, Posterior, Problem, Report, ResidualStatistics, form_score_table,
    marginal_table, parameter_table, points_behind,
};
use streakcast::photometry::ModelFile;

use super::arguments::FitRunArguments;
use super::form::ChosenForm;
use super::points::FitInput;
use crate::output::write_bytes;

/// Results of a fit for the model file and the report.
pub struct FitResults<'a> {
    pub typed: &'a FitRunArguments,
    pub chosen: &'a ChosenForm,
    pub input: &'a FitInput,
    pub problem: &'a Problem,
    pub fit: &'a Fit,
    pub faults: &'a [Fault],
    pub standings: &'a [FormScore],
    /// Residuals of single measurements from the model, mag.
    pub singles: &'a [(f64, f64)],
    pub posterior: Option<(&'a Chain, &'a Posterior)>,
}

/// Picture of a report: suffix of its file name, caption, PNG bytes.
type Drawn = (&'static str, String, Vec<u8>);

/// Checks that the extension of a report is `.md`, `.html` or `.htm`.
pub fn check_name(path: &Path) -> anyhow::Result<()> {
    if is_html(path) || has_extension(path, &["md"]) {
        return Ok(());
    }
    Err(anyhow!("invalid report {}; allowed: a file with the extension .md or .html", path.display()))
}

fn is_html(path: &Path) -> bool {
    has_extension(path, &["html", "htm"])
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let end = path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase());
    end.is_some_and(|end| extensions.contains(&end.as_str()))
}

/// Note in the report if the fit has a robust loss.
const ROBUST: &str = "The fit is robust: it does not minimise the RMS, and outliers have low weights. The core is the scatter of the other \
points. Akaike's criterion below is computed from the loss (sum of losses + 2k), not from the RMS.";
/// Ratio of the errors of the fit to those of the posterior above which the report has a warning.
const LARGE_RATIO: f64 = 1.2;
/// Suffixes of the file names of all pictures of a report.
const PICTURES: [&str; 6] = ["histogram", "residuals", "phase", "maps", "pixels", "corner"];

/// Returns all files of a report: the report, and its separate pictures.
pub fn files(path: &Path) -> Vec<PathBuf> {
    let pictures = PICTURES.iter().filter(|_| !is_html(path));
    std::iter::once(path.to_owned()).chain(pictures.map(|end| path.with_file_name(picture_name(path, end)))).collect()
}

fn picture_name(report: &Path, end: &str) -> String {
    let stem = report.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    format!("{stem}-{end}.png")
}

/// Writes the report: Markdown with separate pictures, or HTML with embedded ones.
pub fn write(path: &Path, results: &FitResults, file: &ModelFile) -> anyhow::Result<()> {
    let drawn = pictures(results, file)?;
    let names: BTreeMap<String, &Drawn> =
        drawn.iter().map(|picture| (picture_name(path, picture.0), picture)).collect();
    let report = text(results, file, &names);
    let notices = &results.input.notices;
    if is_html(path) {
        let page = report.to_html(|name| names.get(name).map(|picture| data_url(&picture.2)));
        return write_bytes(path, page.as_bytes(), notices);
    }
    for (name, (_, _, bytes)) in &names {
        write_bytes(&path.with_file_name(name), bytes, notices)?;
    }
    write_bytes(path, report.to_markdown().as_bytes(), notices)
}

fn text(results: &FitResults, file: &ModelFile, pictures: &BTreeMap<String, &Drawn>) -> Report {
    let fit = results.fit;
    let mut report = Report::new(&format!("Fit of {}", file.name));
    report.paragraph(&format!("{}. Data: {}.", file.title, file.provenance.data));
    report.section("Verdict");
    if results.faults.is_empty() {
        report.paragraph(
            "Sound: every parameter is within its bounds, distinct from the others, and constrained by enough points.",
        );
    } else {
        report.paragraph("**Not sound:**");
        report.list(results.faults.iter().map(ToString::to_string));
    }
    report.section("Points");
    let measurements = &results.input.measurements;
    report.paragraph(&format!(
        "{} measurements in {} groups; {} rows left out; {} points fitted, {} without sunlit surfaces in the model.",
        measurements.points.len(),
        measurements.groups.len(),
        measurements.dropped.total(),
        fit.kept.len(),
        results.input.points.len() - fit.kept.len()
    ));
    if let Some(mismatch) = results.input.band_mismatch(results.chosen.band) {
        report.paragraph(&format!("**Band:** {mismatch}."));
    }
    if measurements.dropped.total() > 0 {
        report.table(&measurements.dropped.table());
    }
    report.section("Parameters");
    report.table(&parameter_table(fit, &points_behind(results.problem, fit)));
    report.paragraph(&format!(
        "Errors: {}. Costs from the starting points: {}.",
        fit.uncertainty.kind,
        costs(&fit.costs)
    ));
    report.section("Residuals");
    let spread = |name: &str, s: ResidualStatistics| {
        format!("{name}: {} points, mean {:+.3}, RMS {:.3}, core {:.3} mag", s.n, s.mean_mag, s.rms_mag, s.core_mag)
    };
    let fitted = fit.statistics(&results.input.points).map(|s| spread("Fitted points", s));
    let singles = ResidualStatistics::weighted(results.singles.iter().copied());
    report.list(fitted.into_iter().chain(singles.map(|s| spread("Single measurements", s))));
    if results.chosen.settings.loss != Loss::Squares {
        report.paragraph(ROBUST);
    }
    if !results.standings.is_empty() {
        report.section("Held-out points");
        report.paragraph(match &results.input.reduction {
            None => "Each form is fitted without one fold of tracks or nights at a time, and compared with the points of that fold.",
            Some(_) => "Each form is fitted to the pixels without the tracks of one fold at a time, and compared with the pixels of that fold.",
        });
        report.table(&form_score_table(results.standings));
    }
    if let Some((_, posterior)) = results.posterior {
        report.section("Posterior");
        report.paragraph(&format!(
            "{} steps of {} walkers after burn-in, {:.0} % of proposals accepted; seed {}.",
            posterior.steps,
            results.typed.walkers,
            100.0 * posterior.acceptance,
            results.typed.seed
        ));
        let narrow = posterior.overconfident(fit, LARGE_RATIO);
        let ratios: Vec<String> = narrow.iter().map(|(name, times)| format!("{name} {times:.1}")).collect();
        report.paragraph(&match ratios.is_empty() {
            true => "The posterior assumes independent points. Its errors agree with those of the fit (fit_sigma): either may be used.".to_owned(),
            false => format!(
                "The posterior assumes independent points, but points of one track or night have common errors. The errors of the fit \
                (fit_sigma) are larger ({} times): use them, and only the shape of the posterior.",
                ratios.join(", ")
            ),
        });
        report.table(&marginal_table(posterior, fit));
    }
    if !pictures.is_empty() {
        report.section("Pictures");
        pictures.iter().for_each(|(name, (_, caption, _))| report.picture(caption, name));
    }
    report.section("Method");
    report.list(file.provenance.notes.iter().cloned());
    report.paragraph(&format!("Sigma {:.3} mag: {}.", file.sigma_mag, file.sigma_origin));
    report
}

fn costs(costs: &[f64]) -> String {
    costs.iter().map(|cost| format!("{cost:.4}")).collect::<Vec<_>>().join(", ")
}

pub use drawn::{of_counts, pictures, pixels_picture, residual_maps, slice};
use streakcast::plot::data_url;

mod drawn {
    use std::collections::BTreeMap;
    use std::path::Path;

    use anyhow::anyhow;
    use streakcast::fit::measurements::{Pixel, Reduction};
    use streakcast::fit::{FitPoint, rms};
    use streakcast::math::healpix::ring_cell;
    use streakcast::photometry::ModelFile;
    use streakcast::plot::{
        Corner, CountsAndSpread, FileOptions, LayerPanel, Layers, PhaseCurve, Picture, PictureFormat, Quantity,
        ResidualHistogram, ResidualPanels, corner, counts_and_spread, layers, phase_curve, residual_histogram,
        residual_panels,
    };

    use super::super::points::provenance;
    use super::{Drawn, FitResults};
    use crate::notices::Notices;
    use crate::output::write_bytes;
    use crate::verbs::plot::json_of;

    /// HEALPix resolution of maps of residuals.
    const NSIDE: u32 = 16;
    /// Largest number of layers in maps of residuals.
    const MAX_LAYERS: usize = 6;

    pub fn pictures(results: &FitResults, file: &ModelFile) -> anyhow::Result<Vec<Drawn>> {
        let (fit, points) = (results.fit, results.problem.points());
        let name = &file.name;
        let mut provenance = provenance(&results.typed.photometry, &results.typed.reduction, results.input);
        provenance.state("model", name.as_str());
        let options = FileOptions { provenance: Some(json_of(&provenance)), ..FileOptions::default() };
        let mut drawn = Vec::new();
        let mut add = |end, caption: &str, picture: Picture| -> anyhow::Result<()> {
            drawn.push((end, caption.to_owned(), picture.to_file(PictureFormat::Png, &options)?));
            Ok(())
        };
        let residuals = &fit.residuals_mag;
        let column = |of: fn(&FitPoint) -> f64| points.iter().map(of).collect::<Vec<f64>>();
        let (sun, longitude) = (column(|p| p.geometry.sun_latitude_rad), column(|p| p.geometry.observer_longitude_rad));
        let (latitude, phase) =
            (column(|p| p.geometry.observer_latitude_rad), column(|p| p.geometry.phase_angle_rad()));
        let measured = column(|p| p.magnitude);
        let model: Vec<f64> = measured.iter().zip(residuals).map(|(measured, residual)| measured - residual).collect();
        let title = format!("{name}: observed minus computed");
        // Single measurements are compared with their predicted sigma, pixels with the scatter of their residuals.
        let scatter = if results.input.reduction.is_some() { rms(residuals) } else { file.sigma_mag };
        let sigma_mag = scatter.max(1e-3);
        add(
            "histogram",
            "Residuals",
            residual_histogram(&ResidualHistogram { title: &title, residuals_mag: residuals, sigma_mag })?,
        )?;
        let panels = ResidualPanels {
            title: &title,
            residuals_mag: residuals,
            sun_latitude_rad: &sun,
            observer_longitude_rad: &longitude,
            observer_latitude_rad: &latitude,
            phase_angle_rad: &phase,
        };
        add("residuals", "Residuals against the geometry", residual_panels(&panels)?)?;
        let curve = PhaseCurve {
            title: name,
            magnitude_name: "magnitude at 1000 km",
            phase_angle_rad: &phase,
            measured_mag: &measured,
            model_mag: &model,
        };
        add("phase", "Magnitudes against the phase angle", phase_curve(&curve)?)?;
        if let Some(picture) = residual_maps(&title, points, residuals, NSIDE, None)? {
            add("maps", "Residuals over the directions around the satellite", picture)?;
        }
        if let Some(reduction) = &results.input.reduction {
            add("pixels", "Number of points and spread of the pixels", of_counts(reduction)?)?;
        }
        if let Some((chain, posterior)) = results.posterior {
            let names: Vec<String> = posterior.marginals.iter().map(|marginal| marginal.name.clone()).collect();
            let burn_in = chain.steps() - posterior.steps;
            let samples: Vec<Vec<f64>> = (0..names.len()).map(|i| chain.column(i, burn_in)).collect();
            let bounds: Vec<[f64; 2]> =
                fit.free.iter().map(|&i| [fit.parameters[i].least, fit.parameters[i].greatest]).collect();
            if (2..=9).contains(&names.len()) {
                let title = format!("Posterior of {name}");
                add(
                    "corner",
                    "Posterior",
                    corner(&Corner {
                        title: &title,
                        names: &names,
                        samples: &samples,
                        truths: None,
                        bounds: Some(&bounds),
                    })?,
                )?;
            }
        }
        Ok(drawn)
    }

    /// Draws mean residuals in cells of the observer's direction, for the one-degree layers of the Sun's latitude with
    /// the most cells. If `from_deg` is given, only layers with these lower ends are drawn. `None` if no point is in
    /// the layers.
    pub fn residual_maps(
        title: &str,
        points: &[FitPoint],
        residuals: &[f64],
        nside: u32,
        from_deg: Option<&[i64]>,
    ) -> anyhow::Result<Option<Picture>> {
        let mut all = BTreeMap::<i64, BTreeMap<u64, (f64, f64)>>::new();
        for (point, residual) in points.iter().zip(residuals) {
            let g = point.geometry.folded();
            let Some(cell) = ring_cell(nside, g.observer_longitude_rad, g.observer_latitude_rad) else { continue };
            let layer = g.sun_latitude_rad.to_degrees().floor() as i64;
            let sum = all.entry(layer).or_default().entry(cell).or_default();
            *sum = (sum.0 + residual, sum.1 + 1.0);
        }
        let mut fullest: Vec<i64> =
            all.keys().copied().filter(|layer| from_deg.is_none_or(|layers| layers.contains(layer))).collect();
        fullest.sort_by_key(|layer| std::cmp::Reverse(all[layer].len()));
        fullest.truncate(MAX_LAYERS);
        fullest.sort_by_key(|layer| std::cmp::Reverse(*layer));
        let cells: Vec<(String, Vec<(u64, f64)>)> = fullest
            .iter()
            .map(|layer| {
                let means = all[layer].iter().map(|(cell, (sum, n))| (*cell, sum / n)).collect();
                (layer_title(*layer as f64, (layer + 1) as f64), means)
            })
            .collect();
        if cells.is_empty() {
            return Ok(None);
        }
        let panel = |(title, cells): &'_ (String, Vec<(u64, f64)>)| (title.clone(), cells.clone());
        let owned: Vec<_> = cells.iter().map(panel).collect();
        let panels =
            owned.iter().map(|(title, cells)| LayerPanel { title, quantity: Quantity::Residual, cells }).collect();
        Ok(Some(layers(&Layers { title, caption: "Means of cells.", nside, is_folded: true, panels })?))
    }

    /// Title of a layer of latitudes of the Sun, with minus signs instead of hyphens.
    fn layer_title(from_deg: f64, to_deg: f64) -> String {
        format!("Sun at latitude {from_deg}° to {to_deg}°").replace('-', "−")
    }

    /// Draws figure 3 of Lu (2024).
    pub fn of_counts(reduction: &Reduction) -> anyhow::Result<Picture> {
        let counts: Vec<f64> = reduction.pixels.iter().map(|pixel| f64::from(pixel.count)).collect();
        let iqr_mag: Vec<f64> = reduction.pixels.iter().map(|pixel| pixel.iqr_mag).collect();
        Ok(counts_and_spread(&CountsAndSpread {
            title: "HEALPix cells: samples and spread",
            counts: &counts,
            iqr_mag: &iqr_mag,
            least_count: f64::from(reduction.options.least_count),
            most_iqr_mag: reduction.options.most_iqr_mag,
        })?)
    }

    /// Draws figure 2 of Lu (2024) for one layer, or figure 3 for all pixels.
    pub fn pixels_picture(
        path: &Path,
        reduction: Option<&Reduction>,
        layer_deg: Option<f64>,
        notices: &Notices,
    ) -> anyhow::Result<()> {
        let reduction =
            reduction.ok_or_else(|| anyhow!("--picture is given with --raw-points; allowed: with reduced pixels"))?;
        let picture = match layer_deg {
            None => of_counts(reduction)?,
            Some(sun_deg) => slice(reduction, sun_deg)?,
        };
        write_bytes(path, &picture.to_bytes(PictureFormat::from_extension(path)?)?, notices)
    }

    /// Draws figure 2 of Lu (2024): magnitudes, counts and spreads of the pixels of the layer that contains a latitude
    /// of the Sun.
    pub fn slice(reduction: &Reduction, sun_deg: f64) -> anyhow::Result<Picture> {
        let width_deg = reduction.options.layer_width_rad.to_degrees();
        let layer = (sun_deg / width_deg).floor() as i32;
        let inside: Vec<&Pixel> = reduction.pixels.iter().filter(|pixel| pixel.layer == layer).collect();
        if inside.is_empty() {
            return Err(anyhow!(
                "layer is {sun_deg} deg, where no pixel lies; allowed: a latitude of the Sun with pixels"
            ));
        }
        let of = |value: fn(&Pixel) -> f64| inside.iter().map(|pixel| (pixel.cell, value(pixel))).collect::<Vec<_>>();
        let (mode, count, spread) = (of(|p| p.mode_mag), of(|p| f64::from(p.count)), of(|p| p.iqr_mag));
        let from = f64::from(layer) * width_deg;
        let title = layer_title(from, from + width_deg);
        Ok(layers(&Layers {
            title: &title,
            caption: "",
            nside: reduction.options.nside,
            is_folded: reduction.options.fold,
            panels: vec![
                LayerPanel { title: "(a) magnitude at 1000 km", quantity: Quantity::Magnitude, cells: &mode },
                LayerPanel { title: "(b) number of points", quantity: Quantity::Count, cells: &count },
                LayerPanel { title: "(c) interquartile range", quantity: Quantity::Spread, cells: &spread },
            ],
        })?)
    }
}
