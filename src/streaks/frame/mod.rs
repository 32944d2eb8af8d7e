//! Frames on file: `target_frame` (one that streaks are to be put into), `synthetic` (one made from nothing) with `star_trails`, `write` (a copy with streaks in it).

mod star_trails;
mod synthetic;
mod target_frame;
mod write;

pub use synthetic::{StarField, SyntheticError, SyntheticFrame, SyntheticShot};
pub use target_frame::{FrameOverrides, TargetChip, TargetError, TargetFrame};
pub use write::{InjectError, InjectOptions, Injected, inject};
