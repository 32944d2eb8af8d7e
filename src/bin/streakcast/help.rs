//! Help of the verbs: required flags in the usage line, and two examples each.

use clap::{Arg, Command};

/// Flags of which one, or one set, is required, on the command line or in the configuration file.
struct Group {
    /// Help heading of the flags; empty if they have no heading.
    heading: &'static str,
    /// Help heading that also states which flags are required.
    marked_heading: &'static str,
    /// Ids of the flags without a heading.
    ids: &'static [&'static str],
    /// Alternatives as written in the usage line.
    usage: &'static str,
    /// Alternatives in words, appended to the help of the flags in `ids`.
    rule: &'static str,
}

const SATELLITES: Group = Group {
    heading: "Satellites",
    marked_heading: "Satellites (required: --elements or --shells)",
    ids: &[],
    usage: "(--elements <FILE>... | --shells <NAME>...)",
    rule: "",
};
const SITE: Group = Group {
    heading: "Site",
    marked_heading: "Site (required: --site, --mpc, or --lat and --lon)",
    ids: &[],
    usage: "(--site <NAME> | --mpc <CODE> | --lat <DEG> --lon <DEG>)",
    rule: "",
};
const SITE_OR_FRAME: Group = Group {
    marked_heading: "Site (required: --site, --mpc, or --lat and --lon; with --image also from the header)",
    ..SITE
};
const SITE_OF_FRAME: Group =
    Group { marked_heading: "Site (required: --site, --mpc, or --lat and --lon, or the header)", ..SITE };
const MEASURED_FRAMES: Group = Group { heading: "", marked_heading: "", ids: &[], usage: "<FRAME>...", rule: "" };
const MASKED_FRAMES: Group =
    Group { usage: "<FRAME>... (-o <FILE> | --polygons <FILE> | --regions <FILE>)", ..MEASURED_FRAMES };
const FIELD: Group = Group {
    heading: "Camera",
    marked_heading: "Camera (required: --fov, --field or --telescope)",
    ids: &[],
    usage: "(--fov <ANGLE> | --field <FILE> | --telescope <NAME>)",
    rule: "",
};
const TIMES: Group = Group {
    heading: "",
    marked_heading: "",
    ids: &["times", "times_file", "start", "end", "step"],
    usage: "(--times <TIME>... | --times-file <FILE> | --start <TIME> --end <TIME> --step <TIME>)",
    rule: "--times, --times-file, or --start, --end and --step",
};
const SELECTION: Group = Group {
    heading: "",
    marked_heading: "",
    ids: &["norad", "name", "generation"],
    usage: "(--norad <ID>... | --name <TEXT>... | --generation <KIND>...)",
    rule: "--norad, --name or --generation",
};
const FRAMES: Group = Group {
    heading: "",
    marked_heading: "",
    ids: &["image", "synthetic"],
    usage: "(--image <FILE>... | --synthetic <FILE>)",
    rule: "--image or --synthetic",
};
const POINTING: Group = Group {
    heading: "",
    marked_heading: "",
    ids: &["target", "ra", "dec"],
    usage: "(--target <NAME> | --ra <ANGLE> --dec <ANGLE>)",
    rule: "--target, or --ra and --dec",
};
const GATE_POINTING: Group = Group {
    heading: "",
    marked_heading: "",
    ids: &[],
    usage: "(--ra <ANGLE> --dec <ANGLE> | --targets <FILE> --target <NAME> | --indi <HOST:PORT>)",
    rule: "",
};
const GATE_EXPOSURE: Group = Group {
    heading: "",
    marked_heading: "",
    ids: &["exposure"],
    usage: "(--exposure <TIME> | --stdin ekos)",
    rule: "this or --stdin",
};
const STREAK: Group = Group {
    heading: "Streak",
    marked_heading: "Streak (required: position and times)",
    ids: &[],
    usage: "(--end <RA,DEC> --end <RA,DEC> | --ra <ANGLE> --dec <ANGLE> --position-angle <DEG> |\n        \
            --image <FILE> --from-pix <X,Y> --to-pix <X,Y> | --region <FILE>)\n       \
            (--start <TIME> --exposure <TIME> | --times <TIME> <TIME>)",
    rule: "",
};

