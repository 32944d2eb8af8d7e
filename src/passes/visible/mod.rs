//! Visible passes: intervals above a site's horizon, and what of them is seen at night and in sunlight.

mod above_horizon;
mod visible_passes;

pub use visible_passes::{NotShown, Visibility, VisiblePass, VisiblePasses, VisibleRequest, intervals_where};
