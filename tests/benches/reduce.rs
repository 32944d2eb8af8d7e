//! Reduction of two million rows of photometry, from text to geometry to pixels: time, rows per second, peak memory.
//!
//! ```text
//! cargo bench --bench reduce                  2 million simulated rows, on all threads of the pool
//! cargo bench --bench reduce -- 10            10 million
//! ```
//!
//! The rows are first simulated (also timed) and written to a temporary folder: 40 nights in a year, a shell of 1584
//! satellites, one element set per night and satellite.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use flate2::Compression;
use flate2::write::GzEncoder;
use hifitime::Epoch;
use streakcast::elements::{Constellation, History};
use streakcast::fit::measurements::{
    PhotometryOptions, Placement, RecordReader, ReduceOptions, Reducer, Selection, measure_each,
};
use streakcast::frames::seconds_after;
use streakcast::photometry::ModelLibrary;

#[path = "../common/simulated_photometry.rs"]
#[allow(dead_code)]
mod simulated_photometry;

use simulated_photometry::{SimulationOptions, simulate, write_mmt_csv};

const SHELL: &str = "[[constellation]]\nname = 'shell'\nshell = [{ altitude_km = 550, inclination_deg = 53, planes = 72, \
                     satellites_per_plane = 22, phasing = 17 }]";
/// Number of rounds of each measurement, of which the median is printed.
const ROUNDS: usize = 3;
const DAY_S: f64 = 86_400.0;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    match words.as_slice() {
        [word, folder] if word == "measure" => measure(Path::new(folder)),
        _ => make(words.iter().find_map(|word| word.parse::<u32>().ok()).unwrap_or(2)),
    }
}

/// Returns the noon before the first of forty nights in a year.
fn first_night() -> Epoch {
    "2023-01-05T12:00:00 UTC".parse().expect("an epoch")
}

/// Returns one element set per night and satellite.
fn history() -> History {
    let shell = Constellation::from_toml(SHELL).expect("a shell").remove(0);
    let nights = (0..40).map(|night| seconds_after(first_night(), (f64::from(night) * 9.0 + 0.5) * DAY_S));
    History::new(nights.flat_map(|epoch| shell.element_sets(epoch)).collect())
}

/// Simulates `millions` million rows. They are measured in another process, so that its memory is only that of the
/// reduction.
fn make(millions: u32) {
    let (history, model) = (history(), ModelLibrary::embedded().get("starlink-v1.5").expect("shipped"));
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..u64::from(millions.div_ceil(2)) {
        let mut options = SimulationOptions::mmt9(first_night(), 40);
        (options.seed, options.night_step_days, options.tracks_per_night) = (seed, 9, 315);
        let begin = Instant::now();
        let mut simulation = simulate(&model, &history, &options);
        simulation.records.groups.iter_mut().for_each(|group| group.insert_str(0, &seed.to_string()));
        println!("simulated {} rows in {:.2} s", simulation.records.records.len(), begin.elapsed().as_secs_f64());
        let path = folder.path().join(format!("mmt_{seed}.csv"));
        let mut out = BufWriter::new(File::create(&path).expect("a file"));
        write_mmt_csv(&mut out, &simulation.records).expect("written");
        drop(out);
        pack(&path);
    }
    let itself = std::env::current_exe().expect("a name");
    let status = Command::new(itself).arg("measure").arg(folder.path()).status();
    assert!(status.is_ok_and(|status| status.success()), "measuring failed");
}

fn measure(folder: &Path) {
    let history = history();
    let files = |end: &str| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|one| one == end)).collect();
        files.sort();
        files
    };
    let (plain, packed) = (files("csv"), files("gz"));
    let bytes: u64 = plain.iter().map(|path| path.metadata().expect("a file").len()).sum();
    println!("{:.0} MB of text, {} threads", bytes as f64 * 1e-6, rayon::current_num_threads());
    println!("memory before reading, with the element sets: {}", memory("VmRSS"));
    let recorded = Placement::recorded(Some(550.0));
    let elements = Placement::elements(&history);
    time("text, distance and phase", &plain, &recorded);
    time("text, element sets", &plain, &elements);
    time("gzip, distance and phase", &packed, &recorded);
}

fn time(name: &str, files: &[PathBuf], placement: &Placement) {
    let mut seconds: Vec<f64> = Vec::new();
    let (mut summary, mut rows) = (String::new(), 0);
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        let mut reader = RecordReader::open(files, &PhotometryOptions::default()).expect("files");
        let mut reducer = Reducer::new(ReduceOptions::default()).expect("options");
        let dropped = measure_each(&mut reader, placement, &Selection::default(), |points| reducer.add(points));
        let reduction = reducer.finish();
        seconds.push(begin.elapsed().as_secs_f64());
        let dropped = dropped.expect("measured");
        rows = reduction.points + dropped.total();
        let counts: Vec<String> = dropped.iter().map(|(reason, n, _)| format!("{} {n}", reason.name())).collect();
        let (pixels, kept) = (reduction.pixels.len(), reduction.kept().count());
        summary =
            format!("{} points in {pixels} pixels, {kept} kept; dropped: {}", reduction.points, counts.join(", "));
    }
    seconds.sort_by(f64::total_cmp);
    let median = seconds[ROUNDS / 2];
    println!(
        "{name}: {median:.2} s, {:.2} million rows/s, peak memory {}",
        rows as f64 * 1e-6 / median,
        memory("VmHWM")
    );
    println!("    {summary}");
}

/// Writes a gzipped copy of the file.
fn pack(path: &Path) {
    let mut out = GzEncoder::new(File::create(path.with_extension("csv.gz")).expect("a file"), Compression::fast());
    out.write_all(&std::fs::read(path).expect("a file")).expect("packed");
    out.finish().expect("packed");
}

/// Returns the peak and current memory as text, if the operating system provides them.
fn memory(what: &str) -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(what)?.strip_prefix(':'));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kilobytes.map_or_else(|| "unknown".to_owned(), |kilobytes| format!("{:.0} MB", kilobytes / 1024.0))
}
