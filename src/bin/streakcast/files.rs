//! Files on the command line: no output replaces an input or another output.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{ArgMatches, Command};
use streakcast::config::Config;

use crate::verbs::plot::data_path;

/// Arguments that are output files in all verbs.
const OUTPUTS: [&str; 11] = [
    "output",
    "picture",
    "status_file",
    "light_curves",
    "truth",
    "trails",
    "preview",
    "preview_marked",
    "report",
    "polygons",
    "regions",
];

/// Checks that no output file of a verb is also another output or an input. Inputs include the files named in the
/// configuration file.
pub fn check(command: &Command, matches: &ArgMatches) -> anyhow::Result<()> {
    let (mut command, mut matches) = (command, matches);
    let mut verb = "";
    while let Some((name, inner)) = matches.subcommand() {
        let Some(subcommand) = command.find_subcommand(name) else { break };
        if verb.is_empty() {
            verb = name;
        }
        (command, matches) = (subcommand, inner);
    }
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        // `annotate` may replace its schedule, in which all cells are kept.
        if (verb, id) == ("annotate", "schedule") {
            continue;
        }
        let is_output = OUTPUTS.contains(&id) || (verb, id) == ("plot", "data");
        let texts = matches.try_get_raw(id).ok().flatten().into_iter().flatten();
        if is_output {
            outputs.extend(texts.map(PathBuf::from));
        } else {
            // A model for one kind of satellite is given as KIND=FILE.
            let of_kind = |text: &OsStr| Some(PathBuf::from(text.to_str()?.split_once('=')?.1));
            inputs.extend(texts.flat_map(|text| [Some(PathBuf::from(text)), of_kind(text)]).flatten());
        }
    }
    // The data of a plot are written beside its picture.
    let has_flag = |id| matches.try_get_one::<bool>(id).ok().flatten().is_some_and(|flag| *flag);
    let has_value = |id| matches.try_get_raw(id).ok().flatten().is_some();
    if verb == "plot" && !has_flag("no_data") && !has_value("data") && !has_value("from") {
        outputs.extend(outputs.first().map(|picture| data_path(picture)));
    }
    let of_keys = ["file", "home"].into_iter().filter_map(|id| matches.try_get_one::<PathBuf>(id).ok().flatten());
    for file in of_keys.filter(|_| !outputs.is_empty()) {
        // If this file has an error, the verb reports it later.
        inputs.extend(Config::read(file).map_or_else(|_| Vec::new(), |config| config.files()));
    }
    check_distinct(&inputs, &outputs)
}

/// Returns a warning if other users can read a secret file; `what` names its content.
pub fn readable_by_others(what: &str, path: &Path) -> Option<String> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(path).ok()?.permissions().mode();
        let shown = path.display();
        (mode & 0o077 != 0).then(|| format!("{what} {shown} can be read by others; run chmod 600 {shown}"))
    }
    #[cfg(not(unix))]
    {
        let _ = (what, path);
        None
    }
}

/// Checks that no output is also an input or another output. Devices and pipes may be both.
pub fn check_distinct(inputs: &[impl AsRef<Path>], outputs: &[impl AsRef<Path>]) -> anyhow::Result<()> {
    let mut files = BTreeMap::new();
    for path in inputs.iter().map(AsRef::as_ref).filter(|path| path.is_file()) {
        files.insert(fs::canonicalize(path)?, "an input");
    }
    for path in outputs.iter().map(AsRef::as_ref).filter(|path| path.is_file() || !path.exists()) {
        let file = fs::canonicalize(path).unwrap_or_else(|_| new_file(path));
        if let Some(other) = files.insert(file, "another output") {
            bail!("output {} is also {other}; allowed: another file", path.display());
        }
    }
    Ok(())
}

/// Returns the path of a file that does not exist, with the canonical path of its folder.
fn new_file(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned()).join(path.file_name().unwrap_or_default())
}
