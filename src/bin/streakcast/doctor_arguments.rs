//! What can be typed after `doctor`.

use std::path::PathBuf;

use clap::Args;

use crate::shared_arguments::{OutputArguments, RulesArguments, SharedArguments};

#[derive(Args)]
pub struct DoctorArguments {
    /// Folder of fetched elements; that of the system for caches, in it streakcast, where unsaid
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
    /// The time to look at, as 2024-08-14T00:30:00Z; that of this machine's clock where unsaid
    #[arg(long, value_name = "TIME")]
    pub now: Option<String>,
    /// End with exit code 1 where there is a warning, or where elements or site were not said and so not looked at
    #[arg(long)]
    pub strict: bool,
    #[command(flatten)]
    pub rules: RulesArguments,
    #[command(flatten)]
    pub shared: SharedArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}
