//! Numerical routines without astronomy: elementary functions, quadrature, minima, quantiles, HEALPix, vector loops.

pub(crate) mod elementary;
pub mod healpix;
pub(crate) mod minimum;
pub(crate) mod quadrature;
pub mod quantile;
pub(crate) mod vectors;
