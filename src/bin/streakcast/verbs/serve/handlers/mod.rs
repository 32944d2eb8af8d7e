//! Handlers of the API paths. Each handler reads its query, calls the library and returns JSON.

mod document;
pub mod dome;
pub mod exposure;
pub mod exposures;
pub mod forecast;
pub mod health;
pub mod night;
pub mod satchecker;
mod satchecker_positions;
mod target;
