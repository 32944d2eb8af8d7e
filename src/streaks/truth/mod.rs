//! True parameters of drawn streaks: `table` (truth tables), `mask` (marked pixels and their bits, relative to
//! the noise of `noise_map`).

mod mask;
mod noise_map;
mod table;

#[cfg(all(feature = "fits", unix))]
pub(super) use mask::SHARE_WITHOUT_NOISE;
pub use mask::{MaskPlanes, MaskPreset, changed_spans, mask_spans};
pub use noise_map::NoiseMap;
pub use table::{TruthRow, points_table, trail_table, truth_rows, truth_table};
