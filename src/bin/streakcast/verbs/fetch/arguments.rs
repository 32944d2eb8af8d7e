//! Flags of `fetch`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::help::{Typed, help};

#[derive(Args)]
pub struct FetchArguments {
    #[command(subcommand)]
    pub source: FetchSource,
}

help! { FetchArguments, "fetch", "celestrak --group active", "satchecker --epoch 2024-08-14T00:30:00Z" }

#[derive(Subcommand)]
pub enum FetchSource {
    /// Download a group of element sets (GP) from CelesTrak, for example starlink or active
    Celestrak(Typed<CelestrakArguments>),
    /// Download supplemental element sets (SupGP, from ephemerides of operators) from CelesTrak, for example oneweb
    Supgp(Typed<SupgpArguments>),
    /// Download the whole catalogue of Space-Track; requires an account
    SpaceTrack(Typed<SpaceTrackArguments>),
    /// Download the element sets of SatChecker closest to a time
    Satchecker(Typed<SatcheckerArguments>),
    /// Download the newest public ephemerides of chosen Starlinks, for example the candidates of a schedule
    StarlinkEphemerides(Typed<StarlinkEphemeridesArguments>),
}

#[derive(Args)]
pub struct CelestrakArguments {
    /// Name of the group
    #[arg(long, value_name = "GROUP")]
    pub group: String,
    /// Format of the elements; tle and 2le have no catalogue numbers above 99999
    #[arg(long, value_name = "FORMAT", default_value = "csv")]
    pub elements_format: ElementsFormat,
    #[command(flatten)]
    pub days: DaysArguments,
    #[command(flatten)]
    pub checks: RecordCheckArguments,
    #[command(flatten)]
    pub common: CommonFetchArguments,
}

help! {
    CelestrakArguments, "fetch celestrak",
    "--group starlink",
    "--group active --elements-format json --cache elements"
}

#[derive(Args)]
pub struct SupgpArguments {
    /// Name of the file
    #[arg(long, value_name = "FILE")]
    pub file: String,
    /// Format of the elements
    #[arg(long, value_name = "FORMAT", default_value = "csv")]
    pub elements_format: ElementsFormat,
    #[command(flatten)]
    pub days: DaysArguments,
    #[command(flatten)]
    pub checks: RecordCheckArguments,
    #[command(flatten)]
    pub common: CommonFetchArguments,
}

help! { SupgpArguments, "fetch supgp", "--file starlink", "--file oneweb --cache elements" }

#[derive(Args)]
pub struct SpaceTrackArguments {
    /// File with user name and password on two lines, readable only by its owner
    #[arg(long, value_name = "FILE", conflicts_with_all = ["identity_env", "password_env"], required_unless_present = "identity_env")]
    pub credentials: Option<PathBuf>,
    /// Environment variable with the user name, instead of --credentials
    #[arg(long, value_name = "NAME", requires = "password_env")]
    pub identity_env: Option<String>,
    /// Environment variable with the password, instead of --credentials
    #[arg(long, value_name = "NAME", requires = "identity_env")]
    pub password_env: Option<String>,
    #[command(flatten)]
    pub days: DaysArguments,
    #[command(flatten)]
    pub checks: RecordCheckArguments,
    #[command(flatten)]
    pub common: CommonFetchArguments,
}

help! {
    SpaceTrackArguments, "fetch space-track",
    "--credentials account.txt",
    "--identity-env ST_USER --password-env ST_PASSWORD"
}

#[derive(Args)]
pub struct SatcheckerArguments {
    /// Time of the elements, for example 2024-08-14T00:30:00Z
    #[arg(long, value_name = "TIME")]
    pub epoch: String,
    #[command(flatten)]
    pub checks: RecordCheckArguments,
    #[command(flatten)]
    pub common: CommonFetchArguments,
}

help! {
    SatcheckerArguments, "fetch satchecker",
    "--epoch 2024-08-14T00:30:00Z",
    "--epoch 2024-08-14T00:30:00Z --cache elements"
}

#[derive(Args)]
pub struct StarlinkEphemeridesArguments {
    /// CSV tables of flag or passes: the satellites of the column norad_ids or norad_id
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "norad")]
    pub candidates: Vec<PathBuf>,
    /// NORAD catalogue numbers, separated by commas
    #[arg(long, value_name = "ID", value_delimiter = ',', num_args = 1..)]
    pub norad: Vec<u32>,
    /// Largest number of satellites; each file has about 2 MB
    #[arg(long, value_name = "N", default_value_t = 500)]
    pub max_satellites: usize,
    #[command(flatten)]
    pub common: CommonFetchArguments,
}

help! {
    StarlinkEphemeridesArguments, "fetch starlink-ephemerides",
    "--candidates verdicts.csv",
    "--norad 48430,44713 --cache ephemerides"
}

/// Files of earlier days.
#[derive(Args)]
pub struct DaysArguments {
    /// Print the folder with the element sets of earlier days too (newest, and about 3, 7, 11 and 15 days old), which
    /// make the positions of Starlinks more accurate
    #[arg(long)]
    pub with_older: bool,
}

/// Checks against the previous file of the same source.
#[derive(Args)]
pub struct RecordCheckArguments {
    /// Accept a file with less than half of the records of the previous one
    #[arg(long)]
    pub accept_fewer: bool,
}

#[derive(Args)]
pub struct CommonFetchArguments {
    /// Cache folder; the folder streakcast in the cache folder of the system if omitted
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
    /// Timeout of the whole download, including the wait for other processes, with its unit; for ephemerides of each
    /// file
    #[arg(long, value_name = "TIME", default_value = "120s")]
    pub timeout: String,
    /// Suppress everything except errors on standard error
    #[arg(long, short)]
    pub quiet: bool,
    /// Base address of another server, for tests
    #[arg(long, value_name = "URL", hide = true)]
    pub base_url: Option<String>,
    /// Largest accepted response, bytes, for tests
    #[arg(long, value_name = "N", hide = true, default_value_t = 256 << 20)]
    pub max_bytes: u64,
    /// Time of the request, for tests
    #[arg(long, value_name = "TIME", hide = true)]
    pub now: Option<String>,
}

/// Format of element sets.
#[derive(Copy, Clone, PartialEq, Eq, ValueEnum)]
pub enum ElementsFormat {
    Csv,
    Json,
    Xml,
    Kvn,
    Tle,
    #[value(name = "2le")]
    TwoLine,
}

impl ElementsFormat {
    /// Returns the value of `FORMAT` in CelesTrak's URLs.
    pub fn name(self) -> &'static str {
        match self {
            ElementsFormat::Csv => "csv",
            ElementsFormat::Json => "json",
            ElementsFormat::Xml => "xml",
            ElementsFormat::Kvn => "kvn",
            ElementsFormat::Tle => "tle",
            ElementsFormat::TwoLine => "2le",
        }
    }
}
