//! Answers of the paths: each reads its query, calls the library and writes JSON.

mod document;
pub mod dome;
pub mod exposure;
pub mod health;
pub mod night;
pub mod satchecker;
mod satchecker_positions;
