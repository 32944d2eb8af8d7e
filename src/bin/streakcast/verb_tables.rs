//! Tables of verbs in the configuration file and the home file: `[forecast]` and `[plot.night]` have the flags of these
//! verbs as keys.
//!
//! The keys of a verb are inserted before its flags on the command line, and all are parsed and checked in the same
//! way. The layers are, topmost first: flags, the table of the verb and the top of the configuration file, and the
//! table of the verb and the top of the home file. A key is omitted if a layer above answers its question. Keys at the
//! tops of the files are combined by [`Config::with_file`].

use std::ffi::OsString;
use std::fs::symlink_metadata;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::error::{ContextKind, ContextValue};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, ValueHint};
use streakcast::config::{Config, Question};
use streakcast::input::{is_stream, read_to_string, toml_line};
use toml::{Table, Value};

use crate::failure::usage_message;
use crate::help::parser;
use crate::local_time::local_time;

/// Smallest similarity of two names for a suggestion.
const SIMILAR: f64 = 0.85;

/// Command line with the keys of the files for its verb.
pub struct Words {
    pub words: Vec<OsString>,
    /// Files and tables of the inserted keys.
    tables: Vec<String>,
    /// Names of the inserted flags, each with its file, table and line.
    inserted: Vec<(String, String)>,
}

impl Words {
    /// Returns a command line without keys of a file.
    pub fn typed(words: Vec<OsString>) -> Self {
        Self { words, tables: Vec::new(), inserted: Vec::new() }
    }

    /// Returns files and tables of the inserted keys, if there are any.
    pub fn tables(&self) -> Option<String> {
        (!self.tables.is_empty()).then(|| self.tables.join(" or "))
    }

    /// Returns file, table and line if the error is that of an inserted key.
    pub fn place_of(&self, error: &clap::Error) -> Option<&str> {
        let names = [ContextKind::InvalidArg, ContextKind::PriorArg].into_iter().filter_map(|kind| error.get(kind));
        let mut texts = names.flat_map(|value| match value {
            ContextValue::String(name) => vec![name.as_str()],
            ContextValue::Strings(names) => names.iter().map(String::as_str).collect(),
            _ => Vec::new(),
        });
        let place_of = |flag: &str| self.inserted.iter().find(|(inserted, _)| inserted == flag);
        texts.find_map(|name| place_of(flag_of(name)?)).map(|(_, place)| place.as_str())
    }

    /// Returns file, table and line if a message of a verb is about the value of an inserted key, with whose name it
    /// begins.
    pub fn place_in(&self, message: &str) -> Option<&str> {
        let start = ["invalid ", "unknown ", "--"].iter().fold(message, |text, word| text.trim_start_matches(word));
        let is_named = |flag: &str| start.strip_prefix(flag).is_some_and(|rest| rest.starts_with([' ', ':']));
        self.inserted.iter().find(|(flag, _)| is_named(flag)).map(|(_, place)| place.as_str())
    }
}

