//! Readers of files: mutated copies of valid files give an error or are accepted; nothing panics.
//!
//! `STREAKCAST_MUTATIONS=1000000 cargo test --release --test library mutated_files` reads a million
//! files per reader.

use std::fs;
use std::path::Path;

use streakcast::config::Config;
use streakcast::elements::{Constellation, Generation, ReadOptions, Satellites};
use streakcast::frames::EopTable;
use streakcast::images::{Detector, ExposureTime, Header, OUTLINES, PixelPosition, Telescope, Wcs, parse_regions};
use streakcast::learn::read_delays;
use streakcast::passes::{Field, LearnedFile, LearnedKind, LearnedLateness};
use streakcast::photometry::{BrightnessModel, StandardMagnitudes};
use streakcast::schedule::{Policy, Schedule, ScheduleOptions, read_targets};

use crate::common::golden_dir;
use crate::common::mutated::Reader;
use streakcast::Error;

/// Returns the files of a folder, relative to the project.
fn files(folder: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
        .iter()
        .filter(|path| path.extension().is_none_or(|end| end != "md"))
        .map(|path| fs::read(path).unwrap())
        .collect()
}

fn file(path: &str) -> Vec<u8> {
    fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// Returns a function that reads text. Readers of text get it from a function that replaces invalid UTF-8 or rejects
/// it.
fn of_text<T, E: std::fmt::Display>(
    read: impl Fn(&str) -> Result<T, E> + Sync,
) -> impl Fn(&[u8]) -> Result<(), String> {
    move |bytes| read(&String::from_utf8_lossy(bytes)).map(drop).map_err(|error| error.to_string())
}

/// Returns a function that writes bytes to a file and reads it.
fn of_path<T, E: std::fmt::Display>(
    read: impl Fn(&Path) -> Result<T, E> + Sync,
) -> impl Fn(&[u8]) -> Result<(), String> {
    move |bytes| {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        fs::write(file.path(), bytes).expect("written");
        read(file.path()).map(drop).map_err(|error| error.to_string())
    }
}

fn reader<'a>(
    name: &'static str,
    seeds: Vec<Vec<u8>>,
    read: impl Fn(&[u8]) -> Result<(), String> + Sync + 'a,
) -> Reader<'a> {
    Reader { name, seeds, read: Box::new(read) }
}

#[test]
fn element_sets() {
    let options = ReadOptions { accept_bad_checksums: true, ..ReadOptions::default() };
    let read = |bytes: &[u8]| Satellites::from_bytes("t", bytes, &options).map(drop).map_err(|error| error.to_string());
    reader("element sets", files("tests/data/elements"), read).check();
}

#[test]
fn ephemerides() {
    let read = |bytes: &[u8]| {
        Satellites::from_bytes("t", bytes, &ReadOptions::default()).map(drop).map_err(|error| error.to_string())
    };
    let names = ["invented.oem", "invented_itrf.xml"];
    let seeds = names.map(|name| fs::read(golden_dir().join("ephemerides").join(name)).unwrap());
    reader("ephemerides", seeds.to_vec(), read).check();
}

#[test]
fn schedules_and_targets() {
    let options =
        ScheduleOptions { time_scale: None, default_time_scale: Some(hifitime::TimeScale::UTC), ..Default::default() };
    let mut seeds = files("tests/data/schedules");
    seeds.push(file("examples/night.csv"));
    reader("schedules", seeds, of_path(|path| Schedule::read(path, &options))).check();
    let targets =
        b"name,ra_deg,dec_deg,exposure_s,band\nM 31,10.68,41.27,30,g\nvega,18h36m56s,+38d47m01s,,r\n".to_vec();
    reader("targets", vec![targets], of_path(|path| read_targets(path, Some(30.0), 0.0))).check();
}

#[cfg(feature = "sqlite")]
#[test]
fn databases() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("opsim.db");
    let database = rusqlite::Connection::open(&path).unwrap();
    database
        .execute_batch(
            "CREATE TABLE observations (observationId INTEGER, observationStartMJD REAL, visitExposureTime REAL, \
             fieldRA REAL, fieldDec REAL, rotSkyPos REAL, band TEXT); \
             INSERT INTO observations VALUES (1, 60900.1, 30.0, 10.0, -20.0, 5.0, 'g'), (2, 60900.2, 30.0, 11.0, -21.0, 6.0, 'r');",
        )
        .unwrap();
    drop(database);
    let options = ScheduleOptions { time_scale: Some(hifitime::TimeScale::UTC), ..ScheduleOptions::default() };
    let seed = fs::read(&path).unwrap();
    reader("databases", vec![seed], of_path(|path| Schedule::read(path, &options))).check();
}

