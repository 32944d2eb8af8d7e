//! The learned file of all kinds, and its tables.

use std::collections::BTreeMap;

use hifitime::Epoch;

use super::hierarchy::{KindFit, fit_kind};
use super::lateness::{MeasuredDelay, learn_lateness};
use super::leave_out::satellites_differ;
use super::pass::Pass;
use crate::elements::{Generation, NoradId};
use crate::error::{Error, ErrorKind};
use crate::output::{Column, Kind, Table, format_utc};
use crate::passes::{LearnedFile, LearnedKind, LearnedMagnitude, LearnedSatellite, ModelChoice};
use crate::watch::Watch;

/// Learned file, with the fits of its kinds.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Learned {
    /// Content of the file.
    pub file: LearnedFile,
    /// Fits of the kinds with magnitudes.
    #[doc(hidden)]
    pub fits: BTreeMap<Generation, KindFit>,
    /// Kinds whose satellites have no offsets of their own in the file, because such offsets do not improve the
    /// predictions of other passes.
    pub without_satellites: Vec<Generation>,
}

/// First and last time, and numbers of passes and measurements.
struct Extent {
    first: Epoch,
    last: Epoch,
    passes: usize,
    measurements: usize,
}

impl Extent {
    fn of_passes<'p>(passes: impl Iterator<Item = &'p Pass> + Clone) -> Option<Self> {
        Some(Self {
            first: passes.clone().map(Pass::first).min()?,
            last: passes.clone().map(Pass::last).max()?,
            passes: passes.clone().count(),
            measurements: passes.map(|pass| pass.points().len()).sum(),
        })
    }

    fn utc(&self) -> [String; 2] {
        [self.first, self.last].map(|epoch| format_utc(epoch, 0))
    }
}

/// Learns the offsets of satellites and kinds from passes, and the errors along the track from delays with their kinds.
///
/// Offsets of single satellites are included only for kinds for which they improve the prediction of other passes.
/// `models` must not apply a learned file. `provenance` names the files and options.
///
/// # Errors
/// [`TooFewData`](crate::ErrorKind::TooFewData) without passes; [`Cancelled`](crate::ErrorKind::Cancelled) if `watch`
/// stops.
pub fn learn(
    passes: &[Pass],
    delays: &BTreeMap<Generation, Vec<MeasuredDelay>>,
    models: &ModelChoice,
    provenance: serde_json::Map<String, serde_json::Value>,
    watch: &Watch,
) -> Result<Learned, Error> {
    let Some(all) = Extent::of_passes(passes.iter()) else {
        return Err(Error::new(
            ErrorKind::TooFewData,
            "nothing to learn from: no pass has a satellite with a brightness model",
        )
        .allowing("measurements with times and satellite numbers"));
    };
    let mut kinds: BTreeMap<Generation, LearnedKind> = BTreeMap::new();
    for (kind, delays) in delays {
        if let Some(lateness) = learn_lateness(delays) {
            kinds.insert(*kind, LearnedKind { kind: *kind, magnitude: None, lateness: Some(lateness) });
        }
    }
    let (mut satellites, mut fits, mut without_satellites) = (Vec::new(), BTreeMap::new(), Vec::new());
    for kind in Generation::ALL {
        let of_kind: Vec<&Pass> = passes.iter().filter(|pass| pass.kind() == kind).collect();
        let (Some(extent), Some(model)) = (Extent::of_passes(of_kind.iter().copied()), models.of_kind(kind)) else {
            continue;
        };
        watch.check()?;
        let fit = fit_kind(&of_kind, model.sigma_mag());
        let mut by_satellite: BTreeMap<NoradId, Vec<&Pass>> = BTreeMap::new();
        for pass in &of_kind {
            by_satellite.entry(pass.norad_id()).or_default().push(pass);
        }
        let [first_utc, last_utc] = extent.utc();
        let magnitude = LearnedMagnitude {
            model: model.source().to_string(),
            satellites: by_satellite.len(),
            passes: extent.passes,
            measurements: extent.measurements,
            first_utc,
            last_utc,
            offset_mag: rounded(fit.offset_mag),
            offset_sigma_mag: rounded(fit.offset_sigma_mag),
            satellite_sigma_mag: rounded(fit.satellite_sigma_mag),
            pass_scale_mag: rounded(fit.pass_scale_mag),
            point_sigma_mag: rounded(fit.point_sigma_mag),
            // Prediction for a satellite without measurements: no satellite has the number 0.
            sigma_mag: rounded(fit.predict(NoradId(0)).sigma_mag),
        };
        let entry = kinds.entry(kind).or_insert(LearnedKind { kind, magnitude: None, lateness: None });
        entry.magnitude = Some(magnitude);
        if !satellites_differ(&of_kind, model.sigma_mag(), watch)? {
            without_satellites.push(kind);
            by_satellite.clear();
        }
        for (id, of_satellite) in by_satellite {
            let Some(extent) = Extent::of_passes(of_satellite.iter().copied()) else { continue };
            let ([first_utc, last_utc], prediction) = (extent.utc(), fit.predict(id));
            satellites.push(LearnedSatellite {
                norad_id: id.0,
                kind,
                passes: extent.passes,
                measurements: extent.measurements,
                first_utc,
                last_utc,
                offset_mag: rounded(prediction.offset_mag),
                offset_sigma_mag: rounded(prediction.offset_sigma_mag),
                sigma_mag: rounded(prediction.sigma_mag),
            });
        }
        fits.insert(kind, fit);
    }
    let file = LearnedFile::new(provenance, all.utc(), kinds.into_values().collect(), satellites);
    Ok(Learned { file, fits, without_satellites })
}

