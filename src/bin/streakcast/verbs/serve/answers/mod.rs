//! What each path answers: from the question to the library and back to JSON.

mod columns;
mod document;
pub mod dome;
pub mod exposure;
pub mod health;
mod horizontal;
pub mod night;
pub mod satchecker;
mod satchecker_positions;
