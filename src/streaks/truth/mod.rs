//! True parameters of drawn streaks: `table` (truth tables), `mask` (marked pixels and their bits).

mod mask;
mod table;

pub use mask::{MaskPlanes, MaskPreset, MaskSpan, changed_spans, mask_spans, noise_of};
pub use table::{TruthRow, points_table, trail_table, truth_rows, truth_table};
