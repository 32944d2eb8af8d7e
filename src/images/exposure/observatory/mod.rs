//! Site of a telescope, from the header of its frame.
//!
//! `positions` reads the position and the codes of the Minor Planet Center, `names` the names of sites, and `coordinates`
//! latitudes and longitudes in keywords that no standard defines. `choice` chooses the site, and compares them.

mod choice;
mod coordinates;
mod names;
mod positions;

pub use choice::{HeaderSite, SITE_KEYWORDS, site_from_headers};
pub use coordinates::unused_coordinates;
pub use positions::UNNAMED_SITE;

pub(super) use coordinates::longitude_of_unknown_sense_deg;
