//! The paper's form (Lu 2024, section 2) as something to be fitted: chassis and sail, seven coefficients and the panel offset.
//!
//! `shape` says which satellite and which terms, `columns` holds what the geometry of each point makes of them, `earth` the
//! same for the Earth's light, `kernel` puts coefficients to them in vector loops.

mod columns;
mod earth;
mod kernel;
mod shape;

pub use shape::TwoPanelForm;
