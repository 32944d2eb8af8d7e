//! `serve`: a page and an HTTP API for one schedule and one set of satellites, read once at the start.
//!
//! `run` reads the inputs into `state` and listens; `server` accepts connections; `router` maps paths to handlers,
//! behind `filter`; `query` reads parameters; `answers/` computes the
//! responses on the threads of `workers`; `problem` holds error responses; `openapi` describes the API; `page` holds
//! the files of the page.

mod answers;
mod arguments;
mod filter;
mod openapi;
mod page;
mod problem;
mod query;
mod router;
mod run;
mod server;
mod state;
mod workers;

pub use arguments::ServeArguments;
pub use run::run;
