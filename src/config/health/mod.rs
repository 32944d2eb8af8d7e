//! Setup check of a configuration at a moment.
//!
//! `finding` defines one finding with its remedy. `elements` checks the element sets (ages, duplicates, models),
//! `surroundings` clock, Earth orientation, site, camera and policy; `check` combines them.

mod check;
mod elements;
mod finding;
mod surroundings;

pub use check::Health;
pub use elements::{AgeBin, ElementState, EphemerisState, Unmatched};
pub use finding::{Finding, MomentSource, Severity, finding_table};
