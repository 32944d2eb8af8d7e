//! `fetch`: downloads element sets into a cache. Each data set is requested at most once in the interval that its
//! source allows. A cached file is replaced only by data that can be read as element sets.
//!
//! `sources` defines the addresses, `request` sends requests, `verify` checks the data and writes the sidecar with the
//! time of the last request, `run` combines them, and `ephemerides` downloads files of chosen satellites.

mod arguments;
mod common;
mod ephemerides;
mod request;
mod run;
mod sources;
mod verify;

pub use arguments::FetchArguments;
pub use run::run;