/// Additional help of a verb.
struct VerbHelp {
    /// Names of the verb and of its subcommand, separated by blanks.
    path: &'static str,
    /// Ids of flags that are always required.
    flags: &'static [&'static str],
    groups: &'static [Group],
    examples: [&'static str; 2],
}

const fn verb(path: &'static str, examples: [&'static str; 2]) -> VerbHelp {
    VerbHelp { path, flags: &[], groups: &[], examples }
}

const SKY: &[Group] = &[SATELLITES, SITE];
const CAMERA_AND_SKY: &[Group] = &[SATELLITES, SITE, FIELD];

const VERBS: &[VerbHelp] = &[
    VerbHelp {
        path: "passes",
        flags: &["start", "exposure"],
        groups: &[POINTING, SATELLITES, SITE, FIELD],
        examples: [
            "--start 2024-08-14T03:30:00Z --exposure 30s --ra 280 --dec=-30 --shells oneweb --mpc X05 --fov 3.5deg",
            "--start 2024-08-14T03:30:00Z --exposure 2min --ra 18h40m --dec=-30d --elements active.tle --site Paranal --telescope vst",
        ],
    },
    VerbHelp {
        path: "flag",
        flags: &["schedule"],
        groups: CAMERA_AND_SKY,
        examples: [
            "--schedule night.csv --elements active.tle --mpc X05 --telescope rubin --limit-mag 7",
            "--schedule night.csv --shells starlink-gen1 --site Paranal --fov 1deg --fail-on avoid",
        ],
    },
    VerbHelp {
        path: "annotate",
        flags: &["schedule", "output"],
        groups: CAMERA_AND_SKY,
        examples: [
            "--schedule baseline.db --elements active.tle --mpc X05 --telescope rubin -o annotated.db",
            "--schedule night.ecsv --shells oneweb --mpc X05 --fov 3.5deg -o annotated.ecsv",
        ],
    },
    VerbHelp {
        path: "windows",
        flags: &["targets"],
        groups: CAMERA_AND_SKY,
        examples: [
            "--targets targets.csv --night 2024-08-13 --elements active.tle --mpc X05 --fov 1deg --limit-mag 7",
            "--targets targets.csv --night 2024-08-13 --shells oneweb --mpc X05 --fov 1deg --format astroq",
        ],
    },
    VerbHelp {
        path: "forecast",
        flags: &[],
        groups: SKY,
        examples: [
            "--start 2024-08-14T00:00:00Z --end 2024-08-14T00:10:00Z --shells oneweb --mpc X05 --max-mag 8",
            "--night 2024-08-14 --elements active.tle --lat 48.2 --lon 16.4 --format ics -o passes.ics",
        ],
    },
    VerbHelp {
        path: "ephemeris",
        flags: &[],
        groups: &[SELECTION, TIMES, SATELLITES, SITE],
        examples: [
            "--name S1 --start 2024-08-14T03:30:00Z --end 2024-08-14T03:31:00Z --step 30s --shells oneweb --mpc X05 --min-altitude 20",
            "--norad 25544 --times 2024-08-14T03:30:00Z --elements active.tle --site Paranal --format ecsv",
        ],
    },
    VerbHelp {
        path: "gate",
        flags: &[],
        groups: &[GATE_POINTING, GATE_EXPOSURE, SATELLITES, SITE, FIELD],
        examples: [
            "--ra 280 --dec=-30 --exposure 30s --shells oneweb --mpc X05 --fov 1deg --now 2024-08-14T03:30:00Z",
            "--stdin ekos --indi localhost --elements active.tle --fov 1deg --limit-mag 7 --status-file gate.json",
        ],
    },
    VerbHelp {
        path: "identify",
        flags: &[],
        groups: &[STREAK, SATELLITES, SITE_OR_FRAME],
        examples: [
            "--end 280,-30 --end 280.5,-30.3 --start 2024-08-14T03:30:00Z --exposure 30s --shells oneweb --mpc X05",
            "--image frame.fits --from-pix 12,940 --to-pix 2030,1105 --elements active.tle --mpc X05",
        ],
    },
    verb(
        "map",
        [
            "sky --model starlink-v1.5 --sun-altitude-deg=-15 --step-deg 5",
            "body --model visorsat --sun-latitude-deg 20 --step-deg 5",
        ],
    ),
    verb(
        "map body",
        [
            "--model visorsat --sun-latitude-deg 20 --step-deg 5",
            "--model visorsat --sun-latitude-deg 20 --picture body.png",
        ],
    ),
    verb(
        "map sky",
        [
            "--model visorsat --sun-altitude-deg=-15 --step-deg 5",
            "--model visorsat --sun-altitude-deg=-15 --site Paranal --picture sky.png",
        ],
    ),
    verb("map paper", ["-o figures", "-o figures --format svg"]),
    verb("plot", ["--list", "body --model visorsat --sun-latitude-deg 20 -o body.png"]),
    VerbHelp {
        path: "plot night",
        flags: &[],
        groups: &[],
        examples: [
            "--schedule night.csv --elements active.tle --mpc X05 --telescope rubin -o night.png",
            "--from night-data.ecsv -o night.svg",
        ],
    },
    verb(
        "plot field",
        [
            "--start 2024-08-14T03:30:00Z --exposure 30s --ra 280 --dec=-30 --shells oneweb --mpc X05 --fov 9deg -o field.png",
            "--from passes.csv -o field.svg",
        ],
    ),
    verb(
        "plot light-curve",
        [
            "--start 2024-08-14T00:00:00Z --exposure 30s --ra 210 --dec=-30 --elements active.tle --mpc X05 --fov 9deg -o curve.png",
            "--from curves.ecsv -o curve.svg",
        ],
    ),
    verb(
        "plot sky-chart",
        ["--from curves.ecsv -o chart.png", "--from curves.ecsv --norad 25544 --time-zone Europe/Vienna -o chart.svg"],
    ),
    verb(
        "plot sky-rate",
        [
            "--start 2024-08-14T00:00:00Z --exposure 30s --shells oneweb --mpc X05 --fov 3.5deg --nside 4 --repeats 5 -o rate.png",
            "--from rate-data.ecsv -o rate.svg",
        ],
    ),
    verb(
        "plot sun-altitude",
        [
            "--schedule night.csv --elements active.tle --mpc X05 --telescope rubin -o trails.png",
            "--from night-data.ecsv -o trails.svg",
        ],
    ),
    verb(
        "plot sky",
        [
            "--model visorsat --sun-altitude-deg=-15 -o sky.png",
            "--model visorsat --sun-altitude-deg=-15 --site Paranal --no-data -o sky.svg",
        ],
    ),
    verb(
        "plot body",
        [
            "--model visorsat --sun-latitude-deg 20 -o body.png",
            "--model visorsat --sun-latitude-deg 20 --no-data -o body.svg",
        ],
    ),
    verb(
        "plot corner",
        ["--chains chains.ecsv -o corner.png", "--chains chains.ecsv --parameters c1,c2 -o corner.svg"],
    ),
    verb(
        "plot residuals",
        [
            "--from pixels.ecsv --model visorsat -o residuals.png",
            "--from points.ecsv --model fitted.json -o residuals.svg",
        ],
    ),
    verb(
        "plot histogram",
        [
            "--from pixels.ecsv --model visorsat -o histogram.png",
            "--from points.ecsv --model fitted.json -o histogram.svg",
        ],
    ),
    verb(
        "plot phase-curve",
        ["--from pixels.ecsv --model visorsat -o phase.png", "--from points.ecsv --model fitted.json -o phase.svg"],
    ),
    VerbHelp {
        path: "inject",
        flags: &["output"],
        groups: &[FRAMES],
        examples: [
            "--image frame.fits --random-streaks 3 --magnitude 5,8 --seeing 1.2arcsec -o streaks.fits --truth streaks.csv",
            "--image frame.fits --elements active.tle --mpc X05 --telescope rubin -o streaks.fits",
        ],
    },
    VerbHelp {
        path: "measure",
        flags: &[],
        groups: &[MEASURED_FRAMES, SATELLITES, SITE_OF_FRAME],
        examples: [
            "frame.fits --elements active.tle --mpc X05 --seeing 1.2arcsec",
            "night/a.fits night/b.fits --elements active.tle --mpc X05 --zero-point 27.1 --format fit -o photometry.csv",
        ],
    },
    VerbHelp {
        path: "mask",
        flags: &[],
        groups: &[MASKED_FRAMES, SATELLITES, SITE_OF_FRAME],
        examples: [
            "frame.fits --elements active.tle --mpc X05 --seeing 1.2arcsec -o mask.fits --regions mask.reg",
            "visit.fits --elements active.tle --mpc X05 --telescope rubin --into MASK --bit STREAK -o masked.fits",
        ],
    },
    verb("fetch", ["celestrak --group active", "satchecker --epoch 2024-08-14T00:30:00Z"]),
    verb("fetch celestrak", ["--group starlink", "--group active --elements-format json --cache elements"]),
    verb("fetch supgp", ["--file starlink", "--file oneweb --cache elements"]),
    verb("fetch space-track", ["--credentials account.txt", "--identity-env ST_USER --password-env ST_PASSWORD"]),
    verb("fetch starlink-ephemerides", ["--candidates verdicts.csv", "--norad 48430,44713 --cache ephemerides"]),
    verb("fetch satchecker", ["--epoch 2024-08-14T00:30:00Z", "--epoch 2024-08-14T00:30:00Z --cache elements"]),
    verb(
        "fit",
        [
            "reduce --photometry pomenis.csv --height-km 550 -o pixels.ecsv",
            "run --photometry pomenis.csv --height-km 550 --model starlink-v1.5 -o fitted.json",
        ],
    ),
    verb(
        "fit run",
        [
            "--photometry pomenis.csv --height-km 550 --model starlink-v1.5 -o fitted.json --report fit.html",
            "--photometry mmt.csv --elements history.tle --model starlink-v1.5 --raw-points --mcmc 2000 --chains chains.ecsv -o fitted.json",
        ],
    ),
    verb(
        "fit compare",
        [
            "--photometry pomenis.csv --height-km 550 --model starlink-v1.5",
            "--photometry mmt.csv --elements history.tle --model starlink-v1.5 --raw-points --folds 10",
        ],
    ),
    verb(
        "fit reduce",
        [
            "--photometry pomenis.csv --height-km 550 -o pixels.ecsv",
            "--photometry mmt.csv --elements history.tle --raw-points -o points.ecsv",
        ],
    ),
    verb(
        "fit identify",
        [
            "--photometry pomenis.csv --elements history.tle -o identified.csv",
            "--photometry slingshot.csv --elements history.tle --site Paranal --max-offset-s 60 -o identified.csv",
        ],
    ),
    verb(
        "learn",
        [
            "--photometry photometry.csv --elements history.tle -o learned.json",
            "--photometry mmt.csv --height-km 1200 --kind oneweb -o learned.json --leave-pass-out 0,1,2",
        ],
    ),
    verb(
        "alarms",
        [
            "--photometry tonight.csv --elements history.tle --learned learned.json",
            "--photometry mmt.csv --height-km 1200 --kind oneweb --learned learned.json --picture alarms.png",
        ],
    ),
    VerbHelp {
        path: "serve",
        flags: &[],
        groups: CAMERA_AND_SKY,
        examples: [
            "--elements active.tle --mpc X05 --telescope rubin",
            "--schedule night.csv --shells oneweb --mpc X05 --fov 3.5deg --bind 0.0.0.0:8642 --token-file token.txt",
        ],
    },
    VerbHelp {
        path: "statistics",
        flags: &["night"],
        groups: SKY,
        examples: [
            "--night 2024-06-21 --shells oneweb --mpc X05 --sun-altitude-deg=-12,-18 --moments 3",
            "--night 2024-03-20 2024-06-21 --elements active.tle --site Paranal --fov 1deg --exposure 60s",
        ],
    },
    verb("reproduce", ["bassa2022", "hu2022 --schedule baseline.db --time-scale utc"]),
    verb("model", ["list", "show visorsat"]),
    verb("model list", ["", "--config streakcast.toml --format csv"]),
    verb("model show", ["visorsat", "visorsat --format table"]),
    verb(
        "model pressure",
        ["starlink-v1.5 --mass-kg 295", "v2mini-panels --mass-kg 575 --sun-latitude-deg -20 0 20 --format csv"],
    ),
    verb("model check", ["", "visorsat-mine.json --data photometry"]),
    verb(
        "doctor",
        [
            "--shells oneweb --mpc X05 --now 2026-11-25T00:00:00Z",
            "--elements active.tle --mpc X05 --telescope rubin --strict",
        ],
    ),
    verb(
        "setup",
        [
            "--place Vienna --camera 1.5x1.0deg --limit-mag 7",
            "--place=-30.24,-70.75,2663 --elements active.tle --force",
        ],
    ),
    verb("sites", ["", "rubin --format json"]),
    verb("shells", ["", "starlink --format csv"]),
    verb("completions", ["bash", "zsh"]),
    verb("man", ["-o man", "-o man --quiet"]),
];

