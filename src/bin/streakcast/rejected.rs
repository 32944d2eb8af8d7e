//! Flags that all verbs share and some verbs cannot use: the help omits them, and giving them is an error. Keys of the
//! same name in a configuration file are accepted, because other verbs use them.

use anyhow::bail;
use clap::parser::ValueSource;
use clap::{ArgMatches, Command};

const CAMERA: &[&str] = &["fov", "field", "rotation", "telescope", "min_probability"];
const FIELD: &[&str] = &["fov", "field", "rotation", "min_probability"];
const ORBIT: &[&str] =
    &["observer_elements", "observer_norad", "limb_height_km", "max_zenith_angle", "min_sun_angle", "min_limb_angle"];

/// Reason for the rejection of the flags of a telescope in orbit.
const NO_ORBIT: &str = "cannot be used, because a telescope in orbit has no horizon; for satellites in its field use passes, flag or \
                        windows, for numbers statistics";

/// Verbs, ids of the flags that they reject, and the reason.
const REJECTED: &[(&str, &[&str], &str)] = &[
    ("forecast", CAMERA, "has no effect on passes over a site"),
    ("ephemeris", CAMERA, "has no effect on an ephemeris"),
    ("identify", CAMERA, "has no effect on the identification of a streak"),
    ("measure", FIELD, "has no effect on measure, where the frame is the field"),
    ("mask", &["fov", "field", "rotation"], "has no effect on mask, where the frame is the field"),
    ("inject", FIELD, "has no effect on inject, where the frame is the field"),
    ("statistics", &["rotation", "min_probability"], "has no effect on statistics"),
    ("forecast", ORBIT, NO_ORBIT),
];

/// Omits the rejected flags from the help.
pub fn hide(command: Command) -> Command {
    REJECTED.iter().fold(command, |command, (verb, ids, _)| {
        // A build without a feature lacks some verbs.
        if command.find_subcommand(verb).is_none() {
            return command;
        }
        command.mut_subcommand(verb, |inner| {
            inner.mut_args(|arg| if ids.contains(&arg.get_id().as_str()) { arg.hide(true) } else { arg })
        })
    })
}

/// # Errors
/// A flag that the verb rejects is on the command line.
pub fn check(matches: &ArgMatches) -> anyhow::Result<()> {
    let Some((given, matches)) = matches.subcommand() else { return Ok(()) };
    for (_, ids, why) in REJECTED.iter().filter(|(verb, ..)| *verb == given) {
        if let Some(id) = ids.iter().find(|id| matches.value_source(id) == Some(ValueSource::CommandLine)) {
            bail!("--{} {why}; allowed: the command without it", id.replace('_', "-"));
        }
    }
    Ok(())
}
