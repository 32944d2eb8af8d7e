//! What is true of drawn streaks: `table` (rows for people and pipelines), `mask` (pixels) in the bits of `mask_planes`.

mod mask;
mod mask_planes;
mod table;

pub use mask::{MaskSpan, changed_spans, mask_spans, noise_of};
pub use mask_planes::{MaskPlanes, MaskPreset};
pub use table::{TruthRow, points_table, trail_table, truth_rows, truth_table};
