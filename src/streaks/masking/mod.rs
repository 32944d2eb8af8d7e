//! Masks of real streaks: the pixels that the light of satellites may reach, given the errors of their positions.
//!
//! `corridor` computes the area of one satellite on a chip as cells, `light_width` the width of its light, and `area`
//! the pixels of cells. `measured` reads measured streaks, and `satellites` combines these for a frame. `write` creates
//! mask files and adds bits to mask planes; `table` creates tables and region files.

mod area;
mod corridor;
mod light_width;
mod measured;
mod satellites;
mod table;
mod write;

pub(super) use area::polygons;
pub(super) use corridor::Cell;
pub use measured::{MeasuredStreak, UnusedReason, is_same_file_name, read_measured_streaks};
pub use satellites::{
    FrameMask, LeftOutReason, MaskOptions, MaskedStreak, StreakOrigin, mask_frame, missing_zero_point,
};
pub use table::{corridor_table, left_out_table, region_file};
pub use write::{ChosenPlanes, MaskBit, PlaneChoice, mask_history, write_mask_file, write_mask_planes};
