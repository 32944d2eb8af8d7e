//! How a point's light spreads: `seeing` (what the air makes of it), `blur` (with defocus and size), `radii` and `curve` (functions of
//! a radius), `wings` (where they end), `disk` (blurring by a uniform disk), `integrals` (along a line, over a pixel), `edge` (of half a line), `even` (where it is nearly
//! a cubic), `tables` (all together), `lanes` (read many at a time), `lattice` (of a line, read along rows), `parts` (finer pixels), `profile` (on the detector's pixels), `point` (drawn).

mod blur;
mod curve;
mod disk;
mod edge;
mod even;
mod integrals;
mod lanes;
mod lattice;
mod parts;
mod point;
mod profile;
mod radii;
mod seeing;
mod tables;
mod wings;

pub use blur::{Blur, BlurError};
pub use edge::EdgeTable;
pub use lanes::Lanes;
pub use lattice::Lattice;
pub use parts::Parts;
pub use point::draw_point;
pub use profile::RadialProfile;
pub use seeing::Seeing;
pub use tables::ProfileTables;
