//! Maps as pictures, PNG and SVG.
//!
//! `disc` projects a half sphere on a disc, `contour` draws lines of equal magnitude, `scale` gives magnitudes colours, `picture` lays discs,
//! colour bar and words out, `encode` makes files of it, and `maps` makes pictures of the room [`maps`](crate::maps) and of the paper's figures.

mod contour;
mod disc;
mod encode;
mod error;
mod font;
mod maps;
mod picture;
mod scale;

pub use disc::{Disc, Seen};
pub use encode::PictureFormat;
pub use error::PlotError;
pub use maps::{body_picture, paper_picture, sky_picture};
pub use picture::Picture;
pub use scale::MagnitudeScale;
