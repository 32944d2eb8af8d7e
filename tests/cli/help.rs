//! Help of the verbs, their examples, and errors for missing inputs.

use std::path::Path;

use assert_cmd::Command;

const STREAKCAST: &str = env!("CARGO_BIN_EXE_streakcast");

fn run(arguments: &[&str], folder: &Path) -> (i32, String, String) {
    let output = Command::new(STREAKCAST).args(arguments).current_dir(folder).envs(home(folder)).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Returns the environment of a user without files; `setup` writes into this folder.
fn home(folder: &Path) -> [(&'static str, &Path); 3] {
    ["HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"].map(|name| (name, folder))
}

fn help(verb: &[&str]) -> String {
    let (code, help, stderr) = run(&[verb, &["--help"]].concat(), Path::new("."));
    assert_eq!(code, 0, "{stderr}");
    help
}

/// Returns the subcommands in a help text, without `help`.
fn subcommands(help: &str) -> Vec<&str> {
    let Some((_, list)) = help.split_once("\nCommands:\n") else { return Vec::new() };
    // Lines with a deeper indentation continue a description.
    let lines = list.lines().take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
    lines.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect()
}

/// Returns the help of all verbs and their subcommands.
fn all_help() -> Vec<String> {
    let mut all = Vec::new();
    for verb in subcommands(&help(&[])) {
        let text = help(&[verb]);
        all.extend(subcommands(&text).into_iter().map(|inner| help(&[verb, inner])));
        all.push(text);
    }
    all
}

fn examples(help: &str) -> Vec<&str> {
    let (_, list) = help.split_once("\nExamples:\n").unwrap_or_else(|| panic!("no examples: {help}"));
    list.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

/// Every example is complete: it runs, or fails only because a file of the example is missing here.
#[test]
fn every_verb_has_two_working_examples() {
    let mut completed = 0;
    for help in all_help() {
        let examples = examples(&help);
        assert_eq!(examples.len(), 2, "{help}");
        for example in examples {
            let mut words: Vec<&str> = example.split_whitespace().collect();
            assert_eq!(words.remove(0), "streakcast", "{example}");
            // Verbs that use the network or take a long time are run with an invalid value, which is checked after all
            // flags are parsed.
            let end = match words[..words.len().min(2)] {
                ["fetch", _] => Some((["--timeout", "0s"], "timeout is 0 s; allowed")),
                ["reproduce", _] | ["map", "paper"] => Some((["--threads", "0"], "threads is 0; allowed")),
                _ => None,
            };
            words.extend(end.iter().flat_map(|(flag, _)| flag));
            let folder = tempfile::tempdir().unwrap();
            let (code, stdout, stderr) = run(&words, folder.path());
            match (code, end) {
                (0 | 1, _) => completed += 1,
                (_, Some((_, error))) => assert!(stderr.contains(error), "{example}: {stderr}"),
                (_, None) => {
                    // The default port of serve may be in use.
                    let is_complete =
                        (stdout + &stderr).contains("No such file") || stderr.contains("Address already in use");
                    assert!(is_complete, "{example}: {stderr}");
                }
            }
        }
    }
    assert!(completed >= 20, "{completed}");
}

#[test]
fn required_flags_are_marked() {
    let text = help(&["passes"]);
    for part in [
        "Usage: streakcast passes --start <TIME> --exposure <TIME>\n",
        "(--target <NAME> | --ra <ANGLE> --dec <ANGLE>)",
        "(--elements <FILE>... | --shells <NAME>...)",
        "(--site <NAME> | --mpc <CODE> | --lat <DEG> --lon <DEG>)",
        "(--fov <ANGLE> | --field <FILE> | --telescope <NAME>)",
        "for example 30s or 2min (required)\n",
        "Satellites (required: --elements or --shells):\n",
        "Site (required: --site, --mpc, or --lat and --lon):\n",
        "Camera (required: --fov, --field or --telescope):\n",
    ] {
        assert!(text.contains(part), "'{part}' is not in: {text}");
    }
    assert!(help(&["map", "sky"]).contains("negative below the horizon) (required)\n"));
    assert!(help(&["windows"]).contains("for example 2024-08-14; tonight if omitted\n"));
    assert!(help(&["windows"]).contains("(--targets <FILE> | --target <NAME> | --ra <ANGLE> --dec <ANGLE>)\n"));
    assert!(!help(&["doctor"]).contains("required"));
    assert!(!help(&["serve"]).contains("any target (required)"));
}

/// Flags of a camera are not listed for verbs without a camera, or whose field is the frame.
#[test]
fn rejected_flags_are_not_listed() {
    for verb in ["forecast", "ephemeris", "identify", "measure", "inject", "statistics"] {
        let text = help(&[verb]);
        assert!(!text.contains("--rotation") && !text.contains("--min-probability"), "{text}");
    }
    assert!(help(&["statistics"]).contains("--fov") && help(&["inject"]).contains("--telescope"));
    assert!(!help(&["forecast"]).contains("--observer-norad") && help(&["passes"]).contains("--observer-norad"));
    assert!(help(&["flag"]).contains("--rotation"));
    assert!(!help(&["mask"]).contains("--rotation") && help(&["mask"]).contains("--min-probability"));
}

/// A flag that a verb ignores is an error, but not the key of a configuration file, which is for other verbs.
#[test]
fn ignored_flags_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("obs.toml"), "fov = '1deg'\nshells = 'oneweb'\nmpc = 'X05'\n").unwrap();
    let (code, _, stderr) = run(&["forecast", "--night", "2024-08-14", "--fov", "1deg"], folder.path());
    let error = "error: --fov has no effect on passes over a site; allowed: the command without it\n";
    assert_eq!((code, stderr.as_str()), (2, error));
    let span = ["--start", "2024-08-14T00:00:00Z", "--end", "2024-08-14T00:01:00Z", "--config", "obs.toml"];
    let (code, _, stderr) = run(&[&["forecast"], &span[..]].concat(), folder.path());
    assert!(code < 2, "{stderr}");
}

/// Checks that one error lists all of these inputs.
#[track_caller]
fn misses(arguments: &str, inputs: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let (code, stdout, stderr) = run(&arguments, folder.path());
    assert_eq!((code, stdout.as_str(), stderr.lines().count()), (2, "", 1), "{stderr}");
    assert!(stderr.starts_with("error: missing"), "{stderr}");
    for input in inputs {
        assert!(stderr.contains(input), "'{input}' is not in: {stderr}");
    }
}

#[test]
fn all_missing_inputs_are_in_one_error() {
    let sky = ["satellites (--elements FILE or --shells NAME", "site (--site NAME, --mpc CODE, or --lat and --lon)"];
    let field = "field of view (--fov ANGLE, --field FILE or --telescope NAME)";
    let exposure =
        ["start of the exposure (--start TIME", "exposure time (--exposure TIME", "pointing (--target NAME, or "];
    misses("passes", &[&sky[..], &[field], &exposure].concat());
    misses("passes --mpc X05 --shells oneweb --start 2024-08-14T03:30:00Z", &[field, exposure[1], exposure[2]]);
    misses("flag", &[&sky[..], &[field, "schedule (--schedule FILE)"]].concat());
    misses("serve", &[&sky[..], &[field]].concat());
    misses("annotate", &[&sky[..], &[field, "schedule (--schedule FILE)", "output file (-o FILE)"]].concat());
    let targets = "targets (--targets FILE, --target NAME, or --ra and --dec)";
    misses("windows", &[&sky[..], &[field, targets]].concat());
    misses("forecast", &sky);
    misses(
        "ephemeris",
        &[&sky[..], &["selection of satellites (--norad ID", "times (--times TIME, --times-file FILE, or "]].concat(),
    );
    misses("statistics", &[&sky[..], &["night (--night DATE)"]].concat());
    misses("gate", &[&sky[..], &[field, "pointing (--ra and --dec", exposure[1]]].concat());
    misses(
        "identify",
        &[
            &sky[..],
            &["streak (--end RA,DEC twice; ", "times of the streak (--start and --exposure, or --times TIME TIME"],
        ]
        .concat(),
    );
    misses("inject", &["frames (--image FILE or --synthetic FILE)", "output file (-o FILE)", "streaks (", "seeing ("]);
    misses("mask", &[sky[0], "frames (FRAME..., FITS files)", "output (-o FILE, --polygons FILE or --regions FILE)"]);
    misses("plot field", &[&sky[..], &[field, "picture (-o FILE)"], &exposure].concat());
    misses(
        "plot night",
        &[&sky[..], &[field, "picture (-o FILE)", "schedule (--schedule FILE or --from FILE)"]].concat(),
    );
    misses("plot sky-rate", &[&sky[..], &[field, "picture (-o FILE)", exposure[0], exposure[1]]].concat());
    // The error for a single missing input lists its flags.
    misses("forecast --night 2024-08-14 --mpc X05", &["missing satellites; specify --elements FILE or --shells NAME"]);
    misses("plot body --model visorsat --sun-latitude-deg 20", &["missing picture; specify -o FILE"]);
}

/// Returns an element set 20 days old. With a large drag term, SGP4 fails at this age.
fn old_set(norad_id: u32, bstar_per_earth_radius: f64) -> String {
    let pair = crate::common::elements::pair(norad_id, "226.52426840");
    let mut set = crate::common::elements::read(pair.as_bytes()).unwrap().element_sets[0].clone();
    set.epoch -= hifitime::Unit::Day * 20;
    set.bstar_per_earth_radius = bstar_per_earth_radius;
    streakcast::elements::format_tle(&set).unwrap().map(|line| line + "\n").concat()
}

#[test]
fn element_sets_that_cannot_be_propagated_are_counted_on_one_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.tle"), old_set(90_001, 0.0) + &old_set(90_002, 5.0)).unwrap();
    let arguments = "passes --elements a.tle --mpc X05 --fov 3deg --ra 310 --dec=-30 --exposure 30s \
                     --start 2026-08-14T23:29:05Z";
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let (code, _, stderr) = run(&arguments, folder.path());
    assert!(code < 2, "{stderr}");
    let line = "warning: 1 of 2 element sets cannot be propagated to this date";
    assert!(stderr.contains(&format!("{line}; --verbose lists them\n")), "{stderr}");
    assert!(!stderr.contains("SGP4"), "{stderr}");
    let (_, _, stderr) = run(&[&arguments[..], &["--verbose"]].concat(), folder.path());
    assert!(stderr.contains(&format!("{line}:\n  satellite 90002: SGP4")), "{stderr}");
    let (code, _, stderr) = run(&[&arguments[..], &["--verbose", "--quiet"]].concat(), folder.path());
    assert!(code == 2 && stderr.contains("--quiet"), "{stderr}");
    // Several streaks of a table have one such line.
    #[cfg(unix)]
    {
        let rows = "310,-30,310.5,-30\n310,-30,310,-30.5\n";
        std::fs::write(folder.path().join("streaks.csv"), format!("ra1_deg,dec1_deg,ra2_deg,dec2_deg\n{rows}"))
            .unwrap();
        let arguments =
            "identify --streaks streaks.csv --elements a.tle --mpc X05 --exposure 30s --start 2026-08-14T23:29:05Z";
        let (code, _, stderr) = run(&arguments.split_whitespace().collect::<Vec<_>>(), folder.path());
        assert!(code < 2 && stderr.matches(line).count() == 1 && stderr.contains("2 streaks: "), "{stderr}");
    }
}