#[test]
fn settings() {
    let config =
        b"shells = ['starlink-gen1']\nmpc = 'X05'\nfov = '3.5deg'\nlimit_mag = 7\n[policy]\nmargin_s = 3\n".to_vec();
    let full = |text: &str| {
        let config = Config::from_toml(text, "t").map_err(|error| error.to_string())?;
        config.observation().map(drop).map_err(|error| error.to_string())
    };
    reader("configurations", vec![config], of_text(full)).check();
    reader("policies", vec![file("examples/policy.toml")], of_text(Policy::from_toml)).check();
    reader("fields", vec![file("examples/field.json")], of_text(Field::from_json)).check();
    reader("telescopes", files("src/images/telescope/presets"), of_text(|text| Telescope::from_toml(text, "t")))
        .check();
    let detector =
        b"gain_e_adu = 1.5\nread_noise_e = 6.0\nbias_adu = 200.0\nquantisation = { greatest_adu = 65535.0 }\n";
    reader("detectors", vec![detector.to_vec()], of_text(Detector::from_toml)).check();
    let shells = b"[[constellation]]\nname = 'c'\nsource = 's'\n[[constellation.shell]]\naltitude_km = 550.0\n\
        inclination_deg = 53.0\nplanes = 72\nsatellites_per_plane = 22\nphasing = 17\n";
    reader("constellations", vec![shells.to_vec()], of_text(Constellation::from_toml)).check();
    #[cfg(all(feature = "fits", unix))]
    {
        let read = of_text(|text| streakcast::streaks::SyntheticFrame::from_toml(text, "t"));
        reader("synthetic frames", vec![file("examples/synthetic.toml")], read).check();
    }
}

#[test]
fn models_and_measurements() {
    let models: Vec<_> =
        files("src/photometry/models").into_iter().filter(|text| !text.starts_with(b"{\n  \"$schema\"")).collect();
    reader("models", models, of_text(|text| BrightnessModel::from_json(text, "t"))).check();
    let qs_mag = b"25544   98 67A    ISS            -2.0              348\n".to_vec();
    reader("standard magnitudes", vec![qs_mag], of_text(StandardMagnitudes::from_qs_mag)).check();
    let delays =
        b"# of streakcast measure\nnorad_id,late_s,late_sigma_s,late_expected_sigma_s\n44714,0.5,0.1,1.2\n44715,,,\n";
    reader("measured delays", vec![delays.to_vec()], of_path(read_delays)).check();
    let dates = ["2026-01-01T00:00:00Z", "2026-01-03T00:00:00Z"].map(str::to_owned);
    let lateness = LearnedLateness { measurements: 7, factor: 1.1, relative_sigma: 0.2 };
    let kind = LearnedKind { kind: Generation::OneWeb, magnitude: None, lateness: Some(lateness) };
    let learned = LearnedFile::new(serde_json::Map::new(), dates, vec![kind], vec![]).to_json();
    reader("learned files", vec![learned.into_bytes()], of_text(|text| LearnedFile::from_json(text, "t"))).check();
}

#[test]
fn headers_and_regions() {
    let read = |text: &str| {
        let header = Header::from_text(text);
        // Headers of world coordinates have no exposure time: an error is accepted as well as a time.
        let _ = ExposureTime::from_headers(&[&header]);
        let wcs = Wcs::from_header(&header)?;
        // A mutated projection may have no position there.
        let _ = wcs.to_sky(PixelPosition { x: 10.0, y: 20.0 }).and_then(|direction| wcs.to_pixel(direction));
        Ok::<_, Error>(wcs.cards())
    };
    reader("world coordinates", files("tests/data/wcs"), of_text(read)).check();
    let regions =
        b"# Region file format: DS9\nfk5\nline(10.1,20.2,10.3,20.4) # text={s}\nbox 232 9 20\" 2\' 30\n".to_vec();
    reader("regions", vec![regions], of_text(|text| parse_regions("t", text, OUTLINES))).check();
}

#[test]
fn earth_orientation() {
    // Columns as in the ReadMe of the IERS; the numbers are invented.
    let text = "\
161231 57753.00 I  0.072600 0.000091  0.264600 0.000091  I-0.4080000 0.0000100  0.0000 0.0000
17 1 1 57754.00 I  0.070600 0.000091  0.265600 0.000091  I 0.5908000 0.0000100  0.0000 0.0000
17 1 2 57755.00 P  0.068600 0.000091  0.266600 0.000091  P 0.5896000 0.0000100  0.0000 0.0000\n";
    reader("Earth orientation", vec![text.as_bytes().to_vec()], of_text(EopTable::from_finals2000a)).check();
}
