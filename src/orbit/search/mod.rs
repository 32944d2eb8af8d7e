//! Candidate satellites for a search cone: plane test, then side test, then phase test, on orbits interpolated over a
//! few hours.
//!
//! `window` holds the slow elements of a catalogue over a few hours, `cone` is the search volume, `candidates` runs the
//! tests: `plane` (does the orbit plane pass the cone), `side` (is the satellite on that side of the Earth) and the
//! phase test of `cone` (is it near the cone at the time), on the orbits of `kepler`.

mod candidates;
mod cone;
mod kepler;
mod plane;
mod side;
mod window;

pub use candidates::Candidate;
pub use cone::{Beam, Cone, Cones, ShadowCone};
pub use window::{MAX_WINDOW_S, Reach, Window};