/// The completion script completes verbs and flags in bash.
#[cfg(unix)]
#[test]
fn bash_completes_verbs_and_flags() {
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("streakcast.bash");
    let (code, text, stderr) = run(&["completions", "bash"], folder.path());
    assert_eq!((code, stderr.as_str()), (0, ""));
    std::fs::write(&script, text).unwrap();
    let complete = |words: &[&str]| {
        let (last, count) = (words.len() - 1, words.join("' '"));
        let bash = format!(
            "source '{}'; COMP_WORDS=('{count}'); COMP_CWORD={last}; _streakcast streakcast '{}' '{}'; echo \"${{COMPREPLY[@]}}\"",
            script.display(),
            words[last],
            words[last - 1]
        );
        let output = std::process::Command::new("bash").args(["--norc", "-c", &bash]).output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    assert_eq!(complete(&["streakcast", "fl"]), "flag");
    assert_eq!(complete(&["streakcast", "flag", "--fail"]), "--fail-on");
    assert_eq!(complete(&["streakcast", "map", "bo"]), "body");
    for shell in ["zsh", "fish", "powershell", "elvish"] {
        let (code, text, _) = run(&["completions", shell], folder.path());
        assert!(code == 0 && text.contains("fail-on"), "{shell}");
    }
}

#[test]
fn every_verb_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = run(&["man", "-o", "pages"], folder.path());
    assert_eq!((code, stdout.as_str()), (0, ""), "{stderr}");
    let page = |name: &str| std::fs::read_to_string(folder.path().join("pages").join(name)).unwrap();
    for verb in subcommands(&help(&[])) {
        let text = page(&format!("streakcast-{verb}.1"));
        assert!(text.contains(".SH NAME") && text.contains("Examples:"), "{verb}");
        for inner in subcommands(&help(&[verb])) {
            page(&format!("streakcast-{verb}-{inner}.1"));
        }
    }
    assert!(page("streakcast.1").contains("flag") && stderr.starts_with("wrote "), "{stderr}");
}
