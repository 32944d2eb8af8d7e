//! `gate`: waits until an exposure can start clear.

mod arguments;
mod clock;
mod ekos;
mod indi;
mod places;
mod run;
mod status_file;

pub use arguments::GateArguments;
pub use run::run;
