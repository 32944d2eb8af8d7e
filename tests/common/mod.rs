//! Helpers for the integration tests, and the folder of real data with a message if it is missing.
#![allow(dead_code)]

pub mod agreement;
#[cfg(feature = "cli")]
pub mod cli;
pub mod elements;
#[cfg(all(feature = "fits", unix))]
pub mod injected;
pub mod maps;
pub mod random;
#[cfg(feature = "serve")]
pub mod server;
#[cfg(feature = "fit")]
pub mod simulated_photometry;

use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder of real data: `STREAKCAST_DATA`, otherwise `../shared/data` next to the project. It is not part of the
/// project (licences differ), so tests that need it are skipped with a message on standard error if it is missing. Call
/// this function at the start of such a test:
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
    // Written to the handle directly: output of `eprintln!` is hidden if a test passes.
    let _ = writeln!(
        std::io::stderr(),
        "\n*** SKIPPED {test}: no real data at {} (set STREAKCAST_DATA) ***\n",
        folder.display()
    );
    None
}

/// The folder of golden data and small samples of this project.
pub fn golden_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join("data")
}
