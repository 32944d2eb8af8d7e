//! Real photometry: identification of tracks, geometry from element sets compared with geometry from range and phase
//! angle, and complete surveys.
//!
//! Requires the data folder; skipped with a message without it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use streakcast::elements::{History, Keep, NoradId, OrbitPhase, ReadOptions as Elements, Satellites, StationRule};
use streakcast::fit::measurements::{
    AssociationOptions, DropReason, Format, OrbitRadius, PhotometryOptions, Placement, Placer, PositionSource,
    RecordReader, RecordSource, Records, ReduceOptions, Selection, StationInterval, Stations, TrackCandidate,
    associate, measure, reduce,
};
use streakcast::frames::EopTable;

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries.filter(|path| path.is_file()).collect();
    files.sort();
    files
}

fn history(files: &[PathBuf]) -> History {
    let options = Elements { keep: Keep::All, ..Elements::default() };
    Satellites::read(files, &options).unwrap().into_history()
}

fn visorsat(data: &Path) -> Records {
    let path = data.join("derived/mmt9_starlink_visorsat.csv.gz");
    Records::collect(&mut RecordReader::open(&[path], &PhotometryOptions::default()).unwrap()).unwrap()
}

/// Returns track, catalogue number and confidence of the identified tracks.
fn identified(data: &Path) -> Vec<(String, NoradId, String)> {
    let text = std::fs::read_to_string(data.join("derived/mmt9_visorsat_track_ident.csv")).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[0].to_owned(), NoradId(cells[3].parse().unwrap()), cells[10].to_owned())
    };
    text.lines().skip(1).map(row).collect()
}

fn best(data: &Path, records: &Records) -> HashMap<String, Vec<TrackCandidate>> {
    let history = history(&files_in(&data.join("tle/mmt_2021")));
    let (eop, options) = (EopTable::embedded(), AssociationOptions::default());
    let tracks = records.groups.iter().cloned().zip(records.by_group());
    tracks.map(|(name, track)| (name, associate(&track, &records.sites, &history, &eop, &options))).collect()
}

fn quantile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    streakcast::math::quantile::quantile(&sorted, p)
}

#[test]
fn valid_tracks_are_identified() {
    let Some(data) = crate::common::data_dir() else { return };
    let records = visorsat(&data);
    // The 132 rows with a polariser are omitted, with a message.
    assert_eq!(records.dropped.count(DropReason::WrongFilter), 132);
    assert_eq!(records.records.len(), 12_633);
    let begin = std::time::Instant::now();
    let found = best(&data, &records);
    println!("{} tracks in {:.2} s", found.len(), begin.elapsed().as_secs_f64());
    let (mut ranges, mut phases, mut sure) = (Vec::new(), Vec::new(), 0);
    for (track, norad_id, confidence) in identified(&data) {
        let Some(first) = found.get(&track).and_then(|candidates| candidates.first()) else {
            assert_ne!(confidence, "sure", "{track} has no candidate");
            continue;
        };
        println!("{track} {confidence} {norad_id}: {first:?}");
        println!("    {:?}", found[&track].get(1));
        if confidence == "sure" {
            assert_eq!(first.norad_id, norad_id, "{track}");
            ranges.push(first.range_rms_km);
            phases.push(first.phase_rms_rad.unwrap().to_degrees());
            sure += 1;
        }
    }
    assert_eq!(sure, 29);
    let (range_km, phase_deg) = (quantile(&ranges, 0.5), quantile(&phases, 0.5));
    println!("median differences {range_km:.2} km, {phase_deg:.2} deg");
    // Public element sets have errors of about one kilometre.
    assert!(range_km < 1.0 && phase_deg < 0.5, "{range_km} km, {phase_deg} deg");
}

