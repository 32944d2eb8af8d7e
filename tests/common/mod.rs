//! Helpers for integration tests. Tests that need real data are skipped with a message if the data folder is missing.
#![allow(dead_code)]

pub mod agreement;
#[cfg(feature = "cli")]
pub mod cli;
pub mod elements;
#[cfg(all(feature = "fits", unix))]
pub mod injected;
pub mod maps;
pub mod mutated;
pub mod random;
#[cfg(feature = "serve")]
pub mod server;
#[cfg(feature = "fit")]
pub mod simulated_photometry;

use std::io::Write;
use std::path::{Path, PathBuf};

/// Returns the folder of real data: `STREAKCAST_DATA`, or else `../shared/data` next to the project. It is not part of
/// the project, because its licences differ. If it is missing, a message is printed on standard error, and the test
/// must be skipped:
///
/// ```ignore
/// let Some(data) = common::data_dir() else { return };
/// ```
pub fn data_dir() -> Option<PathBuf> {
    let folder = std::env::var_os("STREAKCAST_DATA")
        .map(PathBuf::from)
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join("shared").join("data"));
    if folder.join("INDEX.md").is_file() {
        return Some(folder);
    }
    let test = std::thread::current().name().unwrap_or("a test").to_string();
    // `eprintln!` is not used, because its output is hidden if a test passes.
    let _ = writeln!(
        std::io::stderr(),
        "\n*** SKIPPED {test}: no real data at {} (set STREAKCAST_DATA) ***\n",
        folder.display()
    );
    None
}

/// Returns the folder of golden data and small samples of this project.
pub fn golden_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join("data")
}
