//! Tests of photometry without real data: golden values of the reduction, every reason to drop a row, and simulated
//! tracks with known true values.

use crate::common::agreement::Agreement;
use crate::common::mutated::Reader;
use crate::simulated_photometry::{Simulation, SimulationOptions, simulate, write_mmt_csv};
use std::collections::HashMap;
use std::io::{Cursor, Write};
use streakcast::{Error, ErrorKind};

use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;
use streakcast::elements::{Constellation, ElementSet, History, NoradId, StationRule};
use streakcast::fit::measurements::{
    ColumnMap, DensityMode, DropReason, Format, Measurement, Measurements, PhotometryOptions, Placement,
    PositionSource, RecordReader, RecordSource, Records, ReduceOptions, Selection, half_sample_mode, kernel_mode,
    kernel_sigma, measure, reduce,
};
use streakcast::frames::seconds_after;
use streakcast::geometry::{Site, ViewingGeometry};
use streakcast::math::healpix::ring_cell;
use streakcast::math::quantile::quantile;
use streakcast::photometry::{Band, BrightnessModel, ModelLibrary, StandardMagnitude};

fn golden(name: &str) -> csv::Reader<std::fs::File> {
    csv::ReaderBuilder::new().comment(Some(b'#')).from_path(crate::common::golden_dir().join(name)).unwrap()
}

#[test]
fn valid_modes_and_quartiles_against_scipy() {
    // Golden values have nine decimals; the grid for the mode of the kernel density is finer than 1e-5 mag.
    const PRINTED_MAG: f64 = 2e-9;
    const GRID_MAG: f64 = 2e-5;
    let mut compared = 0;
    let mut quartiles = Agreement::new("Quartiles and half-sample modes", "numpy, SciPy 1.17", PRINTED_MAG, "mag");
    let mut modes = Agreement::new("Modes of kernel densities", "SciPy 1.17", GRID_MAG, "mag");
    for row in golden("density_modes.csv").records() {
        let row = row.unwrap();
        let number = |at: usize| row[at].parse::<f64>().unwrap();
        let sample: Vec<f64> = row[6].split(' ').map(|value| value.parse().unwrap()).collect();
        for (at, p) in [0.25, 0.5, 0.75].into_iter().enumerate() {
            quartiles.add(quantile(&sample, p) - number(at));
        }
        quartiles.add(kernel_sigma(&sample) - number(3));
        modes.add(kernel_mode(&sample) - number(4));
        quartiles.add(half_sample_mode(&sample) - number(5));
        compared += 1;
    }
    assert_eq!(compared, 14);
}

#[test]
fn valid_cells_against_healpy() {
    let mut compared = 0;
    for row in golden("healpix_cells.csv").records() {
        let row = row.unwrap();
        let [longitude, latitude] = [1, 2].map(|at: usize| row[at].parse::<f64>().unwrap().to_radians());
        let cell = ring_cell(row[0].parse().unwrap(), longitude, latitude);
        assert_eq!(cell, Some(row[3].parse().unwrap()), "{row:?}");
        compared += 1;
    }
    assert_eq!(compared, 240);
    assert_eq!([ring_cell(0, 0.0, 0.0), ring_cell(32, f64::NAN, 0.0), ring_cell(32, 0.0, 1.6)], [None; 3]);
}

const HEADER: &str = "Date,StdMag,Mag,Filter,Penumbra,Distance,Phase,Channel,Track,NORAD\n";
const GOOD: &str = "2021-01-01 15:18:04.795000,8.167,7.18581,Clear,0,697.324,78.267,7,18903315,46056\n";

fn read(text: &str, options: &PhotometryOptions) -> Result<Records, Error> {
    let mut reader = RecordReader::from_reader("t.csv", Box::new(Cursor::new(text.to_owned())), options)?;
    Records::collect(&mut reader)
}

fn measured(text: &str, placement: &Placement, selection: &Selection) -> Measurements {
    let records = read(text, &PhotometryOptions::default()).unwrap();
    measure(&mut records.source(), placement, selection).unwrap()
}

