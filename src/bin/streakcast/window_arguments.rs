//! What can be typed after `windows`.

use std::path::PathBuf;

use clap::Args;

use crate::shared_arguments::{OutputArguments, RulesArguments, SharedArguments};

#[derive(Args)]
pub struct WindowsArguments {
    /// The targets: CSV, ECSV or JSON with name, ra_deg, dec_deg, exposure_s (ra and dec may be written 12h34m -30d30m)
    #[arg(long, value_name = "FILE")]
    pub targets: PathBuf,
    /// The night that begins on this evening, local date of the site, as 2024-08-14
    #[arg(long, value_name = "DATE", conflicts_with_all = ["start", "end"])]
    pub night: Option<String>,
    /// Earliest shutter opening, as 2024-08-14T23:30:00Z
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "end")]
    pub start: Option<String>,
    /// Latest shutter opening
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "start")]
    pub end: Option<String>,
    /// Length of the exposure where a row says none, with its unit
    #[arg(long, value_name = "TIME")]
    pub exposure: Option<String>,
    /// Lowest altitude of a target while the shutter is open, degrees
    #[arg(long, value_name = "DEG", default_value_t = 20.0, allow_hyphen_values = true)]
    pub min_altitude: f64,
    /// Highest altitude of the Sun while the shutter is open, degrees
    #[arg(long, value_name = "DEG", default_value_t = -12.0, allow_hyphen_values = true)]
    pub max_sun_altitude_deg: f64,
    /// Time from the beginning of a request or block to its shutter opening, for lco and eso-p2, with its unit
    #[arg(long, value_name = "TIME")]
    pub overhead: Option<String>,
    #[command(flatten)]
    pub rules: RulesArguments,
    #[command(flatten)]
    pub shared: SharedArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}
