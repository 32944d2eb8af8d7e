//! `fetch`: element sets from their sources into a cache, politely: asked for by name, at most once in the time that the source wants, never again after
//! a refusal before that time is over, and nothing replaced but by what has been read as element sets.
//!
//! `sources` knows the addresses, `stamp` when they were asked, `ask` the network, `verify` what came, `run` the order of things.

mod arguments;
mod ask;
mod credentials;
mod run;
mod sources;
mod stamp;
mod verify;

pub use arguments::FetchArguments;
pub use run::run;
