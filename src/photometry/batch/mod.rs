//! Many magnitudes at once: the two-panel model in loops that the widest vectors of the machine run.

mod kernel;

pub use kernel::{BodyAngles, Places};
pub(super) use kernel::{Columns, standard_magnitudes};
