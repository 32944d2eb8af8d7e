//! Numerical routines without astronomy: elementary functions, interpolation, quadrature, minima, quantiles, scatter of
//! pixels, convex polygons, HEALPix, and vectorised loops.

pub(crate) mod convex;
pub(crate) mod elementary;
pub mod healpix;
pub(crate) mod interpolation;
pub(crate) mod minimum;
pub(crate) mod quadrature;
pub mod quantile;
pub(crate) mod scatter;
pub(crate) mod vectors;
