//! Where the satellites are: SGP4 made ready, and the orbit planes that tell at once which satellites can matter.

mod arc;
mod beam;
mod candidates;
mod index;
mod kepler;
mod phase;
mod propagator;
mod resonance;
mod shade;
mod side;
mod sight;
mod uncertainty;
mod window;

pub use arc::Arc;
pub use beam::Beam;
pub use candidates::{Candidate, Cones};
pub use index::{LeftOut, Reach, SatelliteIndex};
pub use propagator::{DECAYED_RADIUS_KM, OrbitError, Propagator, State};
pub use shade::Shade;
pub use uncertainty::{OrbitClass, OrbitKind, OrbitUncertainty, uncertainty};
pub use window::{Cone, MAX_WINDOW_S, Window};