/// See tests/library/mutated_files.rs for the other readers.
#[test]
fn mutated_photometry_is_read_or_rejected() {
    let score = "norad_cat_id,observation_time_utc,apparent_magnitude,apparent_magnitude_uncertainty,observer_latitude_deg,\
        observer_longitude_deg,observer_altitude_m,observing_filter\n46056,2024-01-02 05:03:04.5,6.1,0.1,43.65,41.43,2030,V\n";
    let pomenis = "observation_time,satellite_height,satellite_altitude,satellite_azimuth,ab_magnitude\n\
        2022-01-02T05:03:04.5,550.1,45.2,123.4,6.1\n";
    let slingshot = "sun altitude,sat altitude,sat height,measured_ab,az diff\n-20.1,45.2,550000,6.1,80.5\n";
    let seeds = [&format!("{HEADER}{GOOD}"), score, pomenis, slingshot].map(|text| text.as_bytes().to_vec());
    let read = |bytes: &[u8]| {
        let source = Box::new(Cursor::new(bytes.to_vec()));
        let records = RecordReader::from_reader("t.csv", source, &PhotometryOptions::default())
            .and_then(|mut reader| Records::collect(&mut reader));
        records.map(drop).map_err(|error| error.to_string())
    };
    Reader { name: "photometry", seeds: seeds.to_vec(), read: Box::new(read) }.check();
}

#[test]
fn verif_each_reason_is_counted_with_its_first_row() {
    let row = |from: &str, to: &str| GOOD.replace(from, to).replace("7.18581", "7.18582");
    let at_550 = Placement::recorded(Some(550.0));
    for (reason, bad, expected) in [
        (
            DropReason::Unparsable,
            row("2021-01-01 15:18:04.795000", "yesterday"),
            "Date is 'yesterday'; allowed: a time",
        ),
        (DropReason::Unparsable, row("2021-01-01", "2191-01-01"), "1957 to 2100"),
        (DropReason::Unparsable, row(",0,", ",2,"), "Penumbra is '2'; allowed: 0 or 1"),
        (DropReason::Unparsable, row("697.324", "-697"), "Distance is '-697'"),
        (DropReason::Unparsable, row("46056", "star"), "NORAD is 'star'"),
        (DropReason::Unparsable, row(GOOD.trim_end(), "2021-01-01,8.1,7.1"), "Date is '2021-01-01'; allowed: a time"),
        (DropReason::WrongFilter, row("Clear", "Pol"), "Filter is 'Pol'"),
        (DropReason::NoMagnitude, GOOD.replace("7.18581", "99.0"), "Mag is '99.0'"),
        (DropReason::NoMagnitude, GOOD.replace("7.18581", "nan"), "Mag is 'nan'"),
        (DropReason::NoMagnitude, GOOD.replace("7.18581", ""), "Mag is ''"),
        (DropReason::Duplicate, GOOD.to_owned(), ""),
        (DropReason::PenumbraFlag, row(",0,", ",1,"), ""),
        // At 550 km height, no satellite has a range of 2900 km at midnight in January.
        (DropReason::NoGeometry, row("697.324", "350.0"), ""),
        (DropReason::NoGeometry, row(",78.267,", ",,"), ""),
    ] {
        // A truncated row lacks filter and range, so that none of it is used.
        let measured = measured(&format!("{HEADER}{GOOD}{bad}"), &at_550, &Selection::default());
        if reason == DropReason::Unparsable && bad.starts_with("2021-01-01,8.1") {
            assert_eq!((measured.points.len(), measured.dropped.total()), (1, 1), "{bad}");
            continue;
        }
        assert_eq!(measured.points.len(), 1, "{bad}: {:?}", measured.dropped);
        assert_eq!((measured.dropped.count(reason), measured.dropped.total()), (1, 1), "{bad}: {:?}", measured.dropped);
        let example = measured.dropped.example(reason).unwrap();
        assert_eq!((example.file.as_str(), example.row), ("t.csv", 2), "{bad}");
        assert!(example.to_string().contains(expected), "{example}");
    }
    // A duplicate row is dropped, unless duplicates are kept.
    let table = measured(&format!("{HEADER}{GOOD}{GOOD}"), &at_550, &Selection::default()).dropped.table();
    assert_eq!(table.rows.len(), 1);
    let kept = PhotometryOptions { keep_duplicates: true, ..PhotometryOptions::default() };
    assert_eq!(read(&format!("{HEADER}{GOOD}{GOOD}"), &kept).unwrap().records.len(), 2);
}

