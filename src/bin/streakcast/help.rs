//! Help of the verbs. Each verb declares beside its flags which inputs it requires, which shared flags it ignores, and
//! two examples; the usage line, the notes in the help and the checks follow from this.

use std::ffi::OsString;
use std::ops::Deref;

use anyhow::anyhow;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, Id};
use streakcast::config::{Config, Mark, RequiredInput, SATELLITES, SITE};

use crate::failure::Outcome;

/// Help of a verb.
#[derive(Copy, Clone)]
pub struct Help {
    /// Names of the verb and of its subcommand, separated by blanks.
    pub verb: &'static str,
    /// Inputs that are required, on the command line or in a configuration file.
    pub asks: &'static [&'static RequiredInput],
    /// Ids of shared flags that the verb cannot use, with the reason: the help omits them, and giving them is an error.
    /// Keys of the same name in a configuration file are accepted, because other verbs use them.
    pub ignores: &'static [(&'static [&'static str], &'static str)],
    /// Two commands without the name of the verb.
    pub examples: [&'static str; 2],
}

/// Shared flags of the field of view.
pub const FIELD_FLAGS: &[&str] = &["fov", "field", "rotation", "min_probability"];
/// Shared flags of a camera.
pub const CAMERA_FLAGS: &[&str] = &["fov", "field", "rotation", "telescope", "min_probability"];

impl Help {
    /// Adds the help to the command of the verb, which has all its flags.
    fn complete(&self, command: Command) -> Command {
        let command = command.mut_args(|arg| self.marked(arg)).after_help(examples(self.verb, self.examples));
        if self.asks.is_empty() {
            return command;
        }
        let (mut first, mut usage) = (format!("streakcast {}", self.verb), Vec::new());
        for input in self.asks {
            if input.is_one_flag() {
                first += &format!(" {}", input.usage());
            } else {
                usage.push(input.usage());
            }
        }
        let usage = [vec![first], usage, vec!["[OPTIONS]".to_owned()]].concat();
        let note = "Required flags may also be keys of the configuration file (--config).";
        command
            .override_usage(usage.join("\n       "))
            .after_help(format!("{note}\n\n{}", examples(self.verb, self.examples)))
    }

    /// Marks an argument as required, in its help text or in its heading, and hides one that has no effect.
    fn marked(&self, arg: Arg) -> Arg {
        let hide = self.ignores.iter().any(|(ids, _)| ids.contains(&arg.get_id().as_str()));
        let arg = if hide { arg.hide(true) } else { arg };
        let (long, short) = (arg.get_long().map(|long| format!("--{long}")), arg.get_short().map(|c| format!("-{c}")));
        let is_of = |input: &&&RequiredInput| {
            let mut flags = input.ways.concat().into_iter().filter_map(|flag| flag.split(' ').next());
            input.mark == Mark::Flags && flags.any(|flag| [long.as_deref(), short.as_deref()].contains(&Some(flag)))
        };
        let note = match self.asks.iter().find(is_of) {
            Some(input) if !input.is_one_flag() => format!(" (required: {})", input.names()),
            None if !arg.is_required_set() => {
                let marked = self.asks.iter().find_map(|input| match input.mark {
                    Mark::Heading(heading, more) if arg.get_help_heading() == Some(heading) => {
                        let names = if input.words.is_empty() { input.names() } else { String::new() };
                        Some(format!("{heading} (required: {names}{more})"))
                    }
                    _ => None,
                });
                // Headings must be static. Each run of the program builds a few of them.
                return marked.map_or(arg.clone(), |heading| arg.help_heading(&*heading.leak()));
            }
            _ => " (required)".to_owned(),
        };
        let text = arg.get_help().map(ToString::to_string).unwrap_or_default();
        arg.help(text + &note)
    }

    /// Returns the error for a flag on the command line that the verb ignores.
    fn rejected(&self, matches: &ArgMatches) -> Option<String> {
        let is_typed = |id: &&&str| matches.value_source(id) == Some(ValueSource::CommandLine);
        self.ignores.iter().find_map(|(ids, why)| {
            let flag = ids.iter().find(is_typed)?.replace('_', "-");
            Some(format!("--{flag} {why}; allowed: the command without it"))
        })
    }

    /// Checks that all required inputs are given; `answers` has those that the configuration does not determine.
    ///
    /// # Errors
    /// One error that lists all missing inputs.
    pub fn check(&self, config: &Config, answers: &[(&RequiredInput, bool)]) -> anyhow::Result<()> {
        check(config, self.asks, answers)
    }
}

