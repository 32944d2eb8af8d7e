//! World coordinates: transformations between pixels and the sky.
//!
//! `header_terms` reads the keywords and `distortion` the polynomials of SIP, TPV and IRAF; `projection` maps the plane
//! to the sphere and rotates it onto the sky, and `wcs` combines them.

mod distortion;
mod header_terms;
mod projection;
#[expect(clippy::module_inception, reason = "the file of the type after which the folder is named")]
mod wcs;

pub use wcs::Wcs;
