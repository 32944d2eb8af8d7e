//! Exit codes, and errors on one line of standard error.

use std::io;
use std::process::ExitCode;

use clap::Command;
use clap::error::ErrorKind;

use crate::screen::printable;

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
    let line = format!("error: {}\n", message.join(" "));
    let _ = io::Write::write_all(&mut io::stderr(), printable(&line).as_bytes());
}

/// Prints help and version on standard output, and a usage error on one line of standard error.
pub fn report_usage(error: &clap::Error, command: Command) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let _ = error.print();
            ExitCode::SUCCESS
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            ExitCode::from(2)
        }
        _ => {
            let text = error.render().to_string();
            let message: Vec<&str> = text
                .lines()
                .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
                .map(str::trim)
                .filter(|line| !line.is_empty())
                .collect();
            let mut message = message.join("; ").replace(":; ", ": ");
            let (verb, path) = innermost(command);
            // clap lists only names that are similar to the unknown one.
            if error.kind() == ErrorKind::InvalidSubcommand {
                let allowed = verb.get_subcommands().filter(|one| !one.is_hide_set()).map(Command::get_name);
                message += &format!("; allowed: {}", allowed.collect::<Vec<_>>().join(", "));
            }
            report(&format!("{} (see {path} --help)", message.trim_start_matches("error: ")));
            ExitCode::from(2)
        }
    }
}

/// Returns the subcommand in the arguments of this program, and its names with those of the commands that contain it.
fn innermost(mut command: Command) -> (Command, String) {
    let mut path = command.get_name().to_owned();
    // Subcommands come first.
    for word in std::env::args_os().skip(1) {
        let Some(inner) = command.find_subcommand(word) else { break };
        path += &format!(" {}", inner.get_name());
        command = inner.clone();
    }
    (command, path)
}
