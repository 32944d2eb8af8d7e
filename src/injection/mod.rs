//! From what was said to frames with streaks in them: which frames, whose light, through what optics, and what is told of it.
//!
//! Every face fills the same [`InjectionSaid`], as it fills a [`crate::config::Setup`]: the command line from its flags, a plugin from its
//! arguments. `asked` makes sense of it, `frames` and `light` bring what goes into what, `run` draws and writes; `array` is for images that
//! are no files.

mod array;
mod asked;
mod error;
mod frames;
mod light;
mod run;
mod said;

pub use array::{ArrayInjected, inject_into_array};
pub use error::InjectionError;
pub use light::SkyOf;
pub use run::{FrameDone, Injections, Mark, inject_frames};
pub use said::InjectionSaid;
