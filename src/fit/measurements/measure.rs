//! From records to measurements: placed, selected, brought to 1000 km; in one piece or chunk by chunk.

use rayon::prelude::*;

use super::dropped::{DropCounts, DropExample, DropReason};
use super::error::MeasuredError;
use super::measurement::{Measurement, Measurements};
use super::placement::{OrbitRadius, Place, Placement, Placer};
use super::record::{Record, RecordSource};
use super::selection::Selection;
use super::station::Stations;

/// All measurements of a source, in memory: 130 bytes each.
///
/// # Errors
/// As for [`measure_each`].
pub fn measure(
    source: &mut impl RecordSource,
    placement: &Placement,
    selection: &Selection,
) -> Result<Measurements, MeasuredError> {
    let mut points = Vec::new();
    let dropped = measure_each(source, placement, selection, |chunk| points.extend_from_slice(chunk))?;
    Ok(Measurements { points, groups: source.groups().to_vec(), dropped })
}

/// Hands measurements on chunk by chunk, in the order of the source, so that memory does not grow with their number; returns what was
/// dropped. Groups are those of the source.
///
/// # Errors
/// * those of the source: a file that cannot be read or understood, mixed filters;
/// * a threshold or limit that cannot be;
/// * element sets are needed and none were given.
pub fn measure_each(
    source: &mut impl RecordSource,
    placement: &Placement,
    selection: &Selection,
    mut take: impl FnMut(&[Measurement]),
) -> Result<DropCounts, MeasuredError> {
    selection.check()?;
    check(placement)?;
    let stations = match (&selection.station, placement.history) {
        (Some(rule), Some(history)) => Some(Stations::new(history, rule)),
        (Some(_), None) => return Err(MeasuredError::NoHistory { what: "the rule of on-station satellites" }),
        (None, _) => None,
    };
    let whole_tracks = matches!(placement.place, Place::Elements { fit_offset_s: Some(_) });
    let mut placer = Placer::new(placement);
    let mut dropped = DropCounts::default();
    let mut held_back: Vec<Record> = Vec::new();
    loop {
        let chunk = source.next_chunk()?;
        let is_last = chunk.is_none();
        let mut records = std::mem::take(&mut held_back);
        records.extend(chunk.into_iter().flatten());
        if whole_tracks && !is_last {
            // The last track of a chunk may go on in the next.
            let group = records.last().map(|record| record.group);
            let end = records.iter().rposition(|record| Some(record.group) != group).map_or(0, |at| at + 1);
            held_back = records.split_off(end);
        }
        let (measured, counts) = judge(&mut placer, source, &records, selection, stations.as_ref());
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

fn check(placement: &Placement) -> Result<(), MeasuredError> {
    let positive = |name: &'static str, value: f64, allowed: &'static str| {
        let is_sound = value > 0.0 && value.is_finite();
        if is_sound { Ok(()) } else { Err(MeasuredError::Setting { name, given: value.to_string(), allowed }) }
    };
    positive("max_element_age_days", placement.max_element_age_days, "more than 0 days")?;
    match placement.place {
        Place::Elements { fit_offset_s: Some(limit) } if !(limit > 0.0 && limit <= 600.0) => {
            Err(MeasuredError::Setting {
                name: "fit_offset_s",
                given: limit.to_string(),
                allowed: "more than 0, to 600 s",
            })
        }
        Place::Elements { .. } | Place::Recorded { radius: Some(OrbitRadius::Elements) }
            if placement.history.is_none() =>
        {
            Err(MeasuredError::NoHistory { what: "geometry by element sets" })
        }
        Place::Recorded { radius: Some(OrbitRadius::HeightKm(height)) } => {
            positive("height_km", height, "more than 0 km")
        }
        _ => Ok(()),
    }
}

/// Records that one thread does in a row.
const RUN: usize = 4096;

fn judge(
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
                let judged: Result<_, DropReason> = match (selection.judge_record(record), placed) {
                    (Some(reason), _) => Err(reason),
                    (None, Err(reason)) => Err(*reason),
                    (None, Ok(placed)) => selection.judge(record, placed, stations).map_or(Ok(placed), Err),
                };
                match judged {
                    Ok(placed) => measured.push(Measurement {
                        magnitude: selection.standard_magnitude(record, placed),
                        sigma_mag: record.sigma_mag,
                        geometry: placed.geometry,
                        group: record.group,
                        norad_id: placed.norad_id,
                        epoch: record.epoch,
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
