//! What can be typed after `forecast`.

use std::path::PathBuf;

use clap::Args;

use crate::shared_arguments::{OutputArguments, SharedArguments, norad_id, utc_offset_h};

/// Its own formats beside those of every verb.
const FORMAT_HELP: &str = "table (on a terminal), csv (anywhere else), ecsv, json, jsonl, votable; parquet in builds that have it; \
     ics (calendar), tdm (CCSDS tracking data message), score (columns of SCORE)";

#[derive(Args)]
#[command(mut_arg("format", |format| format.help(FORMAT_HELP)))]
pub struct ForecastArguments {
    /// The night that begins on this evening, local date of the site, as 2024-08-14
    #[arg(long, value_name = "DATE", conflicts_with_all = ["start", "end"])]
    pub night: Option<String>,
    /// First moment, as 2024-08-14T23:30:00Z
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "end")]
    pub start: Option<String>,
    /// Last moment, at most 31 days later
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "start")]
    pub end: Option<String>,
    /// Passes whose peak is brighter than this alone, in the band asked for
    #[arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Filters")]
    pub max_mag: Option<f64>,
    /// Altitude that counts as rise and set, degrees
    #[arg(long, value_name = "DEG", default_value_t = 10.0, allow_hyphen_values = true, help_heading = "Filters")]
    pub min_altitude: f64,
    /// Passes that culminate at least so high alone, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, help_heading = "Filters")]
    pub min_culmination: f64,
    /// Highest altitude of the Sun at the site, degrees: dark enough to see satellites
    #[arg(long, value_name = "DEG", default_value_t = -6.0, allow_hyphen_values = true, help_heading = "Filters")]
    pub sun_altitude_deg: f64,
    /// Satellites of these kinds alone, as starlink-v2mini, oneweb
    #[arg(long, value_name = "KIND", num_args = 1.., value_delimiter = ',', help_heading = "Filters")]
    pub generation: Vec<String>,
    /// Satellites alone whose names hold one of these, in any case
    #[arg(long, value_name = "TEXT", num_args = 1.., help_heading = "Filters")]
    pub name: Vec<String>,
    /// Satellites of these NORAD catalogue numbers alone
    #[arg(long, value_name = "ID", num_args = 1.., value_delimiter = ',', value_parser = norad_id, help_heading = "Filters")]
    pub norad: Vec<u32>,
    /// Passes in the Earth's shadow and by daylight too
    #[arg(long, help_heading = "Filters")]
    pub include_dark: bool,
    /// Points along each pass from rise to set; 61 for light curves where unsaid
    #[arg(long, value_name = "N", help_heading = "Output")]
    pub samples: Option<usize>,
    /// File of light curves beside, one row a point; its name says the format (csv, ecsv, json, jsonl, vot)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub light_curves: Option<PathBuf>,
    /// Times of the table for eyes on a clock so far ahead of UTC, as +01:00
    #[arg(long, value_name = "OFFSET", allow_hyphen_values = true, value_parser = utc_offset_h, help_heading = "Output")]
    pub utc_offset: Option<f64>,
    /// In a calendar, an alarm so long before each pass, as 5min
    #[arg(long, value_name = "TIME", help_heading = "Output")]
    pub alarm: Option<String>,
    /// Angles of a tracking data message: radec (where unsaid) or azel
    #[arg(long, value_name = "TYPE", help_heading = "Output")]
    pub angle_type: Option<String>,
    #[command(flatten)]
    pub shared: SharedArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}