#[test]
fn valid_distance_and_phase_give_the_angles_of_element_sets() {
    let Some(data) = crate::common::data_dir() else { return };
    let mut records = visorsat(&data);
    let sure: HashMap<String, NoradId> = identified(&data)
        .into_iter()
        .filter(|(_, _, confidence)| confidence == "sure")
        .map(|(track, norad_id, _)| (track, norad_id))
        .collect();
    let groups = records.groups.clone();
    records.records.retain(|record| sure.contains_key(&groups[record.group as usize]));
    let history = history(&files_in(&data.join("tle/mmt_2021")));
    let placement = |source: PositionSource| Placement {
        source,
        identified: sure.clone(),
        max_element_age_days: 50.0,
        ..Placement::elements(&history)
    };
    let by = |source: PositionSource| {
        let placement = placement(source);
        Placer::new(&placement).place(&records.source(), &records.records)
    };
    let truth = by(PositionSource::Elements { fit_offset_s: Some(120.0) });
    let circle = by(PositionSource::Recorded { radius: Some(OrbitRadius::HeightKm(550.0)) });
    let osculating = by(PositionSource::Recorded { radius: Some(OrbitRadius::Elements) });
    // Differences of α for either radius, degrees; and of range and phase angle.
    let (mut rough, mut fine, mut ranges, mut phases) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (at, record) in records.records.iter().enumerate() {
        let Ok(truth) = &truth[at] else { panic!("{:?}", truth[at]) };
        let folded = truth.geometry.folded();
        let apart = |other: &Result<streakcast::fit::measurements::Placed, DropReason>| {
            let other = other.as_ref().ok()?.geometry.observer_longitude_rad;
            Some((other - folded.observer_longitude_rad).abs().to_degrees())
        };
        rough.extend(apart(&circle[at]));
        fine.extend(apart(&osculating[at]));
        let (range_km, phase_rad) = record.sighting.distance_and_phase();
        ranges.push((truth.geometry.range_km - range_km.unwrap()).abs());
        phases.push((truth.geometry.phase_angle_rad() - phase_rad.unwrap()).abs().to_degrees());
    }
    let [rough_deg, fine_deg] = [&rough, &fine].map(|values| quantile(values, 0.9));
    println!(
        "{} rows: circle {rough_deg:.2} deg in {}, elements {fine_deg:.2} deg in {}",
        truth.len(),
        rough.len(),
        fine.len()
    );
    println!("range {:.2} km, phase {:.2} deg", quantile(&ranges, 0.5), quantile(&phases, 0.5));
    assert!(fine.len() >= rough.len() && fine.len() as f64 > 0.9 * truth.len() as f64);
    assert!(fine_deg < 4.0 && rough_deg > 2.0 * fine_deg, "{rough_deg} {fine_deg}");
    assert!(quantile(&ranges, 0.5) < 1.0 && quantile(&phases, 0.5) < 0.5);
}

#[test]
fn valid_raw_text_of_mmt9() {
    let Some(data) = crate::common::data_dir() else { return };
    let path = data.join("photometry/mmt9_raw_format/sat_21736.excerpt.txt");
    let mut reader = RecordReader::open(&[&path], &PhotometryOptions::default()).unwrap();
    let records = Records::collect(&mut reader).unwrap();
    assert_eq!(records.records.len(), 17);
    assert!(records.records.iter().all(|record| record.norad_id == Some(NoradId(64559))));
    assert_eq!(records.records.iter().filter(|record| record.in_penumbra).count(), 6);
    assert_eq!(records.groups, ["35331456"]);
    let measured = measure(&mut records.source(), &Placement::recorded(Some(600.0)), &Selection::default()).unwrap();
    assert_eq!(measured.dropped.count(DropReason::PenumbraFlag), 6);
    // StdMag = Mag - 5 log10(d / 1000 km) + 2.5 log10(1 + cos φ) is 9.048 for this row.
    let point = records.records.iter().find(|record| record.magnitude.0 == 7.59723).unwrap();
    let (range_km, phase_rad) = point.sighting.distance_and_phase();
    let standard = point.magnitude.to_standard(range_km.unwrap()).0 + 2.5 * (1.0 + phase_rad.unwrap().cos()).log10();
    // StdMag has three decimals; the rounding of the other columns of the survey is added.
    assert!((standard - 9.048).abs() < 0.004, "{standard}");
}

