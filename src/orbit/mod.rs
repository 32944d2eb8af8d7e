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

pub use arc::OrbitArc;
pub use ephemeris::PositionSource;
pub use lateness::Lateness;
pub use observer_orbit::ObserverOrbit;
pub use orbit_model::OrbitModel;
pub use propagator::{
    DECAYED_RADIUS_KM, EphemerisCoverage, LeftOut, OrbitError, Propagator, SatelliteIndex, elements_of_age,
};
pub use search::{Beam, Candidate, Cone, Cones, MAX_WINDOW_S, Reach, ShadowCone, Window};
pub use state::State;
pub use station_keeping::{DragModel, MeanMotion, StarlinkClass};
pub use uncertainty::{LEAST_KNOWN_SHARE, OrbitClass, OrbitKind, OrbitUncertainty, uncertainty};