fn shell(epoch: &str) -> Vec<ElementSet> {
    let text = "[[constellation]]\nname = 'shell'\nshell = [{ altitude_km = 550, inclination_deg = 53, planes = 12, satellites_per_plane = 10, phasing = 5 }]";
    let epoch = epoch.parse().unwrap();
    Constellation::from_toml(text).unwrap().remove(0).element_sets(epoch)
}

fn model() -> BrightnessModel {
    ModelLibrary::embedded().get("starlink-v1.5").unwrap().as_ref().clone()
}

/// Options for a night of MMT-9 without errors.
fn quiet() -> SimulationOptions {
    let first = "2023-05-20T12:00:00 UTC".parse().unwrap();
    SimulationOptions {
        tracks_per_night: 25,
        cadence_s: 2.0,
        noise_mag: 0.0,
        point_scatter_mag: 0.0,
        track_scatter_mag: 0.0,
        wrong_association_share: 0.0,
        outlier_track_share: 0.0,
        outlier_point_share: 0.0,
        ..SimulationOptions::mmt9(first, 2)
    }
}

#[test]
fn verif_reasons_that_need_element_sets() {
    let (model, options) = (model(), quiet());
    let history = History::new(shell("2023-05-20T20:00:00 UTC"));
    let Simulation { mut records, .. } = simulate(&model, &history, &options);
    records.records.truncate(200);
    let count = |records: &Records, placement: &Placement, selection: &Selection, reason: DropReason| {
        let measured = measure(&mut records.source(), placement, selection).unwrap();
        let (count, total) = (measured.dropped.count(reason), measured.points.len() as u64 + measured.dropped.total());
        assert_eq!(total, 200, "{:?}", measured.dropped);
        count
    };
    let (placement, all) = (Placement::elements(&history), Selection::default());
    let sound = measure(&mut records.source(), &placement, &all).unwrap();
    assert_eq!((sound.points.len(), sound.dropped.total()), (200, 0), "{:?}", sound.dropped);
    // There is no element set of this number.
    let mut other = records.clone();
    other.records.iter_mut().for_each(|record| record.norad_id = Some(NoradId(5)));
    assert_eq!(count(&other, &placement, &all, DropReason::NoElements), 200);
    other.records.iter_mut().for_each(|record| record.norad_id = None);
    assert_eq!(count(&other, &placement, &all, DropReason::NoElements), 200);
    let identified: HashMap<String, NoradId> = records
        .records
        .iter()
        .map(|record| (records.groups[record.group as usize].clone(), record.norad_id.unwrap()))
        .collect();
    let by_group = Placement { identified, ..Placement::elements(&history) };
    assert_eq!(measure(&mut other.source(), &by_group, &all).unwrap().points, sound.points);
    // The recorded satellite is the next one in the same plane, which is elsewhere, mostly below the horizon.
    let ids: Vec<NoradId> = history.element_sets().iter().map(|set| set.norad_id).collect();
    let next = |id: NoradId| ids[(ids.iter().position(|one| *one == id).unwrap() + 1) % ids.len()];
    other.records.iter_mut().zip(&records.records).for_each(|(other, one)| other.norad_id = one.norad_id.map(next));
    assert!(count(&other, &placement, &all, DropReason::BelowHorizon) > 0);
    let blind = Selection { least_altitude_rad: None, least_grazing_height_km: None, ..Selection::default() };
    assert_eq!(count(&other, &placement, &blind, DropReason::WrongAssociation), 200);
    let by_phase = Selection { max_range_difference_km: None, max_phase_difference_rad: Some(0.01), ..blind };
    assert!(count(&other, &placement, &by_phase, DropReason::WrongAssociation) > 190);
    // Element sets that are a month old.
    let stale = History::new(shell("2023-04-10T20:00:00 UTC"));
    assert_eq!(count(&records, &Placement::elements(&stale), &all, DropReason::StaleElements), 200);
    // The phase of the orbit is unknown from a single element set. It is on station for three equal ones, and raising
    // for three with increasing height.
    let station = Selection { station: Some(StationRule::default()), ..Selection::default() };
    assert_eq!(count(&records, &placement, &station, DropReason::OffStation), 200);
    let days =
        ["2023-05-18T20:00:00 UTC", "2023-05-19T20:00:00 UTC", "2023-05-20T20:00:00 UTC", "2023-05-21T20:00:00 UTC"];
    let steady = History::new(days.iter().flat_map(|day| shell(day)).collect());
    assert_eq!(count(&records, &Placement::elements(&steady), &station, DropReason::OffStation), 0);
    let rising = History::new(
        days.iter()
            .enumerate()
            .flat_map(|(day, at)| shell(at).into_iter().map(move |set| (day, set)))
            .map(|(day, set)| ElementSet { mean_motion_rev_day: set.mean_motion_rev_day - 1e-3 * day as f64, ..set })
            .collect(),
    );
    assert_eq!(
        count(
            &records,
            &Placement::elements(&rising),
            &Selection { station: Some(StationRule::default()), ..Selection::everything() },
            DropReason::OffStation
        ),
        200
    );
    // An element set for which SGP4 cannot be initialised.
    let broken =
        history.element_sets().iter().map(|set| ElementSet { mean_motion_rev_day: 0.0, ..set.clone() }).collect();
    let broken = History::new(broken);
    assert_eq!(count(&records, &Placement::elements(&broken), &all, DropReason::NoPosition), 200);
    // With a smallest grazing height of 3000 km instead of 100 km, all rows are in the shadow.
    let high = Selection { least_grazing_height_km: Some(3000.0), ..Selection::default() };
    assert!(count(&records, &placement, &high, DropReason::Shaded) > 150);
}

