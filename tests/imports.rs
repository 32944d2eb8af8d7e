//! Module imports: modules import only from the modules below them; the table of ARCHITECTURE.md is checked against
//! every line of `src/`.

use std::fs;
use std::path::{Path, PathBuf};

/// Allowed imports of each module. Every module may import `constants`.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("constants", &[]),
    ("math", &[]),
    ("elements", &[]),
    ("frames", &[]),
    ("output", &[]),
    ("geometry", &["frames", "math"]),
    ("images", &["frames", "math", "output"]),
    ("orbit", &["elements", "frames", "math"]),
    ("photometry", &["frames", "geometry", "math"]),
    ("passes", &["elements", "frames", "geometry", "math", "orbit", "photometry"]),
    ("maps", &["frames", "geometry", "images", "math", "output", "photometry"]),
    ("plot", &["maps", "math", "photometry"]),
    ("fit", &["elements", "frames", "geometry", "math", "orbit", "output", "photometry"]),
    ("streaks", &["elements", "frames", "geometry", "images", "math", "orbit", "output", "passes", "photometry"]),
    ("identify", &["elements", "frames", "geometry", "orbit", "output", "passes", "photometry"]),
    ("forecast", &["elements", "frames", "geometry", "orbit", "output", "passes", "photometry"]),
    ("schedule", &["elements", "frames", "geometry", "images", "orbit", "output", "passes", "photometry"]),
    (
        "config",
        &[
            "elements",
            "forecast",
            "frames",
            "geometry",
            "identify",
            "images",
            "orbit",
            "output",
            "passes",
            "photometry",
            "schedule",
            "streaks",
        ],
    ),
];

/// Crates that only the listed modules may import. Test modules may import any crate, but the module rules apply to
/// them.
const RESTRICTED_CRATES: &[(&str, &[&str])] = &[
    ("sgp4", &["elements", "orbit"]),
    ("sofars", &["frames", "geometry"]),
    ("cdshealpix", &["math"]),
    ("rusqlite", &["schedule"]),
    ("quick_xml", &["bin", "elements", "schedule"]),
    ("parquet", &["output", "schedule"]),
    ("arrow_array", &["output", "schedule"]),
    ("arrow_schema", &["output", "schedule"]),
    ("arrow_cast", &["schedule"]),
    ("arrow_select", &["schedule"]),
    ("flate2", &["elements", "fit"]),
    ("rand", &["fit", "images", "streaks"]),
    ("rand_chacha", &["fit", "images", "streaks"]),
    ("rand_distr", &["fit", "images", "streaks"]),
    ("sha2", &["elements", "fit"]),
    ("saphyr", &["schedule"]),
    ("tempfile", &["output"]),
    ("fitsio", &["images"]),
    ("fitsio_sys", &["images"]),
    ("plotters", &["plot"]),
    ("image", &["images", "plot"]),
    ("colorous", &["plot"]),
    ("base64", &["plot"]),
    ("pulp", &["math"]),
    ("statrs", &["fit"]),
    ("npyz", &["fit"]),
    ("zip", &["fit"]),
    ("pulldown_cmark", &["fit"]),
    ("strsim", &["geometry", "schedule"]),
    ("clap", &["bin", "config"]),
    ("anyhow", &["bin"]),
    ("indicatif", &["bin"]),
    ("comfy_table", &["bin"]),
    ("etcetera", &["bin"]),
    ("ureq", &["bin"]),
    ("axum", &["bin"]),
    ("hyper", &["bin"]),
    ("hyper_util", &["bin"]),
    ("tower", &["bin"]),
    ("quick_cache", &["bin"]),
    ("tokio", &["bin"]),
    ("form_urlencoded", &["bin"]),
    ("subtle", &["bin"]),
];

/// Operations that the library must not perform: printing, ending the process, reading environment, clock, network or
/// random sources.
const NEVER_IN_THE_LIBRARY: &[&str] = &[
    "println!",
    "eprintln!",
    "print!",
    "eprint!",
    "dbg!",
    "std::io::stdout",
    "std::io::stderr",
    "std::env",
    "env::var",
    "std::process",
    "SystemTime",
    "Instant::now",
    "Epoch::now",
    "std::net",
    "thread_rng",
    "rand::rng(",
    "from_os_rng",
    "StdRng",
];

