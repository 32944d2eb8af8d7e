//! What can be typed after `statistics` and `reproduce`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::shared_arguments::{OutputArguments, SharedArguments};

#[derive(Args)]
pub struct StatisticsArguments {
    /// Nights by their evening's local date; several show the season, as 2024-03-20 2024-06-21
    #[arg(long, value_name = "DATE", num_args = 1.., value_delimiter = ',', required = true)]
    pub night: Vec<String>,
    /// Altitudes of the Sun at which is counted, degrees
    #[arg(
        long,
        value_name = "DEG,...",
        value_delimiter = ',',
        allow_hyphen_values = true,
        default_values_t = [0.0, -6.0, -12.0, -18.0, -24.0, -30.0, -36.0, -42.0, -48.0]
    )]
    pub sun_altitude_deg: Vec<f64>,
    /// Lowest altitudes of satellites, degrees: a row each
    #[arg(long, value_name = "DEG", num_args = 1.., value_delimiter = ',', default_values_t = [20.0, 30.0])]
    pub min_altitude: Vec<f64>,
    /// Latitudes instead of the site's, degrees north, on its longitude
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', allow_hyphen_values = true)]
    pub latitudes: Vec<f64>,
    /// Length of the exposure with its unit
    #[arg(long, value_name = "TIME", default_value = "30s")]
    pub exposure: String,
    /// Moments that each count is the mean of
    #[arg(long, value_name = "N", default_value_t = 11)]
    pub moments: usize,
    /// Time over which they are spread, with its unit
    #[arg(long, value_name = "TIME", default_value = "10min")]
    pub spread: String,
    #[command(flatten)]
    pub shared: SharedArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum Paper {
    /// Visits of LSST with streaks: Hu et al. 2022
    Hu2022,
    /// Satellites brighter than 7 mag: Lu 2024 (arXiv 2403.11118)
    Lu2024b,
    /// Satellites above an altitude by the density of shells: Bassa et al. 2022
    Bassa2022,
}

#[derive(Args)]
pub struct ReproduceArguments {
    /// The paper
    pub paper: Paper,
    /// For hu2022: visits of LSST, as thirteen nights of its baseline (opsim SQLite and all that flag reads)
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// Scale of times that name none: utc, tai or tt
    #[arg(long, value_name = "SCALE")]
    pub time_scale: Option<String>,
    /// Threads, 1 to 1024; all cores where unsaid
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// No warnings, no progress
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}
