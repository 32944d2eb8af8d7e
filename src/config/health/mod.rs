//! Setup check of a configuration at a given time.
//!
//! `finding` defines the result for one subject. `elements` checks the element sets (ages, duplicates, models),
//! `observation` checks clock, Earth orientation, site, camera and policy; `check` runs all checks.

mod check;
mod elements;
mod finding;
mod observation;

pub use check::Health;
pub use elements::{AgeBin, ElementState, EphemerisState, Unmatched};
pub use finding::{Finding, MomentSource, Severity, finding_table};