/// Adds to the words of the command line the path of the home file, if the verb reads it, and the keys of the verb's
/// tables in this file and in the configuration file.
///
/// # Errors
/// A table or key of a file is unknown, or a value has no form on the command line. Other errors in a file are those of
/// [`Config::read`].
pub fn insert(command: &Command, words: Vec<OsString>, home: Option<&Path>) -> anyhow::Result<Words> {
    let mut all = Words::typed(words);
    // With this setting, a command line with errors is parsed as far as possible. Its errors are reported later.
    let Ok(matches) = command.clone().ignore_errors(true).try_get_matches_from(&all.words) else { return Ok(all) };
    let (mut verb, mut matches, mut path) = (command, &matches, Vec::new());
    while let Some((name, inner)) = matches.subcommand() {
        let Some(subcommand) = verb.find_subcommand(name) else { break };
        path.push(name);
        (verb, matches) = (subcommand, inner);
    }
    // A flag with an invalid value is only among the words.
    let is_given = |arg: &&Arg| {
        let is_typed =
            |name: &str| all.words.iter().filter_map(|word| word.to_str()).any(|word| flag_of(word) == Some(name));
        let names = arg.get_long_and_visible_aliases().unwrap_or_default();
        matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine) || names.into_iter().any(is_typed)
    };
    let mut given: Vec<&Arg> = verb.get_arguments().filter(is_given).collect();
    let reads_home = argument(verb, "home").is_some() && given.iter().all(|arg| arg.get_id() != "no_home");
    if let Some(word) = all.words.iter().find(|word| word.to_str().and_then(flag_of) == Some("home")) {
        bail!("unexpected argument '{}'; allowed: --config FILE, or --no-home", word.display());
    }
    // A file that cannot be reached, and a link to a missing file, are errors when they are read.
    let is_missing = |file: &Path| symlink_metadata(file).is_err_and(|error| error.kind() == ErrorKind::NotFound);
    let home = home.filter(|file| reads_home && !is_missing(file));
    let mut position = 1 + path.len();
    if let Some(home) = home {
        all.words.splice(position..position, ["--home".into(), home.as_os_str().to_owned()]);
        position += 2;
    }
    for file in config_file(verb, matches).iter().map(PathBuf::as_path).chain(home) {
        if is_stream(file) {
            // A stream is read once, later. Its keys, which lie above the tables of the home file, are not known here.
            break;
        }
        if Config::check_size(file).is_err() {
            continue;
        }
        let text = read_to_string(file).unwrap_or_default();
        let Ok(keys) = text.parse::<Table>() else { continue };
        let source = Source { shown: file.display().to_string(), text: &text };
        check(&keys, command, command, &mut Vec::new(), &source)?;
        let table = path.iter().try_fold(&keys, |table, name| find(table, name)?.as_table());
        let mut of_table = Vec::new();
        for (key, value) in table.into_iter().flatten() {
            let Some(arg) = argument(verb, key).filter(|arg| !is_replaced(arg, verb, &given)) else { continue };
            let flag = arg.get_long().unwrap_or_default();
            let is_off = is_same(flag, &format!("no_{key}"));
            let value = &value.as_bool().map_or_else(|| value.clone(), |is_on| Value::Boolean(is_on != is_off));
            let place = source.place(&path, Some(key));
            let texts = texts_of(arg, value, file.parent().unwrap_or(Path::new("")));
            for text in texts.map_err(|why| anyhow!("{place}: {key} {why}"))? {
                let word = text.map_or_else(|| format!("--{flag}"), |text| format!("--{flag}={text}"));
                all.words.insert(position, word.into());
                position += 1;
            }
            all.inserted.push((flag.to_owned(), place));
            of_table.push(arg);
        }
        if !of_table.is_empty() {
            all.tables.push(source.place(&path, None));
        }
        let of_top = keys.keys().filter_map(|key| verb.get_arguments().find(|arg| is_same(arg.get_id().as_str(), key)));
        given.extend(of_table.into_iter().chain(of_top));
    }
    Ok(all)
}

/// Returns the errors of the values in a file's tables of verbs, each with table and line. Only values that the parser
/// of the command line checks are checked.
///
/// # Errors
/// Same as [`insert`].
pub fn value_errors(root: &Command, file: &Path) -> anyhow::Result<Vec<String>> {
    let text = read_to_string(file).unwrap_or_default();
    let keys: Table = text.parse().unwrap_or_default();
    let mut paths = Vec::new();
    verbs_of(root, &keys, &mut Vec::new(), &mut paths);
    let mut errors = Vec::new();
    for path in paths {
        let mut words: Vec<OsString> = vec![root.get_name().into()];
        words.extend(path.iter().map(OsString::from));
        words.extend(["--config".into(), file.as_os_str().to_owned()]);
        let words = insert(root, words, None)?;
        // Missing flags and the like are not errors of the file.
        if let Err(error) = parser(root.clone(), &words.words).try_get_matches_from(&words.words)
            && let Some(place) = words.place_of(&error)
        {
            let message = usage_message(&error, root.clone(), Some(place));
            errors.push(message.split(" (see ").next().unwrap_or_default().to_owned());
        }
    }
    Ok(errors)
}