#[test]
fn verif_invalid_measurements() {
    let records = read(&format!("{HEADER}{GOOD}"), &PhotometryOptions::default()).unwrap();
    let history = History::new(Vec::new());
    let without_history = Placement { history: None, ..Placement::elements(&history) };
    let error = measure(&mut records.source(), &without_history, &Selection::default()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    let station = Selection { station: Some(StationRule::default()), ..Selection::default() };
    assert!(measure(&mut records.source(), &Placement::recorded(Some(550.0)), &station).is_err());
    let negative = Selection { max_range_difference_km: Some(-1.0), ..Selection::default() };
    assert!(measure(&mut records.source(), &Placement::recorded(Some(550.0)), &negative).is_err());
    assert!(measure(&mut records.source(), &Placement::recorded(Some(-5.0)), &Selection::default()).is_err());
    let fit = Placement {
        source: PositionSource::Elements { fit_offset_s: Some(f64::NAN) },
        ..Placement::elements(&history)
    };
    assert!(measure(&mut records.source(), &fit, &Selection::default()).is_err());
    for options in [
        ReduceOptions { nside: 0, ..ReduceOptions::default() },
        ReduceOptions { layer_width_rad: 0.0, ..ReduceOptions::default() },
        ReduceOptions { most_iqr_mag: f64::NAN, ..ReduceOptions::default() },
    ] {
        assert!(reduce(&[], options).is_err_and(|error| error.to_string().contains("; allowed: ")), "{options:?}");
    }
    assert!(reduce(&[], ReduceOptions::default()).unwrap().pixels.is_empty());
}

#[test]
fn verif_files_that_cannot_be_read() {
    let error_of = |text: &str, options: &PhotometryOptions| read(text, options).unwrap_err().to_string();
    let plain = PhotometryOptions::default();
    assert!(error_of("", &plain).contains("has no rows"));
    assert!(error_of(HEADER, &plain).contains("has no rows"));
    assert!(error_of("a,b\n1,2\n", &plain).contains("is unknown; allowed: pomenis, mmt"));
    let named = |format: Format| PhotometryOptions { format: Some(format), ..PhotometryOptions::default() };
    assert!(error_of("a,b\n1,2\n", &named(Format::Mmt)).contains("no column 'Date'"));
    assert!(error_of("a,b\n1,2\n", &named(Format::Csv)).contains("requires a column map"));
    assert!(Format::by_name("fits").unwrap_err().to_string().contains("pomenis, mmt, score, slingshot, csv"));
    assert_eq!(Format::by_name("MMT").unwrap(), Format::Mmt);
    let missing = RecordReader::open(&["no such file"], &plain).unwrap().next_chunk().unwrap_err();
    assert!(missing.to_string().starts_with("cannot read no such file"));
    let none = RecordReader::open::<&str>(&[], &plain).err().map(|error| error.to_string());
    assert_eq!(none.as_deref(), Some("no file of photometry is given; allowed: one or more"));
    // A truncated gzip file.
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(format!("{HEADER}{}", GOOD.repeat(1000)).as_bytes()).unwrap();
    let mut packed = packed.finish().unwrap();
    packed.truncate(packed.len() - 20);
    let reader = RecordReader::from_reader("cut.gz", Box::new(Cursor::new(packed)), &plain);
    let error = reader.and_then(|mut reader| Records::collect(&mut reader)).unwrap_err();
    assert!(error.to_string().starts_with("cannot read cut.gz: "), "{error}");
}

#[test]
fn verif_mixed_filters_are_rejected_unless_named() {
    let map =
        "time=t,time_scale=utc,magnitude=m,filter=f,distance=d,phase=p,latitude=43.6,longitude=41.4,site_height=2000";
    let columns = Some(ColumnMap::from_text(map).unwrap());
    let text = "t,m,f,d,p\n2021-01-01T15:18:04Z,7.1,V,700,80\n2021-01-01T15:18:05Z,7.2,B,700,80\n2021-01-01T15:18:06Z,7.3,v,700,80\n";
    let options = PhotometryOptions { columns: columns.clone(), ..PhotometryOptions::default() };
    let error = read(text, &options).unwrap_err();
    assert_eq!(
        error.to_string(),
        "t.csv data row 2: filter is 'B' after rows of filter 'V'; allowed: one filter, unless the filters are specified"
    );
    let options = PhotometryOptions { filters: vec!["V".into()], ..options };
    let records = read(text, &options).unwrap();
    assert_eq!((records.records.len(), records.dropped.count(DropReason::WrongFilter)), (2, 1));
    let both = PhotometryOptions { filters: vec!["V".into(), "b".into()], ..options };
    assert_eq!(read(text, &both).unwrap().records.len(), 3);
    let mut reader = RecordReader::from_reader("t.csv", Box::new(Cursor::new(text.to_owned())), &both).unwrap();
    Records::collect(&mut reader).unwrap();
    let filters: Vec<(Option<&str>, u64)> = reader.filters().iter().collect();
    assert_eq!(filters, [(Some("V"), 1), (Some("B"), 1), (Some("v"), 1)]);
    assert!(reader.filters().mismatch(Band::V).unwrap().to_string().starts_with("mixed filters: "));
    // MMT-9 has its own filter names. Rows with a polariser are only read if their filter is given.
    let polarised = format!("{HEADER}{GOOD}{}", GOOD.replace("Clear", "Pol"));
    assert_eq!(read(&polarised, &PhotometryOptions::default()).unwrap().dropped.count(DropReason::WrongFilter), 1);
    let named = PhotometryOptions { filters: vec!["pol".into()], ..PhotometryOptions::default() };
    assert_eq!(read(&polarised, &named).unwrap().records.len(), 1);
    // Without a filter column the filter is unknown.
    let map = ColumnMap::from_text("magnitude=m,distance=d,phase=p").unwrap();
    let options = PhotometryOptions { columns: Some(map), filters: vec!["V".into()], ..PhotometryOptions::default() };
    assert!(read(text, &options).unwrap_err().to_string().contains("no column of filters"));
}

/// In SCORE uploads made with spreadsheets, hours have no leading zero.
#[test]
fn verif_hours_of_one_digit_are_read() {
    let head = "satellite_name,norad_cat_id,observation_time_utc,apparent_magnitude,apparent_magnitude_uncertainty,\
                observer_latitude_deg,observer_longitude_deg,observer_altitude_m,observing_filter";
    let row = |time: &str| format!("S,46056,{time},6.1,0.1,43.65,41.43,2030,V\n");
    let times = ["2024-01-02 05:03:04.5", "2024-01-02 5:03:04.5", "2024-01-02T5:03:04.5Z", "2024-01-02  5:03:04.5"];
    let text = format!("{head}\n{}", times.map(row).concat());
    let records = read(&text, &PhotometryOptions { keep_duplicates: true, ..PhotometryOptions::default() }).unwrap();
    assert_eq!(records.records.len(), 4, "{:?}", records.dropped);
    assert!(records.records.iter().all(|record| record.epoch == records.records[0].epoch));
    let wrong = ["2024-01-02 :03:04", "2024-01-02 5-03-04", "2024-01-02 25:03:04", "5:03:04"].map(row).concat();
    let records = read(&format!("{head}\n{wrong}"), &PhotometryOptions::default()).unwrap();
    assert_eq!(records.dropped.count(DropReason::Unparsable), 4);
}

#[test]
fn verif_a_column_map_converts_units_and_scales() {
    let usual = measured(&format!("{HEADER}{GOOD}"), &Placement::recorded(Some(550.0)), &Selection::default());
    let site = Site::by_name("MMT-9").unwrap();
    let (latitude, longitude) = (site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees());
    let map = format!(
        "time=when,time_scale=tai,magnitude=mag,distance=metres,distance_unit=m,phase=angle,angle_unit=rad,\
         norad=id,track=of,latitude={latitude},longitude={longitude},site_height={}",
        site.height_m
    );
    let phase = 78.267_f64.to_radians();
    // TAI is 37 s ahead of UTC; the same time as a Modified Julian Date and as a Julian date in UTC.
    let tai = format!("when;mag;metres;angle;id;of\n2021-01-01T15:18:41.795;7.18581;697324.0;{phase};46056;18903315\n");
    let options = |map: &str| PhotometryOptions {
        columns: Some(ColumnMap::from_text(map).unwrap()),
        ..PhotometryOptions::default()
    };
    let days = 59_215.0 + (15.0 * 3600.0 + 18.0 * 60.0 + 4.795) / 86_400.0;
    let utc = map.replace("=tai", "=utc");
    for (map, text, tolerance_s) in [
        (&map, tai.clone(), 1e-9),
        (&utc, tai.replace("2021-01-01T15:18:41.795", &format!("{days:.12}")), 1e-5),
        (&utc, tai.replace("2021-01-01T15:18:41.795", &format!("{:.10}", days + 2_400_000.5)), 1e-4),
        (&utc, tai.replace("2021-01-01T15:18:41.795", "2021-01-01T15:18:04.795Z"), 1e-9),
    ] {
        let records = read(&text, &options(map)).unwrap();
        let same = measure(&mut records.source(), &Placement::recorded(Some(550.0)), &Selection::default()).unwrap();
        let (one, other) = (&same.points[0], &usual.points[0]);
        assert!((one.epoch.unwrap() - other.epoch.unwrap()).abs().to_seconds() < tolerance_s, "{text}");
        assert!((one.magnitude.0 - other.magnitude.0).abs() < 1e-12);
        let apart = one.geometry.observer_longitude_rad - other.geometry.observer_longitude_rad;
        assert!(apart.abs() < 1e-7, "{apart}");
        assert_eq!((one.norad_id, &same.groups), (other.norad_id, &usual.groups));
    }
    // Z means UTC, although the column mapping states TAI.
    let records = read(&tai.replace("41.795", "41.795Z"), &options(&map)).unwrap();
    assert_eq!(records.dropped.count(DropReason::Unparsable), 1);
}

#[test]
fn verif_long_files_are_read_in_chunks_without_loss() {
    let row = |i: usize| {
        GOOD.replace("04.795000", &format!("{:09.6}", (i % 600_000) as f64 * 1e-4))
            .replace("7.18581", &format!("{:.5}", 5.0 + i as f64 * 1e-5))
    };
    let rows: String = (0..120_000).map(row).collect();
    let text = format!("{HEADER}{rows}{rows}");
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(text.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    let mut reader =
        RecordReader::from_reader("long.gz", Box::new(Cursor::new(packed)), &PhotometryOptions::default()).unwrap();
    let (mut all, mut longest, mut chunks) = (Vec::new(), 0, 0);
    while let Some(chunk) = reader.next_chunk().unwrap() {
        longest = longest.max(chunk.len());
        chunks += 1;
        all.extend(chunk);
    }
    assert!(chunks > 2 && longest < 120_000, "{chunks} chunks, the longest of {longest}");
    assert_eq!(all.len(), 120_000);
    assert!(all.iter().enumerate().all(|(at, record)| record.row as usize == at + 1));
    let duplicates = reader.dropped();
    assert_eq!(duplicates.count(DropReason::Duplicate), 120_000);
    assert_eq!(duplicates.example(DropReason::Duplicate).unwrap().row, 120_001);
    assert_eq!(read(&text, &PhotometryOptions::default()).unwrap().records, all);
}

#[test]
fn verif_simulated_photometry_survives_a_file() {
    // Tolerance for rounding of times to 1 µs, ranges to 1 m, phase angles to 0.001 deg, and magnitudes to 1e-5.
    const ROUNDING_MAG: f64 = 1e-4;
    let (model, options) = (model(), quiet());
    let history = History::new(shell("2023-05-20T20:00:00 UTC"));
    let simulation = simulate(&model, &history, &options);
    assert!(simulation.records.records.len() > 1000 && simulation.truth.len() == simulation.records.groups.len());
    let mut text = Vec::new();
    write_mmt_csv(&mut text, &simulation.records).unwrap();
    let records = read(&String::from_utf8(text).unwrap(), &PhotometryOptions::default()).unwrap();
    assert_eq!((records.records.len(), records.dropped.total()), (simulation.records.records.len(), 0));
    assert_eq!(records.groups, simulation.records.groups);
    let placement = Placement::elements(&history);
    let measured = measure(&mut records.source(), &placement, &Selection::default()).unwrap();
    assert_eq!(measured.dropped.total(), 0, "{:?}", measured.dropped);
    for point in &measured.points {
        let truth = model.standard_magnitude(&point.geometry).unwrap();
        assert!((truth.0 - point.magnitude.0).abs() < ROUNDING_MAG, "{point:?} {truth}");
        assert!(point.geometry.sun_latitude_rad < 0.0);
    }
    // Geometry from range and phase angle, with the true radius from SGP4; there are two mirrored solutions.
    let by_radius = Placement {
        source: PositionSource::Recorded { radius: Some(streakcast::fit::measurements::OrbitRadius::Elements) },
        ..Placement::elements(&history)
    };
    let other = measure(&mut records.source(), &by_radius, &Selection::everything()).unwrap();
    let apart: Vec<f64> = {
        let of = |points: &[Measurement]| -> HashMap<_, ViewingGeometry> {
            points.iter().map(|p| ((p.group, format!("{:?}", p.epoch)), p.geometry.folded())).collect()
        };
        let (one, two) = (of(&measured.points), of(&other.points));
        two.iter()
            .map(|(key, g)| (g.observer_longitude_rad - one[key].observer_longitude_rad).abs().to_degrees())
            .collect()
    };
    let mut sorted = apart.clone();
    sorted.sort_by(f64::total_cmp);
    // Errors by solar parallax and rounding, which are amplified near α = 0 and π.
    assert!(quantile(&sorted, 0.9) < 0.1, "{}", quantile(&sorted, 0.9));
}

#[test]
fn verif_the_seed_determines_the_photometry_on_any_number_of_threads() {
    let model = model();
    let history = History::new(shell("2023-05-20T20:00:00 UTC"));
    let noisy = SimulationOptions {
        noise_mag: 0.1,
        point_scatter_mag: 0.2,
        track_scatter_mag: 0.1,
        wrong_association_share: 0.3,
        outlier_track_share: 0.3,
        outlier_point_share: 0.1,
        ..quiet()
    };
    let on = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| simulate(&model, &history, &SimulationOptions { seed, ..noisy.clone() }))
    };
    let one = on(1, 7);
    assert_eq!(one, on(3, 7));
    assert_ne!(one.records.records, on(2, 8).records.records);
    let wrong = one.truth.iter().filter(|track| track.norad_id != track.recorded_as).count() as f64;
    let turned = one.truth.iter().filter(|track| track.attitude_mag != 0.0).count() as f64;
    let tracks = one.truth.len() as f64;
    // 30 % of fifty tracks, within three sigma.
    assert!((wrong / tracks - 0.3).abs() < 0.2 && (turned / tracks - 0.3).abs() < 0.2, "{wrong} {turned} of {tracks}");
    // Without other errors, the differences from the model are the noise.
    let placement = Placement::elements(&history);
    let measured = measure(&mut one.records.source(), &placement, &Selection::everything()).unwrap();
    let mut residuals: Vec<f64> = measured
        .points
        .iter()
        .filter(|point| {
            let truth = one.truth[point.group as usize];
            truth.norad_id == truth.recorded_as && truth.attitude_mag == 0.0
        })
        .map(|point| point.magnitude.0 - model.standard_magnitude(&point.geometry).unwrap().0)
        .collect();
    residuals.sort_by(f64::total_cmp);
    let core = (quantile(&residuals, 0.75) - quantile(&residuals, 0.25)) / 1.349;
    // The scatter is √(0.1² + 0.2² + 0.1²) = 0.245 mag, and slightly more, because a tenth of the points differ by 1
    // mag.
    assert!((0.22..0.32).contains(&core), "{core}");
    // The result of the reduction does not depend on the number of threads.
    let options = ReduceOptions { least_count: 5, nside: 8, ..ReduceOptions::default() };
    let reduced = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| reduce(&measured.points, options).unwrap())
    };
    assert_eq!(reduced(1), reduced(3));
}

