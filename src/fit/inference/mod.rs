//! Minimisation and sampling of functions of a vector, independent of satellites.
//!
//! `least_squares` minimises a sum of losses with bounds by the Levenberg-Marquardt method. `ensemble` draws from a
//! posterior by the stretch move of Goodman and Weare (2010) and computes autocorrelation times.

mod ensemble;
mod least_squares;

pub(crate) use ensemble::AutocorrelationTime;
pub use ensemble::{Chain, LogProbability, autocorrelation_times, check_walkers};
pub use least_squares::NormalEquations;
pub(crate) use least_squares::{LeastSquares, Minimum, Stop};

pub(super) use ensemble::Ensemble;
pub(super) use least_squares::{minimise, minimise_in_box};
