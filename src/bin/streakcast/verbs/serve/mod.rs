//! `serve`: one page and an HTTP API over a schedule and a sky that are read once and never change.
//!
//! `run` reads and listens; `server` takes connections and stops gracefully, `farewell` ends each; `door` lets in what may come in (`bucket` counts); `routes` knows the
//! paths, `question` their parameters, `answers/` what each computes, on threads that `desk` hands out; `reply` is what goes back; `openapi`
//! describes all of it from the same tables; `page` holds the files of the page; `house` is what every answer rests on.

mod answers;
mod arguments;
mod bucket;
mod desk;
mod door;
mod farewell;
mod house;
mod openapi;
mod page;
mod question;
mod reply;
mod routes;
mod run;
mod server;
mod token;

pub use arguments::ServeArguments;
pub use run::run;
