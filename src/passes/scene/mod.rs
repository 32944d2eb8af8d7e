//! Data that the exposures of one time interval share: Sun, Earth, and the search windows of the catalogue, each with a
//! cache.

mod almanac;
mod scene;
mod window_cache;

pub(super) use almanac::Almanac;
pub(super) use scene::Scene;
pub(super) use window_cache::{SearchScope, WindowCache};