/// Keywords that must not start a line of a `mod.rs` (apart from visibility): such a file declares modules and defines
/// nothing.
const DEFINITIONS: &[&str] =
    &["fn", "struct", "enum", "trait", "impl", "impl<T>", "const", "static", "type", "macro_rules!", "union"];

/// One source file and its position in the module tree.
struct Source {
    /// `orbit`, `passes`, ...; `bin` for the command line; `lib` for the root.
    module: String,
    /// Number of path segments from the crate's root to this module, including its own name.
    depth: usize,
    is_mod: bool,
}

impl Source {
    /// Creates a source from its path below `src/`.
    fn of(path: &Path) -> Self {
        let names: Vec<String> =
            path.with_extension("").components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        let is_mod = names.last().is_some_and(|name| name == "mod");
        let depth = names.len() - usize::from(is_mod);
        Self { module: names[0].clone(), depth, is_mod }
    }
}

/// Code of a line without comments and string literals.
fn code(line: &str) -> String {
    let mut code = String::new();
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '\\' if quoted => {
                characters.next();
            }
            // A quotation mark as a character literal does not start a string.
            '\'' if !quoted && characters.peek() == Some(&'"') => {
                characters.next();
                characters.next();
            }
            '"' => quoted = !quoted,
            '/' if !quoted && characters.peek() == Some(&'/') => break,
            _ if !quoted => code.push(character),
            _ => {}
        }
    }
    code
}

/// Whether `word` occurs in `code` without a preceding letter, digit or underscore.
fn names(code: &str, word: &str) -> bool {
    code.match_indices(word)
        .any(|(at, _)| !code[..at].chars().next_back().is_some_and(|before| before.is_alphanumeric() || before == '_'))
}

