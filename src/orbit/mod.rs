//! Orbits: SGP4 for each element set, interpolated ephemerides, the errors of the predictions, and the search for
//! satellites inside a cone.
//!
//! ```
//! use streakcast::elements::Constellation;
//! use streakcast::frames::{EopTable, Orientation, parse_instant};
//! use streakcast::orbit::Propagator;
//!
//! let epoch = parse_instant("2026-08-14T23:36:25Z", None)?;
//! let elements = Constellation::by_name("starlink-gen1")?.element_sets(epoch);
//! let satellite = Propagator::new(&elements[0])?;
//! let orientation = Orientation::at(epoch, &EopTable::embedded());
//! let state = satellite.state(epoch, &orientation.teme_to_gcrs)?;
//! assert!(state.position.norm_km() > 6700.0 && state.velocity.norm_km_s() > 7.0);
//! # Ok::<(), streakcast::Error>(())
//! ```

mod arc;
mod ephemeris;
mod lateness;
mod nodes;
mod observer_orbit;
mod orbit_model;
mod propagator;
mod resonance;
mod search;
mod shells;
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
pub(crate) use propagator::{EphemerisCoverage, TooOld, elements_of_age, not_initialised};
pub use propagator::{LeftOut, Propagator};
pub(crate) use search::{Beam, Cone, Cones, CrossingCandidate, MAX_WINDOW_S, Reach, SearchScope, ShadowCone, Window};
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