#[test]
fn valid_surveys_are_read_completely() {
    let Some(data) = crate::common::data_dir() else { return };
    // Number of measured rows in these files with these heights.
    for (file, height_km, format, rows, duplicates) in [
        ("photometry/pomenis/pomenis_observations.csv", None, Format::Pomenis, 920, None),
        ("photometry/slingshot_v2/Observations_in_field.csv", None, Format::Slingshot, 1232, None),
        ("derived/mmt9_oneweb.csv.gz", Some(1200.0), Format::Mmt, 57_436, None::<u64>),
    ] {
        for named in [None, Some(format)] {
            let options = PhotometryOptions { format: named, ..PhotometryOptions::default() };
            let mut reader = RecordReader::open(&[data.join(file)], &options).unwrap();
            let measured = measure(&mut reader, &Placement::recorded(height_km), &Selection::everything()).unwrap();
            println!(
                "{file}: {} points, {} groups, {:?}",
                measured.points.len(),
                measured.groups.len(),
                measured.dropped
            );
            assert_eq!(measured.points.len() as u64 + measured.dropped.total(), rows);
            assert_eq!(measured.dropped.count(DropReason::Unparsable), duplicates.unwrap_or(0));
            assert!(measured.points.len() as f64 > 0.9 * rows as f64);
        }
    }
    let path = data.join("photometry/score_format/test_data.csv");
    let options = PhotometryOptions { filters: vec!["clear".into()], ..PhotometryOptions::default() };
    let mut reader = RecordReader::open(&[path], &options).unwrap();
    let records = Records::collect(&mut reader).unwrap();
    println!("SCORE: {} rows, {:?}, dropped {:?}", records.records.len(), records.groups, records.dropped);
    assert!(records.records.len() >= 5 && records.records.iter().all(|record| record.norad_id.is_some()));
    // Positions and ranges from five Dutch frames: the geometry does not need element sets. Visual rows have no ranges.
    let measured = measure(&mut records.source(), &Placement::recorded(None), &Selection::default()).unwrap();
    assert!(
        measured.points.len() >= 2 && measured.dropped.count(DropReason::NoGeometry) >= 3,
        "{:?}",
        measured.dropped
    );
    for point in &measured.points {
        assert!((300.0..800.0).contains(&point.geometry.height_km), "{point:?}");
    }
}

#[test]
fn valid_pixels_of_visorsats() {
    let Some(data) = crate::common::data_dir() else { return };
    let records = visorsat(&data);
    let measured = measure(&mut records.source(), &Placement::recorded(Some(550.0)), &Selection::default()).unwrap();
    let options = ReduceOptions { least_count: 15, ..ReduceOptions::default() };
    let reduction = reduce(&measured.points, options).unwrap();
    let kept: Vec<_> = reduction.kept().collect();
    println!("{} points, {} pixels, {} kept", reduction.points, reduction.pixels.len(), kept.len());
    assert!(kept.len() > 50);
    // At twilight the Sun is not above the chassis. The magnitudes are those of VisorSats (mean 7.2, standard deviation
    // 0.85).
    assert!(kept.iter().all(|pixel| (-35..0).contains(&pixel.layer) && (4.0..11.0).contains(&pixel.mode_mag)));
    let table = reduction.table();
    assert_eq!(table.rows.len(), reduction.pixels.len());
}