/// Returns the list of examples of a verb.
pub fn examples(verb: &str, examples: [&str; 2]) -> String {
    let lines = examples.map(|example| format!("  streakcast {verb} {example}").trim_end().to_owned());
    format!("Examples:\n{}", lines.join("\n"))
}

/// Same as [`Help::check`], for `asks` that depend on flags.
pub fn check(config: &Config, asks: &[&RequiredInput], answers: &[(&RequiredInput, bool)]) -> anyhow::Result<()> {
    let is_answer = |input: &RequiredInput| answers.iter().any(|(answer, _)| answer.name == input.name);
    let others = asks.iter().filter(|input| !is_answer(input)).map(|input| (*input, (input.is_given)(config)));
    let all = answers.iter().copied().chain(others);
    let missing: Vec<&RequiredInput> = all.filter(|(_, is_given)| !is_given).map(|(input, _)| input).collect();
    // A home file can have these.
    let is_of_home = missing.iter().any(|input| [SATELLITES.name, SITE.name].contains(&input.name));
    let setup = if is_of_home { "; streakcast setup writes them once into a home file" } else { "" };
    match missing.as_slice() {
        [] => Ok(()),
        [input] => Err(anyhow!("{}{setup}", input.missing())),
        several => {
            let listed: Vec<String> =
                several.iter().map(|input| format!("{} ({})", input.name, input.flags())).collect();
            Err(anyhow!("missing: {}{setup}", listed.join(", ")))
        }
    }
}

/// Flags of a verb.
pub trait VerbFlags: Args {
    /// Help of the verb.
    const HELP: Help;
}

/// Declares the help of a verb for the type of its flags.
macro_rules! help {
    (
        $flags:ty, $verb:literal $(, asks [$($input:expr),+])? $(, ignores [$($ignored:expr),+])?,
        $first:literal, $second:literal
    ) => {
        impl $crate::help::VerbFlags for $flags {
            const HELP: $crate::help::Help = $crate::help::Help {
                verb: $verb,
                asks: &[$($(&$input),+)?],
                ignores: &[$($($ignored),+)?],
                examples: [$first, $second],
            };
        }
    };
}
pub(crate) use help;

/// Flags of a verb with its help. Flags that it ignores are rejected.
pub struct Typed<T> {
    flags: Box<T>,
    rejected: Option<String>,
}

impl<T> Typed<T> {
    /// Runs the verb.
    ///
    /// # Errors
    /// A flag is given that the verb ignores, or the verb returns an error.
    pub fn run(self, verb: impl FnOnce(T) -> anyhow::Result<Outcome>) -> anyhow::Result<Outcome> {
        self.rejected.map_or_else(|| verb(*self.flags), |message| Err(anyhow!(message)))
    }
}

impl<T> Deref for Typed<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.flags
    }
}

impl<T: VerbFlags> Args for Typed<T> {
    fn group_id() -> Option<Id> {
        T::group_id()
    }

    fn augment_args(command: Command) -> Command {
        T::HELP.complete(T::augment_args(command))
    }

    fn augment_args_for_update(command: Command) -> Command {
        T::HELP.complete(T::augment_args_for_update(command))
    }
}

impl<T: VerbFlags> FromArgMatches for Typed<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let rejected = T::HELP.rejected(matches);
        Ok(Self { flags: Box::new(T::from_arg_matches(matches)?), rejected })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Adds to all verbs what their flags have in common.
pub fn complete(command: Command) -> Command {
    // Lines are not wrapped, so that examples can be copied.
    with_negative_numbers(command).term_width(0)
}

/// Returns the command for these words. In it, a flag of a setting that is true or false may have a value
/// (`--quiet=false`), which the help omits.
pub fn parser(command: Command, words: &[OsString]) -> Command {
    fn with_values(command: Command) -> Command {
        let is_switch = |arg: &Arg| {
            matches!(arg.get_action(), ArgAction::Set) && arg.get_num_args().is_some_and(|count| !count.takes_values())
        };
        let command =
            command.mut_args(|arg| if is_switch(&arg) { arg.num_args(0..=1).require_equals(true) } else { arg });
        command.mut_subcommands(with_values)
    }
    let has_value =
        |word: &OsString| word.to_str().is_some_and(|word| word.ends_with("=true") || word.ends_with("=false"));
    if words.iter().any(has_value) { with_values(command) } else { command }
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