/// Adds the names of the verbs that have a table, with those of the verbs that contain them.
fn verbs_of(verb: &Command, table: &Table, path: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    for inner in verb.get_subcommands() {
        let Some(Value::Table(table)) = find(table, inner.get_name()) else { continue };
        path.push(inner.get_name().to_owned());
        if argument(inner, "config").is_some() {
            found.push(path.clone());
        }
        verbs_of(inner, table, path, found);
        path.pop();
    }
}

/// File of keys, for errors.
struct Source<'a> {
    shown: String,
    text: &'a str,
}

impl Source<'_> {
    /// Returns the file, the table, and the line of a key in it.
    fn place(&self, table: &[&str], key: Option<&str>) -> String {
        let line = key.and_then(|key| toml_line(self.text, &[table, &[key]].concat()));
        let line = line.map(|line| format!(", line {line}")).unwrap_or_default();
        let table = if table.is_empty() { String::new() } else { format!(", [{}]", table.join(".")) };
        format!("configuration {}{table}{line}", self.shown)
    }
}

fn config_file(verb: &Command, matches: &ArgMatches) -> Option<PathBuf> {
    let arg = argument(verb, "config")?;
    matches.try_get_one::<PathBuf>(arg.get_id().as_str()).ok().flatten().cloned()
}

/// Returns the value of a key that is written with hyphens or underscores.
fn find<'a>(table: &'a Table, name: &str) -> Option<&'a Value> {
    table.iter().find(|(key, _)| is_same(key, name)).map(|(_, value)| value)
}

fn is_same(first: &str, other: &str) -> bool {
    first.replace('-', "_") == other.replace('-', "_")
}

/// Returns the flag of a key: the flag with its name, or one that switches it off (`--no-earthshine` for `earthshine`).
fn argument<'a>(verb: &'a Command, key: &str) -> Option<&'a Arg> {
    let with_name = |key: &str| {
        let names = Arg::get_long_and_visible_aliases;
        verb.get_arguments().find(|arg| names(arg).unwrap_or_default().iter().any(|name| is_same(name, key)))
    };
    with_name(key).or_else(|| with_name(&format!("no_{key}")))
}

/// Checks that the tables of verbs have only flags of their verb as keys, that no key of a verb is at the top, and that
/// the time zone exists. Other unknown keys at the top are errors of [`Config::read`]. `path` is the table of `verb`.
fn check<'a>(
    table: &'a Table,
    root: &Command,
    verb: &Command,
    path: &mut Vec<&'a str>,
    source: &Source<'_>,
) -> anyhow::Result<()> {
    for (key, value) in table {
        let inner = verb.get_subcommands().find(|inner| is_same(inner.get_name(), key));
        if let (Some(inner), Value::Table(table)) = (inner, value) {
            path.push(key);
            check(table, root, inner, path, source)?;
            path.pop();
            continue;
        }
        let place = source.place(path, Some(key));
        let mut owners = Vec::new();
        tables_with(root, key, "", &mut owners);
        let is_shared = Config::keys().any(|known| is_same(known, key));
        let is_key = if path.is_empty() { owners.is_empty() || is_shared } else { argument(verb, key).is_some() };
        if is_same(key, "config") || is_same(key, "home") || is_same(key, "no_home") {
            bail!("{place}: {key} is only a flag; allowed: the file without this key");
        }
        if path.is_empty() && owners.is_empty() && !is_shared {
            // An unknown key is an error of the whole file; the other keys need no check.
            return Ok(());
        }
        if !is_key {
            let similarity =
                |arg: &&Arg| strsim::jaro_winkler(arg.get_long().unwrap_or_default(), &key.replace('_', "-"));
            let nearest = verb.get_arguments().max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
            let nearest = nearest.filter(|arg| similarity(arg) > SIMILAR).and_then(Arg::get_long);
            let hint = match (owners.as_slice(), nearest) {
                ([], Some(name)) => format!("did you mean {}?", name.replace('-', "_")),
                ([], None) => "allowed: the flags of the verb".to_owned(),
                ([owner, .., _, _], _) => format!("allowed: in {owner} and the tables of other verbs"),
                (owners, _) => format!("allowed: in {}", owners.join(", ")),
            };
            bail!("{place}: unknown key '{key}'; {hint}");
        }
        if path.is_empty() && is_same(key, "time_zone") {
            let zone = value.as_str().ok_or("not a text".to_owned()).and_then(local_time);
            zone.map_err(|error| anyhow!("{place}: {key} is {value}, {error}"))?;
        }
    }
    Ok(())
}

