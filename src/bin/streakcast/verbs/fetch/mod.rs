//! `fetch`: downloads of element sets into a cache. Each source receives at most one request per allowed interval. A
//! file is replaced only by data that have been read as element sets.
//!
//! `sources` holds the addresses, `request` sends requests, `verify` checks data and holds the sidecar with the time of
//! the last request, `run` combines them, and `ephemerides` downloads files of chosen satellites.

mod arguments;
mod ephemerides;
mod request;
mod run;
mod sources;
mod verify;

pub use arguments::FetchArguments;
pub use run::run;
