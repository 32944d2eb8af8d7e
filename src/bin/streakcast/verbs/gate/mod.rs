//! `gate`: waits until an exposure can start clear.

mod arguments;
mod clock;
mod ekos;
mod fault;
mod indi;
mod places;
mod request;
mod run;
mod status;

pub use arguments::GateArguments;
pub use run::run;
