//! Flags that several verbs share in addition to those of [`Config`].

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use streakcast::config::Config;

use crate::output::Output;

/// Format and file of the output.
#[derive(Args)]
pub struct OutputArguments {
    /// Output format: table (default on a terminal), csv (default elsewhere), ecsv, json, jsonl, votable; optional
    /// parquet
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub format: Option<String>,
    /// Output file; standard output if omitted
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
}

impl OutputArguments {
    /// Opens the output in the given format; if none is given, in that of the configuration.
    pub fn open(self, config: &Config) -> anyhow::Result<Output> {
        Output::new(self.format.as_deref().or(config.format.as_deref()), self.output)
    }
}

/// Rejects camera flags for a result that does not depend on a camera. `subject` names the result in the error.
pub fn reject_camera(flags: &Config, subject: &str) -> anyhow::Result<()> {
    let given = [
        ("--fov", flags.fov.is_some()),
        ("--field", flags.field.is_some()),
        ("--rotation", flags.rotation.is_some()),
        ("--telescope", flags.telescope.is_some()),
        ("--min-probability", flags.min_probability.is_some()),
    ];
    match given.iter().find(|(_, is_given)| *is_given) {
        Some((flag, _)) => Err(anyhow!("{flag} has no effect on {subject}; allowed: the command without it")),
        None => Ok(()),
    }
}
