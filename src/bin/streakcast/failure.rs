//! Exit codes, and errors on one line of standard error.

use std::cmp::Ordering;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

use crate::output::cannot_print;
use streakcast::message::{bounded, printable};

/// Verbs of frames as FITS, which do not exist on Windows: CFITSIO is not built there.
const NOT_ON_WINDOWS: [&str; 3] = ["inject", "mask", "measure"];

/// Result of a command that had no error.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: a negative result, for use in scripts (no passes, or a streaked schedule).
    No,
}

/// Returns the exit code of a result. An error is printed on one line, with exit code 2.
pub fn exit_code(outcome: anyhow::Result<Outcome>) -> ExitCode {
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::No) => ExitCode::from(1),
        // A closed pipe (`| head`) is not an error.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            report(&error.to_string());
            ExitCode::from(2)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|io| io.kind() == io::ErrorKind::BrokenPipe))
}

/// Writes a message on one line of standard error. A closed standard error is ignored.
fn report(message: &str) {
    let message: Vec<&str> = message.split_whitespace().collect();
    let line = format!("error: {}", message.join(" "));
    let _ = io::Write::write_fmt(&mut io::stderr(), format_args!("{}\n", bounded(&printable(&line))));
}

/// Returns the message of a usage error. `place` is the file and table of the value that is in error, if it is not on
/// the command line.
pub fn usage_message(error: &clap::Error, command: Command, place: Option<&str>) -> String {
    let text = error.render().to_string();
    let message: Vec<&str> = text
        .lines()
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect();
    let mut message = message.join("; ").replace(":; ", ": ");
    // Errors of Rust's own parsers of numbers.
    for (error, allowed) in [
        ("invalid float literal", "a number"),
        ("invalid digit found in string", "a whole number of 0 or more"),
        ("number too large to fit in target type", "a smaller number"),
    ] {
        message = message.replace(error, &format!("allowed: {allowed}"));
    }
    if let Some((start, values)) = message.split_once("[possible values: ") {
        message = format!("{start}allowed: {}", values.replacen(']', "", 1));
    }
    let (verb, path) = innermost(command);
    // clap lists only names that are similar to the unknown one.
    if error.kind() == ErrorKind::InvalidSubcommand {
        let allowed = verb.get_subcommands().filter(|subcommand| !subcommand.is_hide_set()).map(Command::get_name);
        message += &format!("; allowed: {}", allowed.collect::<Vec<_>>().join(", "));
    }
    if error.kind() == ErrorKind::UnknownArgument
        && let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg)
        && let Some(tip) = tip(argument, &verb)
    {
        message = format!("{}; tip: {tip}", message.split("; tip: ").next().unwrap_or_default());
    }
    let place = place.map(|place| format!("{place}: ")).unwrap_or_default();
    format!("{place}{} (see {path} --help)", message.trim_start_matches("error: "))
}

/// Names that flags have elsewhere, with the flag that may be meant.
const OTHER_NAMES: [(&str, &str); 12] = [
    ("date", "night"),
    ("day", "night"),
    ("evening", "night"),
    ("latitude", "lat"),
    ("longitude", "lon"),
    ("elevation", "height"),
    ("place", "site"),
    ("observatory", "site"),
    ("tle", "elements"),
    ("omm", "elements"),
    ("satellite", "name"),
    ("duration", "exposure"),
];

/// Returns what may be meant by an unknown argument of a verb; `None` if nothing is similar.
fn tip(argument: &str, verb: &Command) -> Option<String> {
    /// Smallest similarity of the names of flags: with the same first letter, which is rarely wrong, and with another
    /// one.
    const SIMILAR: [f64; 2] = [0.7, 0.8];
    let names = || verb.get_arguments().filter(|arg| !arg.is_hide_set()).filter_map(Arg::get_long);
    let Some(name) = argument.strip_prefix("--") else {
        let is_file = !argument.starts_with('-') && (argument.contains('.') || Path::new(argument).exists());
        let takes_elements = is_file && names().any(|name| name == "elements");
        return takes_elements.then(|| format!("a file of element sets is given by --elements {argument}"));
    };
    let meant = OTHER_NAMES.iter().filter(|(other, known)| *other == name && names().any(|flag| flag == *known));
    if let Some((_, known)) = meant.into_iter().next() {
        return Some(format!("similar: --{known}"));
    }
    let likeness = |known: &str| {
        // Jaro's similarity, with a tenth of the rest added for each common letter at the beginning (Winkler 1990).
        let (jaro, common) = (strsim::jaro(known, name), known.chars().zip(name.chars()).take_while(|(a, b)| a == b));
        let common = common.count().min(4);
        (common > 0, jaro + 0.1 * common as f64 * (1.0 - jaro))
    };
    let is_similar = |known: &&str| {
        let (same_first, similarity) = likeness(known);
        similarity > if same_first { SIMILAR[0] } else { SIMILAR[1] }
    };
    let mut similar: Vec<&str> = names().filter(is_similar).collect();
    similar.sort_by(|a, b| likeness(b).partial_cmp(&likeness(a)).unwrap_or(Ordering::Equal));
    let listed: Vec<String> = similar.iter().take(2).map(|known| format!("--{known}")).collect();
    (!listed.is_empty()).then(|| format!("similar: {}", listed.join(", ")))
}

/// Prints help and version on standard output, and a usage error on one line of standard error. `place` is the file and
/// table of the value that is in error, if it is not on the command line.
pub fn report_usage(error: &clap::Error, command: Command, place: Option<&str>) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let printed = error.print().and_then(|()| io::Write::flush(&mut io::stdout()));
            exit_code(printed.map(|()| Outcome::Done).map_err(|error| cannot_print("the help", error)))
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            ExitCode::from(2)
        }
        _ => {
            if let Some(message) = missing_verb(error, &command) {
                report(&message);
                return ExitCode::from(2);
            }
            report(&usage_message(error, command, place));
            ExitCode::from(2)
        }
    }
}

/// Returns the message for a verb that does not exist on this system; `None` for other errors.
fn missing_verb(error: &clap::Error, command: &Command) -> Option<String> {
    let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    let is_missing = NOT_ON_WINDOWS.contains(&name.as_str()) && command.find_subcommand(name).is_none();
    is_missing.then(|| format!("'{name}' does not exist on Windows"))
}

/// Returns the innermost subcommand in the arguments of this program, and its full name, such as `streakcast map sky`.
fn innermost(mut command: Command) -> (Command, String) {
    let mut path = command.get_name().to_owned();
    // Subcommands come before all flags.
    for word in std::env::args_os().skip(1) {
        let Some(inner) = command.find_subcommand(word) else { break };
        path += &format!(" {}", inner.get_name());
        command = inner.clone();
    }
    (command, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verbs_that_windows_lacks_are_named() {
        let message = |verb: &str| {
            let mut other = Command::new("streakcast").subcommand(Command::new("passes"));
            missing_verb(&other.try_get_matches_from_mut(["streakcast", verb]).unwrap_err(), &other)
        };
        assert_eq!(message("inject").as_deref(), Some("'inject' does not exist on Windows"));
        assert_eq!(message("injekt"), None);
    }

    #[cfg(unix)]
    #[test]
    fn verbs_that_windows_lacks_exist_elsewhere() {
        let all = <crate::Arguments as clap::CommandFactory>::command();
        for verb in NOT_ON_WINDOWS {
            assert!(all.find_subcommand(verb).is_some(), "{verb}");
        }
    }
}
