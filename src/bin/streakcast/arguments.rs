//! Flags that several verbs share in addition to those of [`Config`].

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use streakcast::config::Config;

use crate::output::{FORMATS, Format, Output};

/// Format and file of the output.
#[derive(Clone, Args)]
pub struct OutputArguments {
    /// Output format: table (default on a terminal), csv (default elsewhere), ecsv, json, jsonl, votable
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub format: Option<String>,
    /// Output file; standard output if omitted
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
}

impl OutputArguments {
    /// Opens the output in the given format; if none is given, in that of the configuration.
    pub fn open(self, config: &Config) -> anyhow::Result<Output> {
        let output = Output::new(self.format.as_deref().or(config.format.as_deref()), self.output);
        match &config.run.file {
            Some(file)
                if self.format.is_none()
                    && config.format.as_deref().is_some_and(|name| Format::by_name(name).is_none()) =>
            {
                output.map_err(|error| anyhow!("configuration {}: {error}", file.display()))
            }
            _ => output,
        }
    }

    /// Same as [`OutputArguments::open`], for a verb with further formats: `others`, for errors.
    pub fn open_or(self, config: &Config, others: &str) -> anyhow::Result<Output> {
        let with_others = |error: String| error.replace(FORMATS, &format!("{FORMATS}, {others}"));
        self.open(config).map_err(|error| anyhow!(with_others(error.to_string())))
    }
}
