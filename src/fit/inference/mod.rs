//! Minimisation and sampling of functions of a vector, independent of satellites.
//!
//! `least_squares` minimises a sum of losses by Levenberg and Marquardt's method between bounds; `ensemble` draws from
//! a posterior with the stretch move of Goodman and Weare (2010) and computes autocorrelation times.

mod ensemble;
mod least_squares;

pub use ensemble::{AutocorrelationTime, Chain, LogProbability, autocorrelation_times, check_walkers};
pub use least_squares::{LeastSquares, Minimum, NormalEquations, Stop};

pub(super) use ensemble::Ensemble;
pub(super) use least_squares::{minimise, minimise_in_box};
