//! Two million rows of photometry: text to geometry to pixels, time, rows a second and the greatest memory.
//!
//! ```text
//! cargo bench --bench reduce                  2 million simulated rows, on all threads of the pool
//! cargo bench --bench reduce -- 10            10 million
//! ```
//!
//! The rows are simulated first (timed too) and written to a temporary folder; 40 nights over a year, a shell of 1584 satellites, one
//! element set a night and satellite.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use flate2::Compression;
use flate2::write::GzEncoder;
use streakcast::catalogue::{Constellation, History};
use streakcast::frames::seconds_after;
use streakcast::measured::{
    Placement, ReadOptions, RecordReader, ReduceOptions, Reducer, Selection, SimulationOptions, measure_each, simulate,
    write_mmt_csv,
};
use streakcast::photometry::ModelLibrary;

const SHELL: &str = "[[constellation]]\nname = 'shell'\nshell = [{ altitude_km = 550, inclination_deg = 53, planes = 72, \
                     satellites_per_plane = 22, phasing = 17 }]";
/// Rounds of each measurement; the median is told.
const ROUNDS: usize = 3;
const DAY_S: f64 = 86_400.0;

fn main() {
    let millions = std::env::args().skip(1).find_map(|word| word.parse::<u32>().ok()).unwrap_or(2);
    let shell = Constellation::from_toml(SHELL).expect("a shell").remove(0);
    let model = ModelLibrary::embedded().get("starlink-v1.5").expect("shipped");
    let first = "2023-01-05T12:00:00 UTC".parse().expect("an epoch");
    let nights = (0..40).map(|night| seconds_after(first, (f64::from(night) * 9.0 + 0.5) * DAY_S));
    let history = History::new(nights.flat_map(|epoch| shell.element_sets(epoch)).collect());
    let folder = tempfile::tempdir().expect("a folder");
    let mut rows = 0;
    let mut files = Vec::new();
    let start = Instant::now();
    for seed in 0..u64::from(millions.div_ceil(2)) {
        let mut options = SimulationOptions::mmt9(first, 40).expect("MMT-9");
        (options.seed, options.night_step_days) = (seed, 9);
        let begin = Instant::now();
        let mut simulation = simulate(&model, &history, &options).expect("photometry");
        simulation.records.groups.iter_mut().for_each(|group| group.insert_str(0, &seed.to_string()));
        let points = simulation.records.records.len();
        println!("simulated {points} rows in {:.2} s", begin.elapsed().as_secs_f64());
        rows += points;
        let path = folder.path().join(format!("mmt_{seed}.csv"));
        let mut out = BufWriter::new(File::create(&path).expect("a file"));
        write_mmt_csv(&mut out, &simulation.records).expect("written");
        files.push(path);
    }
    let bytes: u64 = files.iter().map(|path| path.metadata().expect("a file").len()).sum();
    println!("{rows} rows, {:.0} MB of text, made in {:.1} s", bytes as f64 * 1e-6, start.elapsed().as_secs_f64());
    println!("{} threads", rayon::current_num_threads());
    println!("memory before reading, with the element sets: {}", memory("VmRSS"));
    reset_peak();
    let recorded = Placement::recorded(Some(550.0));
    let elements = Placement::elements(&history);
    time("text, distance and phase", &files, rows, &recorded);
    time("text, element sets", &files, rows, &elements);
    let packed: Vec<PathBuf> = files.iter().map(|path| pack(path)).collect();
    time("gzip, distance and phase", &packed, rows, &recorded);
}

fn time(name: &str, files: &[PathBuf], rows: usize, placement: &Placement) {
    let mut seconds: Vec<f64> = Vec::new();
    let mut told = String::new();
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        let mut reader = RecordReader::open(files, &ReadOptions::default()).expect("files");
        let mut reducer = Reducer::new(ReduceOptions::default()).expect("options");
        let dropped = measure_each(&mut reader, placement, &Selection::default(), |points| reducer.add(points));
        let reduction = reducer.finish();
        seconds.push(begin.elapsed().as_secs_f64());
        let counts: Vec<String> =
            dropped.expect("measured").iter().map(|(reason, n, _)| format!("{} {n}", reason.name())).collect();
        let (pixels, kept) = (reduction.pixels.len(), reduction.kept().count());
        told = format!("{} points in {pixels} pixels, {kept} kept; dropped: {}", reduction.points, counts.join(", "));
    }
    seconds.sort_by(f64::total_cmp);
    let median = seconds[ROUNDS / 2];
    println!(
        "{name}: {median:.2} s, {:.2} million rows/s, peak memory {}",
        rows as f64 * 1e-6 / median,
        memory("VmHWM")
    );
    println!("    {told}");
}

fn pack(path: &Path) -> PathBuf {
    let packed = path.with_extension("csv.gz");
    let mut out = GzEncoder::new(File::create(&packed).expect("a file"), Compression::fast());
    out.write_all(&std::fs::read(path).expect("a file")).expect("packed");
    out.finish().expect("packed");
    packed
}

/// Peak or present memory, where the system tells.
fn memory(what: &str) -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(what)?.strip_prefix(':'));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kilobytes.map_or_else(|| "unknown".to_owned(), |kilobytes| format!("{:.0} MB", kilobytes / 1024.0))
}

/// Simulating takes memory too; Linux forgets the peak where it is asked to.
fn reset_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
