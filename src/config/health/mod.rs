//! What is wrong with a config at a moment: before a night, not in it.
//!
//! `finding` is one of them, with what to do. `elements` looks at the element sets (their ages, repetitions, kinds), `surroundings` at clock, Earth
//! orientation, site, camera and policy; `check` puts them together.

mod check;
mod elements;
mod finding;
mod surroundings;

pub use check::Health;
pub use elements::{AgeBin, ElementState, Unmatched};
pub use finding::{Finding, MomentSource, Severity, finding_table};
