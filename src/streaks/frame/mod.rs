//! Frames in files. `target_frame` reads a frame into which streaks are injected, `write` writes the copy with streaks.
//! `synthetic` simulates a frame, `synthetic_shot` holds its exposure, and `star_trails` draws its trailed stars.

mod star_trails;
mod synthetic;
mod synthetic_shot;
mod target_frame;
mod write;

pub use synthetic::{StarField, SyntheticFrame};
pub use synthetic_shot::SyntheticShot;
pub use target_frame::{FrameOverrides, TargetChip, TargetFrame};
pub use write::{InjectOptions, Injected, inject};
pub(super) use write::{mask_name, noise_of_chip};
