//! Converts photometry to the points of a fit.

use anyhow::anyhow;
use streakcast::config::Config;
use streakcast::elements::History;
use streakcast::fit::measurements::{
    DensityMode, DropCounts, DropReason, FilterCounts, Measurements, RecordReader, ReduceOptions, Reducer, Reduction,
    measure, reduce,
};
use streakcast::fit::{FitPoint, RawWeights, points_of_measurements, points_of_pixels, weigh_groups};
use streakcast::output::{Provenance, counted};
use streakcast::photometry::Band;

use super::arguments::{ModeName, PhotometryArguments, ReductionArguments, WeightArguments};
use super::form::ChosenForm;
use super::photometry;
use crate::notices::Notices;
use crate::start::begin;

/// Photometry with its geometry.
pub struct FitInput {
    pub measurements: Measurements,
    pub filters: FilterCounts,
    /// Pixels; `None` if single measurements are fitted.
    pub reduction: Option<Reduction>,
    /// Points of the fit.
    pub points: Vec<FitPoint>,
    /// Measured correlation within groups; `None` for pixels and equal weights.
    pub group_correlation: Option<f64>,
    pub notices: Notices,
}

impl FitInput {
    /// Sets the weights of single measurements by the correlation within their groups, unless weights are equal.
    pub fn weigh(&mut self, chosen: &ChosenForm, typed: &WeightArguments) -> anyhow::Result<()> {
        if self.reduction.is_some() || typed.equal_weights {
            return Ok(());
        }
        let correlation = weigh_groups(chosen.form.as_form(), &mut self.points, &chosen.settings)?;
        let effective: f64 = self.points.iter().map(|point| point.weight).sum();
        self.notices.info(&format!(
            "correlation within groups (tracks, nights or passes) {correlation:.2}: effective number of points {effective:.0}"
        ));
        self.group_correlation = Some(correlation);
        Ok(())
    }

    /// Returns a warning if the band of the photometry differs from that of the model.
    pub fn band_mismatch(&self, band: Band) -> Option<String> {
        self.filters.mismatch(band).map(|mismatch| mismatch.to_string())
    }

    /// Returns the measurements of the pixels with the reduction options, for cross-validation by track.
    pub fn tracks(&self) -> Option<(&Measurements, ReduceOptions)> {
        self.reduction.as_ref().map(|reduction| (&self.measurements, reduction.options))
    }
}

pub fn read(
    typed: &PhotometryArguments,
    reduction: &ReductionArguments,
    weights: &RawWeights,
) -> anyhow::Result<FitInput> {
    let config = photometry::config(&typed.tables);
    let notices = begin(&config)?;
    if !(0.01..=180.0).contains(&reduction.layer_deg) {
        return Err(anyhow!("layer-deg is {} deg; allowed: 0.01 to 180 deg", reduction.layer_deg));
    }
    let options = reduce_options(reduction);
    Reducer::new(options)?;
    let history = photometry::history(typed)?;
    let (measurements, filters) = measured(typed, &config, history.as_ref(), &notices)?;
    let (pixels, points) = if reduction.raw_points {
        (None, points_of_measurements(&measurements, weights))
    } else {
        let pixels = reduce(&measurements.points, options)?;
        let points = points_of_pixels(&pixels);
        notices.info(&format!(
            "{} points in {} pixels, {} of them kept ({} points or more, spread of {} mag or less)",
            pixels.points,
            pixels.pixels.len(),
            points.len(),
            reduction.min_count,
            reduction.max_iqr
        ));
        (Some(pixels), points)
    };
    if points.is_empty() {
        return Err(no_points(&measurements, pixels.as_ref(), history.is_some()));
    }
    Ok(FitInput { measurements, filters, reduction: pixels, points, group_correlation: None, notices })
}

/// Reads the selected measurements, and prints the numbers of rows. `history` are the element sets of the flags.
pub fn measured(
    typed: &PhotometryArguments,
    config: &Config,
    history: Option<&History>,
    notices: &Notices,
) -> anyhow::Result<(Measurements, FilterCounts)> {
    let (placement, selection) = (photometry::placement(typed, history)?, photometry::selection(typed));
    let mut reader = RecordReader::open(&typed.tables.photometry, &photometry::read_options(&typed.tables, config)?)?;
    let measurements = measure(&mut reader, &placement, &selection)?;
    report_counts(notices, &measurements.dropped, measurements.points.len());
    if measurements.points.is_empty() {
        return Err(no_points(&measurements, None, history.is_some()));
    }
    let filters = reader.filters().clone();
    Ok((measurements, filters))
}

