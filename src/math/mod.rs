//! Numerical routines without astronomy: elementary functions, interpolation, quadrature, minima, quantiles, convex
//! polygons, HEALPix, and vectorised loops.

pub(crate) mod convex;
pub(crate) mod elementary;
pub mod healpix;
pub(crate) mod interpolation;
pub(crate) mod minimum;
pub(crate) mod quadrature;
pub mod quantile;
pub(crate) mod vectors;