/// Returns a magnitude with four decimals, which is more than the measurements determine.
fn rounded(mag: f64) -> f64 {
    (mag * 1e4).round() / 1e4
}

const KINDS: [Column; 12] = [
    Column::new("kind", Kind::Text, "Kind of satellite."),
    Column::new("model", Kind::Text, "Source of the magnitudes of the model."),
    Column::new("satellites", Kind::Integer, "Number of satellites."),
    Column::new("passes", Kind::Integer, "Number of passes."),
    Column::new("measurements", Kind::Integer, "Number of measurements."),
    Column::real("offset_mag", "mag", 3, "Mean offset of the satellites; positive is fainter than the model."),
    Column::real("offset_sigma_mag", "mag", 3, "One sigma of offset_mag."),
    Column::real("satellite_sigma_mag", "mag", 3, "Standard deviation of the offsets of the satellites."),
    Column::real("pass_scale_mag", "mag", 3, "Scale of the differences between passes of a satellite."),
    Column::real("point_sigma_mag", "mag", 3, "One sigma of the measurements within a pass."),
    Column::real("sigma_mag", "mag", 3, "One sigma of a measurement of a satellite that is not in the file."),
    Column::real("lateness_factor", "", 3, "Factor of the error along the track; empty without measured delays."),
];

/// Returns a table with one row for each kind of a learned file.
pub fn kind_table(file: &LearnedFile) -> Table {
    let cells = |learned: &LearnedKind| {
        let of = learned.magnitude.as_ref();
        let real = |value: fn(&LearnedMagnitude) -> f64| of.map(value).into();
        vec![
            learned.kind.name().into(),
            of.map(|of| of.model.clone()).into(),
            of.map(|of| of.satellites as i64).into(),
            of.map(|of| of.passes as i64).into(),
            of.map(|of| of.measurements as i64).into(),
            real(|of| of.offset_mag),
            real(|of| of.offset_sigma_mag),
            real(|of| of.satellite_sigma_mag),
            real(|of| of.pass_scale_mag),
            real(|of| of.point_sigma_mag),
            real(|of| of.sigma_mag),
            learned.lateness.as_ref().map(|lateness| lateness.factor).into(),
        ]
    };
    Table { columns: KINDS.to_vec(), rows: file.kinds.iter().map(cells).collect() }
}