#[test]
fn verif_a_late_satellite_is_detected_by_its_ranges() {
    let (model, options) = (model(), quiet());
    let history = History::new(shell("2023-05-20T20:00:00 UTC"));
    let simulation = simulate(&model, &history, &options);
    // Element sets that are 6 s late: the same orbits with later epochs.
    let late =
        history.element_sets().iter().map(|set| ElementSet { epoch: seconds_after(set.epoch, 6.0), ..set.clone() });
    let late = History::new(late.collect());
    let with = |fit_offset_s: Option<f64>| Placement {
        source: PositionSource::Elements { fit_offset_s },
        ..Placement::elements(&late)
    };
    let worst_km = |placement: &Placement| {
        let measured = measure(&mut simulation.records.source(), placement, &Selection::everything()).unwrap();
        let ranges = measured.points.iter().zip(&simulation.records.records);
        ranges
            .map(|(point, record)| (point.geometry.range_km - record.sighting.distance_and_phase().0.unwrap()).abs())
            .fold(0.0, f64::max)
    };
    let (as_it_is, fitted) = (worst_km(&with(None)), worst_km(&with(Some(10.0))));
    // In 6 s a satellite moves by 45 km. After the fit of the time offset, the rotation of the Earth in this time
    // remains: at most 2.8 km, less in range, and partly absorbed by the fit for short tracks.
    assert!(as_it_is > 20.0 && fitted < 3.0, "{as_it_is} {fitted}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn verif_pixels_contain_their_points(
        points in prop::collection::vec((-0.6..0.0_f64, 0.0..6.2_f64, -1.5..-0.2_f64, 3.0..9.0_f64), 1..300),
    ) {
        let points: Vec<Measurement> = points
            .iter()
            .map(|&(sun, longitude, latitude, magnitude)| Measurement {
                magnitude: StandardMagnitude(magnitude),
                sigma_mag: None,
                geometry: ViewingGeometry::from_angles(sun, longitude, latitude, 900.0, 550.0).unwrap(),
                group: 0,
                norad_id: None,
                epoch: None,
                grazing_height_km: None,
                lit_fraction: 1.0,
            })
            .collect();
        let options = ReduceOptions { nside: 4, least_count: 1, mode: DensityMode::Kernel, ..ReduceOptions::default() };
        let reduction = reduce(&points, options).unwrap();
        prop_assert_eq!(reduction.points, points.len() as u64);
        prop_assert_eq!(reduction.pixels.iter().map(|pixel| pixel.count as usize).sum::<usize>(), points.len());
        for pixel in &reduction.pixels {
            let inside: Vec<&Measurement> = points
                .iter()
                .filter(|point| {
                    let g = point.geometry.folded();
                    let layer = g.sun_latitude_rad.to_degrees().floor() as i32;
                    layer == pixel.layer && ring_cell(4, g.observer_longitude_rad, g.observer_latitude_rad) == Some(pixel.cell)
                })
                .collect();
            // Rounding in the conversion of degrees may move a point at the border of a layer to the other side.
            prop_assert!(inside.len().abs_diff(pixel.count as usize) <= 1);
            prop_assert!((0.0..=std::f64::consts::PI + 1e-12).contains(&pixel.observer_longitude_rad));
            prop_assert_eq!(pixel.sun_latitude_rad.to_degrees().floor() as i32, pixel.layer);
            let magnitudes: Vec<f64> = inside.iter().map(|point| point.magnitude.0).collect();
            let [low, high] = [f64::INFINITY, f64::NEG_INFINITY].map(|start| magnitudes.iter().copied().fold(start, if start > 0.0 { f64::min } else { f64::max }));
            // Magnitudes are stored with an error of 5e-7.
            prop_assert!(pixel.mode_mag > low - 1e-6 && pixel.mode_mag < high + 1e-6);
            prop_assert!(pixel.iqr_mag >= 0.0 && pixel.iqr_mag <= high - low + 1e-6);
        }
    }
}
