//! `completions` and `man`: completions for shells and manual pages, generated from the definition of the command line.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Command, ValueHint};
use clap_complete::{Shell, generate};
use clap_mangen::Man;

use crate::failure::Outcome;
use crate::help::help;
use crate::notices::Notices;
use crate::output::{FORMATS, Output, check, write_bytes};
use streakcast::elements::{Constellation, Generation};
use streakcast::photometry::Band;

#[derive(Args)]
pub struct CompletionsArguments {
    /// Shell
    #[arg(value_enum)]
    pub shell: Shell,
}

help! { CompletionsArguments, "completions", "bash", "zsh" }

#[derive(Args)]
pub struct ManArguments {
    /// Folder, created if it is missing
    #[arg(long, short, value_name = "FOLDER", required = true)]
    pub output: PathBuf,
    /// Suppress the list of written files
    #[arg(long, short)]
    pub quiet: bool,
}

help! { ManArguments, "man", "-o man", "-o man --quiet" }

/// Writes the completions of one shell to standard output.
pub fn completions(typed: &CompletionsArguments, mut command: Command) -> anyhow::Result<Outcome> {
    command = with_values(command);
    let mut script = Vec::new();
    generate(typed.shell, &mut command, "streakcast", &mut script);
    let script = String::from_utf8(script)?;
    Output::new(Some("csv"), None)?.write_text(&script, &Notices::new(false))?;
    Ok(Outcome::Done)
}

/// Adds the values of flags that have a short list of values, and hints for files.
fn with_values(command: Command) -> Command {
    const FILES: [&str; 4] = ["field", "policy", "model", "telescope"];
    let values = |id: &str| -> Vec<&'static str> {
        match id {
            "format" => FORMATS.split(", ").collect(),
            "band" => Band::ALL.map(Band::name).to_vec(),
            "mag_system" => vec!["vega", "ab"],
            "generation" => Generation::ALL.map(Generation::name).to_vec(),
            "shadow" => vec!["atmosphere", "geometric"],
            "time_scale" => vec!["utc", "tai", "tt"],
            "angle_type" => vec!["radec", "azel"],
            // The program ends after it has written the completions.
            "shells" => {
                Constellation::embedded().into_iter().map(|constellation| &*constellation.name.leak()).collect()
            }
            _ => Vec::new(),
        }
    };
    let command = command.mut_args(|arg| {
        let (id, is_flag) = (arg.get_id().to_string(), arg.get_action().takes_values() && arg.get_long().is_some());
        match values(&id).as_slice() {
            [] if is_flag && FILES.contains(&id.as_str()) => arg.value_hint(ValueHint::FilePath),
            [] => arg,
            listed if is_flag => arg.value_parser(PossibleValuesParser::new(listed.to_vec())),
            _ => arg,
        }
    });
    command.mut_subcommands(with_values)
}

/// Writes one page for the program, for each verb, and for each of their subcommands: all pages or none.
pub fn man(typed: &ManArguments, mut command: Command) -> anyhow::Result<Outcome> {
    command.build();
    let mut pages = Vec::new();
    add_pages(&command, &mut pages)?;
    let folder = &typed.output;
    let pages: Vec<(PathBuf, Vec<u8>)> = pages.into_iter().map(|(name, page)| (folder.join(name), page)).collect();
    pages.iter().try_for_each(|(path, _)| check(path))?;
    let notices = Notices::new(typed.quiet);
    pages.iter().try_for_each(|(path, page)| write_bytes(path, page, &notices))?;
    Ok(Outcome::Done)
}

fn add_pages(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> anyhow::Result<()> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page)?;
    pages.push((man.get_filename(), page));
    command
        .get_subcommands()
        .filter(|inner| !inner.is_hide_set() && inner.get_name() != "help")
        .try_for_each(|inner| add_pages(inner, pages))
}