/// Adds required flags and examples to the help of all verbs.
pub fn complete(command: Command) -> Command {
    // Lines are not wrapped, so that examples can be copied.
    VERBS.iter().fold(with_negative_numbers(command).term_width(0), |command, help| {
        let names: Vec<&str> = help.path.split(' ').collect();
        at(command, &names, help)
    })
}

/// Accepts negative numbers as values of all flags.
fn with_negative_numbers(command: Command) -> Command {
    let command = command.mut_args(|arg| {
        let takes_values =
            arg.get_action().takes_values() && arg.get_num_args().is_none_or(|count| count.takes_values());
        if arg.get_long().is_some() && takes_values { arg.allow_negative_numbers(true) } else { arg }
    });
    command.mut_subcommands(with_negative_numbers)
}

/// Adds the help to the subcommand with these names, if it is part of this build.
fn at(command: Command, names: &[&str], help: &VerbHelp) -> Command {
    match names {
        [] => with_help(command, help),
        [name, rest @ ..] if command.find_subcommand(name).is_some() => {
            command.mut_subcommand(name, |inner| at(inner, rest, help))
        }
        _ => command,
    }
}

fn with_help(command: Command, help: &VerbHelp) -> Command {
    let examples = help.examples.map(|example| format!("  streakcast {} {example}", help.path).trim_end().to_owned());
    let mut after = format!("Examples:\n{}", examples.join("\n"));
    let mut usage = vec![format!("streakcast {}", help.path)];
    for id in help.flags {
        let arg = command.get_arguments().find(|arg| arg.get_id() == id);
        usage[0] += &arg.map(usage_of).unwrap_or_default();
    }
    let has_groups = !help.groups.is_empty();
    usage.extend(help.groups.iter().map(|group| group.usage.to_owned()));
    usage.push("[OPTIONS]".to_owned());
    if has_groups {
        after = format!("Required flags may also be keys of the configuration file (--config).\n\n{after}");
    }
    let command = command.after_help(after).mut_args(|arg| with_note(arg, help));
    if has_groups { command.override_usage(usage.join("\n       ")) } else { command }
}

/// Marks an argument as required, in its help text or in its heading.
fn with_note(arg: Arg, help: &VerbHelp) -> Arg {
    let id = arg.get_id().as_str();
    let is_required = arg.is_required_set() || help.flags.contains(&id);
    let group = help.groups.iter().find(|group| group.ids.contains(&id));
    let note =
        group.map(|group| format!(" (required: {})", group.rule)).or(is_required.then(|| " (required)".to_owned()));
    if let Some(note) = note {
        let text = arg.get_help().map(ToString::to_string).unwrap_or_default();
        return arg.help(text + &note);
    }
    match help.groups.iter().find(|group| arg.get_help_heading() == Some(group.heading)) {
        Some(group) => arg.help_heading(group.marked_heading),
        None => arg,
    }
}

/// Returns a flag as in a usage line, with a blank before it.
fn usage_of(arg: &Arg) -> String {
    let value = arg.get_value_names().and_then(|names| names.first()).map(|name| format!(" <{name}>"));
    format!(" --{}{}", arg.get_long().unwrap_or_default(), value.unwrap_or_default())
}
