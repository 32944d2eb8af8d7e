//! What the integration tests share: where the folder of real data is, and a loud word when it is not there.
#![allow(dead_code)]

pub mod agreement;
#[cfg(feature = "cli")]
pub mod cli;
pub mod elements;
#[cfg(feature = "fits")]
pub mod injected;
pub mod maps;
pub mod random;
#[cfg(feature = "serve")]
pub mod server;
#[cfg(feature = "fit")]
pub mod simulated_photometry;

use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder of real data: `STREAKCAST_DATA`, else `../shared/data` beside the project.
///
/// It is not part of the project (licences differ), so a test that needs it is left out where it is missing, and says
/// so loudly on standard error. Call it once at the head of such a test:
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
    // The handle itself: what goes through `eprintln!` is kept back when a test passes.
    let _ = writeln!(
        std::io::stderr(),
        "\n*** SKIPPED {test}: no real data at {} (set STREAKCAST_DATA) ***\n",
        folder.display()
    );
    None
}

/// The folder of the project's own golden numbers and small samples.
pub fn golden_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join("data")
}
