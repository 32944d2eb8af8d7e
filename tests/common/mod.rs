//! Helpers for integration tests. Tests that need real data are skipped with a message if the data folder is missing.
#![allow(dead_code)]

pub mod agreement;
pub mod elements;
pub mod maps;
pub mod mutated;
pub mod random;

use std::io::Write;
use std::path::{Path, PathBuf};

/// Returns the root of the repository. The tests of the library and those of the program are in different packages.
pub fn root() -> &'static Path {
    let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    above.find(|folder| folder.join("tests/common").is_dir()).expect("a folder with tests/common")
}

/// Returns the folder of real data: `STREAKCAST_DATA`, or else `../shared/data` next to the project. It is not part of
/// the project, because its licences differ. If it is missing, a message is printed on standard error, and the test
/// must be skipped:
///
/// ```ignore
/// let Some(data) = common::data_dir() else { return };
/// ```
pub fn data_dir() -> Option<PathBuf> {
    let folder =
        std::env::var_os("STREAKCAST_DATA").map(PathBuf::from).unwrap_or_else(|| root().join("../shared/data"));
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

/// Returns true if larger samples are tested, as by `tests/run.sh --all`: the environment variable `STREAKCAST_ALL` is
/// set.
pub fn is_all() -> bool {
    std::env::var_os("STREAKCAST_ALL").is_some()
}

/// Returns the folder of golden data and small samples of this project.
pub fn golden_dir() -> PathBuf {
    root().join("tests").join("data")
}

/// Requires that a table of `docs/tables` is current: the same words and counts. Decimal numbers may differ by two
/// units of their last digit, and percentages without decimals by one, because the last digits of fits depend on the
/// machine.
pub fn assert_is_documented(name: &str, table: &str) {
    let path = root().join("docs/tables").join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert_same(name, &text, table);
}

/// Requires that a documented text is the computed one, with the tolerances of [`assert_is_documented`].
pub fn assert_same(name: &str, text: &str, table: &str) {
    let words =
        |text: &str| text.split_whitespace().map(|word| word.trim_end_matches(',').to_owned()).collect::<Vec<_>>();
    let (all_documented, all_computed) = (words(text), words(table));
    assert_eq!(all_documented.len(), all_computed.len(), "number of words in {name}; computed:\n{table}");
    for (index, (documented, computed)) in all_documented.iter().zip(&all_computed).enumerate() {
        let difference = documented.parse::<f64>().and_then(|a| Ok((a - computed.parse::<f64>()?).abs()));
        let tolerance = match documented.split_once('.') {
            Some((_, decimals)) => 2.5 * 0.1_f64.powi(decimals.len() as i32),
            None if all_documented.get(index + 1).is_some_and(|next| next == "%") => 1.5,
            None => 0.5,
        };
        let is_same = documented == computed || difference.is_ok_and(|difference| difference < tolerance);
        assert!(is_same, "{name} has {documented}, computed {computed}:\n{table}");
    }
}
