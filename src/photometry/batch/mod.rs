//! Many magnitudes at once: the two-panel model in loops that the widest vectors of the machine run.

mod elementary;
mod kernel;

pub use kernel::BodyAngles;
pub(super) use kernel::standard_magnitudes;
