//! `fetch`: element sets from their sources into a cache. Each source is requested by name, at most once in the interval that it allows;
//! a file is replaced only by data that have been read as element sets.
//!
//! `sources` holds the addresses, `ask` sends requests, `verify` checks data and holds the sidecar with the time of the last request, `run`
//! does these in order.

mod arguments;
mod ask;
mod run;
mod sources;
mod verify;

pub use arguments::FetchArguments;
pub use run::run;
