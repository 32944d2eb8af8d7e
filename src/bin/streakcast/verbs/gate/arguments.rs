//! Flags of `gate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use streakcast::config::{Config, PolicyChoice, Quantity};
use streakcast::schedule::MagnitudeLimit;

#[derive(Args)]
pub struct GateArguments {
    /// Right ascension of the field's centre (ICRS): 188.5 (degrees) or 12h34m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "dec")]
    pub ra: Option<Quantity>,
    /// Declination of the field's centre (ICRS): -30.5 or -30d30m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "ra")]
    pub dec: Option<Quantity>,
    /// Length of the exposure with its unit, as 300s; with --stdin what the host says counts
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub exposure: Option<Quantity>,
    /// Crossings brighter than this are waited for, in the band asked for: 7, or by filter L=7,Ha=3,default=6; all lit ones where unsaid
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<MagnitudeLimit>,
    /// Policy file (TOML): limits by magnitude, probability, margin
    #[arg(long, value_name = "FILE")]
    pub policy: Option<PolicyChoice>,
    /// The longest wait with its unit
    #[arg(long, value_name = "TIME", default_value = "90s")]
    pub max_wait: String,
    /// Time kept clear before and after, with its unit: how long the host may take to open the shutter; 2s where no policy says another
    #[arg(long, value_name = "TIME")]
    pub margin: Option<String>,
    /// Exit 1 where it is not clear in time, 2 on any fault; without it both are 0 and a line of log
    #[arg(long)]
    pub strict: bool,
    /// Read what the host says on standard input: ekos (the JSON of its pre-capture script)
    #[arg(long, value_name = "HOST", help_heading = "Host")]
    pub stdin: Option<Host>,
    /// Places by name (TOML), for hosts that tell a target's name alone
    #[arg(long, value_name = "FILE", help_heading = "Host")]
    pub targets: Option<PathBuf>,
    /// The target's name in that file; with --stdin what the host says counts
    #[arg(long, value_name = "NAME", requires = "targets", help_heading = "Host")]
    pub target: Option<String>,
    /// Ask a running mount where it points: an INDI server, as localhost or 10.0.0.2:7624
    #[arg(long, value_name = "HOST:PORT", help_heading = "Host")]
    pub indi: Option<String>,
    /// Which of several mounts
    #[arg(long, value_name = "NAME", requires = "indi", help_heading = "Host")]
    pub indi_device: Option<String>,
    /// How long standard input and the INDI server may keep silent, with its unit
    #[arg(long, value_name = "TIME", default_value = "5s", help_heading = "Host")]
    pub timeout: String,
    /// What was found, and counters over all runs (JSON), for hosts that show neither output nor log
    #[arg(long, value_name = "FILE", help_heading = "Host")]
    pub status_file: Option<PathBuf>,
    /// A rehearsal: the clock stands at this moment, and waits pass at once
    #[arg(long, value_name = "TIME", help_heading = "Time")]
    pub now: Option<String>,
    #[command(flatten)]
    pub config: Config,
}

#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum Host {
    Ekos,
}
