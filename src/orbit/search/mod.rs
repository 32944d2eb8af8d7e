//! Candidate satellites for a search cone, found by a plane test, a side test and a phase test on orbits that are
//! interpolated over a few hours.
//!
//! `window` holds the slowly varying elements of a catalogue over a few hours, `cone` is the search volume, and
//! `candidates` runs the tests: `plane` (does the orbit plane pass through the cone?), `side` (is the satellite on the
//! same side of the Earth?) and the phase test in `cone` (is it near the cone during the exposure?). `kepler` computes
//! positions.

mod candidates;
mod cone;
mod kepler;
mod plane;
mod side;
mod window;

pub use candidates::CrossingCandidate;
pub use cone::{Beam, Cone, Cones, SearchScope, ShadowCone};
pub use window::{MAX_WINDOW_S, Reach, Window};
