//! Conversion of records to measurements: viewing geometry, selection and magnitude at 1000 km, all at once or in
//! chunks.

use hifitime::Epoch;
use rayon::prelude::*;

use super::super::error;
use super::dropped::{DropCounts, DropExample, DropReason};
use super::placement::{OrbitRadius, Placement, Placer, PositionSource};
use super::record::{Record, RecordSource};
use super::selection::{Selection, Stations};
use crate::elements::NoradId;
use crate::error::Error;
use crate::geometry::ViewingGeometry;
use crate::output::{Column, Kind, Table};
use crate::photometry::StandardMagnitude;

/// Measured magnitude with its viewing geometry.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Magnitude at 1000 km in the band of the survey.
    pub magnitude: StandardMagnitude,
    /// Uncertainty (one sigma) stated by the survey, mag.
    pub sigma_mag: Option<f64>,
    /// Directions of Sun and observer in the satellite's frame.
    pub geometry: ViewingGeometry,
    /// Index into [`Measurements::groups`].
    pub group: u32,
    /// NORAD catalogue number, if known.
    pub norad_id: Option<NoradId>,
    /// Time, if known.
    pub epoch: Option<Epoch>,
    /// Lowest height above the ground of the line from satellite to Sun, km; `None` if the satellite is the lowest
    /// point.
    pub grazing_height_km: Option<f64>,
    /// Fraction of the Sun's light that reaches the satellite past the Earth's atmosphere. The magnitude is not
    /// corrected for it.
    pub lit_fraction: f64,
}

/// Measurements, with the numbers of dropped rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    /// Measurements in the order of the files.
    pub points: Vec<Measurement>,
    /// Names of the groups. A group is a track if tracks are recorded, otherwise a satellite, a night or a file.
    pub groups: Vec<String>,
    /// Numbers of dropped rows by reason.
    #[doc(hidden)]
    pub dropped: DropCounts,
}

pub(super) const SUN: Column =
    Column::real("sun_latitude_deg", "deg", 5, "Latitude of the Sun above the chassis plane.");
pub(super) const LONGITUDE: Column = Column::real(
    "observer_longitude_deg",
    "deg",
    5,
    "Longitude of the observer from the Sun's azimuth, right-handed about the satellite's zenith.",
);
pub(super) const LATITUDE: Column =
    Column::real("observer_latitude_deg", "deg", 5, "Observer above the chassis plane; -90 is straight below.");
pub(super) const HEIGHT: Column =
    Column::real("height_km", "km", 3, "Satellite's distance from the Earth's centre less 6378.137 km.");

const POINTS: [Column; 9] = [
    Column::time("utc", "Time; empty if none was recorded."),
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number; empty if unknown."),
    Column::new("group", Kind::Text, "Track, satellite, night or file."),
    Column::real("standard_magnitude", "mag", 4, "Magnitude at 1000 km."),
    Column::real("sigma_mag", "mag", 4, "One sigma stated by the survey."),
    SUN,
    LONGITUDE,
    LATITUDE,
    HEIGHT,
];

impl Measurements {
    /// Returns a table with one row per measurement.
    #[doc(hidden)]
    pub fn table(&self) -> Table {
        let rows = self.points.iter().map(|point| {
            vec![
                point.epoch.into(),
                point.norad_id.map(|id| i64::from(id.0)).into(),
                self.groups.get(point.group as usize).cloned().into(),
                point.magnitude.0.into(),
                point.sigma_mag.into(),
                point.geometry.sun_latitude_rad.to_degrees().into(),
                point.geometry.observer_longitude_rad.to_degrees().into(),
                point.geometry.observer_latitude_rad.to_degrees().into(),
                point.geometry.height_km.into(),
            ]
        });
        Table { columns: POINTS.to_vec(), rows: rows.collect() }
    }
}

/// Returns all measurements of a source; each takes 150 bytes.
///
/// # Errors
/// The errors of [`measure_each`].
pub fn measure(
    source: &mut impl RecordSource,
    placement: &Placement,
    selection: &Selection,
) -> Result<Measurements, Error> {
    let mut points = Vec::new();
    let dropped = measure_each(source, placement, selection, |chunk| points.extend_from_slice(chunk))?;
    Ok(Measurements { points, groups: source.groups().to_vec(), dropped })
}

