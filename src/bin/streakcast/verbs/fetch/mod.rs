//! `fetch`: downloads element sets into a cache. Each data set is requested at most once in the interval that its
//! source allows. A cached file is replaced only if the new data are valid element sets.
//!
//! `sources` defines addresses and policies, `request` sends requests, `verify` checks the data and writes the sidecar
//! with the time of the last request, `run` combines these steps, `days` keeps the files of earlier days, and
//! `ephemerides` downloads files of chosen satellites.

mod arguments;
mod common;
mod days;
mod ephemerides;
mod request;
mod run;
mod sources;
mod verify;

pub use arguments::FetchArguments;
pub use run::run;
