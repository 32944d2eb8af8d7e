//! Module imports: modules import only from the modules below them, and files do not import each other in a circle.
//! ARCHITECTURE.md is compared with all files of `src/`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Modules that every module may import.
const FOR_ALL: [&str; 6] = ["constants", "error", "input", "message", "units", "watch"];

/// Allowed imports of each module besides [`FOR_ALL`].
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("constants", &[]),
    ("error", &[]),
    ("input", &[]),
    ("message", &[]),
    ("units", &[]),
    ("watch", &[]),
    ("math", &[]),
    ("elements", &[]),
    ("frames", &["math"]),
    ("output", &[]),
    ("geometry", &["frames", "math"]),
    ("images", &["frames", "geometry", "math", "output"]),
    ("orbit", &["elements", "frames", "math"]),
    ("photometry", &["frames", "geometry", "math"]),
    ("passes", &["elements", "frames", "geometry", "math", "orbit", "photometry"]),
    ("maps", &["frames", "geometry", "images", "math", "output", "photometry"]),
    ("plot", &["frames", "geometry", "maps", "math", "photometry"]),
    ("fit", &["elements", "frames", "geometry", "math", "orbit", "output", "photometry"]),
    ("streaks", &["elements", "frames", "geometry", "images", "math", "orbit", "output", "passes", "photometry"]),
    (
        "measure",
        &["elements", "frames", "geometry", "images", "math", "orbit", "output", "passes", "photometry", "streaks"],
    ),
    ("learn", &["elements", "fit", "frames", "math", "output", "passes", "photometry"]),
    ("identify", &["elements", "frames", "geometry", "orbit", "output", "passes", "photometry"]),
    ("forecast", &["elements", "frames", "geometry", "orbit", "output", "passes", "photometry"]),
    ("schedule", &["elements", "frames", "geometry", "images", "math", "orbit", "output", "passes", "photometry"]),
    (
        "config",
        &[
            "elements",
            "forecast",
            "frames",
            "geometry",
            "identify",
            "images",
            "math",
            "measure",
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
    ("flate2", &["bin", "elements", "fit"]),
    ("rand", &["fit", "forecast", "images", "streaks"]),
    ("rand_chacha", &["fit", "forecast", "images", "streaks"]),
    ("rand_distr", &["fit", "images", "streaks"]),
    ("sha2", &["elements", "fit"]),
    ("saphyr", &["input"]),
    ("saphyr_parser", &["input"]),
    ("tempfile", &["output"]),
    ("rustix", &["input", "output"]),
    ("fitsio", &["images"]),
    ("fitsio_sys", &["images"]),
    ("plotters", &["plot"]),
    ("image", &["images", "plot"]),
    ("png", &["plot"]),
    ("colorous", &["plot"]),
    ("base64", &["plot"]),
    ("pulp", &["math"]),
    ("statrs", &["fit"]),
    ("pulldown_cmark", &["fit"]),
    ("strsim", &["bin", "config", "elements", "geometry", "schedule"]),
    ("clap", &["bin", "config"]),
    ("clap_complete", &["bin"]),
    ("signal_hook", &["bin"]),
    ("clap_mangen", &["bin"]),
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

/// Operations that the library must not perform: printing, ending the process, and reading the environment, the clock,
/// the network or random numbers of the system.
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

/// Functions that open a file for reading. Only `src/input/file.rs` calls them: it rejects devices and pipes, which
/// block the program or have no end, and bounds the size.
const OPEN_A_FILE: &[&str] = &["File::open(", "fs::read(", "fs::read_to_string(", "from_path(", ".read(true)"];

/// Files that may call these functions.
const MAY_OPEN: &[&str] = &[
    "input/file.rs",
    // Its own temporary files, which it also writes.
    "images/fits/tiles.rs",
    "output/atomic.rs",
];

/// Keywords that must not start a line of a `mod.rs`, apart from visibility: such a file only declares modules and
/// re-exports names.
const DEFINITIONS: &[&str] =
    &["fn", "struct", "enum", "trait", "impl", "impl<T>", "const", "static", "type", "macro_rules!", "union"];

/// Source file and its position in the module tree.
struct Source {
    /// `orbit`, `passes`, ...; `bin` for the command line program; `lib` for the root of the crate.
    module: String,
    /// Number of path segments from the root of the crate to this module, including its own name.
    depth: usize,
    is_mod: bool,
}

impl Source {
    /// Creates a source from its path relative to `src/`.
    fn of(path: &Path) -> Self {
        let names: Vec<String> =
            path.with_extension("").components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        let is_mod = names.last().is_some_and(|name| name == "mod");
        let depth = names.len() - usize::from(is_mod);
        Self { module: names[0].clone(), depth, is_mod }
    }
}

/// Returns the code of a line without comments and string literals.
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

/// Returns true if `word` occurs in `code` without a preceding letter, digit or underscore.
fn names(code: &str, word: &str) -> bool {
    code.match_indices(word)
        .any(|(at, _)| !code[..at].chars().next_back().is_some_and(|before| before.is_alphanumeric() || before == '_'))
}

/// Returns the modules named in a line as `crate::module` or within `crate::{...}`.
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

/// Returns the violations in one file, one per line.
fn violations(path: &Path, text: &str) -> Vec<String> {
    let source = Source::of(path);
    let mut found = Vec::new();
    let mut in_tests = false;
    // A `use crate::{` over several lines is joined to one line.
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
                if module != source.module
                    && !FOR_ALL.contains(&module.as_str())
                    && !(is_known && allowed.contains(&module.as_str()))
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
        let name = path.to_string_lossy().replace('\\', "/");
        if !in_tests && !MAY_OPEN.contains(&&*name) {
            for open in
                OPEN_A_FILE.iter().filter(|open| names(code, open) || open.starts_with('.') && code.contains(**open))
            {
                violation(format!("{open}...) opens a file; use input::open, input::read or input::TableRows"));
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

/// Path of names from the root of the crate, such as `["images", "fits", "hdu"]`.
type Names = Vec<String>;

/// Imports of a source file, for the search for circles.
#[derive(Default)]
struct Imports {
    path: String,
    is_mod: bool,
    /// Absolute paths of imported names.
    used: Vec<Names>,
    /// Absolute paths of re-exported names.
    exported: Vec<Names>,
}

/// Returns the paths of a `use` tree: `a::{b, c::d}` gives `a::b` and `a::c::d`.
fn leaves(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((prefix, rest)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let (mut level, mut parts) = (0, vec![String::new()]);
    for one in rest[..rest.rfind('}').unwrap_or(rest.len())].chars() {
        level += i32::from(one == '{') - i32::from(one == '}');
        match parts.last_mut() {
            Some(part) if one != ',' || level > 0 => part.push(one),
            _ => parts.push(String::new()),
        }
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| leaves(part)).map(|leaf| format!("{prefix}{leaf}")).collect()
}

/// Returns module and imports of a file. The root of the crate is `src/`, or the folder of the command line program.
fn imports(path: &Path, text: &str) -> (Names, Imports) {
    let mut module: Names =
        path.with_extension("").components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    let is_mod = module.pop_if(|name| name == "mod").is_some();
    let root = if module[0] == "bin" { &module[..2] } else { &[] };
    let (mut used, mut exported) = (Vec::new(), Vec::new());
    let text: String =
        text.lines().take_while(|line| !line.starts_with("mod tests")).map(|line| code(line) + " ").collect();
    for statement in text.split(';') {
        let words = format!(" {}", statement.split_whitespace().collect::<Vec<_>>().join(" "));
        let Some((before, tree)) = words.split_once(" use ") else { continue };
        for leaf in leaves(tree) {
            let mut names: Vec<&str> = leaf.split("::").collect();
            let supers = names.iter().take_while(|name| **name == "super").count();
            let base = match names[0] {
                "crate" => root,
                "super" => &module[..module.len().saturating_sub(supers)],
                // The path starts with a name in the same folder (in a mod.rs) or with that of another crate.
                _ => &module[..],
            };
            names.drain(..supers.max(usize::from(["crate", "self"].contains(&names[0]))));
            let names = base.iter().cloned().chain(names.into_iter().map(str::to_owned));
            let names: Names = names.collect();
            if before.ends_with("pub") || before.ends_with(')') {
                exported.push(names.clone());
            }
            used.push(names);
        }
    }
    (module, Imports { path: path.to_string_lossy().replace('\\', "/"), is_mod, used, exported })
}

/// Returns the file that defines a name, which is found through the re-exports of modules.
fn definer(files: &BTreeMap<Names, Imports>, names: &[String], depth: usize) -> Option<Names> {
    for end in (1..=names.len()).rev() {
        let Some(file) = files.get(&names[..end]) else { continue };
        let next = names.get(end).and_then(|name| file.exported.iter().find(|path| path.last() == Some(name)));
        return match next.filter(|path| depth < 9 && **path != names) {
            Some(path) => definer(files, &[path, &names[end + 1..]].concat(), depth + 1),
            None => Some(names[..end].to_vec()).filter(|_| !file.is_mod),
        };
    }
    None
}

/// Returns all files that a file imports directly or indirectly.
fn reach<'a>(below: &'a BTreeMap<&Names, BTreeSet<Names>>, from: &'a Names) -> BTreeSet<&'a Names> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(next) = open.pop() {
        open.extend(below.get(next).into_iter().flatten().filter(|one| reached.insert(*one)));
    }
    reached
}

/// Returns groups of files that import each other directly or indirectly: the strongly connected components.
fn circles(files: &BTreeMap<Names, Imports>) -> Vec<Vec<String>> {
    let below: BTreeMap<&Names, BTreeSet<Names>> = files
        .iter()
        .filter(|(_, file)| !file.is_mod)
        .map(|(module, file)| (module, file.used.iter().filter_map(|names| definer(files, names, 0)).collect()))
        .collect();
    let reached: BTreeMap<&Names, BTreeSet<&Names>> =
        below.keys().map(|module| (*module, reach(&below, module))).collect();
    let mut found = BTreeSet::new();
    for (module, all) in &reached {
        let circle = all.iter().filter(|other| reached.get(**other).is_some_and(|back| back.contains(module)));
        let circle: Vec<String> = circle.map(|other| files[*other].path.clone()).collect();
        if circle.len() > 1 {
            found.insert(circle);
        }
    }
    found.into_iter().collect()
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
    // The table must not contain modules that do not exist.
    for (module, _) in MAY_IMPORT {
        assert!(src.join(module).is_dir() || src.join(module).with_extension("rs").is_file(), "no module {module}");
    }
}

#[test]
fn verif_no_files_import_one_another_in_a_circle() {
    let src = root().join("src");
    let mut paths = Vec::new();
    rust_files(&src, &mut paths);
    let files: BTreeMap<Names, Imports> = paths
        .iter()
        .map(|path| {
            let text = fs::read_to_string(path).expect("a source file");
            imports(path.strip_prefix(&src).expect("below src"), &text)
        })
        .collect();
    let found = circles(&files);
    assert!(found.is_empty(), "files that import one another: {found:?}");
}

#[test]
fn verif_the_search_for_circles_can_fail() {
    let circles_of =
        |texts: &[(&str, &str)]| circles(&texts.iter().map(|(path, text)| imports(Path::new(path), text)).collect());
    let orbit = ("orbit/mod.rs", "mod arc;\nmod index;\npub use arc::Arc;");
    let arc = ("orbit/arc.rs", "use super::index::{Index, Other as Another};");
    for (path, text) in [
        ("orbit/index.rs", "use super::arc::Arc;"),
        ("orbit/index.rs", "use super::Arc;"),
        ("orbit/index.rs", "use crate::{frames::Epoch, orbit::{Arc, Kepler}};"),
        ("orbit/index.rs", "pub(super) use crate::{\n    orbit::Arc,\n};"),
    ] {
        assert_eq!(circles_of(&[orbit, arc, (path, text)]), [["orbit/arc.rs", "orbit/index.rs"]], "{text}");
    }
    for text in
        ["// use super::arc::Arc;", "use super::kepler::Arc;", "#[cfg(test)]\nmod tests {\n    use super::arc::Arc;\n}"]
    {
        assert!(circles_of(&[orbit, arc, ("orbit/index.rs", text)]).is_empty(), "{text}");
    }
    let three = [("a.rs", "use crate::b::B;"), ("b.rs", "use crate::c::C;"), ("c.rs", "use crate::a::A;")];
    assert_eq!(circles_of(&three), [["a.rs", "b.rs", "c.rs"]]);
    assert!(circles_of(&three[..2]).is_empty());
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
        ("streaks/light/curve.rs", "let file = File::open(path)?;"),
        ("images/fits/hdu.rs", "let file = std::fs::File::open(path)?;"),
        ("bin/streakcast/cache.rs", "let bytes = std::fs::read(path)?;"),
        ("bin/streakcast/cache.rs", "let text = fs::read_to_string(path)?;"),
        ("fit/points.rs", "let mut rows = csv::Reader::from_path(path)?;"),
        ("fit/points.rs", "let mut rows = csv::ReaderBuilder::new().from_path(path)?;"),
        ("fit/points.rs", "let file = File::options().read(true).open(path)?;"),
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
        ("input/file.rs", "let file = File::open(path)?;"),
        ("fit/points.rs", "let file = input::open(path)?; let frame = FrameFile::open(path)?;"),
        ("fit/points.rs", "let entries = std::fs::read_dir(folder)?;"),
        ("fit/points.rs", "mod tests {\n    let text = std::fs::read_to_string(path)?;\n}"),
    ] {
        assert!(!offends(path, line), "{path}: {line}: {:?}", violations(Path::new(path), line));
    }
}