/// Modules named by a line as `crate::module` or within `crate::{...}`.
fn imported_modules(code: &str) -> Vec<String> {
    let mut modules = Vec::new();
    for (at, prefix) in code.match_indices("crate::") {
        let rest = &code[at + prefix.len()..];
        let word = |text: &str| -> String {
            text.trim_start().chars().take_while(|one| one.is_alphanumeric() || *one == '_').collect()
        };
        match rest.strip_prefix('{') {
            Some(group) => {
                let mut level = 0;
                let mut start = true;
                for (place, one) in group.char_indices() {
                    match one {
                        '{' => level += 1,
                        '}' if level == 0 => break,
                        '}' => level -= 1,
                        ',' if level == 0 => start = true,
                        _ if start && !one.is_whitespace() => {
                            modules.push(word(&group[place..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
            None => modules.push(word(rest)),
        }
    }
    modules
}

/// Returns all violations in one file, one line each.
fn violations(path: &Path, text: &str) -> Vec<String> {
    let source = Source::of(path);
    let mut found = Vec::new();
    let mut in_tests = false;
    // A `use crate::{` over several lines is read as one line.
    let mut lines: Vec<(usize, String)> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let code = code(line);
        match lines.last_mut() {
            Some((_, open)) if open.contains("use ") && open.matches('{').count() > open.matches('}').count() => {
                open.push_str(&code);
            }
            _ => lines.push((number + 1, code)),
        }
    }
    for (number, code) in &lines {
        in_tests |= code.starts_with("mod tests");
        let mut violation = |what: String| found.push(format!("src/{}:{number}: {what}", path.display()));
        let is_library = source.module != "bin";
        if is_library && source.module != "lib" && source.module != "error" {
            let Some((_, allowed)) = MAY_IMPORT.iter().find(|(module, _)| *module == source.module) else {
                violation(format!("the module {} is not in the table", source.module));
                break;
            };
            for module in imported_modules(code) {
                let is_known = MAY_IMPORT.iter().any(|(known, _)| *known == module);
                if module != source.module && module != "constants" && !(is_known && allowed.contains(&module.as_str()))
                {
                    violation(format!("{} must not import {module}", source.module));
                }
            }
            let climbs = code.match_indices("super::super").count() > 0;
            let supers = (1..8).take_while(|count| code.contains(&"super::".repeat(*count))).count();
            if climbs && supers >= source.depth + usize::from(in_tests) {
                violation("reaches the crate's root by super; use crate::module".to_owned());
            }
        }
        if is_library {
            for never in NEVER_IN_THE_LIBRARY.iter().filter(|never| names(code, never)) {
                violation(format!("{never} in the library"));
            }
        }
        for (restricted, modules) in RESTRICTED_CRATES {
            let is_named = names(code, &format!("{restricted}::")) || names(code, &format!("use {restricted};"));
            if is_named
                && !in_tests
                && !code.contains(&format!("::{restricted}::"))
                && !modules.contains(&source.module.as_str())
            {
                violation(format!("{restricted} imported outside of its modules ({})", modules.join(", ")));
            }
        }
        if source.is_mod {
            let mut words = code.split_whitespace().skip_while(|word| word.starts_with("pub"));
            if let Some(first) = words.next().filter(|first| DEFINITIONS.contains(first)) {
                violation(format!("a mod.rs defines nothing ({first})"));
            }
        }
    }
    found
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("src is there") {
        let path = entry.expect("an entry of src").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn verif_modules_import_only_from_modules_below_them() {
    let src = root().join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    assert!(files.len() > 100, "only {} files found", files.len());
    let found: Vec<String> = files
        .iter()
        .flat_map(|path| {
            let text = fs::read_to_string(path).expect("a source file");
            violations(path.strip_prefix(&src).expect("below src"), &text)
        })
        .collect();
    assert!(found.is_empty(), "{} violations:\n{}", found.len(), found.join("\n"));
    // The table must not name modules that no longer exist.
    for (module, _) in MAY_IMPORT {
        assert!(src.join(module).is_dir() || src.join(module).with_extension("rs").is_file(), "no module {module}");
    }
}

#[test]
fn verif_imports_go_one_way() {
    for (module, allowed) in MAY_IMPORT {
        let own = MAY_IMPORT.iter().position(|(name, _)| name == module);
        for below in *allowed {
            let place = MAY_IMPORT.iter().position(|(name, _)| name == below);
            assert!(place.is_some() && place < own, "{module} imports {below}, which is not below it");
        }
    }
}

#[test]
fn verif_the_check_itself_can_fail() {
    let offends = |path: &str, line: &str| !violations(Path::new(path), line).is_empty();
    for (path, line) in [
        ("photometry/band.rs", "use crate::orbit::Propagator;"),
        ("photometry/band.rs", "    let x = crate::passes::Sky::new();"),
        ("frames/time.rs", "use crate::{constants::DAY_S, elements::ElementSet};"),
        ("frames/time.rs", "use crate::{\n    constants::DAY_S,\n    elements::ElementSet,\n};"),
        ("photometry/brdf/law.rs", "use super::super::super::orbit::Propagator;"),
        ("photometry/band.rs", "use super::super::orbit::Propagator;"),
        ("passes/sky.rs", "use crate::schedule::Policy;"),
        ("passes/sky.rs", "use sgp4::Constants;"),
        ("passes/sky.rs", "let x = rusqlite::Connection::open(path);"),
        ("orbit/arc.rs", "println!(\"here\");"),
        ("orbit/arc.rs", "let now = std::time::SystemTime::now();"),
        ("orbit/arc.rs", "use std::env;"),
        ("schedule/policy.rs", "use clap::Parser;"),
        ("orbit/arc.rs", "use rand::RngExt;"),
        ("fit/measurements/simulate.rs", "let mut random = rand::rng();"),
        ("fit/measurements/simulate.rs", "let random = rand::rngs::StdRng::seed_from_u64(1);"),
        ("orbit/mod.rs", "pub fn helper() {}"),
        ("orbit/mod.rs", "pub(crate) const X: f64 = 1.0;"),
        ("newroom/file.rs", "use crate::frames::Epoch;"),
    ] {
        assert!(offends(path, line), "{path}: {line}");
    }
    for (path, line) in [
        ("photometry/band.rs", "// use crate::orbit::Propagator;"),
        ("photometry/band.rs", "use crate::geometry::ViewingGeometry;"),
        ("photometry/brdf/law.rs", "use super::super::panel::Panel;"),
        ("passes/sky.rs", "let text = \"sgp4::Constants and println!\";"),
        ("schedule/formats/opsim.rs", "use rusqlite::Connection;"),
        ("bin/streakcast/main.rs", "println!(\"{}\", anyhow::anyhow!(\"x\"));"),
        ("orbit/mod.rs", "pub use arc::Arc;"),
        ("fit/measurements/simulate.rs", "use rand_chacha::ChaCha8Rng;"),
        ("config/document.rs", "use crate::{frames::EopTable, schedule::Policy};"),
    ] {
        assert!(!offends(path, line), "{path}: {line}: {:?}", violations(Path::new(path), line));
    }
}
