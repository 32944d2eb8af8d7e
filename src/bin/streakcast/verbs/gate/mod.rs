//! `gate`: waits until an exposure can start without a crossing.

mod arguments;
mod clock;
mod deadline;
mod ekos;
mod indi;
mod report;
mod run;
mod sky;
mod status_file;
mod targets;

pub use arguments::{GateArguments, check_values};
pub use run::run;
