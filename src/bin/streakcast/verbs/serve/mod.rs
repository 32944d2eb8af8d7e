//! `serve`: serves a web page and an HTTP API. The satellites and, if one is given, the schedule are read at the start.
//! `reload` reads element files again when they change.
//!
//! `run` reads the inputs into `state` and opens the port; `server` accepts connections; `filter` checks requests, and
//! `router` maps their paths to handlers; `query` parses parameters; `handlers/` computes responses on the threads of
//! `workers`; `problem` defines error responses; `openapi` describes the API; `page` embeds the files of the page.

mod arguments;
mod filter;
mod handlers;
mod openapi;
mod page;
mod problem;
mod query;
mod reload;
mod router;
mod run;
mod server;
mod state;
mod workers;

pub use arguments::ServeArguments;
pub use run::run;
