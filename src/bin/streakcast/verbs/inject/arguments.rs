//! Flags of `inject`.

use std::path::PathBuf;

use clap::Args;
use streakcast::config::{Config, InjectionConfig};

#[derive(Args)]
pub struct InjectArguments {
    #[command(flatten)]
    pub injection: InjectionConfig,
    /// File to write, whole or not at all; a folder for several frames
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// The truth table beside the frame: a file that ends in .csv, .ecsv, .json or .jsonl
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub truth: Option<PathBuf>,
    /// Rows for Rubin's source_injection: a CSV or ECSV file of trails
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub trails: Option<PathBuf>,
    /// Picture of the frame (the chip with the longest streak): a .png file
    #[cfg(feature = "plot")]
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub preview: Option<PathBuf>,
    /// Picture of the frame with the streaks marked
    #[cfg(feature = "plot")]
    #[arg(long, value_name = "FILE", help_heading = "Truth")]
    pub preview_marked: Option<PathBuf>,
    #[command(flatten)]
    pub config: Config,
}