/// Returns the weights of single measurements.
pub fn weights(typed: &WeightArguments) -> anyhow::Result<RawWeights> {
    if !(typed.scatter_mag > 0.0 && typed.scatter_mag.is_finite()) {
        return Err(anyhow!("scatter-mag is {} mag; allowed: above 0 mag", typed.scatter_mag));
    }
    let default = RawWeights::default();
    let group_correlation = if typed.equal_weights { 0.0 } else { default.group_correlation };
    Ok(RawWeights { scatter_mag: typed.scatter_mag, group_correlation })
}

fn reduce_options(typed: &ReductionArguments) -> ReduceOptions {
    ReduceOptions {
        layer_width_rad: typed.layer_deg.to_radians(),
        nside: typed.nside,
        fold: !typed.no_fold,
        mode: match typed.mode {
            ModeName::HalfSample => DensityMode::HalfSample,
            ModeName::Kernel => DensityMode::Kernel,
        },
        least_count: typed.min_count,
        least_tracks: typed.min_tracks,
        most_iqr_mag: typed.max_iqr,
    }
}

/// Returns the provenance: files, thresholds of selection and reduction, numbers of used and omitted rows.
pub fn provenance(photometry: &PhotometryArguments, reduction: &ReductionArguments, input: &FitInput) -> Provenance {
    let mut provenance = Provenance::new();
    photometry::state(photometry, &mut provenance);
    if let Some(pixels) = &input.reduction {
        provenance.state("layer_deg", reduction.layer_deg);
        let options = &pixels.options;
        provenance.state("nside", i64::from(options.nside));
        provenance.state("mode", options.mode.to_string());
        provenance.state("min_count", i64::from(options.least_count));
        provenance.state("min_tracks", i64::from(options.least_tracks));
        provenance.state("max_iqr_mag", options.most_iqr_mag);
        provenance.state("folded", options.fold);
        provenance.state("pixels_kept", pixels.kept().count());
    }
    provenance.state("measurements", input.measurements.points.len());
    let dropped = &input.measurements.dropped;
    provenance.state("rows_left_out", dropped.total() as i64);
    for (reason, count, _) in dropped.iter() {
        provenance.state(&format!("left_out_{}", reason.name()), count as i64);
    }
    for (filter, rows) in input.filters.iter() {
        provenance.state(&format!("rows_through_{}", filter.unwrap_or("no_named_filter")), rows as i64);
    }
    provenance
}

/// Returns the error for a fit without points. It lists options that may help.
fn no_points(measurements: &Measurements, pixels: Option<&Reduction>, has_elements: bool) -> anyhow::Error {
    let most = measurements.dropped.iter().max_by_key(|(_, count, _)| *count);
    match (measurements.points.len(), pixels, most) {
        (0, _, Some((reason, count, _))) => anyhow!(
            "no measurement remains: {} left out, {count} of them for {}{}",
            counted(measurements.dropped.total() as usize, "row", "rows"),
            reason.name().replace('_', " "),
            remedy(reason, has_elements)
        ),
        (0, ..) => anyhow!("no measurement remains: the tables contain none; allowed: tables with photometry"),
        (n, ..) => anyhow!(
            "no pixel remains of {n} measurements; change --min-count, --max-iqr or --min-tracks, or use --raw-points"
        ),
    }
}

fn remedy(reason: DropReason, has_elements: bool) -> &'static str {
    match reason {
        DropReason::NoGeometry if has_elements => {
            " (the site is missing: specify --mpc CODE, --site NAME, or --lat DEG and --lon DEG, or columns with the latitude and longitude of each row)"
        }
        DropReason::NoGeometry => " (distance and phase need --height-km, others a site or --elements)",
        DropReason::NoElements => " (the satellites of the rows must be in --elements)",
        DropReason::StaleElements => " (see --max-element-age-days)",
        DropReason::WrongFilter => " (see --filter)",
        _ => "",
    }
}

/// Prints the number of rows used, and the number of omitted rows for each reason.
fn report_counts(notices: &Notices, dropped: &DropCounts, used: usize) {
    let used = counted(used, "measurement", "measurements");
    notices.info(&format!("{used}, {} left out", counted(dropped.total() as usize, "row", "rows")));
    for (reason, count, example) in dropped.iter() {
        let first = example.map(|example| format!(" (first: {example})")).unwrap_or_default();
        notices.info(&format!("  {count} {}{first}", reason.name().replace('_', " ")));
    }
}
