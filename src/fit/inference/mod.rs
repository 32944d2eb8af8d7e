//! Minima and posteriors of functions of a vector; nothing here has heard of satellites.
//!
//! `box_quadratic` minimises a quadratic form between bounds, `least_squares` a sum of squares by Levenberg and Marquardt with
//! those steps, `stretch` and `ensemble` draw from a posterior (Goodman and Weare 2010) and `autocorrelation` says how many
//! draws that makes.

mod autocorrelation;
mod box_quadratic;
mod ensemble;
mod least_squares;
mod stretch;

pub use autocorrelation::{AutocorrelationTime, autocorrelation_times};
pub use box_quadratic::minimise_in_box;
pub use ensemble::{Chain, Ensemble, EnsembleError, LogProbability, check_walkers};
pub use least_squares::{LeastSquares, Minimum, NormalEquations, Stop, minimise};
