//! Photometry as typed, made into points of a fit.

use anyhow::anyhow;
use streakcast::fit::measurements::{
    DensityMode, DropCounts, DropReason, FilterCounts, Measurements, RecordReader, ReduceOptions, Reducer, Reduction,
    measure, reduce,
};
use streakcast::fit::{FitPoint, RawWeights, points_of_measurements, points_of_pixels};
use streakcast::output::Provenance;
use streakcast::photometry::Band;

use super::arguments::{ModeName, PhotometryArguments, ReductionArguments, WeightArguments};
use super::photometry;
use crate::notices::Notices;
use crate::verbs::judged::begin;

/// Photometry in its geometry.
pub struct Placed {
    pub measurements: Measurements,
    pub filters: FilterCounts,
    /// Pixels, unless single measurements were asked for.
    pub reduction: Option<Reduction>,
    /// Points to be fitted.
    pub points: Vec<FitPoint>,
    pub notices: Notices,
}

impl Placed {
    /// What there is to say of photometry that is not in the model's band.
    pub fn band_mismatch(&self, band: Band) -> Option<String> {
        self.filters.mismatch(band).map(|mismatch| mismatch.to_string())
    }

    /// The measurements behind pixels, and how these are made of them: what is held out of fits to pixels.
    pub fn tracks(&self) -> Option<(&Measurements, ReduceOptions)> {
        self.reduction.as_ref().map(|reduction| (&self.measurements, reduction.options))
    }
}

pub fn read(
    typed: &PhotometryArguments,
    reduction: &ReductionArguments,
    weights: &RawWeights,
) -> anyhow::Result<Placed> {
    let config = photometry::config(&typed.tables);
    let notices = begin(&config)?;
    if !(0.01..=180.0).contains(&reduction.layer_deg) {
        return Err(anyhow!("layer-deg {}; allowed: 0.01 to 180", reduction.layer_deg));
    }
    let options = reduce_options(reduction);
    Reducer::new(options)?;
    let history = photometry::history(typed)?;
    let (placement, selection) = (photometry::placement(typed, history.as_ref())?, photometry::selection(typed));
    let mut reader = RecordReader::open(&typed.tables.photometry, &photometry::read_options(&typed.tables, &config)?)?;
    let measurements = measure(&mut reader, &placement, &selection)?;
    tell(&notices, &measurements.dropped, measurements.points.len());
    let filters = reader.filters().clone();
    let (pixels, points) = if reduction.raw_points {
        (None, points_of_measurements(&measurements, weights))
    } else {
        let pixels = reduce(&measurements.points, options)?;
        let points = points_of_pixels(&pixels);
        notices.say(&format!(
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
        return Err(nothing_left(&measurements, pixels.as_ref()));
    }
    Ok(Placed { measurements, filters, reduction: pixels, points, notices })
}

/// How single measurements are weighed, as typed.
pub fn weights(typed: &WeightArguments) -> anyhow::Result<RawWeights> {
    if !(typed.scatter_mag > 0.0 && typed.scatter_mag.is_finite()) {
        return Err(anyhow!("scatter-mag {}; allowed: more than 0", typed.scatter_mag));
    }
    Ok(RawWeights { scatter_mag: typed.scatter_mag, by_group: !typed.equal_weights })
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

/// What an answer rests on: files, thresholds of the selection and the reduction, rows used and left out.
pub fn provenance(photometry: &PhotometryArguments, reduction: &ReductionArguments, placed: &Placed) -> Provenance {
    let mut provenance = Provenance::new();
    photometry::state(photometry, &mut provenance);
    if let Some(pixels) = &placed.reduction {
        provenance.state("layer_deg", reduction.layer_deg);
        let options = &pixels.options;
        provenance.state("nside", i64::from(options.nside));
        provenance.state("mode", format!("{:?}", options.mode));
        provenance.state("min_count", i64::from(options.least_count));
        provenance.state("min_tracks", i64::from(options.least_tracks));
        provenance.state("max_iqr_mag", options.most_iqr_mag);
        provenance.state("folded", options.fold);
        provenance.state("pixels_kept", pixels.kept().count());
    }
    provenance.state("measurements", placed.measurements.points.len());
    let dropped = &placed.measurements.dropped;
    provenance.state("rows_left_out", dropped.total() as i64);
    for (reason, count, _) in dropped.iter() {
        provenance.state(&format!("left_out_{}", reason.name()), count as i64);
    }
    for (filter, rows) in placed.filters.iter() {
        provenance.state(&format!("rows_through_{}", filter.unwrap_or("no_named_filter")), rows as i64);
    }
    provenance
}

/// Why no point is left, and which option may help.
fn nothing_left(measurements: &Measurements, pixels: Option<&Reduction>) -> anyhow::Error {
    let most = measurements.dropped.iter().max_by_key(|(_, count, _)| *count);
    match (measurements.points.len(), pixels, most) {
        (0, _, Some((reason, count, _))) => anyhow!(
            "no measurement is left: {} rows left out, {count} of them for {}{}",
            measurements.dropped.total(),
            reason.name().replace('_', " "),
            remedy(reason)
        ),
        (0, ..) => anyhow!("no measurement is left: the tables hold none"),
        (n, ..) => anyhow!(
            "no pixel is left of {n} measurements; allowed by --min-count, --max-iqr and --min-tracks, or point by point with --raw-points"
        ),
    }
}

fn remedy(reason: DropReason) -> &'static str {
    match reason {
        DropReason::NoGeometry => " (distance and phase need --height-km, others a site or --elements)",
        DropReason::NoElements => " (the rows must name a satellite that --elements hold)",
        DropReason::StaleElements => " (see --max-element-age-days)",
        DropReason::WrongFilter => " (see --filter)",
        _ => "",
    }
}

/// How many rows were used, and why others were not.
fn tell(notices: &Notices, dropped: &DropCounts, used: usize) {
    notices.say(&format!("{used} measurements, {} rows left out", dropped.total()));
    for (reason, count, example) in dropped.iter() {
        let first = example.map(|one| format!(" (first: {one})")).unwrap_or_default();
        notices.say(&format!("  {count} {}{first}", reason.name().replace('_', " ")));
    }
}
