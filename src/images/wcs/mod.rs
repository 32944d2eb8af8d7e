//! World coordinates: transformations between pixels and the sky.
//!
//! `header_terms` reads the keywords, `distortion` the polynomials of SIP, TPV and IRAF; `projection` maps the
//! projection plane to the sphere and rotates it to its place on the sky; `wcs` combines these steps.

mod distortion;
mod header_terms;
mod projection;
#[expect(clippy::module_inception, reason = "the file of the type after which the folder is named")]
mod wcs;

pub use wcs::Wcs;
