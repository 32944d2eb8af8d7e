//! Flags of `fetch`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

#[derive(Args)]
pub struct FetchArguments {
    #[command(subcommand)]
    pub source: FetchSource,
}

#[derive(Subcommand)]
pub enum FetchSource {
    /// A group of CelesTrak's general perturbations elements, as starlink or active
    Celestrak(CelestrakArguments),
    /// A file of CelesTrak's supplemental elements (from operators' own ephemerides), as starlink or oneweb
    Supgp(SupgpArguments),
    /// The whole catalogue of Space-Track, with an account of your own
    SpaceTrack(SpaceTrackArguments),
    /// The element sets that SatChecker holds nearest to a moment
    Satchecker(SatcheckerArguments),
}

#[derive(Args)]
pub struct CelestrakArguments {
    /// Name of the group
    #[arg(long, value_name = "GROUP")]
    pub group: String,
    /// Format of the elements; TLE and its like have no room for catalogue numbers of 100000 and more
    #[arg(long, value_name = "FORMAT", default_value = "csv")]
    pub elements_format: ElementsFormat,
    #[command(flatten)]
    pub common: CommonFetchArguments,
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
    pub common: CommonFetchArguments,
}

#[derive(Args)]
pub struct SpaceTrackArguments {
    /// File with two lines, user name and password, that nobody else can read
    #[arg(long, value_name = "FILE", conflicts_with_all = ["identity_env", "password_env"], required_unless_present = "identity_env")]
    pub credentials: Option<PathBuf>,
    /// Environment variable that holds the user name
    #[arg(long, value_name = "NAME", requires = "password_env")]
    pub identity_env: Option<String>,
    /// Environment variable that holds the password
    #[arg(long, value_name = "NAME", requires = "identity_env")]
    pub password_env: Option<String>,
    #[command(flatten)]
    pub common: CommonFetchArguments,
}

#[derive(Args)]
pub struct SatcheckerArguments {
    /// The moment, as 2024-08-14T00:30:00Z
    #[arg(long, value_name = "TIME")]
    pub epoch: String,
    #[command(flatten)]
    pub common: CommonFetchArguments,
}

#[derive(Args)]
pub struct CommonFetchArguments {
    /// Folder to keep the files in; that of the system for caches, in it streakcast, where unsaid
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
    /// Give up where all of it is not there after so long, with its unit
    #[arg(long, value_name = "TIME", default_value = "120s")]
    pub timeout: String,
    /// Take a file with less than half of the records of the one before
    #[arg(long)]
    pub accept_fewer: bool,
    /// No word on standard error but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Another server in place of the source's own, for tests
    #[arg(long, value_name = "URL", hide = true)]
    pub base_url: Option<String>,
    /// Largest answer that is taken, bytes, for tests
    #[arg(long, value_name = "N", hide = true, default_value_t = 256 << 20)]
    pub max_bytes: u64,
    /// The time, for tests
    #[arg(long, value_name = "TIME", hide = true)]
    pub now: Option<String>,
}

/// What elements come as.
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
    /// As CelesTrak spells it.
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
