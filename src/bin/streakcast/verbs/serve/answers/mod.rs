//! Answers of the paths: each reads its query, calls the library and writes JSON.

mod columns;
mod document;
pub mod dome;
pub mod exposure;
pub mod health;
mod horizontal;
pub mod night;
pub mod satchecker;
mod satchecker_positions;
