//! Orbits: SGP4 for each element set, interpolated ephemerides, the errors of the predictions, and the search for
//! satellites inside a cone.

mod arc;
mod ephemeris;
mod lateness;
mod observer_orbit;
mod orbit_model;
mod propagator;
mod resonance;
mod search;
mod starlink_lateness;
mod state;
mod station_keeping;
#[cfg(test)]
mod test_elements;
mod uncertainty;

pub(crate) use arc::OrbitArc;
pub use ephemeris::PositionSource;
pub(crate) use lateness::Lateness;
pub(crate) use observer_orbit::ObserverOrbit;
pub(crate) use propagator::{EphemerisCoverage, elements_of_age};
pub use propagator::{LeftOut, OrbitError, Propagator};
pub(crate) use search::{Beam, Candidate, Cone, Cones, MAX_WINDOW_S, Reach, ShadowCone, Window};
pub use state::State;
pub(crate) use uncertainty::LEAST_KNOWN_SHARE;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    orbit_model::OrbitModel,
    propagator::SatelliteIndex,
    station_keeping::{DragModel, MeanMotion, StarlinkClass},
    uncertainty::{OrbitClass, OrbitKind, OrbitUncertainty, uncertainty},
};
