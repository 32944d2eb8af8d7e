//! Rooms import from the rooms below them and nothing else: the table of ARCHITECTURE.md held against every line of `src/`.

use std::fs;
use std::path::{Path, PathBuf};

/// What each room may import of the others. Everybody may import `constants`.
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

/// Crates that only some rooms may name: one door each. Test modules may use any crate; their rooms are held all the same.
const DOORS: &[(&str, &[&str])] = &[
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

/// What the library never does by itself: print, end the process, ask the environment, the clock, the network or chance.
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

/// Words that a line of a `mod.rs` must not begin with, visibility apart: it introduces its files and defines nothing.
const DEFINITIONS: &[&str] =
    &["fn", "struct", "enum", "trait", "impl", "impl<T>", "const", "static", "type", "macro_rules!", "union"];

/// One source file, placed.
struct Source {
    /// `orbit`, `passes`, ...; `bin` for the command line; `lib` for the root.
    room: String,
    /// How many names lie between the crate's root and this module, its own included.
    depth: usize,
    is_mod: bool,
}

impl Source {
    /// From the path below `src/`.
    fn of(path: &Path) -> Self {
        let names: Vec<String> =
            path.with_extension("").components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        let is_mod = names.last().is_some_and(|name| name == "mod");
        let depth = names.len() - usize::from(is_mod);
        Self { room: names[0].clone(), depth, is_mod }
    }
}

/// The code of a line: without comments, and without what stands in quotation marks.
fn code(line: &str) -> String {
    let mut code = String::new();
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '\\' if quoted => {
                characters.next();
            }
            // A quotation mark as a character is none.
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

/// True where `word` stands in `code` with no letter, digit or underscore before it.
fn names(code: &str, word: &str) -> bool {
    code.match_indices(word)
        .any(|(at, _)| !code[..at].chars().next_back().is_some_and(|before| before.is_alphanumeric() || before == '_'))
}

/// The rooms that a line names as `crate::room` or within `crate::{...}`.
fn rooms_named(code: &str) -> Vec<String> {
    let mut rooms = Vec::new();
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
                            rooms.push(word(&group[place..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
            None => rooms.push(word(rest)),
        }
    }
    rooms
}

/// Everything wrong with one file, a line each.
fn offences(path: &Path, text: &str) -> Vec<String> {
    let source = Source::of(path);
    let mut found = Vec::new();
    let mut in_tests = false;
    // A `use crate::{` may go on over several lines: they are read as one.
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
        let mut offence = |what: String| found.push(format!("src/{}:{number}: {what}", path.display()));
        let is_library = source.room != "bin";
        if is_library && source.room != "lib" && source.room != "error" {
            let Some((_, allowed)) = MAY_IMPORT.iter().find(|(room, _)| *room == source.room) else {
                offence(format!("the room {} is not in the table", source.room));
                break;
            };
            for room in rooms_named(code) {
                let is_known = MAY_IMPORT.iter().any(|(known, _)| *known == room);
                if room != source.room && room != "constants" && !(is_known && allowed.contains(&room.as_str())) {
                    offence(format!("{} must not import {room}", source.room));
                }
            }
            let climbs = code.match_indices("super::super").count() > 0;
            let supers = (1..8).take_while(|count| code.contains(&"super::".repeat(*count))).count();
            if climbs && supers >= source.depth + usize::from(in_tests) {
                offence("climbs to the crate's root by super; say crate::room".to_owned());
            }
        }
        if is_library {
            for never in NEVER_IN_THE_LIBRARY.iter().filter(|never| names(code, never)) {
                offence(format!("{never} in the library"));
            }
        }
        for (door, rooms) in DOORS {
            let is_named = names(code, &format!("{door}::")) || names(code, &format!("use {door};"));
            if is_named && !in_tests && !code.contains(&format!("::{door}::")) && !rooms.contains(&source.room.as_str())
            {
                offence(format!("{door} outside of its door ({})", rooms.join(", ")));
            }
        }
        if source.is_mod {
            let mut words = code.split_whitespace().skip_while(|word| word.starts_with("pub"));
            if let Some(first) = words.next().filter(|first| DEFINITIONS.contains(first)) {
                offence(format!("a mod.rs defines nothing ({first})"));
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
fn verif_rooms_import_only_what_lies_below_them() {
    let src = root().join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    assert!(files.len() > 100, "only {} files found", files.len());
    let found: Vec<String> = files
        .iter()
        .flat_map(|path| {
            let text = fs::read_to_string(path).expect("a source file");
            offences(path.strip_prefix(&src).expect("below src"), &text)
        })
        .collect();
    assert!(found.is_empty(), "{} offences:\n{}", found.len(), found.join("\n"));
    // A room that went away leaves the table too.
    for (room, _) in MAY_IMPORT {
        assert!(src.join(room).is_dir() || src.join(room).with_extension("rs").is_file(), "no room {room}");
    }
}

#[test]
fn verif_imports_go_one_way() {
    for (room, allowed) in MAY_IMPORT {
        let own = MAY_IMPORT.iter().position(|(name, _)| name == room);
        for below in *allowed {
            let place = MAY_IMPORT.iter().position(|(name, _)| name == below);
            assert!(place.is_some() && place < own, "{room} imports {below}, which does not lie below it");
        }
    }
}

#[test]
fn verif_the_check_itself_can_fail() {
    let offends = |path: &str, line: &str| !offences(Path::new(path), line).is_empty();
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
        assert!(!offends(path, line), "{path}: {line}: {:?}", offences(Path::new(path), line));
    }
}
