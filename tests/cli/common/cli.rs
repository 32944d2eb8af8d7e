//! Helpers for tests of the command line: run the program, and read its output.

use assert_cmd::Command;
use serde_json::Value;
use streakcast::elements::{Constellation, NoradId, Origin, format_tle};
use tempfile::TempDir;

const STREAKCAST: &str = env!("CARGO_BIN_EXE_streakcast");
/// Flags of a simulated constellation over Rubin Observatory, which needs no data files and has crossings at every
/// dusk.
pub const SKY: &[&str] = &["--shells", "starlink-gen1", "--mpc", "X05", "--quiet"];

/// Returns true if this process and therefore the programs that it starts ignore a signal, as under `nohup`. Prints
/// that the signal is skipped.
#[cfg(unix)]
pub fn is_ignored(signal: &str, number: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let set = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap_or("0");
    let is_ignored = u64::from_str_radix(set.trim(), 16).unwrap() >> (number - 1) & 1 == 1;
    if is_ignored {
        println!("*** SKIPPED {signal}: the tests were started with this signal ignored ***");
    }
    is_ignored
}

pub fn run(arguments: &[&[&str]]) -> (i32, String, String) {
    let mut program = Command::new(STREAKCAST);
    program.args(arguments.concat()).env("STREAKCAST_NO_HOME", "1").current_dir(super::root());
    let output = program.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[track_caller]
pub fn done(arguments: &[&[&str]]) -> String {
    let (code, stdout, stderr) = run(arguments);
    assert_eq!(code, 0, "{stderr}");
    stdout
}

#[track_caller]
pub fn json(arguments: &[&[&str]]) -> Value {
    serde_json::from_str(&done(&[&arguments.concat(), &["--format", "json"]])).unwrap()
}

/// Returns the header and the rows of CSV or ECSV, without the `#` lines.
pub fn records(text: &str) -> Vec<csv::StringRecord> {
    let reader = csv::ReaderBuilder::new().has_headers(false).comment(Some(b'#')).from_reader(text.as_bytes());
    reader.into_records().collect::<Result<_, _>>().unwrap()
}

pub fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).display().to_string()
}

/// Flags of the field and the magnitude limit for schedules.
pub const FLAG: &[&str] = &["--fov", "3.5deg", "--limit-mag", "6.5"];

/// First catalogue number of [`published_constellation`]. No real satellite has it or a larger one.
pub const FIRST_NORAD: usize = 90_001;

/// Writes the element sets of a simulated constellation as if they were published, with the names of Starlinks of V1.5,
/// and returns the flags that use them.
pub fn published_constellation(folder: &TempDir, epoch: &str) -> [String; 2] {
    let sets = Constellation::by_name("starlink-gen1").unwrap().element_sets(epoch.parse().unwrap());
    let mut text = String::new();
    for (number, set) in sets.iter().enumerate() {
        let mut set = set.clone();
        set.norad_id = NoradId((FIRST_NORAD + number) as u32);
        set.origin = Origin::Published;
        let [line1, line2] = format_tle(&set).unwrap();
        text += &format!("STARLINK-{}\n{line1}\n{line2}\n", 3001 + number);
    }
    let file = path(folder, "elements.tle");
    std::fs::write(&file, text).unwrap();
    ["--elements".to_owned(), file]
}
