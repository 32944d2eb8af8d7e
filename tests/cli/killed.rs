//! Commands killed at random moments: each output is whole or absent, and the inputs are unchanged.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::common::random::Random;

/// Number of runs of each command that are killed if `STREAKCAST_KILLS` is not set.
const DEFAULT_KILLS: usize = 3;

/// Returns all files of a folder except temporary ones, which the next run removes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let named = entries.map(|entry| (entry.file_name().into_string().unwrap(), entry.path()));
    named
        .filter(|(name, _)| !name.starts_with(".streakcast-"))
        .map(|(name, path)| (name, fs::read(path).unwrap()))
        .collect()
}

/// Runs a command in a folder with the files that `fill` creates, once to its end and then to random moments.
fn check(name: &str, fill: impl Fn(&Path), arguments: &str) {
    let command = |folder: &TempDir| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_streakcast"));
        command.env("STREAKCAST_NO_HOME", "1");
        command.args(arguments.split_whitespace()).current_dir(folder.path());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let complete = TempDir::new().unwrap();
    fill(complete.path());
    let inputs = files(complete.path());
    let begin = Instant::now();
    assert_eq!(command(&complete).status().unwrap().code(), Some(0), "{name}");
    let duration_s = begin.elapsed().as_secs_f64();
    let outputs = files(complete.path());
    assert!(outputs.len() > inputs.len(), "{name}");
    assert!(inputs.iter().all(|(file, bytes)| outputs.get(file) == Some(bytes)), "{name}: an input has changed");

    let kills = std::env::var("STREAKCAST_KILLS").map_or(DEFAULT_KILLS, |text| text.parse().expect("a number"));
    let mut random = Random(kills as u64);
    let mut unfinished = 0;
    for _ in 0..kills {
        let folder = TempDir::new().unwrap();
        fill(folder.path());
        let mut child = command(&folder).spawn().unwrap();
        // Whenever the signal arrives, even after the end, the outputs must be whole or absent.
        std::thread::sleep(Duration::from_secs_f64(random.between(0.0, 1.1 * duration_s)));
        let _ = child.kill();
        unfinished += usize::from(child.wait().unwrap().code().is_none());
        let found = files(folder.path());
        for (file, bytes) in &found {
            assert!(outputs.get(file) == Some(bytes), "{name}: {file} is not whole");
        }
        assert!(inputs.keys().all(|file| found.contains_key(file)), "{name}: an input is missing");
    }
    println!("{name}: {unfinished} of {kills} runs killed before their end");
}

fn copy(from: &Path, to: &Path) {
    fs::copy(from, to).unwrap();
}

fn schedule(folder: &Path) {
    copy(&crate::common::root().join("examples/night.csv"), &folder.join("night.csv"));
}

const SKY: &str = "--shells starlink-gen1 --mpc X05 --fov 3.5deg --limit-mag 6.5";

#[test]
fn verdicts_are_whole_or_absent() {
    check("flag", schedule, &format!("flag --schedule night.csv {SKY} -o flags.ecsv"));
    check("annotate", schedule, &format!("annotate --schedule night.csv {SKY} -o annotated.csv"));
}

#[cfg(unix)]
#[test]
fn frames_are_whole_or_absent() {
    let random = "--random-streaks 3 --magnitude 4,7 --exposure 30s --seeing 1.5arcsec --seed 1";
    let synthetic = crate::common::root().join("examples/synthetic.toml");
    let synthetic = |folder: &Path| copy(&synthetic, &folder.join("synthetic.toml"));
    check("inject --synthetic", synthetic, &format!("inject --synthetic synthetic.toml -o frame.fits {random}"));

    let frame = TempDir::new().unwrap();
    synthetic(frame.path());
    let made = Command::new(env!("CARGO_BIN_EXE_streakcast"))
        .env("STREAKCAST_NO_HOME", "1")
        .args(format!("inject --synthetic synthetic.toml -o frame.fits {random} -q").split_whitespace())
        .current_dir(frame.path())
        .status()
        .unwrap();
    assert!(made.success());
    let frame = frame.path().join("frame.fits");
    let fill = |folder: &Path| copy(&frame, &folder.join("frame.fits"));
    check("inject", fill, &format!("inject --image frame.fits -o streaked.fits --truth truth.csv {random}"));
}

#[test]
fn models_are_whole_or_absent() {
    let photometry = super::fit::folder();
    let fill = |folder: &Path| copy(&photometry.path().join("mmt.csv"), &folder.join("mmt.csv"));
    check(
        "fit",
        fill,
        &format!("{} --name mine --date 2026-11 --folds 0 -o mine.json --report fit.md", super::fit::FIT),
    );
}
