//! Frames in files: `target_frame` (a frame into which streaks are injected), `synthetic` (a simulated frame, its
//! exposure in `synthetic_shot`) with `star_trails`, `write` (a copy with streaks).

mod star_trails;
mod synthetic;
mod synthetic_shot;
mod target_frame;
mod write;

pub use synthetic::{StarField, SyntheticFrame};
pub use synthetic_shot::SyntheticShot;
pub use target_frame::{FrameOverrides, TargetChip, TargetFrame};
pub use write::{InjectOptions, Injected, inject};
