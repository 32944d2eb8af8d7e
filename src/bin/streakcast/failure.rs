//! How it ends: exit codes, and errors on one line of standard error.

use std::io;
use std::process::ExitCode;

use clap::CommandFactory;
use clap::error::ErrorKind;

use crate::arguments::Arguments;

/// What a verb comes back with when nothing went wrong.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: what a script asked about is not so (no passes, a streaked schedule).
    No,
}

/// The exit code of an outcome; an error is printed on one line and ends with 2.
pub fn exit_code(outcome: anyhow::Result<Outcome>) -> ExitCode {
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::No) => ExitCode::from(1),
        // A reader that has seen enough (`| head`) is no failure.
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

/// Standard error may be closed; there is then nobody left to tell.
fn report(message: &str) {
    let message: Vec<&str> = message.split_whitespace().collect();
    let _ = io::Write::write_all(&mut io::stderr(), format!("error: {}\n", message.join(" ")).as_bytes());
}

/// Help and version go to standard output; what was typed wrongly is told on one line.
pub fn report_usage(error: &clap::Error) -> ExitCode {
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
            let told: Vec<&str> = text
                .lines()
                .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
                .map(str::trim)
                .filter(|line| !line.is_empty())
                .collect();
            let mut told = told.join("; ").replace(":; ", ": ");
            // Of an unknown word clap tells at most what it is like; a user wants to know what there is.
            if let Some(names) = names_beside(error) {
                told += &format!("; allowed: {names}");
            }
            report(&format!("{} (see streakcast --help)", told.trim_start_matches("error: ")));
            ExitCode::from(2)
        }
    }
}

/// The subcommands where an unknown one was typed: those of the command that its words lead to.
fn names_beside(error: &clap::Error) -> Option<String> {
    if error.kind() != ErrorKind::InvalidSubcommand {
        return None;
    }
    // Verbs stand first: the first word that is none is the unknown one.
    let mut command = Arguments::command();
    for word in std::env::args_os().skip(1) {
        let Some(inner) = command.find_subcommand(word) else { break };
        command = inner.clone();
    }
    let names: Vec<&str> =
        command.get_subcommands().filter(|one| !one.is_hide_set()).map(clap::Command::get_name).collect();
    Some(names.join(", "))
}