/// Passes measurements to `take` in chunks, in the order of the source, so that memory does not grow with their number.
/// Returns the numbers of dropped rows. The groups are those of the source.
///
/// # Errors
/// * the errors of the source: an unreadable or invalid file, mixed filters;
/// * an invalid threshold or limit;
/// * missing element sets.
pub fn measure_each(
    source: &mut impl RecordSource,
    placement: &Placement,
    selection: &Selection,
    mut take: impl FnMut(&[Measurement]),
) -> Result<DropCounts, Error> {
    selection.check()?;
    check(placement)?;
    let stations = match (&selection.station, placement.history) {
        (Some(rule), Some(history)) => Some(Stations::new(history, rule)),
        (Some(_), None) => return Err(error::no_history("the rule of on-station satellites")),
        (None, _) => None,
    };
    let whole_tracks = matches!(placement.source, PositionSource::Elements { fit_offset_s: Some(_) });
    let mut placer = Placer::new(placement);
    let mut dropped = DropCounts::default();
    let mut held_back: Vec<Record> = Vec::new();
    loop {
        let chunk = source.next_chunk()?;
        let is_last = chunk.is_none();
        let mut records = std::mem::take(&mut held_back);
        records.extend(chunk.into_iter().flatten());
        if whole_tracks && !is_last {
            // The last track of a chunk may continue in the next.
            let group = records.last().map(|record| record.group);
            let end = records.iter().rposition(|record| Some(record.group) != group).map_or(0, |at| at + 1);
            held_back = records.split_off(end);
        }
        let (measured, counts) = select(&mut placer, source, &records, selection, stations.as_ref());
        dropped.append(counts);
        if !measured.is_empty() {
            take(&measured);
        }
        if is_last {
            break;
        }
    }
    let mut all = source.dropped().clone();
    all.append(dropped);
    Ok(all)
}

fn check(placement: &Placement) -> Result<(), Error> {
    let positive = |name: &'static str, value: f64, allowed: &'static str| {
        let is_sound = value > 0.0 && value.is_finite();
        if is_sound { Ok(()) } else { Err(Error::invalid(name, value, allowed)) }
    };
    positive("max_element_age_days", placement.max_element_age_days, "more than 0 days")?;
    match placement.source {
        PositionSource::Elements { fit_offset_s: Some(limit) } if !(limit > 0.0 && limit <= 600.0) => {
            Err(Error::invalid("fit_offset_s", limit, "more than 0, to 600 s"))
        }
        PositionSource::Elements { .. } | PositionSource::Recorded { radius: Some(OrbitRadius::Elements) }
            if placement.history.is_none() =>
        {
            Err(error::no_history("the geometry"))
        }
        PositionSource::Recorded { radius: Some(OrbitRadius::HeightKm(height)) } => {
            positive("height_km", height, "more than 0 km")
        }
        _ => Ok(()),
    }
}

/// Number of records per task.
const RUN: usize = 4096;

fn select(
    placer: &mut Placer,
    source: &impl RecordSource,
    records: &[Record],
    selection: &Selection,
    stations: Option<&Stations>,
) -> (Vec<Measurement>, DropCounts) {
    let placed = placer.place(source, records);
    let files = source.files();
    let runs: Vec<(Vec<Measurement>, DropCounts)> = records
        .par_chunks(RUN)
        .zip(placed.par_chunks(RUN))
        .map(|(records, placed)| {
            let mut measured = Vec::with_capacity(records.len());
            let mut dropped = DropCounts::default();
            for (record, placed) in records.iter().zip(placed) {
                let selected: Result<_, DropReason> = match (selection.drop_record(record), placed) {
                    (Some(reason), _) => Err(reason),
                    (None, Err(reason)) => Err(*reason),
                    (None, Ok(placed)) => selection.drop_placed(record, placed, stations).map_or(Ok(placed), Err),
                };
                match selected {
                    Ok(placed) => measured.push(Measurement {
                        magnitude: selection.standard_magnitude(record, placed),
                        sigma_mag: record.sigma_mag,
                        geometry: placed.geometry,
                        group: record.group,
                        norad_id: placed.norad_id,
                        epoch: record.epoch,
                        grazing_height_km: placed.grazing_height_km(),
                        lit_fraction: placed.illumination().lit_fraction(),
                    }),
                    Err(reason) => dropped.add(reason, || DropExample {
                        file: files.get(record.file as usize).cloned().unwrap_or_default(),
                        row: u64::from(record.row),
                        problem: String::new(),
                    }),
                }
            }
            (measured, dropped)
        })
        .collect();
    let mut dropped = DropCounts::default();
    let mut measured = Vec::with_capacity(records.len());
    for (some, counts) in runs {
        measured.extend(some);
        dropped.append(counts);
    }
    (measured, dropped)
}
