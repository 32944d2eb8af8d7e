//! Flags of `serve`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

use streakcast::config::{Config, FIELD, RulesConfig, SATELLITES, SITE};

use crate::help::help;
use crate::local_time::ZoneArguments;

#[derive(Args)]
pub struct ServeArguments {
    /// Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON or VOTable; without one, the page
    /// shows any target
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// Address and port to listen at; port 0 selects a free port; addresses other than loopback require a token
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8642", value_parser = address, help_heading = "Service")]
    pub bind: SocketAddr,
    /// File with the access token of the API on its first line
    #[arg(long, value_name = "FILE", conflicts_with = "token_env", help_heading = "Service")]
    pub token_file: Option<PathBuf>,
    /// Environment variable with the access token
    #[arg(long, value_name = "NAME", help_heading = "Service")]
    pub token_env: Option<String>,
    /// Rate limit, requests per second from one address, 1 to 100000
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "Service")]
    pub rate: u32,
    #[command(flatten, next_help_heading = "Service")]
    pub zone: ZoneArguments,
    #[command(flatten)]
    pub rules: RulesConfig,
    #[command(flatten)]
    pub config: Config,
}

help! {
    ServeArguments, "serve", asks [SATELLITES, SITE, FIELD],
    "--elements active.tle --mpc X05 --telescope rubin",
    "--schedule night.csv --shells oneweb --mpc X05 --fov 3.5deg --bind 0.0.0.0:8642 --token-file token.txt"
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let allowed = "not an address with a port; allowed: an IP address and a port of 0 to 65535, for example 127.0.0.1:8642 or [::1]:8642";
    text.parse().map_err(|_| allowed.to_owned())
}
