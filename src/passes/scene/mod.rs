//! Data that the exposures of one time interval share: Sun, Earth, and the search windows of the catalogue, each with a
//! cache.

mod almanac;
mod shared;
mod window_cache;

pub(super) use almanac::Almanac;
pub(super) use shared::Scene;
pub(super) use window_cache::{SearchScope, WindowCache};
