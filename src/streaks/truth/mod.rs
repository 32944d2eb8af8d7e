//! Truth of drawn streaks: `table` (truth tables), `mask` (pixels and the bits that mark them).

mod mask;
mod table;

pub use mask::{MaskPlanes, MaskPreset, MaskSpan, changed_spans, mask_spans, noise_of};
pub use table::{TruthRow, points_table, trail_table, truth_rows, truth_table};
