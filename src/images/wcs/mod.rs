//! World coordinates: from pixels to the sky and back.
//!
//! `header_terms` reads the keywords, `distortion` with `polynomial` the polynomials of SIP, TPV and IRAF, `projection` knows the plane, `sphere`
//! turns it onto the sky, and `wcs` puts all together.

mod distortion;
mod error;
mod header_terms;
mod polynomial;
mod projection;
mod sphere;
#[expect(clippy::module_inception, reason = "the file of the type after which the folder is named")]
mod wcs;

pub use error::WcsError;
pub use wcs::Wcs;
