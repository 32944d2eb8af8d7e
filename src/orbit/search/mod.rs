//! Candidate satellites for a search cone: plane test, then side test, then phase test, on orbits interpolated over a
//! few hours.
//!
//! `window` holds the slow elements of a catalogue over a few hours, `cone` is the search volume, `candidates` runs the
//! tests: `plane` (does the orbit plane pass the cone), `side` (is the satellite on that side of the Earth) and `phase`
//! (is it near the cone at the time). `kepler`, `beam` and `shadow_cone` are their geometry.

mod beam;
mod candidates;
mod cone;
mod kepler;
mod phase;
mod plane;
mod shadow_cone;
mod side;
mod window;

pub use beam::Beam;
pub use candidates::Candidate;
pub use cone::{Cone, Cones};
pub use shadow_cone::ShadowCone;
pub use window::{MAX_WINDOW_S, Reach, Window};