fn joined(path: &str, inner: &Command) -> String {
    if path.is_empty() { inner.get_name().to_owned() } else { format!("{path}.{}", inner.get_name()) }
}

/// Adds the names of the tables that have this key to `owners`.
fn tables_with(verb: &Command, key: &str, path: &str, owners: &mut Vec<String>) {
    for inner in verb.get_subcommands() {
        let path = joined(path, inner);
        if argument(inner, key).is_some() && argument(inner, "config").is_some() {
            owners.push(format!("[{path}]"));
        }
        tables_with(inner, key, &path, owners);
    }
}

/// Returns the name of a flag such as `--name` or `--name=value`.
fn flag_of(word: &str) -> Option<&str> {
    word.strip_prefix("--")?.split([' ', '=']).next()
}

/// Returns true if a flag on the command line answers the question of a key.
fn is_replaced(key: &Arg, verb: &Command, given: &[&Arg]) -> bool {
    let conflicts =
        |first: &Arg, other: &Arg| verb.get_arg_conflicts_with(first).iter().any(|arg| arg.get_id() == other.get_id());
    let is_same_question = |key: &str, flag: &str| {
        let is_answered = |question: &Question| question.keys.contains(&key) && question.is_answered_by(&[flag]);
        key == flag || Config::QUESTIONS.iter().any(is_answered)
    };
    given.iter().any(|flag| {
        is_same_question(key.get_id().as_str(), flag.get_id().as_str()) || conflicts(key, flag) || conflicts(flag, key)
    })
}

/// Returns the values of a flag as texts: one for each element of an array; `None` for a flag without a value.
fn texts_of(arg: &Arg, value: &Value, folder: &Path) -> Result<Vec<Option<String>>, String> {
    let takes_value = arg.get_num_args().is_none_or(|count| count.takes_values()) && arg.get_action().takes_values();
    if !takes_value {
        return match value {
            Value::Boolean(true) => Ok(vec![None]),
            Value::Boolean(false) if matches!(arg.get_action(), ArgAction::SetTrue) => Ok(Vec::new()),
            Value::Boolean(false) => Ok(vec![Some("false".to_owned())]),
            _ => Err(format!("is {value}; allowed: true")),
        };
    }
    let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
    values.iter().map(|item| text_of(arg, item, folder).map(Some)).collect()
}

/// Returns a value as on the command line. Paths are relative to the folder of the file.
fn text_of(arg: &Arg, value: &Value, folder: &Path) -> Result<String, String> {
    let text = match value {
        Value::String(text) => text.clone(),
        Value::Integer(_) | Value::Float(_) | Value::Datetime(_) => value.to_string(),
        // A limit by band, as g=7,default=6.
        Value::Table(numbers) if numbers.values().all(|number| number.is_float() || number.is_integer()) => {
            numbers.iter().map(|(name, number)| format!("{name}={number}")).collect::<Vec<_>>().join(",")
        }
        _ => return Err(format!("is {value}; allowed: a text or a number, as for the flag")),
    };
    Ok(match arg.get_value_hint() {
        ValueHint::AnyPath => folder.join(text).display().to_string(),
        // A form of the point spread function, or a file.
        ValueHint::FilePath if folder.join(&text).is_file() => folder.join(text).display().to_string(),
        _ => Config::in_folder(arg.get_id().as_str(), &text, folder),
    })
}