#[test]
fn valid_stations_are_distinguished() {
    let Some(data) = crate::common::data_dir() else { return };
    let sets = history(&[data.join("derived/starlink_tle_history_2026-05-29_2026-08-21_sel.tle")]);
    // Since 2025 some shells have heights of 460 to 485 km; Direct to Cell is at 360 km.
    let stations = Stations::new(&sets, &StationRule { min_height_km: 355.0, ..StationRule::default() });
    let index = std::fs::read_to_string(data.join("derived/starlink_tle_history_sel_index.csv")).unwrap();
    // Number of element sets in each phase, for satellites that were mostly on station, raising or decaying.
    let mut tally: HashMap<&str, HashMap<&str, usize>> = HashMap::new();
    for row in index.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let norad_id = NoradId(cells[1].parse().unwrap());
        let intervals = stations.intervals(norad_id);
        assert!(intervals.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].phase != pair[1].phase));
        assert_eq!(intervals.iter().map(|one| one.element_sets).sum::<usize>(), sets.sets_of(norad_id).len());
        for interval in &intervals {
            let middle = interval.start + (interval.end - interval.start) * 0.5;
            if interval.element_sets > 3 {
                assert!(intervals.iter().any(|one| one.start <= middle && middle <= one.end));
            }
            *tally.entry(cells[0]).or_default().entry(interval.phase.name()).or_default() += interval.element_sets;
        }
        for set in sets.sets_of(norad_id) {
            let phase = stations.phase_at(norad_id, set.epoch);
            assert!(intervals.iter().any(|one| one.phase == phase && one.start <= set.epoch && set.epoch <= one.end));
        }
    }
    println!("{tally:#?}");
    let share = |group: &str, phase: OrbitPhase| {
        *tally[group].get(phase.name()).unwrap_or(&0) as f64 / tally[group].values().sum::<usize>() as f64
    };
    assert!(share("v15_onstation_cfg", OrbitPhase::OnStation) > 0.95);
    assert!(share("v2mini_onstation", OrbitPhase::OnStation) > 0.9);
    // Raising alternates with parking orbits. Decaying satellites first remain in their orbits.
    assert!(share("raising", OrbitPhase::Raising) > 3.0 * share("raising", OrbitPhase::Decaying));
    assert!(share("decaying", OrbitPhase::Decaying) > 3.0 * share("decaying", OrbitPhase::Raising));
    assert!(share("v15_onstation_cfg", OrbitPhase::Raising) + share("v15_onstation_cfg", OrbitPhase::Decaying) < 0.02);
    // Histories over years: these satellites were raised, were on station by the rule of the paper, and then decayed.
    for number in [44713, 44714, 44724] {
        let sets = history(&[data.join(format!("tle/history/starlink_{number}.txt"))]);
        let intervals = Stations::new(&sets, &StationRule::default()).intervals(NoradId(number));
        let is_on_station = |one: &&StationInterval| one.phase == OrbitPhase::OnStation;
        let longest = intervals.iter().filter(is_on_station).max_by_key(|one| one.end - one.start).unwrap();
        println!("{number}: {} intervals, longest {longest:?}", intervals.len());
        assert!((longest.end - longest.start).to_unit(hifitime::Unit::Day) > 30.0, "{number}");
        let raised = intervals.iter().position(|one| one.phase == OrbitPhase::Raising).unwrap();
        let station = intervals.iter().position(|one| one == longest).unwrap();
        assert!(raised < station, "{number} was raised after its longest time on station");
    }
}

#[test]
fn verif_sources_in_memory_and_in_files_agree() {
    let Some(data) = crate::common::data_dir() else { return };
    let records = visorsat(&data);
    let path = data.join("derived/mmt9_starlink_visorsat.csv.gz");
    let mut reader = RecordReader::open(&[path], &PhotometryOptions::default()).unwrap();
    let placement = Placement::recorded(Some(550.0));
    let streamed = measure(&mut reader, &placement, &Selection::default()).unwrap();
    let kept = measure(&mut records.source(), &placement, &Selection::default()).unwrap();
    assert_eq!(streamed, kept);
    assert_eq!(reader.groups().len(), 35);
}
